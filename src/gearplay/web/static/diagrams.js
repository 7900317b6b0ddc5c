// The plots of a bifurcation diagram and of a map.

import { CONFIG, axis, layout, plain, plotly, scaled, shownAs, shownUnit, style } from "./plotting.js";

const wordsOf = (control) => plain(`${control.owner} ${control.label} [${shownUnit(control.unit)}]`.trim());

/** Draw a bifurcation diagram over the field that a control sets. */
export async function drawBifurcation(result, control) {
  await plotly();
  const [unit, factor] = shownAs(result.unit);
  const traces = ["up", "down"].map((way) => {
    const [count, keep] = result[way].shape;
    const x = new Float64Array(count * keep);
    for (let i = 0; i < count; i++) x.fill(result.x[i] * control.factor, i * keep, (i + 1) * keep);
    return { x, y: scaled(result[way], factor), mode: "markers", type: "scatter", name: way === "up" ? "rising" : "falling",
      marker: { size: 2, color: style(way === "up" ? "rising" : "falling"), opacity: 0.7 } };
  });
  const words = { xaxis: axis(wordsOf(control)), yaxis: axis(plain(`${result.signal} [${unit}]`)) };
  return Plotly.react("bifurcation", traces, layout({ uirevision: `${result.key}`, ...words }), CONFIG);
}

/** Draw a map over the fields that two controls set. */
export async function drawMap(result, first, second) {
  await plotly();
  const [rows, columns] = result.values.shape;
  const [unit, factor] = shownAs(result.unit);
  const z = Array.from({ length: rows }, (_, i) => scaled(result.values.subarray(i * columns, (i + 1) * columns), factor));
  const trace = { type: "heatmap", x: scaled(result.x, first.factor), y: scaled(result.y, second.factor), z, colorscale: "Viridis",
    hovertemplate: `${wordsOf(first)}: %{x:.4g}<br>${wordsOf(second)}: %{y:.4g}<br>${plain(result.measure)}: %{z:.4g} ${unit}<extra></extra>`,
    colorbar: { title: { text: plain(`${result.measure} [${unit}]`), side: "right" }, exponentformat: "power" } };
  const words = { xaxis: axis(wordsOf(first)), yaxis: axis(wordsOf(second)) };
  return Plotly.react("map", [trace], layout({ showlegend: false, margin: { l: 74, r: 120, t: 12, b: 42, autoexpand: false },
    uirevision: `${result.key}`, ...words }), CONFIG);
}
