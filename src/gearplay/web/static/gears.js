// The shape of gears in the plane: teeth, sizes, where they meet.

export const rimOf = (gear) => (gear.teeth && gear.module ? 0.5 * gear.module * gear.teeth + (gear.internal ? 3 : 1.2) * gear.module : 3 * gear.shaft);

/** Return the box around gears: [left, right, low, high]. */
export function boxOf(gears) {
  const ends = (low, axis) => gears.map((gear) => gear[axis] + (low ? -1 : 1) * rimOf(gear));
  return [Math.min(...ends(true, "x")), Math.max(...ends(false, "x")), Math.min(...ends(true, "y")), Math.max(...ends(false, "y"))];
}

const involute = (alpha) => Math.tan(alpha) - alpha;

/** Outline of a gear about its centre; a ring's is that of its spaces. `gap` is the drawn backlash [m]. */
export function outline(gear, gap) {
  const { teeth: z, module: m, pressure_angle: alpha, internal } = gear;
  const r = 0.5 * m * z;
  const base = r * Math.cos(alpha);
  const tip = r + (internal ? gear.dedendum : gear.addendum) * m;
  const root = r - (internal ? gear.addendum : gear.dedendum) * m;
  const half = Math.PI / (2 * z) + gear.shift + ((internal ? 1 : -1) * gap) / (4 * r);
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
export function phases(mechanism) {
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
export function toward(a, b) {
  const angle = Math.atan2(b.y - a.y, b.x - a.x);
  if (a.internal) return angle;
  return b.internal ? angle + Math.PI : angle;
}

/** Where two gears' pitch circles touch. */
export function pitchPoint(a, b) {
  const teeth = Math.abs(a.teeth + (a.internal || b.internal ? -1 : 1) * b.teeth);
  const [angle, r] = [toward(a, b), (Math.hypot(b.x - a.x, b.y - a.y) * a.teeth) / teeth];
  return [a.x + r * Math.cos(angle), a.y + r * Math.sin(angle)];
}
