// The search of an instance: fitness, collection, novelty against fitness, contribution, and the winner's ancestors.

const SMOOTHED = 25; // generations of the running mean

function showCurves(one, history) {
  const { columns } = history;
  const made = columns.generation.length
    ? [fitnessChart(history), sizeChart(columns), noveltyChart(columns)]
    : [element("p", { class: "note" }, "No generation is finished yet.")];
  if (history.contribution.length) made.push(contributionChart(history.contribution));
  place("search").replaceChildren(...made);
}

function generations(columns) {
  return { label: "generation", low: 0, high: Math.max(columns.generation.at(-1), 1) };
}

function fitnessChart({ of, columns }) {
  const { generation, fitness, best } = columns;
  const thinned = of > generation.length ? ` ${generation.length} of ${of} generations are drawn.` : "";
  return chart(
    "Fitness of the best and of the population",
    `Line: best so far. Dots: each generation's offspring, mean over its deployments; dashed: their running mean over ${SMOOTHED}.${thinned}`,
    generations(columns),
    { label: "fitness", ...range(fitness.concat(best)) },
    (across, up) => [
      ...dots(generation, fitness, across, up, "dot", "var(--trail)"),
      line(generation, running(fitness), across, up, { stroke: "var(--interference)", "stroke-dasharray": "5 3" }),
      line(generation, best, across, up, { stroke: "var(--blue)", "stroke-width": 2 }, true),
    ],
  );
}

/** Mean of each value and those before it, SMOOTHED in all. */
function running(values) {
  return values.map((_, at) => {
    const some = values.slice(Math.max(0, at - SMOOTHED + 1), at + 1);
    return some.reduce((a, b) => a + b, 0) / some.length;
  });
}

function sizeChart(columns) {
  return chart(
    "Collection",
    "Solutions that the collection holds after each generation.",
    generations(columns),
    { label: "solutions", ...range(columns.size, 0) },
    (across, up) => [line(columns.generation, columns.size, across, up, { stroke: "var(--blue)" }, true)],
  );
}

function noveltyChart({ generation, novelty, fitness, accepted }) {
  const where = (wanted) => novelty.map((value, at) => (accepted[at] === wanted ? value : null));
  const title = (at) => `generation ${generation[at]}: fitness ${figure(fitness[at])}, novelty ${figure(novelty[at])}`;
  if (novelty.every((value) => value === null)) return element("p", { class: "dim" }, "This search measures no novelty.");
  return chart(
    "Novelty against fitness",
    "Each offspring: full dots were taken into the collection, rings were not.",
    { label: "fitness", ...range(fitness) },
    { label: "novelty", ...range(novelty) },
    (across, up) => [
      ...dots(fitness, where(false), across, up, "ring", "var(--dim)", title),
      ...dots(fitness, where(true), across, up, "dot", "var(--blue)", title),
    ],
  );
}

function contributionChart(contribution) {
  const agents = contribution.map((_, agent) => agent);
  return chart(
    "Contribution of each agent",
    "Delivered packets that an agent of the best solution had held, mean over its deployments.",
    { label: "agent", low: -0.7, high: contribution.length - 0.3, ticks: agents.filter((n) => agents.length < 25 || n % 5 === 0) },
    { label: "packets", ...range(contribution, 0) },
    (across, up) =>
      contribution.map((value, agent) =>
        drawn("rect", {
          x: across(agent - 0.35),
          y: up(value),
          width: across(0.7) - across(0),
          height: up(0) - up(value),
          fill: "var(--blue)",
        }),
      ),
  );
}

const LINEAGE_COLUMNS = [["generation"], ["fitness", 3], ["kept", 0], ["copied", 0], ["fresh", 0]];

function showLineage(lineage) {
  if (!lineage.length) {
    place("lineage").replaceChildren();
    return;
  }
  const names = { kept: "rules of the parent", copied: "copied from agents", fresh: "new at random" };
  const head = LINEAGE_COLUMNS.map(([name]) => element("th", { scope: "col", class: "number" }, names[name] ?? name));
  const rows = lineage.map((one) =>
    element("tr", {}, ...LINEAGE_COLUMNS.map(([name, digits = 0]) => element("td", { class: "number" }, figure(one[name], digits)))),
  );
  place("lineage").replaceChildren(
    element("h3", {}, "Lineage of the winner"),
    element("p", { class: "dim" }, "The best solution, its parent, that one's parent, … and where the rules of each came from."),
    element(
      "div", { class: "scroll", tabindex: 0 },
      element("table", {}, element("thead", {}, element("tr", {}, ...head)), element("tbody", {}, ...rows)),
    ),
  );
}
