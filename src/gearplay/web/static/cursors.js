// Where the moving mechanism is, on the plots beside it: a line in the histories, a dot in the orbit. Plain elements that are moved,
// since plotly.js would take longer to draw them than a frame lasts.

import { frameAt } from "./mechanism.js";
import { MODELS } from "./plotting.js";

function markOf(plot, kind, model = "") {
  const known = plot.querySelector(`:scope > .${kind}${model && `.${model}`}`);
  if (known) return known;
  const made = document.createElement("div");
  made.className = `${kind} ${model}`.trim();
  plot.append(made);
  return made;
}

function place(mark, x, y, inside) {
  mark.hidden = !inside;
  if (inside) mark.style.transform = `translate(${x}px, ${y}px)`;
}

/** Put the line of a history at a time [s]. */
function placeLine(name, time) {
  const plot = document.getElementById(name);
  const full = plot.sketched ?? plot._fullLayout;
  if (!full?.xaxis?._length) return;
  const { xaxis, _size: size } = full;
  const at = xaxis.l2p(time);
  const mark = markOf(plot, "time-line");
  mark.style.height = `${size.h}px`;
  place(mark, size.l + at, size.t, at >= 0 && at <= xaxis._length);
}

/** Put the dot of a model's shaft at its place [m]. */
function placeDot(model, x, y) {
  const plot = document.getElementById("orbit");
  const full = plot.sketched ?? plot._fullLayout;
  if (!full?.xaxis?._length) return;
  const { xaxis, yaxis } = full;
  const [px, py] = [xaxis.l2p(1e6 * x), yaxis.l2p(1e6 * y)];
  const inside = px >= 0 && px <= xaxis._length && py >= 0 && py <= yaxis._length;
  place(markOf(plot, "shaft-dot", model), xaxis._offset + px, yaxis._offset + py, inside);
}

/** Move all marks to a time [s] of a result; the dots are of the shaft in `sleeve`. */
export function moveCursors(result, sleeve, time) {
  for (const name of ["backlash", "forces"]) placeLine(name, time);
  const k = result.mechanism.gears.find((gear) => gear.rotor === sleeve)?.index ?? -1;
  for (const model of MODELS) {
    const frames = result.models[model]?.frames;
    const n = frames?.t.length ?? 0;
    const i = n ? frameAt(frames.t, time) : 0;
    if (k >= 0 && n) placeDot(model, frames.rotors[3 * k * n + i], frames.rotors[(3 * k + 1) * n + i]);
    else document.querySelector(`#orbit > .shaft-dot.${model}`)?.remove();
  }
}
