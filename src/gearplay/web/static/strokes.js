// What a drawing of the mechanism is made of: circles, springs, arrows.

export function circle(c, x, y, r) { c.beginPath(); c.arc(x, y, r, 0, 2 * Math.PI); }

/** A spring from the ground, left of a shaft or below it, to the shaft where it is. */
export function spring(c, x, y, dx, dy, axis, shaft) {
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
export function arrow(c, x, y, fx, fy, peak, reach, width, color) {
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
