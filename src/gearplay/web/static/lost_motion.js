// Lost motion: its form, the hysteresis curve, the key numbers of a shaft, and both over its turn.

import { CONFIG, axis, layout, plain, plotly, scaled } from "./plotting.js";
import { style } from "./colors.js";
import { field, numberField, submitButton } from "./forms.js";
import { $ } from "./page.js";

const ARCMIN = (180 * 60) / Math.PI;
const DEGREE = 180 / Math.PI;

/** Make the form for a case, as the server describes it. */
export function fillLostMotion(form, { rotors, lost_motion: { at, hold, torque } }) {
  form.replaceChildren();
  for (const [name, words, chosen] of [["at", "shaft", at], ["hold", "held", hold]]) {
    field(form, name, words, document.createElement("select")).append(...rotors.map((each) => new Option(each, each, each === chosen, each === chosen)));
  }
  numberField(form, "torque", "rated torque [N m]", torque);
  numberField(form, "positions", "positions over a turn", 1);
  submitButton(form, "Compute lost motion");
}

export function lostMotionWords(form) {
  const data = new FormData(form);
  return { at: data.get("at"), hold: data.get("hold"), torque: Number(data.get("torque")), positions: Number(data.get("positions")) };
}

/** Fill the tiles of key numbers. */
function fillRows(list, rows) {
  list.replaceChildren(...rows.map(([words, value]) => {
    const tile = document.createElement("div");
    tile.append(Object.assign(document.createElement("dt"), { textContent: words }), Object.assign(document.createElement("dd"), { textContent: value }));
    return tile;
  }));
}

/** Draw the hysteresis curve of a result, and the numbers over a turn where it has them. */
export async function drawLostMotion(result) {
  await plotly();
  $("lost_motion-title").textContent = `Lost motion of ${result.at}, ${result.hold} held`;
  fillRows($("lost_motion-rows"), result.rows);
  const branch = (name, words, color, width) => {
    const points = result.branches[name];
    const [, count] = points.shape;
    return { x: points.subarray(0, count), y: points.subarray(count), mode: "lines", name: words, line: { color: style(color), width } };
  };
  const traces = [branch("loading", "torque rises", "uncoupled", 4), branch("unloading", "torque falls", "coupled", 2),
    { x: [-result.small, result.small], y: scaled(result.ends, ARCMIN), mode: "lines+markers", name: "lost motion",
      line: { color: style("alert"), dash: "dash", width: 1 }, marker: { color: style("alert"), size: 6 } }];
  const words = { xaxis: axis(plain(`torque on ${result.at} [N m]`)), yaxis: axis("rotation [arcmin]") };
  await Plotly.react("lost_motion", traces, layout({ uirevision: `${result.key}`, ...words }), CONFIG);
  await drawTurn(result);
}

async function drawTurn({ turn, at, key }) {
  const place = $("lost_motion-turn");
  place.hidden = !turn.position;
  if (place.hidden) { Plotly.purge(place); return; }
  const traces = [["lost_motion", "lost motion", "alert"], ["backlash", "backlash", "coupled"]].map(([name, words, color]) => (
    { x: scaled(turn.position, DEGREE), y: scaled(turn[name], ARCMIN), mode: "lines+markers", name: words, line: { color: style(color) }, marker: { size: 4 } }));
  const words = { xaxis: axis(plain(`angle of ${at} [deg]`)), yaxis: axis("over a turn [arcmin]", { rangemode: "tozero" }) };
  await Plotly.react(place, traces, layout({ uirevision: `${key}`, ...words }), CONFIG);
}
