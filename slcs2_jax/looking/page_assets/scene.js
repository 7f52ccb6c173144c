// An episode unpacked, and one of its frames drawn on a canvas.

// by number of the fate: name, colour, dashes
const FATES = {
  1: ["delivered", "--delivered", []],
  3: ["lost to the jammer", "--jammed", [1.5, 2.5]],
  4: ["lost to interference", "--interference", [6, 3]],
  5: ["receiver busy", "--refused", [8, 2, 2, 2]],
  2: ["too weak", "--weak", [2, 5]],
};
const MARGIN = 15; // m around everything
const TRAIL_STEPS = 300; // time-steps of each agent's path that are drawn
const ARRAYS = { int32: Int32Array, int16: Int16Array, int8: Int8Array, uint8: Uint8Array };

/** The bytes of a replay as its header with an array for each of the sections. */
function unpackReplay(buffer) {
  const size = new DataView(buffer).getUint32(0, true);
  const replay = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, size)));
  let at = 4 + size;
  for (const [name, kind, length] of replay.sections) {
    const end = at + length * ARRAYS[kind].BYTES_PER_ELEMENT;
    replay[name] = new ARRAYS[kind](buffer.slice(at, end));
    at = end;
  }
  for (const name of ["x", "y", "jammer_x", "jammer_y"]) replay[name] = metres(replay[name], replay);
  return replay;
}

/** Differences from frame to frame, one agent or jammer after another, summed up; m. */
function metres(differences, { frames, unit }) {
  const found = new Float32Array(differences.length);
  const sum = new Int16Array(1); // wraps round as the differences do
  for (let at = 0; at < found.length; at++) {
    sum[0] = (at % frames ? sum[0] : 0) + differences[at];
    found[at] = sum[0] * unit;
  }
  return found;
}

/** Where a node is in a frame: agents, then the source, then the sink; m. */
function nodePlace(replay, node, frame) {
  if (node === replay.agents) return [0, 0];
  if (node > replay.agents) return replay.sink;
  const at = node * replay.frames + frame;
  return [replay.x[at], replay.y[at]];
}

/** Left, right, bottom and top of everything that happens, m. */
function bounds(replay) {
  const xs = [0, replay.sink[0]];
  const ys = [0, replay.sink[1]];
  for (const at of replay.x) xs.push(at);
  for (const at of replay.y) ys.push(at);
  for (const at of replay.jammer_x) xs.push(at);
  for (const at of replay.jammer_y) ys.push(at);
  for (const [at, low, high] of replay.vertical) { xs.push(at); ys.push(low, high); }
  for (const [at, low, high] of replay.horizontal) { ys.push(at); xs.push(low, high); }
  const least = (values) => values.reduce((a, b) => Math.min(a, b)) - MARGIN;
  const most = (values) => values.reduce((a, b) => Math.max(a, b)) + MARGIN;
  return { left: least(xs), right: most(xs), bottom: least(ys), top: most(ys) };
}

/** What draws frames of a replay on a canvas, as large as the page gives it. */
class Scene {
  constructor(canvas, replay) {
    this.canvas = canvas;
    this.replay = replay;
    this.bounds = bounds(replay);
    const { left, right, bottom, top } = this.bounds;
    canvas.style.aspectRatio = `${right - left} / ${top - bottom}`;
  }

  /** From m to pixels of the canvas. */
  point([x, y]) {
    return [(x - this.bounds.left) * this.pixels, (this.bounds.top - y) * this.pixels];
  }

  colour(name) {
    return this.style.getPropertyValue(name);
  }

  /** Draw a frame; `shown`: { links, paths, sent }, `watched`: an agent or null. */
  draw(frame, shown, watched) {
    this.style = getComputedStyle(document.documentElement);
    const density = devicePixelRatio || 1;
    this.canvas.width = this.canvas.clientWidth * density;
    this.canvas.height = this.canvas.clientHeight * density;
    this.pixels = this.canvas.clientWidth / (this.bounds.right - this.bounds.left);
    const pen = this.canvas.getContext("2d");
    pen.scale(density, density);
    pen.font = "12px system-ui, sans-serif";
    pen.textAlign = "center";
    for (let jammer = 0; jammer < this.replay.reach.length; jammer++) this.drawJammer(pen, jammer, frame);
    if (shown.links) this.drawLinks(pen, frame);
    if (shown.paths) this.drawPaths(pen, frame);
    this.drawWorld(pen);
    if (shown.sent) this.drawSent(pen, frame);
    this.drawAgents(pen, frame, watched);
  }

  stroke(pen, points, colour, width, dashes = []) {
    pen.strokeStyle = colour;
    pen.lineWidth = width;
    pen.setLineDash(dashes);
    pen.beginPath();
    points.forEach((point, at) => (at ? pen.lineTo(...point) : pen.moveTo(...point)));
    pen.stroke();
    pen.setLineDash([]);
  }

  drawJammer(pen, jammer, frame) {
    const { jammer_x, jammer_y, reach, jammed, frames } = this.replay;
    const at = jammer * frames + frame;
    const colour = this.colour("--jammed");
    const [x, y] = this.point([jammer_x[at], jammer_y[at]]);
    pen.beginPath();
    pen.arc(x, y, reach[jammer] * this.pixels, 0, 2 * Math.PI);
    if (jammed[at] >= 0) {
      pen.globalAlpha = 0.12;
      pen.fillStyle = colour;
      pen.fill();
      pen.globalAlpha = 1;
    }
    pen.setLineDash([2, 3]);
    pen.strokeStyle = colour;
    pen.stroke();
    pen.setLineDash([]);
    for (const side of [-1, 1]) this.stroke(pen, [[x - 6, y - 6 * side], [x + 6, y + 6 * side]], colour, 4);
    pen.fillStyle = this.colour("--ink");
    const name = reach.length > 1 ? `jammer ${jammer}` : "jammer";
    pen.fillText(jammed[at] >= 0 ? `${name} on ${jammed[at]}` : name, x, y + 20);
  }

  drawWorld(pen) {
    const { vertical, horizontal, thickness, sink } = this.replay;
    const width = Math.max(thickness * this.pixels, 1.2);
    const colour = this.colour("--wall");
    for (const [x, low, high] of vertical) this.stroke(pen, [this.point([x, low]), this.point([x, high])], colour, width);
    for (const [y, low, high] of horizontal) this.stroke(pen, [this.point([low, y]), this.point([high, y])], colour, width);
    pen.fillStyle = this.colour("--ink");
    const [x, y] = this.point([0, 0]);
    pen.fillRect(x - 6, y - 6, 12, 12);
    pen.fillText("source", x, y + 20);
    const [sinkX, sinkY] = this.point(sink);
    pen.beginPath();
    for (const [dx, dy] of [[0, -9], [9, 0], [0, 9], [-9, 0]]) pen.lineTo(sinkX + dx, sinkY + dy);
    pen.fill();
    pen.fillText("sink", sinkX, sinkY + 23);
    this.drawScale(pen);
  }

  /** A bar of 100 m. */
  drawScale(pen) {
    const y = this.canvas.clientHeight - 12;
    this.stroke(pen, [[12, y - 4], [12, y], [12 + 100 * this.pixels, y], [12 + 100 * this.pixels, y - 4]], this.colour("--ink"), 1.2);
    pen.fillText("100 m", 12 + 50 * this.pixels, y - 5);
  }

  drawLinks(pen, frame) {
    const { agents, heard } = this.replay;
    const colour = this.colour("--link");
    const start = frame * Math.ceil(((agents + 2) * agents) / 8);
    for (let node = 0; node < agents + 2; node++) {
      for (let agent = 0; agent < agents; agent++) {
        const bit = node * agents + agent;
        if (!((heard[start + (bit >> 3)] >> (bit & 7)) & 1)) continue;
        this.stroke(pen, [node, agent].map((one) => this.point(nodePlace(this.replay, one, frame))), colour, 1);
      }
    }
  }

  drawPaths(pen, frame) {
    const { agents, moments } = this.replay;
    let first = frame;
    while (first > 0 && moments[frame] - moments[first - 1] <= TRAIL_STEPS) first--;
    const colour = this.colour("--trail");
    for (let agent = 0; agent < agents; agent++) {
      const points = [];
      for (let at = first; at <= frame; at++) points.push(this.point(nodePlace(this.replay, agent, at)));
      this.stroke(pen, points, colour, 1.2);
    }
  }

  drawSent(pen, frame) {
    const { starts, sender, receiver, fate } = this.replay;
    for (let at = starts[frame]; at < starts[frame + 1]; at++) {
      const [, colour, dashes] = FATES[fate[at]];
      const ends = [sender[at], receiver[at]].map((node) => this.point(nodePlace(this.replay, node, frame)));
      this.stroke(pen, ends, this.colour(colour), 2, dashes);
      this.drawHead(pen, ...ends, this.colour(colour));
    }
  }

  drawHead(pen, [x1, y1], [x2, y2], colour) {
    const length = Math.hypot(x2 - x1, y2 - y1);
    if (length < 1) return;
    const [ux, uy] = [(x2 - x1) / length, (y2 - y1) / length];
    const back = Math.min(6, length / 3);
    const tip = [x2 - ux * back, y2 - uy * back];
    const wing = (side) => [tip[0] - 9 * ux - side * 4.5 * uy, tip[1] - 9 * uy + side * 4.5 * ux];
    this.stroke(pen, [wing(1), tip, wing(-1)], colour, 2);
  }

  drawAgents(pen, frame, watched) {
    const { agents, frames, holding, down } = this.replay;
    for (let agent = 0; agent < agents; agent++) {
      const [x, y] = this.point(nodePlace(this.replay, agent, frame));
      pen.beginPath();
      pen.arc(x, y, 5, 0, 2 * Math.PI);
      const at = agent * frames + frame;
      pen.fillStyle = this.colour(down[at] ? "--weak" : holding[at] ? "--blue" : "--paper");
      pen.fill();
      pen.strokeStyle = this.colour("--blue");
      pen.lineWidth = 1.5;
      pen.stroke();
      if (agent !== watched) continue;
      pen.beginPath();
      pen.arc(x, y, 10, 0, 2 * Math.PI);
      pen.strokeStyle = this.colour("--ink");
      pen.stroke();
    }
  }

  /** The agent nearest to a place on the canvas, if it is near. */
  agentAt(frame, x, y) {
    let [nearest, least] = [null, 18];
    for (let agent = 0; agent < this.replay.agents; agent++) {
      const [ax, ay] = this.point(nodePlace(this.replay, agent, frame));
      const away = Math.hypot(ax - x, ay - y);
      if (away < least) [nearest, least] = [agent, away];
    }
    return nearest;
  }
}
