// A canvas's drawing context that writes SVG, for figures to be downloaded: as much of it as uPlot and plot.js use.

class SvgPath {
  constructor(other) {
    this.d = other?.d ?? "";
  }
  moveTo(x, y) {
    this.d += `M${x} ${y}`;
  }
  lineTo(x, y) {
    this.d += `${this.d ? "L" : "M"}${x} ${y}`; // the first point of a canvas's path is moved to
  }
  rect(x, y, width, height) {
    this.d += `M${x} ${y}h${width}v${height}h${-width}Z`;
  }
  /** Whole circles only. */
  arc(x, y, radius) {
    this.d += `M${x + radius} ${y}a${radius} ${radius} 0 1 0 ${-2 * radius} 0a${radius} ${radius} 0 1 0 ${2 * radius} 0Z`;
  }
  bezierCurveTo(...places) {
    this.d += `C${places.join(" ")}`;
  }
  closePath() {
    this.d += "Z";
  }
}

class SvgContext {
  constructor() {
    this.parts = [];
    this.clips = 0;
    this.saved = [];
    this.state = { transform: "", clip: "", dash: [] };
    Object.assign(this, { fillStyle: "#000", strokeStyle: "#000", lineWidth: 1, globalAlpha: 1, font: "10px sans-serif" });
  }
  save() {
    this.saved.push([{ ...this.state }, this.fillStyle, this.strokeStyle, this.lineWidth, this.globalAlpha]);
  }
  restore() {
    if (this.saved.length) [this.state, this.fillStyle, this.strokeStyle, this.lineWidth, this.globalAlpha] = this.saved.pop();
  }
  translate(x, y) {
    this.state.transform += `translate(${x} ${y})`;
  }
  rotate(angle) {
    this.state.transform += `rotate(${(angle * 180) / Math.PI})`;
  }
  setLineDash(dash) {
    this.state.dash = dash;
  }
  clearRect() {}
  beginPath() {
    this.path = new SvgPath();
  }
  moveTo(x, y) {
    this.path.moveTo(x, y);
  }
  lineTo(x, y) {
    this.path.lineTo(x, y);
  }
  rect(...place) {
    this.path.rect(...place);
  }
  clip(path = this.path) {
    const outer = this.state.clip;
    this.state.clip = `clip-path="url(#c${this.clips})"`;
    this.parts.push(`<clipPath id="c${this.clips++}" ${outer}><path d="${path.d}"/></clipPath>`);
  }
  fill(path = this.path) {
    this.#put("path", `d="${path.d}" fill="${this.fillStyle}"`);
  }
  fillRect(x, y, width, height) {
    this.#put("rect", `x="${x}" y="${y}" width="${width}" height="${height}" fill="${this.fillStyle}"`);
  }
  stroke(path = this.path) {
    const dash = this.state.dash.length ? ` stroke-dasharray="${this.state.dash.join(" ")}"` : "";
    this.#put("path", `d="${path.d}" fill="none" stroke="${this.strokeStyle}" stroke-width="${this.lineWidth}"${dash}`);
  }
  fillText(text, x, y) {
    const anchor = { center: "middle", right: "end", end: "end" }[this.textAlign] ?? "start";
    const [size] = this.font.match(/[\d.]+px/);
    const lower = { top: 0.8, middle: 0.35 }[this.textBaseline] ?? 0;
    const shift = lower * Number.parseFloat(size);
    const style = `font-family="sans-serif" font-size="${size}" text-anchor="${anchor}" fill="${this.fillStyle}"`;
    this.#put("text", `x="${x}" y="${y + shift}" ${style}`, escaped(text));
  }
  #put(tag, attributes, text = "") {
    const alpha = this.globalAlpha < 1 ? ` opacity="${this.globalAlpha}"` : "";
    const transform = this.state.transform ? ` transform="${this.state.transform}"` : "";
    this.parts.push(`<g ${this.state.clip}><${tag} ${attributes}${alpha}${transform}>${text}</${tag}></g>`);
  }
}

function escaped(text) {
  return String(text).replace(/[&<>"]/g, (letter) => `&#${letter.charCodeAt(0)};`);
}

/**
 * The SVG of a figure, in light colours. `draw` makes a uPlot of this size in an element of its own and returns it;
 * `legend` tells the labels and colours of its series.
 */
function svgOf(title, draw, width, height, legend) {
  const context = new SvgContext();
  const { Path2D } = window;
  const { getContext } = HTMLCanvasElement.prototype;
  const { theme } = document.documentElement.dataset;
  let plot, keys;
  try {
    window.Path2D = SvgPath;
    HTMLCanvasElement.prototype.getContext = () => context;
    document.documentElement.dataset.theme = "light";
    plot = draw();
    plot.batch(() => {}); // draws at once; else it would when everything else is done
    keys = legend();
  } finally {
    window.Path2D = Path2D;
    HTMLCanvasElement.prototype.getContext = getContext;
    document.documentElement.dataset.theme = theme;
  }
  plot.destroy();
  const lines = keys.map(({ label, colour }, at) => {
    const y = height + 18 * at;
    return `<rect x="60" y="${y}" width="12" height="12" fill="${colour}"/>${text(label, 78, y + 11)}`;
  });
  const heading = `<title>${escaped(title)}</title>${text(title, 10, -8)}`;
  const scaled = `<g transform="scale(${1 / devicePixelRatio})">${context.parts.join("")}</g>`;
  const below = height + 18 * keys.length + 6;
  const size = `width="${width}" height="${below + 24}" viewBox="0 -24 ${width} ${below + 24}"`;
  return `<svg xmlns="http://www.w3.org/2000/svg" ${size}>${heading}${scaled}${lines.join("")}</svg>`;
}

function text(content, x, y) {
  return `<text x="${x}" y="${y}" font-family="sans-serif" font-size="12px">${escaped(content)}</text>`;
}
