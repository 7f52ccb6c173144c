// The table of rules: every agent's, to be sorted and searched.

const ROWS = 100; // that are shown at first, and more at each wish

const RULE_COLUMNS = {
  agent: ["agent", "number"],
  rule: ["rule", ""],
  strength: ["strength ζ", "number"],
  quality: ["quality q", "number"],
  error: ["error ε", "number"],
  usage: ["use τ", "number"],
  matched: ["matched", "number"],
  chosen: ["chosen", "number"],
  origin: ["origin", ""],
};

function showRules(table) {
  if (!table) {
    place("rules").replaceChildren(element("p", { class: "dim" }, "There is no saved solution to show."));
    return;
  }
  const rows = ruleRows(table);
  const columns = Object.keys(RULE_COLUMNS).filter((name) => rows[0][name] !== undefined);
  const view = { sort: "strength", descending: true, text: "", agent: "all", count: ROWS };
  const body = element("tbody");
  const said = element("p", { class: "dim", role: "status" });
  const heads = columns.map((name) =>
    element(
      "th", { scope: "col", class: RULE_COLUMNS[name][1], "data-column": name },
      element("button", { type: "button", click: () => change(sortedBy(view, name)) }, RULE_COLUMNS[name][0]),
    ),
  );
  const more = element("button", { type: "button", click: () => change({ count: view.count + 5 * ROWS }) }, "Show more");

  function change(wanted) {
    Object.assign(view, wanted);
    const found = selected(rows, view);
    body.replaceChildren(...found.slice(0, view.count).map((row) => ruleRow(row, columns)));
    said.textContent = `${found.length} of ${rows.length} rules; ${Math.min(found.length, view.count)} shown`;
    more.hidden = found.length <= view.count;
    for (const head of heads) {
      const by = head.dataset.column === view.sort;
      head.setAttribute("aria-sort", by ? (view.descending ? "descending" : "ascending") : "none");
    }
  }

  place("rules").replaceChildren(
    ruleTools(table.agents, change),
    said,
    element(
      "div", { class: "scroll", tabindex: 0 },
      element("table", {}, element("thead", {}, element("tr", {}, ...heads)), body),
    ),
    more,
    element(
      "p", { class: "dim" },
      "Strength, quality, error and use as learnt in the search. Matched and chosen: time-steps of the replay in which the condition held, and in which the rule was drawn.",
    ),
  );
  change({});
}

function ruleRows(table) {
  return table.text.map((text, at) => ({
    agent: Math.floor(at / table.rules),
    rule: table.texts[text],
    strength: table.strength[at],
    quality: table.quality[at],
    error: table.error[at],
    usage: table.usage[at],
    matched: table.matched?.[at],
    chosen: table.chosen?.[at],
    origin: table.origins[table.origin[at]],
  }));
}

/** A column once more: the other way round. Another column: numbers from the greatest, texts from A. */
function sortedBy(view, name) {
  const again = view.sort === name;
  return { sort: name, descending: again ? !view.descending : RULE_COLUMNS[name][1] === "number" && name !== "agent" };
}

function selected(rows, view) {
  const words = view.text.toLowerCase().split(/\s+/).filter(Boolean);
  const found = rows.filter((row) => {
    const said = `${row.rule} ${row.origin}`.toLowerCase();
    return (view.agent === "all" || row.agent === Number(view.agent)) && words.every((word) => said.includes(word));
  });
  const sign = view.descending ? -1 : 1;
  const by = (a, b) => (a < b ? -sign : a > b ? sign : 0);
  return found.sort((a, b) => by(a[view.sort], b[view.sort])); // equal ones stay in order
}

function ruleRow(row, columns) {
  return element(
    "tr", {},
    ...columns.map((name) => {
      const learnt = ["strength", "quality", "error"].includes(name);
      const value = learnt ? figure(row[name]) : row[name];
      return element("td", { class: RULE_COLUMNS[name][1] || (name === "rule" ? "code" : "") }, value);
    }),
  );
}

function ruleTools(agents, change) {
  const numbers = Array.from({ length: agents }, (_, agent) => element("option", { value: agent }, `agent ${agent}`));
  const search = element("input", { type: "search", id: "rule-search", input: (event) => change({ text: event.target.value, count: ROWS }) });
  const agent = element(
    "select", { id: "rule-agent", change: (event) => change({ agent: event.target.value, count: ROWS }) },
    element("option", { value: "all" }, "all agents"), ...numbers,
  );
  return element(
    "div", { class: "tools" },
    element("label", { for: "rule-search" }, "Search"), search,
    element("label", { for: "rule-agent" }, "of"), agent,
  );
}
