// The page of the suite: tables whose columns sort, figures, and the rules or settings of its entries.

function showSuite(index) {
  place("about").replaceChildren(...index.about.map((line) => element("p", {}, line)));
  place("tables").replaceChildren(...index.tables.map(sortable));
  place("figures").replaceChildren(...index.figures.map(plot));
  place("rules").replaceChildren(...index.rules.map(shownRules));
  place("watch").hidden = !index.replays.length;
  place("replays").replaceChildren(tableOf(replayColumns(index.replays), index.replays));
}

function replayColumns(replays) {
  return [
    ["world", (one) => one.world, ""],
    ["field", (one) => one.field, ""],
    ["entry", (one) => element("button", { type: "button", click: () => watch(one) }, one.entry), ""],
    ["fitness", (one) => figure(one.fitness), "number"],
  ];
}

/** Play an episode, and say which rules acted most in it. */
async function watch(one) {
  showReplay(unpackReplay(await bytes(one.replay)), one.rules, one);
  const rows = one.says.map(([text, share]) => element("tr", {}, element("td", { class: "number" }, `${(100 * share).toFixed(1)} %`), element("td", {}, text)));
  place("says").replaceChildren(...(rows.length ? [element("h3", {}, "The rules that acted most"), element("table", {}, element("tbody", {}, ...rows))] : []));
}

/** A table with a button in the head of every column; a second press turns the order round. */
function sortable(table) {
  const frame = element("div", { class: "scroll", tabindex: 0 });
  let [by, down] = [null, false];
  const show = () => {
    const rows = by === null ? table.rows : [...table.rows].sort((a, b) => (down ? -1 : 1) * compared(a[by].sort, b[by].sort));
    const columns = table.header.map((name, at) => [name, (row) => row[at].text, typeof table.rows[0][at].sort === "number" ? "number" : ""]);
    const made = tableOf(columns, rows);
    made.querySelectorAll("th").forEach((head, at) => {
      const press = () => {
        [by, down] = [at, by === at ? !down : typeof table.rows[0][at].sort === "number"];
        show();
      };
      head.setAttribute("aria-sort", by === at ? (down ? "descending" : "ascending") : "none");
      head.replaceChildren(element("button", { type: "button", click: press }, table.header[at]));
    });
    frame.replaceChildren(made);
  };
  show();
  return element(
    "section", {},
    element("h2", {}, table.title, " ", element("button", { type: "button", click: () => download(`${table.name}.csv`, table.csv, "text/csv") }, "CSV")),
    frame,
  );
}

/** Numbers and texts in order; what is not known comes last upward. */
function compared(a, b) {
  if (a === null || b === null) return Number(a === null) - Number(b === null);
  return typeof a === "number" && typeof b === "number" ? a - b : String(a).localeCompare(String(b));
}

function shownRules(one) {
  return element("details", {}, element("summary", {}, one.title), element("p", {}, one.about), element("pre", {}, one.text));
}

showPage(showSuite);
