// Charts as SVG: axes with labels, and marks upon them.

const SVG = "http://www.w3.org/2000/svg";
const CHART = { width: 420, height: 250, left: 54, right: 10, top: 10, bottom: 40 };

/** An SVG element. */
function drawn(tag, attributes, text) {
  const made = document.createElementNS(SVG, tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  if (text !== undefined) made.textContent = text;
  return made;
}

/** A figure: `marks` draw on it, given the scales; x and y are { label, low, high, ticks? }. */
function chart(title, caption, x, y, marks) {
  const { width, height, left, right, top, bottom } = CHART;
  const across = scale(x.low, x.high, left, width - right);
  const up = scale(y.low, y.high, height - bottom, top);
  const svg = drawn("svg", { viewBox: `0 0 ${width} ${height}`, role: "img", "aria-label": `${title}. ${caption}` });
  for (const value of x.ticks ?? ticks(x.low, x.high)) {
    const at = across(value);
    svg.append(drawn("line", { x1: at, x2: at, y1: height - bottom, y2: height - bottom + 4, stroke: "var(--ink)" }));
    svg.append(drawn("text", { x: at, y: height - bottom + 16, "text-anchor": "middle" }, short(value)));
  }
  for (const value of y.ticks ?? ticks(y.low, y.high)) {
    const at = up(value);
    svg.append(drawn("line", { x1: left, x2: width - right, y1: at, y2: at, stroke: "var(--rule)", "stroke-width": 0.5 }));
    svg.append(drawn("text", { x: left - 6, y: at + 4, "text-anchor": "end" }, short(value)));
  }
  svg.append(drawn("path", { d: `M${left} ${top}V${height - bottom}H${width - right}`, stroke: "var(--ink)", fill: "none" }));
  svg.append(drawn("text", { x: (left + width - right) / 2, y: height - 6, "text-anchor": "middle" }, x.label));
  const middle = (top + height - bottom) / 2;
  svg.append(drawn("text", { x: 12, y: middle, "text-anchor": "middle", transform: `rotate(-90 12 ${middle})` }, y.label));
  svg.append(...marks(across, up));
  return element("figure", {}, element("h3", {}, title), svg, element("figcaption", {}, caption));
}

function scale(low, high, from, to) {
  return (value) => from + ((value - low) / (high - low || 1)) * (to - from);
}

/** Round values within a range, five or so. */
function ticks(low, high) {
  const rough = (high - low) / 5 || 1;
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((factor) => factor * power).find((size) => size >= rough);
  const found = [];
  for (let number = Math.ceil(low / step - 1e-9); number * step <= high + step * 1e-9; number++) found.push(number * step);
  return found;
}

function short(value) {
  return String(Number(value.toPrecision(6)));
}

/** Least and greatest of the numbers among the values, a little wider; from `least` on at any rate. */
function range(values, least = Infinity) {
  const known = values.filter((value) => value !== null);
  const low = known.reduce((a, b) => Math.min(a, b), least);
  const high = known.reduce((a, b) => Math.max(a, b), least === Infinity ? -Infinity : least);
  if (!Number.isFinite(low)) return { low: 0, high: 1 };
  const room = (high - low || 1) * 0.04;
  return { low: low === least ? low : low - room, high: high + room };
}

/** A line through the points whose y is known; `step`: constant between them. */
function line(xs, ys, across, up, attributes, step = false) {
  let path = "";
  ys.forEach((y, at) => {
    if (y === null) return;
    const to = `${across(xs[at]).toFixed(1)} ${up(y).toFixed(1)}`;
    path += !path ? `M${to}` : step ? `H${across(xs[at]).toFixed(1)}V${up(y).toFixed(1)}` : `L${to}`;
  });
  return drawn("path", { d: path, fill: "none", "stroke-width": 1.5, ...attributes });
}

/** A mark at each point whose y is known: "dot" or "ring". */
function dots(xs, ys, across, up, shape, colour, title) {
  const style = shape === "dot" ? { fill: colour } : { fill: "none", stroke: colour };
  return ys.flatMap((y, at) => {
    if (y === null || xs[at] === null) return [];
    const mark = drawn("circle", { cx: across(xs[at]).toFixed(1), cy: up(y).toFixed(1), r: 2, ...style });
    if (title) mark.append(drawn("title", {}, title(at)));
    return [mark];
  });
}
