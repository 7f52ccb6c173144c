// The page of a study: what differs, verdicts, figures and tables by one measure or the other, and all runs.

function showStudy(index) {
  place("about").textContent = index.about;
  place("differs").replaceChildren(element("p", {}, index.agree), ...index.differs.map(shownTable));
  if (index.verdicts) place("verdicts").replaceChildren(shownTable(index.verdicts));
  place("claims").hidden = !index.verdicts;
  const choice = place("metric");
  choice.append(...Object.entries(index.metrics).map(([metric, title]) => element("option", { value: metric }, title)));
  const show = () => place("studies").replaceChildren(...index.studies.map((one) => shownStudy(one, choice.value)));
  choice.addEventListener("change", show);
  show();
  place("runs").replaceChildren(tableOf(RUN_COLUMNS, index.runs));
}

const RUN_COLUMNS = [
  ["world", (one) => one.world, ""],
  ["algorithm", (one) => (one.page ? element("a", { href: one.page }, one.arm) : one.arm), ""],
  ["seed", (one) => one.seed, "number"],
  ["mean over fresh deployments", (one) => figure(one.fresh), "number"],
  ["best fitness of the search", (one) => figure(one.best), "number"],
  ["generations", (one) => (one.planned ? `${one.generations}${one.ended ? "" : ` of ${one.planned}, not ended`}` : "–"), "number"],
  ["rules and replay", (one) => (one.replay ? "yes" : ""), ""],
];

function shownStudy(one, metric) {
  const wanted = (item) => item.metric === null || item.metric === metric;
  return element(
    "section", {},
    element("h2", {}, one.title),
    ...one.state.map((line) => element("p", {}, line)),
    element("div", { class: "charts" }, ...one.figures.filter(wanted).map(plot)),
    ...one.tables.filter(wanted).map(shownTable),
  );
}

function shownTable(table) {
  const columns = table.header.map((name, at) => [name, (row) => row[at], table.rows.every((row) => row[at].length < 40) ? "short" : "long"]);
  return element(
    "div", { class: "table" },
    element("h3", {}, table.title, " ", element("button", { type: "button", click: () => download(`${table.name}.csv`, table.csv, "text/csv") }, "CSV")),
    element("div", { class: "scroll", tabindex: 0 }, tableOf(columns, table.rows)),
  );
}

showPage(showStudy);
