// Names of gears and the way they turn, over the drawing of the whole mechanism.

import { rimOf } from "./gears.js";

const wrapped = (angle) => angle - 2 * Math.PI * Math.round(angle / (2 * Math.PI));

/** Return which way a rotor is seen to turn at a frame: 1 counter-clockwise, -1 clockwise, 0 at rest. */
export function turnOf(index, { turns, orbit, t, i }, turning) {
  const n = t.length;
  const [a, b] = i + 1 < n ? [i, i + 1] : [i - 1, i];
  if (a < 0) return 0;
  const step = (angles) => (angles ? wrapped(angles[index * n + b] - angles[index * n + a]) : 0);
  const angle = step(turns) + (turning ? step(orbit) : 0);
  return Math.abs(angle) > 1e-7 ? Math.sign(angle) : 0;
}

/** An arc with a head about (x, y) [px], over the top where the axis points up. */
function turnArrow(c, x, y, radius, turn, middle, half, size) {
  const [from, to] = [middle - turn * half, middle + turn * half]; // mathematical angles
  c.beginPath();
  c.arc(x, y, radius, -from, -to, turn > 0);
  c.stroke();
  const [ex, ey] = [x + radius * Math.cos(to), y - radius * Math.sin(to)];
  const heading = Math.atan2(-Math.cos(to) * turn, -Math.sin(to) * turn);
  c.beginPath();
  c.moveTo(ex + size * Math.cos(heading), ey + size * Math.sin(heading));
  for (const side of [2.3, -2.3]) c.lineTo(ex + size * Math.cos(heading + side), ey + size * Math.sin(heading + side));
  c.closePath();
  c.fill();
}

/** Write names and draw arrows; `to` returns where a gear's centre is on the canvas [px], `scale` is px per m. */
export function drawLabels(c, mechanism, view, { to, scale, ratio, turning }) {
  const { gears, carried } = mechanism;
  c.font = `600 ${11 * ratio}px system-ui, sans-serif`;
  c.textAlign = "center";
  c.lineJoin = "round";
  const write = (text, x, y) => {
    c.lineWidth = 3.5 * ratio;
    c.strokeStyle = view.paper;
    c.strokeText(text, x, y);
    c.fillStyle = view.ink;
    c.fillText(text, x, y);
  };
  for (const gear of gears) {
    const [x, y] = to(gear);
    const text = gear.shown;
    const hub = carried.find(({ on }) => on === gear.rotor);
    const toothed = gear.teeth && gear.module;
    if (!toothed && hub) { // a carrier: on its first arm
      const pin = gears.find((each) => each.rotor === hub.rotor);
      const [px, py] = to(pin);
      const share = 0.62;
      write(text, x + share * (px - x), y + share * (py - y) - 5 * ratio);
      continue;
    }
    const rim = rimOf(gear) * scale;
    if (rim < 9 * ratio) continue;
    const pitch = toothed ? 0.5 * gear.module * gear.teeth * scale : 0.7 * rim;
    const turn = turnOf(gear.index, view, turning);
    if (turn) {
      [c.strokeStyle, c.fillStyle, c.lineWidth] = [view.color, view.color, 1.8 * ratio];
      const radius = gear.internal ? pitch + 0.6 * (rim - pitch) : Math.max(0.55 * pitch, gear.shaft * scale + 4 * ratio);
      turnArrow(c, x, y, radius, turn, Math.PI / 2, gear.internal ? 0.18 : 0.7, Math.min(6 * ratio, Math.max(3.5 * ratio, 0.25 * radius)));
    }
    if (gear.internal) write(text, x, y + rim - (rim - pitch) * 0.35 + 4 * ratio);
    else write(text, x, y + Math.min(gear.shaft * scale * 1.6 + 12 * ratio, Math.max(0.6 * pitch, 12 * ratio)));
  }
  c.textAlign = "start";
}

/** Draw where one shaft, or two that are coupled, go through planes that are drawn apart. */
export function drawAxes(c, { axes }, view, thin) {
  c.strokeStyle = view.color;
  c.lineWidth = 1.5 * thin;
  c.setLineDash([8 * thin, 3 * thin, 2 * thin, 3 * thin]);
  for (const [x, y, toX, toY] of axes) {
    c.beginPath();
    c.moveTo(x, y);
    c.lineTo(toX, toY);
    c.stroke();
  }
  c.setLineDash([]);
}
