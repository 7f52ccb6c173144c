// The page as a whole: which instance is shown, and what is said of it.

const index = { entries: [], runs: [] };
let showing = 0; // counts what was asked for, so that what comes late to an older question is dropped

async function start(data) {
  Object.assign(index, data);
  listInstances();
  await choose(0);
}

const INSTANCE_COLUMNS = [
  ["algorithm", (one, at) => element("button", { type: "button", click: () => choose(at) }, one.arm), ""],
  ["world", (one) => one.world, ""],
  ["seed", (one) => one.seed, "number"],
  ["generations", (one) => `${one.generations}${one.ended ? "" : ` of ${one.planned}, not ended`}`, "number"],
  ["best fitness", (one) => figure(one.best), "number"],
  ["in fresh deployments, mean ± SD", (one) => freshly(one), "number"],
];

function freshly(one) {
  return one.fresh_mean === null ? "–" : `${figure(one.fresh_mean)} ± ${figure(one.fresh_sd)} (${one.fresh})`;
}

function listInstances() {
  place("instances").replaceChildren(tableOf(INSTANCE_COLUMNS, index.entries));
}

/** Show an instance. */
async function choose(at) {
  const asked = ++showing;
  const one = index.entries[at];
  [...place("instances").querySelectorAll("tbody tr")].forEach((row, number) => {
    row.classList.toggle("chosen", number === at);
    row.toggleAttribute("aria-current", number === at);
  });
  summarise(one, index.runs[one.run]);
  const [history, rules, packed] = await Promise.all([
    json(one.history),
    one.rules && json(one.rules),
    one.replay && bytes(one.replay),
  ]);
  if (asked !== showing) return;
  showCurves(one, history);
  showLineage(history.lineage);
  showRules(rules);
  showReplay(packed && unpackReplay(packed), rules, one);
}

function summarise(one, run) {
  const said = {
    "best fitness": `${figure(one.best)}, generation ${one.winner ?? "–"}`,
    "in fresh deployments": one.fresh_mean === null ? null : `${freshly(one)}: mean ± SD (how many)`,
    world: run.world,
    swarm: run.swarm,
    evaluations: one.evaluations && `${one.evaluations.toLocaleString("en")}, ${one.env_steps.toLocaleString("en")} time-steps`,
    run: run.name,
    command: run.command && element("code", {}, run.command),
    "made with": [run.versions, run.device, run.started].filter(Boolean).join("; "),
  };
  const list = element("dl");
  for (const [name, value] of Object.entries(said)) {
    if (value) list.append(element("dt", {}, name), element("dd", {}, value));
  }
  const notes = [];
  if (!one.ended) notes.push(`This run has not ended: ${one.generations} of ${one.planned} generations.`);
  if (one.note) notes.push(one.note);
  place("summary").replaceChildren(...notes.map((note) => element("p", { class: "note" }, note)), list, found(one), changed(run));
}

function found(one) {
  if (!one.found.length) return "";
  return element("section", { id: "found" }, element("h3", {}, "What it does"),
    element("ul", {}, ...one.found.map((line) => element("li", {}, line))));
}

function changed(run) {
  if (!run.settings.length) return element("p", { class: "dim" }, "All settings are at their defaults.");
  const head = ["setting", "value", "default", "meaning"].map((name) => element("th", { scope: "col" }, name));
  const rows = run.settings.map((row) => element("tr", {}, ...row.map((value) => element("td", {}, value))));
  return element(
    "details", {},
    element("summary", {}, `${rows.length} settings that are not at their default`),
    element("table", {}, element("thead", {}, element("tr", {}, ...head)), element("tbody", {}, ...rows)),
  );
}

showPage(start);
