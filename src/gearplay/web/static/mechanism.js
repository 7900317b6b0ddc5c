// The mechanism in motion: gears with involute teeth, shafts in their sleeves, forces; small motions magnified.

import { boxOf, drawAxes, drawLabels, rimOf, shaftOf } from "./labels.js";
import { style } from "./colors.js";

const involute = (alpha) => Math.tan(alpha) - alpha;

/** Outline of a gear about its centre; a ring's is that of its spaces. `gap` is the drawn backlash [m]. */
function outline(gear, gap) {
  const { teeth: z, module: m, pressure_angle: alpha, internal } = gear;
  const r = 0.5 * m * z;
  const base = r * Math.cos(alpha);
  const tip = r + (internal ? gear.dedendum : gear.addendum) * m;
  const root = r - (internal ? gear.addendum : gear.dedendum) * m;
  const half = Math.PI / (2 * z) + ((internal ? 1 : -1) * gap) / (4 * r);
  const flank = [];
  for (let i = 0; i <= 6; i++) {
    const rho = Math.max(root, base) + ((tip - Math.max(root, base)) * i) / 6;
    const at = half + involute(alpha) - involute(Math.acos(Math.min(1, base / rho)));
    flank.push([rho, Math.max(at, 0.02 / z)]);
  }
  if (root < base) flank.unshift([root, flank[0][1]]);
  const path = new Path2D();
  for (let k = 0; k < z; k++) {
    const middle = (2 * Math.PI * k) / z;
    for (const [rho, at] of flank) point(path, rho, middle - at, k === 0 && rho === flank[0][0]);
    for (const [rho, at] of [...flank].reverse()) point(path, rho, middle + at, false);
  }
  path.closePath();
  return path;
}

function point(path, rho, angle, first) {
  const [x, y] = [rho * Math.cos(angle), rho * Math.sin(angle)];
  if (first) path.moveTo(x, y); else path.lineTo(x, y);
}

/** Turn every gear so that teeth meet spaces at its mesh: phases at t = 0, by the meshes in their order. */
function phases(mechanism) {
  const gears = new Map(mechanism.gears.map((gear) => [gear.name, gear]));
  const found = new Map();
  for (let round = 0; round < mechanism.meshes.length + 1; round++) {
    for (const mesh of mechanism.meshes) {
      let [a, b] = [gears.get(mesh.driver), gears.get(mesh.driven)];
      if (!found.has(a.name) && !found.has(b.name)) { if (round === 0 && found.size) continue; found.set(a.name, toward(a, b)); }
      if (found.has(b.name) && !found.has(a.name)) [a, b] = [b, a];
      if (found.has(b.name)) continue;
      const [ra, rb] = [0.5 * a.module * a.teeth, 0.5 * b.module * b.teeth];
      const pitch = Math.PI * a.module;
      const beta = toward(a, b);
      let arc = (found.get(a.name) - beta) * ra;
      arc -= pitch * Math.round(arc / pitch);
      found.set(b.name, a.internal || b.internal ? beta + arc / rb : beta + Math.PI - arc / rb + Math.PI / b.teeth);
    }
  }
  return found;
}

/** Direction from gear a's centre to the pitch point with b. */
function toward(a, b) {
  const angle = Math.atan2(b.y - a.y, b.x - a.x);
  if (a.internal) return angle;
  return b.internal ? angle + Math.PI : angle;
}

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
    this.playing = !matchMedia("(prefers-reduced-motion: reduce)").matches;
    this.at = 0;
    this.speed = 0.05;
    this.magnify = 1;
    this.turning = false; // whether carriers turn, or are held
    this.look = {}; // names of the sleeve and the mesh in the close-ups
    this.last = performance.now();
    new ResizeObserver(() => this.draw()).observe(place);
    const tick = (now) => { this.step(now); requestAnimationFrame(tick); };
    requestAnimationFrame(tick);
  }

  show(result) {
    this.result = result;
    this.mechanism = { carried: [], couplings: [], ...result.mechanism };
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
    this.draw();
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
    const close = [this.sleeveWindow(), this.meshWindow()].filter((each) => each);
    const column = close.length ? Math.round(Math.min(0.38 * width, 0.55 * height)) : 0;
    c.setTransform(1, 0, 0, 1, 0, 0);
    c.clearRect(0, 0, width, height);
    this.paint(c, view, [0, 0, width - column, height], this.whole, ratio);
    close.forEach((each, k) => {
      const place = [width - column, (k * height) / close.length, column, height / close.length];
      this.paint(c, view, place, each, ratio);
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

  sleeveWindow() {
    const { gears, sleeves } = this.mechanism;
    const sleeve = sleeves.find((each) => each.name === this.look.sleeve) ?? sleeves[0];
    const gear = sleeve && gears.find((each) => each.rotor === sleeve.name);
    if (!gear) return null;
    const play = Math.max(this.factor * sleeve.clearance, 0.02 * shaftOf(gear));
    const shaft = sleeve.clearance > 0 ? Math.min(2.5 * play, shaftOf(gear)) : shaftOf(gear); // so large that its play is seen well
    const span = sleeve.clearance > 0 ? 2.4 * (shaft + play) : 4 * shaft;
    return { x: gear.x, y: gear.y, width: span, height: span, shaft, words: `${sleeve.clearance > 0 ? "sleeve" : "bearing"} of ${sleeve.name}` };
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

  /** Paint what lies in a window of the plane [m] into a place of the canvas [px]. */
  paint(c, view, [x0, y0, w, h], { x, y, width, height, shaft: drawn, named }, ratio) {
    const { gears, sleeves, meshes } = this.mechanism;
    const { i, t, turns, orbit, rotors, sleeves: pressed, meshes: flanks } = view;
    const scale = 0.96 * Math.min(w / width, h / height);
    const [M, n, thin, reach] = [this.factor, t.length, (1.2 * ratio) / scale, (0.3 * Math.min(w, h)) / scale];
    c.save();
    c.setTransform(1, 0, 0, 1, 0, 0);
    c.beginPath();
    c.rect(x0, y0, w, h);
    c.clip();
    c.setTransform(scale, 0, 0, -scale, x0 + w / 2 - scale * x, y0 + h / 2 + scale * y);
    const at = (k) => [rotors[3 * k * n + i], rotors[(3 * k + 1) * n + i], rotors[(3 * k + 2) * n + i]];
    const carried = this.mechanism.carried ?? [];
    /** Draw what belongs to a rotor, its set turned with its carrier where that is wanted. */
    const within = (index, draw) => {
      const angle = this.turning ? orbit[index * n + i] : 0;
      if (!angle) return draw();
      const axis = this.axisOf(index);
      c.save();
      c.translate(axis.x, axis.y);
      c.rotate(angle);
      c.translate(-axis.x, -axis.y);
      draw();
      c.restore();
    };
    const layers = [...gears].filter((gear) => gear.teeth && gear.module).sort((a, b) => rimOf(b) - rimOf(a)); // small before large
    layers.forEach((gear, k) => within(gear.index, () => {
      const [dx, dy, theta] = at(gear.index);
      const outlined = this.outlineOf(gear);
      c.save();
      c.translate(gear.x + M * dx, gear.y + M * dy);
      c.rotate((this.phases.get(gear.name) ?? 0) + turns[gear.index * n + i] + M * theta);
      c.lineWidth = thin;
      c.fillStyle = k % 2 ? view.gear2 : view.gear1;
      c.fill(outlined, "evenodd");
      c.strokeStyle = view.ink;
      c.stroke(outlined);
      c.restore();
    }));
    if (named) for (const { rotor, on } of carried) { // arms of a carrier
      const [pin, hub] = [rotor, on].map((name) => gears.find((gear) => gear.rotor === name));
      within(pin.index, () => {
        const [dx, dy] = at(hub.index);
        c.strokeStyle = view.soft;
        c.globalAlpha = 0.55;
        c.lineCap = "round";
        c.lineWidth = 0.9 * shaftOf(pin);
        c.beginPath();
        c.moveTo(hub.x + M * dx, hub.y + M * dy);
        c.lineTo(pin.x + M * dx, pin.y + M * dy);
        c.stroke();
        c.globalAlpha = 1;
        c.lineCap = "butt";
      });
    }
    drawAxes(c, this.mechanism, view, thin);
    gears.forEach((gear, k) => within(gear.index, () => {
      const first = gears.findIndex((each) => each.index === gear.index);
      if (gears.findIndex((each) => each.index === gear.index && each.plane === gear.plane) !== k) return; // one shaft for all its gears
      const [dx, dy] = at(gear.index);
      const sleeve = sleeves.findIndex((each) => each.name === gear.rotor);
      const shaft = drawn ?? shaftOf(gear);
      c.lineWidth = 1.6 * thin;
      if (sleeve >= 0) {
        const play = M * sleeves[sleeve].clearance;
        c.strokeStyle = view.soft;
        c.setLineDash(play > 0 ? [] : [4 * thin, 4 * thin]); // a bearing that is all spring
        circle(c, gear.x, gear.y, play > 0 ? shaft + play : 1.3 * shaft);
        c.stroke();
        c.setLineDash([]);
      }
      const support = (this.mechanism.supports ?? []).find((each) => each.name === gear.rotor);
      if (support) {
        c.strokeStyle = view.soft;
        c.lineWidth = thin;
        for (const [axis, k] of support.stiffness.entries()) if (k > 0) spring(c, gear.x, gear.y, M * dx, M * dy, axis, shaft);
      }
      c.fillStyle = view.color;
      circle(c, gear.x + M * dx, gear.y + M * dy, shaft);
      c.fill();
      if (sleeve < 0 || first !== k) return;
      const force = [pressed[2 * sleeve * n + i], pressed[(2 * sleeve + 1) * n + i]];
      arrow(c, gear.x + M * dx, gear.y + M * dy, ...force, this.peak, reach, 2 * thin, view.alert);
    }));
    for (const { between } of this.mechanism.couplings ?? []) {
      const [one, other] = between.map((name) => gears.find((gear) => gear.rotor === name));
      if (Math.hypot(one.x - other.x, one.y - other.y) > 1e-6) continue; // two axes joined by a drive
      const radius = 1.7 * Math.max(shaftOf(one), shaftOf(other));
      c.strokeStyle = view.ink;
      c.lineWidth = 1.6 * thin;
      for (const [side, gear] of [[1, one], [-1, other]]) { // each end's mark on a ring: apart by the twist
        const [dx, dy, theta] = at(gear.index);
        const angle = turns[gear.index * n + i] + M * theta;
        c.setLineDash(side > 0 ? [] : [2 * thin, 2 * thin]);
        circle(c, gear.x + M * dx, gear.y + M * dy, radius);
        c.stroke();
        c.setLineDash([]);
        c.beginPath();
        c.moveTo(gear.x + M * dx + radius * Math.cos(angle), gear.y + M * dy + radius * Math.sin(angle));
        c.lineTo(gear.x + M * dx + (1 - 0.3 * side) * radius * Math.cos(angle), gear.y + M * dy + (1 - 0.3 * side) * radius * Math.sin(angle));
        c.stroke();
      }
    }
    for (const [j, mesh] of meshes.entries()) {
      const [a, b] = [mesh.driver, mesh.driven].map((name) => gears.find((gear) => gear.name === name));
      const turn = (a.sense || 1);
      for (const [row, sense] of [[0, 1], [1, -1]]) {
        const force = flanks[(2 * j + row) * n + i];
        const angle = toward(a, b) + sense * turn * (Math.PI / 2 - mesh.pressure_angle);
        within(a.index, () => arrow(c, ...pitchPoint(a, b), force * Math.cos(angle), force * Math.sin(angle), this.peak, reach, 2 * thin, view.alert));
      }
    }
    c.setTransform(1, 0, 0, 1, 0, 0);
    const seen = (gear) => {
      const [axis, angle] = [this.axisOf(gear.index), this.turning ? orbit[gear.index * n + i] : 0];
      const [dx, dy] = [gear.x - axis.x, gear.y - axis.y];
      const [gx, gy] = [axis.x + dx * Math.cos(angle) - dy * Math.sin(angle), axis.y + dx * Math.sin(angle) + dy * Math.cos(angle)];
      return [x0 + w / 2 + scale * (gx - x), y0 + h / 2 - scale * (gy - y)];
    };
    if (named) drawLabels(c, this.mechanism, view, { to: seen, scale, ratio, turning: this.turning });
    c.restore();
  }

  /** Centre about which a rotor's set turns: that of its carrier. */
  axisOf(index) {
    const { gears, carried } = this.mechanism;
    const gear = gears.find((each) => each.index === index);
    const on = (carried ?? []).find((each) => each.rotor === gear.rotor)?.on;
    return (on && gears.find((each) => each.rotor === on)) || gear;
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

function pitchPoint(a, b) {
  const [angle, r] = [toward(a, b), 0.5 * a.module * a.teeth];
  return [a.x + r * Math.cos(angle), a.y + r * Math.sin(angle)];
}

function circle(c, x, y, r) { c.beginPath(); c.arc(x, y, r, 0, 2 * Math.PI); }

/** A spring from the ground, left of a shaft or below it, to the shaft where it is. */
function spring(c, x, y, dx, dy, axis, shaft) {
  const [from, coils, width] = [-3.2 * shaft, 5, 0.35 * shaft];
  const to = (axis ? dy : dx) - shaft;
  const point = (along, across) => (axis ? [x + dx + across, y + along] : [x + along, y + dy + across]);
  c.beginPath();
  c.moveTo(...point(from, -0.8 * shaft));
  c.lineTo(...point(from, 0.8 * shaft));
  c.moveTo(...point(from, 0));
  for (let k = 1; k < 2 * coils; k++) c.lineTo(...point(from + ((to - from) * k) / (2 * coils), k % 2 ? width : -width));
  c.lineTo(...point(to, 0));
  c.stroke();
}

/** An arrow whose length grows with the root of the force, so that small ones are seen; the largest has the length `reach`. */
function arrow(c, x, y, fx, fy, peak, reach, width, color) {
  const force = Math.hypot(fx, fy);
  if (!(force > 1e-6 * peak)) return;
  const length = reach * Math.sqrt(force / peak);
  const angle = Math.atan2(fy, fx);
  const [ex, ey] = [x + length * Math.cos(angle), y + length * Math.sin(angle)];
  const head = Math.min(0.16 * reach, 0.5 * length);
  c.strokeStyle = color;
  c.lineWidth = width;
  c.beginPath();
  c.moveTo(x, y);
  c.lineTo(ex, ey);
  for (const side of [2.6, -2.6]) { c.moveTo(ex, ey); c.lineTo(ex + head * Math.cos(angle + side), ey + head * Math.sin(angle + side)); }
  c.stroke();
}
