// The plots of a bifurcation diagram and of a map.

import { CONFIG, axis, layout, plain, plotly, scaled, shownAs, shownUnit } from "./plotting.js";
import { style } from "./colors.js";

const wordsOf = (control) => plain(`${control.owner} ${control.label} [${shownUnit(control.unit)}]`.trim());

/** Draw a bifurcation diagram over the field that a control sets. */
export async function drawBifurcation(result, control) {
  await plotly();
  const [unit, factor] = shownAs(result.unit);
  const traces = ["up", "down"].map((way) => {
    const [count, keep] = result[way].shape;
    const x = new Float64Array(count * keep);
    for (let i = 0; i < count; i++) x.fill(result.x[i] * control.factor + control.offset, i * keep, (i + 1) * keep);
    return { x, y: scaled(result[way], factor), mode: "markers", type: "scatter", name: way === "up" ? "rising" : "falling",
      marker: { size: 2, color: style(way === "up" ? "rising" : "falling"), opacity: 0.7 } };
  });
  const words = { xaxis: axis(wordsOf(control)), yaxis: axis(plain(`${result.signal} [${unit}]`)) };
  return Plotly.react("bifurcation", traces, layout({ uirevision: `${result.key}`, ...words }), CONFIG);
}

// Cells of few values stand apart, with a tick at each value: nothing was computed between them.
const few = ({ length }) => length <= 6;
const ticksAt = (values) => (few(values) ? { tickvals: values, ticktext: Array.from(values, (value) => String(Number(value.toPrecision(4)))) } : {});

/** Draw a map over the fields that two controls set. */
export async function drawMap(result, first, second) {
  await plotly();
  const [rows, columns] = result.values.shape;
  const [unit, factor] = shownAs(result.unit);
  const z = Array.from({ length: rows }, (_, i) => scaled(result.values.subarray(i * columns, (i + 1) * columns), factor));
  const cells = (array) => Array.from({ length: rows }, (_, i) => Array.from(array.subarray(i * columns, (i + 1) * columns)));
  const [spread, impacts] = [result.spread ?? result.values.map(() => NaN), result.impacts ?? result.values.map(() => NaN)].map(cells);
  const about = spread.map((row, i) => row.map((each, j) => [Number.isFinite(each) ? ` ± ${Number((each * factor).toPrecision(2))}` : "", Math.round(impacts[i][j]) || 0]));
  const trace = { type: "heatmap", customdata: about, x: scaled(result.x, first.factor, first.offset), y: scaled(result.y, second.factor, second.offset), z, colorscale: "Viridis",
    hovertemplate: `${wordsOf(first)}: %{x:.4g}<br>${wordsOf(second)}: %{y:.4g}<br>${plain(result.measure)}: %{z:.4g}%{customdata[0]} ${unit}<br>%{customdata[1]} impacts<extra></extra>`,
    colorbar: { title: { text: plain(`${result.measure} [${unit}]`), side: "right" }, exponentformat: "power" } };
  Object.assign(trace, { xgap: few(trace.x) ? 3 : 0, ygap: few(trace.y) ? 3 : 0 });
  const words = { xaxis: axis(wordsOf(first), ticksAt(trace.x)), yaxis: axis(wordsOf(second), ticksAt(trace.y)) };
  const doubt = hatching(result, trace);
  return Plotly.react("map", doubt ? [trace, doubt] : [trace], layout({ showlegend: Boolean(doubt), margin: { l: 74, r: 120, t: doubt ? 34 : 12, b: 42, autoexpand: false },
    uirevision: `${result.key}`, ...words }), CONFIG);
}

/** Return strokes over the cells that say little, with the reason as their name; null where there is none. */
function hatching({ doubtful, few }, { x, y }) {
  if (!doubtful?.some((each) => each)) return null;
  const [wide, high] = [x[1] - x[0], y[1] - y[0]];
  const strokes = { x: [], y: [] };
  for (const [k, each] of doubtful.entries()) {
    if (!each) continue;
    const [left, low] = [x[k % x.length] - wide / 2, y[Math.floor(k / x.length)] - high / 2];
    for (const [a, b] of [[[0, 0.5], [0.5, 1]], [[0, 0], [1, 1]], [[0.5, 0], [1, 0.5]]]) { // three diagonals
      strokes.x.push(left + a[0] * wide, left + b[0] * wide, null);
      strokes.y.push(low + a[1] * high, low + b[1] * high, null);
    }
  }
  return { ...strokes, mode: "lines", type: "scatter", hoverinfo: "skip", line: { color: "#ff5a36", width: 1.5 }, showlegend: true,
    name: "hatched: uncertain" };
}
