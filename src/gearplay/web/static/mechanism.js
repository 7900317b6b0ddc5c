// The mechanism in motion, a drawing for each model: gears, shafts in their sleeves, forces; small motions magnified.

import { boxOf, outline, phases, pitchPoint, rimOf } from "./gears.js";
import { paint } from "./painting.js";
import { style } from "./colors.js";

/** Number of the frame at a time [s]; frames are evenly spaced. */
export function frameAt(t, time) {
  const share = (time - t[0]) / (t[t.length - 1] - t[0] || 1);
  return Math.max(0, Math.min(t.length - 1, Math.round(share * (t.length - 1))));
}

export class Stage {
  constructor(place, onTime) {
    this.place = place;
    this.onTime = onTime;
    this.panes = [];
    this.at = 0;
    this.speed = 0.05;
    this.magnify = 1;
    this.turning = false; // whether carriers turn, or are held
    this.look = {}; // names of the sleeve and the mesh in the close-ups
    this.last = performance.now();
    this.inView = true;
    new ResizeObserver(() => this.draw()).observe(place);
    new IntersectionObserver((changes) => { this.inView = changes.at(-1).isIntersecting; }).observe(place);
    this.playing = !matchMedia("(prefers-reduced-motion: reduce)").matches;
  }

  get playing() { return this.plays; }

  /** Play or pause; a paused browser is not woken for frames. */
  set playing(plays) {
    const begins = plays && !this.plays;
    this.plays = plays;
    if (!begins) return;
    this.last = performance.now();
    const tick = (now) => {
      if (!this.plays) { this.ticking = false; return; }
      requestAnimationFrame(tick);
      this.step(now);
    };
    if (!this.ticking) requestAnimationFrame(tick);
    this.ticking = true;
  }

  show(result) {
    this.result = result;
    this.mechanism = { carried: [], couplings: [], supports: [], axes: [], ...result.mechanism };
    const models = Object.keys(result.models);
    if (this.panes.map((pane) => pane.model).join() !== models.join()) {
      this.place.replaceChildren();
      this.panes = models.map((model) => {
        const figure = document.createElement("figure");
        const canvas = document.createElement("canvas");
        canvas.setAttribute("role", "img");
        canvas.setAttribute("aria-label", `The mechanism in motion, ${model} model`);
        const caption = document.createElement("figcaption");
        caption.textContent = model;
        caption.className = `${model}-text`;
        figure.append(canvas, caption);
        this.place.append(figure);
        return { model, canvas, context: canvas.getContext("2d") };
      });
    }
    this.colors = Object.fromEntries([...models, "ink", "soft", "line", "paper", "gear1", "gear2", "alert"].map((name) => [name, style(name)]));
    this.phases = phases(this.mechanism);
    this.paths = new Map();
    const [left, right, low, high] = boxOf(this.mechanism.gears);
    this.whole = { x: (left + right) / 2, y: (low + high) / 2, width: right - left, height: high - low, named: true };
    const times = models.map((model) => result.models[model].frames.t).filter((t) => t.length);
    this.span = times.length ? [Math.min(...times.map((t) => t[0])), Math.max(...times.map((t) => t[t.length - 1]))] : [0, 1];
    this.peak = 1e-9;
    for (const model of models) {
      for (const key of ["sleeves", "meshes"]) for (const value of result.models[model].frames[key]) this.peak = Math.max(this.peak, Math.abs(value));
    }
    this.draw();
  }

  /** How many times small motions are drawn larger: the slider times what makes a clearance a quarter of a module. */
  get factor() {
    const { gears, sleeves, meshes } = this.mechanism;
    const module = gears.find((gear) => gear.module)?.module ?? 0.01;
    const small = Math.max(1e-7, ...sleeves.map((each) => each.clearance), ...meshes.map((each) => each.backlash));
    return (this.magnify * 0.25 * module) / small;
  }

  step(now) {
    const passed = Math.min(0.1, (now - this.last) / 1000);
    this.last = now;
    if (!this.result || !this.playing || document.hidden) return;
    const length = this.span[1] - this.span[0];
    this.at = (this.at + (passed * this.speed) / Math.max(length, 1e-9)) % 1;
    if (this.inView) this.draw();
    this.onTime();
  }

  get time() { return this.span[0] + this.at * (this.span[1] - this.span[0]); }

  draw() {
    if (!this.result) return;
    for (const pane of this.panes) this.pane(pane);
  }

  /** Draw one model: the whole mechanism, and beside it close-ups of the sleeve and the mesh that are looked at. */
  pane({ model, canvas, context: c }) {
    const { t } = this.result.models[model].frames;
    if (!t.length) return;
    const ratio = window.devicePixelRatio || 1;
    if (!canvas.clientWidth) return; // on a tab that is not shown
    const [width, height] = [Math.round(canvas.clientWidth * ratio), Math.round(canvas.clientHeight * ratio)];
    if (canvas.width !== width || canvas.height !== height) { canvas.width = width; canvas.height = height; }
    const view = { ...this.result.models[model].frames, ...this.colors, i: frameAt(t, this.time), color: this.colors[model] };
    const close = [this.sleeveWindow(view), this.meshWindow()].filter((each) => each);
    const column = close.length ? Math.round(Math.min(0.38 * width, 0.55 * height)) : 0;
    c.setTransform(1, 0, 0, 1, 0, 0);
    c.clearRect(0, 0, width, height);
    paint(c, this, view, [0, 0, width - column, height], this.whole, ratio);
    close.forEach((each, k) => {
      const place = [width - column, (k * height) / close.length, column, height / close.length];
      paint(c, this, view, place, each, ratio);
      c.strokeStyle = view.line;
      c.lineWidth = ratio;
      c.strokeRect(...place);
      c.font = `${12 * ratio}px system-ui, sans-serif`;
      c.fillStyle = view.paper;
      c.fillRect(place[0] + ratio, place[1] + ratio, c.measureText(each.words).width + 10 * ratio, 20 * ratio);
      c.fillStyle = view.soft;
      c.fillText(each.words, place[0] + 6 * ratio, place[1] + 15 * ratio);
    });
  }

  /** Return the drawing as it stands, all models with a title over them, as PNG. */
  picture(title) {
    const ratio = window.devicePixelRatio || 1;
    const [gap, head] = [10 * ratio, 64 * ratio];
    const made = document.createElement("canvas");
    made.width = this.panes.reduce((sum, { canvas }) => sum + canvas.width + gap, gap);
    made.height = Math.max(...this.panes.map(({ canvas }) => canvas.height)) + head + gap;
    const c = made.getContext("2d");
    c.fillStyle = this.colors.paper;
    c.fillRect(0, 0, made.width, made.height);
    c.font = `600 ${15 * ratio}px system-ui, sans-serif`;
    c.fillStyle = this.colors.ink;
    c.fillText(`${title}; ${this.time.toFixed(4)} s, clearances ${this.factor.toPrecision(3)} times as large`, gap, 22 * ratio, made.width - 2 * gap);
    let left = gap;
    for (const { canvas, model } of this.panes) {
      c.fillStyle = this.colors[model];
      c.fillText(model, left, 50 * ratio);
      c.drawImage(canvas, left, head);
      left += canvas.width + gap;
    }
    return new Promise((resolve) => { made.toBlob(resolve, "image/png"); });
  }

  /** The window about the bush of the sleeve that is looked at, in a frame. */
  sleeveWindow({ bushes, t, i }) {
    const { gears, sleeves } = this.mechanism;
    const k = Math.max(0, sleeves.findIndex((each) => each.name === this.look.sleeve));
    const sleeve = sleeves[k];
    const gear = sleeve && gears.find((each) => each.rotor === sleeve.name);
    if (!gear) return null;
    const play = Math.max(this.factor * sleeve.clearance, 0.02 * gear.shaft);
    const shaft = sleeve.clearance > 0 ? Math.min(2.5 * play, gear.shaft) : gear.shaft; // so large that its play is seen well
    const span = sleeve.clearance > 0 ? 2.4 * (shaft + play) : 4 * shaft;
    const [dx, dy] = [0, 1].map((axis) => this.factor * bushes[(2 * k + axis) * t.length + i]);
    return { x: gear.x + dx, y: gear.y + dy, width: span, height: span, shaft, words: `${sleeve.clearance > 0 ? sleeve.kind : "bearing"} of ${sleeve.name}` };
  }

  meshWindow() {
    const { gears, meshes } = this.mechanism;
    const mesh = meshes.find((each) => each.name === this.look.mesh) ?? meshes[0];
    if (!mesh) return null;
    const [a, b] = [mesh.driver, mesh.driven].map((name) => gears.find((gear) => gear.name === name));
    const [x, y] = pitchPoint(a, b);
    const span = 3.6 * Math.PI * a.module;
    return { x, y, width: span, height: span, words: `mesh ${mesh.name}` };
  }

  /** Outline of a gear with its backlash drawn; kept, since only the magnification changes it. */
  outlineOf(gear) {
    const gap = this.factor * Math.max(0, ...this.mechanism.meshes.filter((m) => m.driver === gear.name || m.driven === gear.name).map((m) => m.backlash));
    const key = `${gear.name} ${gap.toPrecision(3)}`;
    if (!this.paths.has(key)) {
      const teeth = outline(gear, Math.min(gap, 0.8 * Math.PI * gear.module));
      const path = new Path2D();
      if (gear.internal) path.arc(0, 0, rimOf(gear), 0, 2 * Math.PI);
      path.addPath(teeth);
      this.paths.set(key, path);
    }
    return this.paths.get(key);
  }
}
