// The replay: play, pause, scrub, speed, and what an agent does at the moment.

const SPEEDS = [1, 2, 5, 10, 20, 40]; // frames per second

let player = null;

function showReplay(replay, rules, one) {
  player?.stop();
  player = null;
  if (!replay) {
    place("replay").replaceChildren(element("p", { class: "dim" }, "This instance is not replayed on this page."));
    return;
  }
  player = new Player(replay, rules, one);
  place("replay").replaceChildren(...player.parts());
  player.show(0);
}

class Player {
  constructor(replay, rules, one) {
    this.replay = replay;
    this.rules = rules;
    this.one = one;
    this.frame = 0;
    this.watched = 0;
    this.shown = { links: true, paths: true, sent: true };
    this.playing = false;
    this.canvas = element("canvas", {
      tabindex: 0, role: "img", "aria-label": "The swarm at the moment; what it does is told below",
      keydown: (event) => this.key(event), pointermove: (event) => this.point(event), click: (event) => this.point(event),
    });
    this.scene = new Scene(this.canvas, replay);
    this.slider = element("input", {
      type: "range", min: 0, max: replay.frames - 1, value: 0, "aria-label": "time-step",
      input: (event) => this.show(Number(event.target.value)),
    });
    this.button = element("button", { type: "button", id: "play", click: () => this.toggle() }, "Play");
    this.speed = element("select", { "aria-label": "frames per second" });
    this.speed.append(...SPEEDS.map((speed) => element("option", { value: speed }, `${speed} frames/s`)));
    this.speed.value = 20;
    this.agent = element("select", { "aria-label": "agent", change: (event) => this.watch(Number(event.target.value)) });
    for (let agent = 0; agent < replay.agents; agent++) this.agent.append(element("option", { value: agent }, `agent ${agent}`));
    this.time = element("output", { id: "time" });
    this.said = element("div", { class: "watched", id: "watched" });
    this.redraw = () => this.show(this.frame);
    this.resizing = new ResizeObserver(this.redraw);
    this.resizing.observe(this.canvas);
    document.addEventListener("themechange", this.redraw);
  }

  parts() {
    const { steps, frames, time_limit, fitness, moments } = this.replay;
    const every = frames > 1 ? moments[1] - moments[0] : 1;
    const step = (by) => element("button", { type: "button", "aria-label": `${Math.abs(by)} frame ${by < 0 ? "back" : "on"}`, click: () => this.show(this.frame + by) }, by < 0 ? "‹" : "›");
    return [
      element("p", {}, `${this.one.of ?? `Fresh deployment ${this.one.deployment} of the best solution in its own world`}: fitness ${figure(fitness)}, ${steps.toLocaleString("en")} of ${time_limit.toLocaleString("en")} time-steps. ${every === 1 ? "Every time-step is shown" : `One time-step in ${every} is shown, with all that was sent since the one before`}.`),
      element("div", { class: "tools" }, this.button, step(-1), step(1), this.slider, this.speed, this.time),
      this.canvas,
      this.legend(),
      element("div", { class: "tools" }, ...Object.keys(this.shown).map((name) => this.box(name)), element("label", {}, "Watch ", this.agent), element("span", { class: "dim" }, "or point at an agent. Keys: space plays, ← → step, Home and End jump, + − change the speed, [ ] change the agent.")),
      this.said,
    ];
  }

  box(name) {
    const label = { links: "who heard whom", paths: "paths", sent: "transmissions" }[name];
    const change = (event) => {
      this.shown[name] = event.target.checked;
      this.redraw();
    };
    return element("label", {}, element("input", { type: "checkbox", checked: "", change }), ` ${label}`);
  }

  legend() {
    const item = (label, ...marks) => {
      const svg = drawn("svg", { viewBox: "0 0 34 10", "aria-hidden": "true" });
      svg.append(...marks);
      return element("li", {}, svg, label);
    };
    const bar = (colour, dashes, width = 2) => drawn("path", { d: "M0 5H34", stroke: `var(${colour})`, "stroke-width": width, "stroke-dasharray": dashes.join(" ") });
    const dot = (fill) => drawn("circle", { cx: 17, cy: 5, r: 4, fill, stroke: "var(--blue)", "stroke-width": 1.5 });
    return element(
      "ul", { class: "legend" },
      ...Object.values(FATES).map(([label, colour, dashes]) => item(label, bar(colour, dashes))),
      item("agent with a packet", dot("var(--blue)")),
      item("without", dot("var(--paper)")),
      ...(this.replay.down.some(Boolean) ? [item("down", dot("var(--weak)"))] : []),
      item("heard each other", bar("--link", [], 1.5)),
      item("path", bar("--trail", [], 1.5)),
    );
  }

  /** Go to a frame. */
  show(frame) {
    const { frames, moments, delivered, waiting, packets, holding, agents } = this.replay;
    this.frame = Math.max(0, Math.min(frames - 1, frame));
    this.slider.value = this.frame;
    let held = 0;
    for (let agent = 0; agent < agents; agent++) held += holding[agent * frames + this.frame];
    this.time.textContent = `time-step ${moments[this.frame].toLocaleString("en")}: delivered ${delivered[this.frame]} of ${packets}, held ${held}, waiting ${waiting[this.frame]}`;
    this.slider.setAttribute("aria-valuetext", this.time.textContent);
    this.scene.draw(this.frame, this.shown, this.watched);
    this.tell();
  }

  /** What the watched agent does. */
  tell() {
    const { frames, rule, action, actions, holding, down } = this.replay;
    const at = this.watched * frames + this.frame;
    const number = rule[at];
    const did = action[at] === 255 ? "acted by no rule" : `did: ${actions[action[at]]}`;
    const text = number < 0 || !this.rules ? null : this.rules.texts[this.rules.text[this.watched * this.rules.rules + number]];
    this.said.replaceChildren(
      element("p", {}, element("strong", {}, `Agent ${this.watched}`), ` ${down[at] ? "is down and " : ""}${holding[at] ? "holds a packet" : "holds nothing"}; in the last time-step it ${did}`),
      element("p", { class: "code" }, text === null ? "no rule was drawn" : `rule ${number}: ${text}`),
    );
  }

  watch(agent) {
    this.watched = (agent + this.replay.agents) % this.replay.agents;
    this.agent.value = this.watched;
    this.redraw();
  }

  point(event) {
    const box = this.canvas.getBoundingClientRect();
    const agent = this.scene.agentAt(this.frame, event.clientX - box.left, event.clientY - box.top);
    if (agent !== null && agent !== this.watched) this.watch(agent);
  }

  toggle() {
    if (this.playing) this.pause();
    else this.play();
  }

  play() {
    if (this.frame === this.replay.frames - 1) this.show(0);
    this.playing = true;
    this.button.textContent = "Pause";
    let [then, due] = [performance.now(), 0];
    const tick = (now) => {
      if (!this.playing) return;
      due += ((now - then) / 1000) * Number(this.speed.value);
      then = now;
      const whole = Math.floor(due);
      due -= whole;
      if (whole) this.show(this.frame + whole);
      if (this.frame === this.replay.frames - 1) this.pause();
      else requestAnimationFrame(tick);
    };
    requestAnimationFrame(tick);
  }

  pause() {
    this.playing = false;
    this.button.textContent = "Play";
  }

  /** Leave the page. */
  stop() {
    this.pause();
    this.resizing.disconnect();
    document.removeEventListener("themechange", this.redraw);
  }

  key(event) {
    const faster = (by) => {
      this.speed.selectedIndex = Math.max(0, Math.min(SPEEDS.length - 1, this.speed.selectedIndex + by));
    };
    const keys = {
      " ": () => this.toggle(),
      ArrowLeft: () => this.show(this.frame - 1),
      ArrowRight: () => this.show(this.frame + 1),
      Home: () => this.show(0),
      End: () => this.show(this.replay.frames - 1),
      "+": () => faster(1),
      "-": () => faster(-1),
      "[": () => this.watch(this.watched - 1),
      "]": () => this.watch(this.watched + 1),
    };
    if (!keys[event.key] || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    keys[event.key]();
  }
}
