// The search of an instance: fitness, collection, novelty against fitness, contribution, and the winner's ancestors.

const SMOOTHED = 25; // generations of the running mean

function showCurves(one, history) {
  const { columns } = history;
  const figures = columns.generation.length ? [fitnessFigure(history), sizeFigure(columns), noveltyFigure(columns)] : [];
  if (history.contribution.length) figures.push(contributionFigure(history.contribution));
  const made = figures.filter(Boolean).map(plot);
  if (!columns.generation.length) made.unshift(element("p", { class: "note" }, "No generation is finished yet."));
  place("search").replaceChildren(...made);
}

function fitnessFigure({ of, columns }) {
  const { generation, fitness, best } = columns;
  const thinned = of > generation.length ? ` ${generation.length} of ${of} generations are drawn.` : "";
  return {
    title: "Fitness of the best and of the population",
    caption: `Best so far in the search; each generation's offspring, mean over its deployments, and their running mean over ${SMOOTHED}.${thinned}`,
    name: "fitness",
    x: { label: "generation" },
    y: { label: "fitness" },
    xs: generation,
    series: [
      { label: "offspring", ys: fitness, kind: "dots", colour: "--trail" },
      { label: "running mean", ys: running(fitness), kind: "line", colour: "--interference", dash: 1 },
      { label: "best so far", ys: best, kind: "steps", colour: "--blue", dash: 0 },
    ],
  };
}

/** Mean of each value and those before it, SMOOTHED in all. */
function running(values) {
  return values.map((_, at) => {
    const some = values.slice(Math.max(0, at - SMOOTHED + 1), at + 1);
    return some.reduce((a, b) => a + b, 0) / some.length;
  });
}

function sizeFigure(columns) {
  return {
    title: "Collection",
    caption: "Solutions that the collection holds after each generation.",
    name: "collection",
    x: { label: "generation" },
    y: { label: "solutions" },
    xs: columns.generation,
    series: [{ label: "solutions", ys: columns.size, kind: "steps" }],
  };
}

/** None of a search that measures no novelty. */
function noveltyFigure({ novelty, fitness, accepted }) {
  if (novelty.every((value) => value === null)) return null;
  const order = fitness.map((_, at) => at).sort((a, b) => fitness[a] - fitness[b]);
  const where = (wanted) => order.map((at) => (accepted[at] === wanted ? novelty[at] : null));
  return {
    title: "Novelty against fitness",
    caption: "Each offspring: full dots were taken into the collection, rings were not.",
    name: "novelty",
    x: { label: "fitness" },
    y: { label: "novelty" },
    xs: order.map((at) => fitness[at]),
    series: [
      { label: "not taken", ys: where(false), kind: "rings", colour: "--dim" },
      { label: "taken", ys: where(true), kind: "dots", colour: "--blue" },
    ],
  };
}

function contributionFigure(contribution) {
  return {
    title: "Contribution of each agent",
    caption: "Delivered packets that an agent of the best solution had held, mean over its deployments.",
    name: "contribution",
    x: { label: "agent", names: contribution.map((_, agent) => String(agent)) },
    y: { label: "packets" },
    series: [{ label: "packets", ys: contribution, kind: "bars" }],
  };
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
