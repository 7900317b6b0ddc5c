// What is seen through a window of the plane: gears, arms of carriers, shafts, couplings, forces, names.

import { drawAxes, drawLabels } from "./labels.js";
import { pitchPoint, rimOf, toward } from "./gears.js";
import { arrow, circle, spring } from "./strokes.js";

/** Where everything is at a frame, and how large it is drawn: what every part of the painting asks. */
class Scene {
  constructor(c, stage, view, { scale, shaft, ratio, reach, turning }) {
    Object.assign(this, { c, stage, view, shaft, reach, turning });
    this.mechanism = stage.mechanism;
    this.factor = stage.factor;
    this.thin = (1.2 * ratio) / scale;
    this.frames = view.t.length;
  }

  /** A value of a row of the frames. */
  value(rows, row) { return rows[row * this.frames + this.view.i]; }

  /** Where a rotor is drawn, [x, y] beside its place, and its small angle. */
  offset(index) { return [0, 1, 2].map((axis) => this.factor * this.value(this.view.rotors, 3 * index + axis)); }

  /** Where the bush of a sleeve is drawn, [x, y] beside the place of its shaft. */
  bush(sleeve) { return [0, 1].map((axis) => this.factor * this.value(this.view.bushes, 2 * sleeve + axis)); }

  turn(index) { return this.value(this.view.turns, index); }

  /** Angle by which a rotor's set is turned with its carrier: 0 where carriers are held. */
  carriedBy(index) { return this.turning ? this.value(this.view.orbit, index) : 0; }

  gear(name) { return this.mechanism.gears.find((gear) => gear.name === name); }

  shaftAt(rotor) { return this.mechanism.gears.find((gear) => gear.rotor === rotor); }

  /** Centre about which a rotor's set turns: that of its carrier. */
  axis(index) {
    const gear = this.mechanism.gears.find((each) => each.index === index);
    const on = this.mechanism.carried.find((each) => each.rotor === gear.rotor)?.on;
    return (on && this.shaftAt(on)) || gear;
  }

  /** Draw what belongs to a rotor, turned with its set. */
  within(index, draw) {
    const angle = this.carriedBy(index);
    if (!angle) return draw();
    const { x, y } = this.axis(index);
    this.c.save();
    this.c.translate(x, y);
    this.c.rotate(angle);
    this.c.translate(-x, -y);
    draw();
    this.c.restore();
  }

  /** Where a gear's centre is seen in the plane. */
  seen(gear) {
    const [axis, angle] = [this.axis(gear.index), this.carriedBy(gear.index)];
    const [dx, dy] = [gear.x - axis.x, gear.y - axis.y];
    return [axis.x + dx * Math.cos(angle) - dy * Math.sin(angle), axis.y + dx * Math.sin(angle) + dy * Math.cos(angle)];
  }

  force(x, y, fx, fy) { arrow(this.c, x, y, fx, fy, this.stage.peak, this.reach, 2 * this.thin, this.view.alert); }
}

/** Paint what lies in a window of the plane [m] into a place of the canvas [px]. */
export function paint(c, stage, view, [x0, y0, w, h], { x, y, width, height, shaft, named }, ratio) {
  const scale = 0.96 * Math.min(w / width, h / height);
  const reach = (0.3 * Math.min(w, h)) / scale;
  const turning = stage.turning && named; // close-ups go with the carrier
  const scene = new Scene(c, stage, view, { scale, shaft, ratio, reach, turning });
  c.save();
  c.setTransform(1, 0, 0, 1, 0, 0);
  c.beginPath();
  c.rect(x0, y0, w, h);
  c.clip();
  c.setTransform(scale, 0, 0, -scale, x0 + w / 2 - scale * x, y0 + h / 2 + scale * y);
  paintGears(scene);
  if (named) paintArms(scene);
  drawAxes(c, scene.mechanism, view, scene.thin);
  paintShafts(scene);
  paintCouplings(scene);
  paintMeshForces(scene);
  c.setTransform(1, 0, 0, 1, 0, 0);
  const to = (gear) => {
    const [gx, gy] = scene.seen(gear);
    return [x0 + w / 2 + scale * (gx - x), y0 + h / 2 - scale * (gy - y)];
  };
  if (named) drawLabels(c, scene.mechanism, view, { to, scale, ratio, turning });
  c.restore();
}

function paintGears(scene) {
  const { c, stage, view, mechanism } = scene;
  const layers = mechanism.gears.filter((gear) => gear.teeth && gear.module).sort((a, b) => rimOf(b) - rimOf(a)); // small before large
  layers.forEach((gear, k) => scene.within(gear.index, () => {
    const [dx, dy, theta] = scene.offset(gear.index);
    const outlined = stage.outlineOf(gear);
    c.save();
    c.translate(gear.x + dx, gear.y + dy);
    c.rotate((stage.phases.get(gear.name) ?? 0) + scene.turn(gear.index) + theta);
    c.lineWidth = scene.thin;
    c.fillStyle = k % 2 ? view.gear2 : view.gear1;
    c.fill(outlined, "evenodd");
    c.strokeStyle = view.ink;
    c.stroke(outlined);
    c.restore();
  }));
}

/** Arms of carriers, from the hub to each pin. */
function paintArms(scene) {
  const { c, view, mechanism } = scene;
  for (const { rotor, on } of mechanism.carried) {
    const [pin, hub] = [scene.shaftAt(rotor), scene.shaftAt(on)];
    scene.within(pin.index, () => {
      const [dx, dy] = scene.offset(hub.index);
      c.strokeStyle = view.soft;
      c.globalAlpha = 0.55;
      c.lineCap = "round";
      c.lineWidth = 0.9 * pin.shaft;
      c.beginPath();
      c.moveTo(hub.x + dx, hub.y + dy);
      c.lineTo(pin.x + dx, pin.y + dy);
      c.stroke();
      c.globalAlpha = 1;
      c.lineCap = "butt";
    });
  }
}

/** Shafts with their sleeves, supports and what presses them. */
function paintShafts(scene) {
  const { c, view, mechanism, thin } = scene;
  const { gears, sleeves } = mechanism;
  gears.forEach((gear, k) => scene.within(gear.index, () => {
    const first = gears.findIndex((each) => each.index === gear.index);
    if (gears.findIndex((each) => each.index === gear.index && each.plane === gear.plane) !== k) return; // one shaft for all its gears
    const [dx, dy] = scene.offset(gear.index);
    const shaft = scene.shaft ?? gear.shaft;
    const sleeve = sleeves.findIndex((each) => each.name === gear.rotor);
    c.lineWidth = 1.6 * thin;
    if (sleeve >= 0) {
      const play = scene.factor * sleeves[sleeve].clearance;
      c.strokeStyle = view.soft;
      c.setLineDash(play > 0 ? [] : [4 * thin, 4 * thin]); // a bearing that is all spring
      const [bx, by] = scene.bush(sleeve);
      circle(c, gear.x + bx, gear.y + by, play > 0 ? shaft + play : 1.3 * shaft);
      c.stroke();
      c.setLineDash([]);
    }
    const support = mechanism.supports.find((each) => each.name === gear.rotor);
    if (support) {
      c.strokeStyle = view.soft;
      c.lineWidth = thin;
      for (const [axis, stiffness] of support.stiffness.entries()) if (stiffness > 0) spring(c, gear.x, gear.y, dx, dy, axis, shaft);
    }
    c.fillStyle = view.color;
    circle(c, gear.x + dx, gear.y + dy, shaft);
    c.fill();
    if (sleeve < 0 || first !== k) return;
    const [fx, fy] = [0, 1].map((axis) => scene.value(view.sleeves, 2 * sleeve + axis));
    scene.force(gear.x + dx, gear.y + dy, fx, fy);
  }));
}

/** A mark of each end of a coupling on a ring of its own: they are apart by the twist. */
function paintCouplings(scene) {
  const { c, view, mechanism, thin } = scene;
  for (const { between } of mechanism.couplings) {
    const [one, other] = between.map((name) => scene.shaftAt(name));
    if (Math.hypot(one.x - other.x, one.y - other.y) > 1e-6) continue; // two axes joined by a drive
    const radius = 1.7 * Math.max(one.shaft, other.shaft);
    c.strokeStyle = view.ink;
    c.lineWidth = 1.6 * thin;
    for (const [side, gear] of [[1, one], [-1, other]]) {
      const [dx, dy, theta] = scene.offset(gear.index);
      const [x, y, angle] = [gear.x + dx, gear.y + dy, scene.turn(gear.index) + theta];
      c.setLineDash(side > 0 ? [] : [2 * thin, 2 * thin]);
      circle(c, x, y, radius);
      c.stroke();
      c.setLineDash([]);
      c.beginPath();
      for (const share of [1, 1 - 0.3 * side]) c.lineTo(x + share * radius * Math.cos(angle), y + share * radius * Math.sin(angle));
      c.stroke();
    }
  }
}

/** Forces of drive and back flanks, along their lines of action. */
function paintMeshForces(scene) {
  const { view, mechanism } = scene;
  for (const [j, mesh] of mechanism.meshes.entries()) {
    const [a, b] = [scene.gear(mesh.driver), scene.gear(mesh.driven)];
    for (const [row, sense] of [[0, 1], [1, -1]]) {
      const force = scene.value(view.meshes, 2 * j + row);
      const angle = toward(a, b) + sense * (a.sense || 1) * (Math.PI / 2 - mesh.pressure_angle);
      scene.within(a.index, () => scene.force(...pitchPoint(a, b), force * Math.cos(angle), force * Math.sin(angle)));
    }
  }
}
