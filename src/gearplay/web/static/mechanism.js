// The mechanism in motion: gears with involute teeth, shafts in their sleeves, forces; small motions magnified.

const style = (name) => getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
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

export class Stage {
  constructor(place, onTime) {
    this.place = place;
    this.onTime = onTime;
    this.panes = [];
    this.playing = !matchMedia("(prefers-reduced-motion: reduce)").matches;
    this.at = 0;
    this.speed = 0.05;
    this.magnify = 1;
    this.frames = 0;
    this.last = performance.now();
    const tick = (now) => { this.step(now); requestAnimationFrame(tick); };
    requestAnimationFrame(tick);
  }

  show(result) {
    this.result = result;
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
        figure.append(canvas, caption);
        this.place.append(figure);
        return { model, canvas, context: canvas.getContext("2d") };
      });
    }
    this.phases = phases(result.mechanism);
    this.paths = new Map();
    const frames = result.models[models[0]].frames;
    this.span = frames.t.length ? [frames.t[0], frames.t[frames.t.length - 1]] : [0, 1];
    this.peak = 1e-9;
    for (const model of models) {
      for (const key of ["sleeves", "meshes"]) for (const value of result.models[model].frames[key]) this.peak = Math.max(this.peak, Math.abs(value));
    }
    this.draw();
  }

  /** How many times small motions are drawn larger: the slider times what makes a clearance a quarter of a module. */
  get factor() {
    const { gears, sleeves, meshes } = this.result.mechanism;
    const module = gears.find((gear) => gear.module)?.module ?? 0.01;
    const small = Math.max(1e-7, ...sleeves.map((each) => each.clearance), ...meshes.map((each) => each.backlash));
    return (this.magnify * 0.25 * module) / small;
  }

  step(now) {
    const passed = Math.min(0.1, (now - this.last) / 1000);
    this.last = now;
    if (!this.result || !this.playing || document.hidden) return;
    this.frames += 1;
    const length = this.span[1] - this.span[0];
    this.at = (this.at + (passed * this.speed) / Math.max(length, 1e-9)) % 1;
    this.draw();
    this.onTime(this.at, this.span[0] + this.at * length);
  }

  draw() {
    if (!this.result) return;
    for (const pane of this.panes) this.pane(pane);
  }

  pane({ model, canvas, context: c }) {
    const view = this.result.models[model];
    const { gears, sleeves, meshes } = this.result.mechanism;
    const { t, rotors, sleeves: pressed, meshes: flanks } = view.frames;
    if (!t.length) return;
    const ratio = window.devicePixelRatio || 1;
    const [width, height] = [canvas.clientWidth * ratio, canvas.clientHeight * ratio];
    if (canvas.width !== Math.round(width) || canvas.height !== Math.round(height)) { canvas.width = Math.round(width); canvas.height = Math.round(height); }
    const size = (gear) => (gear.teeth && gear.module ? 0.5 * gear.module * gear.teeth + (gear.internal ? 3.2 : 1.2) * gear.module : 0.02);
    const left = Math.min(...gears.map((g) => g.x - size(g)));
    const right = Math.max(...gears.map((g) => g.x + size(g)));
    const low = Math.min(...gears.map((g) => g.y - size(g)));
    const high = Math.max(...gears.map((g) => g.y + size(g)));
    const scale = 0.96 * Math.min(width / (right - left), height / (high - low));
    const n = t.length;
    const i = Math.min(n - 1, Math.floor(this.at * n));
    const time = t[i];
    const M = this.factor;
    c.setTransform(1, 0, 0, 1, 0, 0);
    c.clearRect(0, 0, width, height);
    c.setTransform(scale, 0, 0, -scale, width / 2 - (scale * (left + right)) / 2, height / 2 + (scale * (low + high)) / 2);
    const thin = 1.2 / scale;
    const [ink, soft, paper, color] = [style("ink"), style("soft"), style("paper"), style(model)];
    const at = (k) => [rotors[3 * k * n + i], rotors[(3 * k + 1) * n + i], rotors[(3 * k + 2) * n + i]];
    gears.forEach((gear, k) => {
      const [x, y, theta] = at(k);
      c.save();
      c.translate(gear.x + M * x, gear.y + M * y);
      c.lineWidth = thin;
      if (gear.teeth && gear.module) {
        const gap = M * Math.max(0, ...meshes.filter((m) => m.driver === gear.name || m.driven === gear.name).map((m) => m.backlash));
        const key = `${gear.name} ${gap.toPrecision(3)}`;
        if (!this.paths.has(key)) this.paths.set(key, outline(gear, Math.min(gap, 0.8 * Math.PI * gear.module)));
        c.rotate((this.phases.get(gear.name) ?? 0) + gear.speed * time + M * theta);
        if (gear.internal) {
          const ring = new Path2D();
          ring.arc(0, 0, 0.5 * gear.module * gear.teeth + 3 * gear.module, 0, 2 * Math.PI);
          ring.addPath(this.paths.get(key));
          c.fillStyle = paper;
          c.fill(ring, "evenodd");
          c.strokeStyle = ink;
          c.stroke(ring);
        } else {
          c.fillStyle = paper;
          c.fill(this.paths.get(key));
          c.strokeStyle = ink;
          c.stroke(this.paths.get(key));
        }
      }
      c.restore();
    });
    gears.forEach((gear, k) => {
      const [x, y] = at(k);
      const sleeve = sleeves.findIndex((each) => each.name === gear.name);
      const shaft = 0.6 * (gear.module ?? 0.004) + 0.004;
      c.lineWidth = 1.6 * thin;
      if (sleeve >= 0) {
        c.strokeStyle = soft;
        circle(c, gear.x, gear.y, shaft + M * sleeves[sleeve].clearance);
        c.stroke();
      }
      c.fillStyle = color;
      circle(c, gear.x + M * x, gear.y + M * y, shaft);
      c.fill();
      if (sleeve >= 0) arrow(c, gear.x + M * x, gear.y + M * y, pressed[2 * sleeve * n + i], pressed[(2 * sleeve + 1) * n + i], this.peak, scale, color);
    });
    meshes.forEach((mesh, j) => {
      const [a, b] = [gears.find((g) => g.name === mesh.driver), gears.find((g) => g.name === mesh.driven)];
      const beta = toward(a, b);
      const r = 0.5 * a.module * a.teeth;
      const [px, py] = [a.x + r * Math.cos(beta), a.y + r * Math.sin(beta)];
      const turn = Math.sign(a.speed || 1);
      for (const [row, sense] of [[0, 1], [1, -1]]) {
        const force = flanks[(2 * j + row) * n + i];
        if (!(force > 0)) continue;
        const angle = beta + sense * turn * (Math.PI / 2 - mesh.pressure_angle);
        arrow(c, px, py, force * Math.cos(angle), force * Math.sin(angle), this.peak, scale, style("alert"));
      }
    });
  }
}

function circle(c, x, y, r) { c.beginPath(); c.arc(x, y, r, 0, 2 * Math.PI); }

/** An arrow whose length grows with the root of the force, so that small ones are seen. */
function arrow(c, x, y, fx, fy, peak, scale, color) {
  const force = Math.hypot(fx, fy);
  if (!(force > 1e-6 * peak)) return;
  const length = (110 / scale) * Math.sqrt(force / peak);
  const angle = Math.atan2(fy, fx);
  const [ex, ey] = [x + length * Math.cos(angle), y + length * Math.sin(angle)];
  const head = Math.min(10 / scale, 0.5 * length);
  c.strokeStyle = color;
  c.lineWidth = 2.5 / scale;
  c.beginPath();
  c.moveTo(x, y);
  c.lineTo(ex, ey);
  for (const side of [2.6, -2.6]) { c.moveTo(ex, ey); c.lineTo(ex + head * Math.cos(angle + side), ey + head * Math.sin(angle + side)); }
  c.stroke();
}
