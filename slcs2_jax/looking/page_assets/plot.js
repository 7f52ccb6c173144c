// Figures: drawn by uPlot, each with its SVG and its data to be downloaded.
//
// A figure is { title, caption, name, x, y, xs, series, level, cells }: x and y are { label, names }, `names` for an axis
// of places instead of numbers; a series is { label, ys, low, high, kind, colour, like }, `kind` one of KINDS, `low` and
// `high` the ends of an interval, `like` the number of a series whose colour it has; `level` is the height of a horizontal line. `cells` (rows of numbers, lowest first) makes it
// a map of colours, without series.

const INKS = ["--blue", "--interference", "--delivered", "--jammed", "--refused", "--weak"];
const DASHES = [[], [7, 3], [2, 3], [9, 3, 2, 3], [4, 4], [12, 3]];
const KINDS = {
  line: () => uPlot.paths.linear(),
  steps: () => uPlot.paths.stepped({ align: 1 }),
  bars: () => uPlot.paths.bars({ size: [0.7] }),
  dots: () => () => null,
  rings: () => () => null,
  joined: () => uPlot.paths.linear(), // dots, and a line from each to the next
};
const HEIGHT = 210; // without what stands below the x axis
const [LEVEL, SLANTED] = [50, 100]; // for its names, side by side or, of many, slanted

function ink(name) {
  return getComputedStyle(document.documentElement).getPropertyValue(name).trim();
}

/** The element of a figure. */
function plot(figure) {
  const frame = element("div", { class: "plot", role: "img", "aria-label": `${figure.title}. ${figure.caption}` });
  const apart = spread(figure);
  const draw = (into, width) => new uPlot(options(apart, width), data(apart), into);
  let shown = null;
  const show = () => {
    shown?.destroy();
    shown = draw(frame, Math.max(frame.clientWidth, 220));
  };
  new ResizeObserver(() => (shown && shown.width === Math.max(frame.clientWidth, 220)) || show()).observe(frame);
  document.addEventListener("themechange", () => frame.isConnected && show());
  const size = () => Math.max(frame.clientWidth, 480);
  const legend = () => (figure.series ?? []).map((one, at) => ({ label: one.label, colour: inkOf(one, at) }));
  const svg = () => svgOf(figure.title, () => draw(element("div"), size()), size(), heightOf(figure), legend);
  return element(
    "figure", {},
    element("h3", {}, figure.title),
    frame,
    element(
      "figcaption", {}, figure.caption, " ",
      element("button", { type: "button", click: () => download(`${figure.name}.svg`, svg(), "image/svg+xml") }, "SVG"),
      " ",
      element("button", { type: "button", click: () => download(`${figure.name}.csv`, figureCsv(figure), "text/csv") }, "CSV"),
    ),
  );
}

/** At places, series stand beside one another, each in rows of its own. */
function spread(figure) {
  const { x, series = [] } = figure;
  if (!x.names || series.length < 2) return figure;
  const rows = x.names.flatMap((_, at) => series.map((_, number) => [at, number]));
  const own = (number, values) => values && rows.map(([at, whose]) => (whose === number ? values[at] : null));
  return {
    ...figure,
    xs: rows.map(([at, number]) => at + ((number + 0.5) / series.length - 0.5) * 0.6),
    series: series.map((one, number) => ({ ...one, ys: own(number, one.ys), low: own(number, one.low), high: own(number, one.high) })),
  };
}

function below(figure) {
  return figure.x.names?.length > 5 && figure.x.names.some((name) => name.length > 3) ? SLANTED : LEVEL;
}

function heightOf(figure) {
  return HEIGHT + below(figure);
}

function download(name, text, type) {
  const link = element("a", { href: URL.createObjectURL(new Blob([text], { type })), download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 60_000);
}

function xsOf(figure) {
  return figure.xs ?? figure.x.names.map((_, at) => at);
}

/** uPlot's columns: the x, then of each series its y and, where there are such, the ends of its intervals. */
function data(figure) {
  const columns = (figure.series ?? []).flatMap((one) => (one.low ? [one.ys, one.high, one.low] : [one.ys]));
  return [xsOf(figure), ...columns];
}

function options(figure, width) {
  const series = [{ label: figure.x.label, value: (_, value) => said(value, figure.x) }];
  const bands = [];
  const edges = {}; // columns of the intervals' ends, by the series' own column
  (figure.series ?? []).forEach((one, number) => {
    const column = series.push(seriesOf(one, number, figure)) - 1;
    if (!one.low) return;
    edges[column] = [column + 1, column + 2];
    series.push(edgeOf(), edgeOf());
    if (one.kind === "line") bands.push({ series: edges[column], fill: `${series[column].stroke}2a` });
  });
  return {
    width,
    height: heightOf(figure),
    series,
    bands,
    scales: { x: { time: false, range: rangeOf(figure.x) }, y: { range: rangeOf(figure.y, figure.level) } },
    axes: [axisOf(figure.x, !figure.cells, below(figure)), axisOf(figure.y, !figure.cells, figure.y.names ? 80 : 56)],
    legend: { show: !figure.cells },
    cursor: { points: { show: !figure.cells } },
    hooks: {
      drawClear: [(u) => figure.cells && drawCells(u, figure.cells)],
      draw: [(u) => figure.level !== undefined && drawLevel(u, figure.level), (u) => drawIntervals(u, figure, edges)],
      setSeries: [
        (u, column, changed) => {
          if (changed.show !== undefined) edges[column]?.forEach((edge) => u.setSeries(edge, { show: changed.show }));
        },
      ],
    },
  };
}

function inkOf(one, number) {
  return ink(one.colour ?? INKS[(one.like ?? number) % INKS.length]);
}

function seriesOf(one, number, figure) {
  const stroke = inkOf(one, number);
  const marked = ["dots", "rings", "joined"].includes(one.kind);
  return {
    label: one.label,
    stroke,
    width: one.kind === "bars" ? 0 : 1.6,
    fill: one.kind === "bars" ? stroke : undefined,
    dash: marked && one.kind !== "joined" ? [] : DASHES[one.dash ?? number % DASHES.length],
    spanGaps: true,
    paths: KINDS[one.kind](),
    points: { show: marked, size: one.kind === "joined" || figure.x.names ? 7 : 4, fill: one.kind === "rings" ? ink("--paper") : stroke },
    value: (_, value) => (value === null || value === undefined ? "–" : short(value)),
  };
}

/** An interval's end: in the scale and in the data, but not in the legend; drawn as a band or by drawIntervals. */
function edgeOf() {
  return { class: "edge", width: 0, paths: KINDS.line(), points: { show: false }, spanGaps: true };
}

function axisOf(axis, grid, size) {
  const rule = ink("--rule");
  const found = { label: axis.label, stroke: ink("--ink"), grid: { show: grid, stroke: rule, width: 0.5 }, ticks: { stroke: rule, size: 5 }, size };
  if (size === SLANTED) found.rotate = 35;
  if (axis.names) Object.assign(found, { splits: axis.names.map((_, at) => at), values: (_, at) => at.map((one) => axis.names[one] ?? "") });
  return found;
}

/** A little more than the numbers take, and the level with them. */
function rangeOf(axis, level) {
  if (axis.names) return [-0.5, axis.names.length - 0.5];
  return (_, least, greatest) => {
    if (least === null) return [0, 1];
    const [low, high] = [Math.min(least, level ?? least), Math.max(greatest, level ?? greatest)];
    const room = (high - low || 1) * 0.05;
    return [low - room, high + room];
  };
}

function said(value, axis) {
  return value === null || value === undefined ? "–" : (axis.names?.[Math.round(value)] ?? short(value));
}

function short(value) {
  return String(Number(value.toPrecision(5)));
}

function drawLevel(u, level) {
  const y = u.valToPos(level, "y", true);
  Object.assign(u.ctx, { strokeStyle: ink("--dim"), lineWidth: devicePixelRatio });
  stroke(u.ctx, u.bbox.left, y, u.bbox.left + u.bbox.width, y);
}

function stroke(ctx, x1, y1, x2, y2) {
  ctx.beginPath();
  ctx.moveTo(x1, y1);
  ctx.lineTo(x2, y2);
  ctx.stroke();
}

/** Intervals of single values as bars with caps. */
function drawIntervals(u, figure, edges) {
  for (const [column, [high, low]] of Object.entries(edges)) {
    if (!u.series[column].show || u.bands.some((band) => band.series[0] === high)) continue;
    Object.assign(u.ctx, { strokeStyle: u.series[column].stroke(), lineWidth: 1.5 * devicePixelRatio });
    u.data[0].forEach((at, row) => {
      if (typeof u.data[low][row] !== "number") return;
      const [x, top, bottom] = [u.valToPos(at, "x", true), u.valToPos(u.data[high][row], "y", true), u.valToPos(u.data[low][row], "y", true)];
      const cap = 4 * devicePixelRatio;
      for (const line of [[x, top, x, bottom], [x - cap, top, x + cap, top], [x - cap, bottom, x + cap, bottom]]) stroke(u.ctx, ...line);
    });
  }
}

/** Each cell in a colour between that of the least and that of the greatest value, with its value. */
function drawCells(u, cells) {
  const known = cells.flat().filter((value) => value !== null);
  const [low, high] = [Math.min(...known), Math.max(...known)];
  cells.forEach((row, y) =>
    row.forEach((value, x) => {
      if (value === null) return;
      const share = (value - low) / (high - low || 1);
      const [left, top] = [u.valToPos(x - 0.5, "x", true), u.valToPos(y + 0.5, "y", true)];
      const [right, bottom] = [u.valToPos(x + 0.5, "x", true), u.valToPos(y - 0.5, "y", true)];
      u.ctx.fillStyle = `rgb(${[0, 1, 2].map((c) => Math.round([0, 34, 78][c] + share * ([254, 232, 56][c] - [0, 34, 78][c]))).join(",")})`;
      u.ctx.fillRect(left, top, right - left, bottom - top);
      Object.assign(u.ctx, { fillStyle: share < 0.5 ? "#ffffff" : "#000000", textAlign: "center", textBaseline: "middle", font: `${12 * devicePixelRatio}px sans-serif` });
      u.ctx.fillText(value.toFixed(3), (left + right) / 2, (top + bottom) / 2);
    }),
  );
}

function figureCsv(figure) {
  const cell = (value) => {
    const text = value === null || value === undefined ? "" : String(value);
    return /[",\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
  };
  const line = (values) => values.map(cell).join(",");
  if (figure.cells) {
    const head = [figure.y.label, ...figure.x.names.map((name) => `${figure.x.label}: ${name}`)];
    return [head, ...figure.cells.map((row, at) => [figure.y.names[at], ...row])].map(line).join("\n") + "\n";
  }
  const head = [figure.x.label, ...figure.series.flatMap(({ label, low }) => (low ? [label, `${label} high`, `${label} low`] : [label]))];
  const [xs, ...columns] = data(figure);
  return [head, ...xs.map((x, row) => [figure.x.names?.[x] ?? x, ...columns.map((column) => column[row])])].map(line).join("\n") + "\n";
}
