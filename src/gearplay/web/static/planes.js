// Stages that lie one behind the other, drawn beside each other: what meshes lies in one plane.

export const shaftOf = (gear) => 0.6 * (gear.module ?? 0.004) + 0.004;
export const rimOf = (gear) => (gear.teeth && gear.module ? 0.5 * gear.module * gear.teeth + (gear.internal ? 3 : 1.2) * gear.module : 0.02);

const ASPECT = 0.9; // width to height of the place for the whole mechanism

/** Return for each gear the number of its plane: with the gears it meshes with, its carrier, and discs coupled to it. */
function planesOf({ gears, meshes, carried, couplings }) {
  const lead = gears.map((_, k) => k);
  const find = (k) => (lead[k] === k ? k : (lead[k] = find(lead[k])));
  const join = (a, b) => { if (a >= 0 && b >= 0) lead[find(b)] = find(a); };
  const named = (name) => gears.findIndex((gear) => gear.name === name);
  const turned = (name) => gears.findIndex((gear) => gear.rotor === name);
  for (const { driver, driven } of meshes) join(named(driver), named(driven));
  for (const { rotor, on } of carried) join(turned(on), turned(rotor));
  const hubs = new Set(carried.map(({ on }) => on));
  for (const { between } of couplings) {
    const [one, other] = between.map(turned);
    if (between.some((name) => !hubs.has(name) && !gears[turned(name)].teeth)) join(one, other); // a plain disc
  }
  const known = [...new Set(lead.map((_, k) => find(k)))];
  return lead.map((_, k) => known.indexOf(find(k)));
}

/** Return the box around gears: [left, right, low, high]. */
export function boxOf(gears) {
  const ends = (low, axis) => gears.map((gear) => gear[axis] + (low ? -1 : 1) * rimOf(gear));
  return [Math.min(...ends(true, "x")), Math.max(...ends(false, "x")), Math.min(...ends(true, "y")), Math.max(...ends(false, "y"))];
}

/** Move planes that would cover each other beside each other, along x (0) or y (1); return the gears, moved. */
function spread(gears, planes, axis) {
  const count = Math.max(...planes) + 1;
  const placed = [];
  let moved = gears;
  for (let plane = 0; plane < count; plane++) {
    const mine = gears.filter((_, k) => planes[k] === plane);
    const box = boxOf(mine);
    const covers = placed.some((other) => box[0] < other[1] && other[0] < box[1] && box[2] < other[3] && other[2] < box[3]);
    let shift = 0;
    if (covers) {
      const gap = 0.04 * Math.max(box[1] - box[0], box[3] - box[2]);
      shift = axis ? Math.min(...placed.map((each) => each[2])) - gap - box[3] : Math.max(...placed.map((each) => each[1])) + gap - box[0];
    }
    placed.push(axis ? [box[0], box[1], box[2] + shift, box[3] + shift] : [box[0] + shift, box[1] + shift, box[2], box[3]]);
    moved = moved.map((gear, k) => (planes[k] !== plane ? gear : { ...gear, plane, x: gear.x + (axis ? 0 : shift), y: gear.y + (axis ? shift : 0) }));
  }
  return moved;
}

/** Return a mechanism whose planes are drawn apart, with `axes`: pairs of places where one shaft, or two that are coupled, are seen. */
export function apart(mechanism) {
  const whole = { carried: [], couplings: [], ...mechanism };
  const planes = planesOf(whole);
  const size = (gears) => { const [l, r, b, t] = boxOf(gears); return Math.max((r - l) / ASPECT, t - b); };
  const ways = [0, 1].map((axis) => spread(whole.gears, planes, axis));
  const gears = size(ways[1]) < size(ways[0]) ? ways[1] : ways[0];
  const axes = [];
  for (const [k, gear] of gears.entries()) {
    const before = gears.slice(0, k).findLast((each) => each.rotor === gear.rotor && each.plane !== gear.plane);
    if (before) axes.push([before, gear]);
  }
  for (const { between } of whole.couplings) {
    const [one, other] = between.map((name) => gears.find((gear) => gear.rotor === name));
    if (one.plane !== other.plane) axes.push([one, other]);
  }
  return { ...whole, gears, axes };
}
