// The plots of a run: orbit, spectrum, backlash, forces and contacts; and the table of contacts.

import { CONFIG, MODELS, axis, layout, plain, plotly, scaled } from "./plotting.js";
import { style } from "./colors.js";

const SIGNALS = {
  drive_force: { words: "drive", dash: "solid" },
  back_force: { words: "back", dash: "dot" },
  sleeve_force: { words: "sleeve", dash: "dash" },
};
const FEW = 30; // impacts
const lineOf = (model, dash = "solid", width = 1.1) => ({ color: style(model), width, dash });
const names = (result) => MODELS.filter((model) => model in result.models);

const pause = () => new Promise((resolve) => { setTimeout(resolve); });
const inView = (name) => {
  const { top, bottom, height } = document.getElementById(name).getBoundingClientRect();
  return height > 0 && bottom > 0 && top < window.innerHeight;
};

/**
 * Draw a run, first the plots that are seen; return what draws the others, one by one, while `wanted()` says so.
 * `look` names the sleeve and the mesh that are looked at, and the spectrum (`spectrum`, `scale`).
 */
export async function drawRun(result, look) {
  await plotly();
  const draws = { orbit: drawOrbit, spectrum: drawSpectrum, backlash: drawBacklash, forces: drawForces };
  const [near, far] = [Object.keys(draws).filter(inView), Object.keys(draws).filter((name) => !inView(name))];
  for (const name of near) await draws[name](result, look);
  return async (wanted) => {
    for (const name of far) {
      await pause();
      if (!wanted()) return false;
      if (document.getElementById(name).offsetParent === null) continue; // on a tab that is not shown: drawn when it is
      await draws[name](result, look);
    }
    return true;
  };
}

/** Return the views of an earlier run that lies beside this one, with words for its models. */
const overlaid = (overlay) => Object.entries(overlay?.models ?? {}).map(([model, view]) => ({ model, view, words: `earlier, ${model}` }));
const ghost = (model) => ({ color: `${style(model)}70`, width: 0.9 }); // behind what is of now
const roomFor = (overlay) => (overlay ? { margin: { l: 74, r: 14, t: 52, b: 42, autoexpand: false } } : {}); // for a second row of the legend

function drawOrbit(result, { sleeve, overlay }) {
  const traces = [];
  for (const model of names(result)) {
    const orbit = result.models[model].orbits.find((each) => each.name === sleeve);
    if (!orbit) continue;
    if (!traces.length) {
      const [c, angle] = [1e6 * orbit.clearance, Array.from({ length: 181 }, (_, i) => (i * Math.PI) / 90)];
      traces.push({ x: angle.map((a) => c * Math.cos(a)), y: angle.map((a) => c * Math.sin(a)), mode: "lines", hoverinfo: "skip",
        line: { color: style("soft"), width: 1.2 }, showlegend: false });
    }
    traces.push({ x: scaled(orbit.x, 1e6), y: scaled(orbit.y, 1e6), mode: "lines", line: lineOf(model, "solid", 0.9), name: model,
      hovertemplate: "%{x:.4g}, %{y:.4g} µm" });
  }
  for (const { view, words, model } of overlaid(overlay)) {
    const orbit = view.orbits.find((each) => each.name === sleeve);
    if (orbit) traces.unshift({ x: scaled(orbit.x, 1e6), y: scaled(orbit.y, 1e6), mode: "lines", line: ghost(model), name: words });
  }
  return Plotly.react("orbit", traces, layout({ ...roomFor(overlay), uirevision: `${sleeve}`, xaxis: axis("x [µm]", { scaleanchor: "y" }), yaxis: axis("y [µm]") }), CONFIG);
}

export async function drawSpectrum(result, { spectrum, scale, overlay }) {
  await plotly();
  const traces = [];
  let [top, low] = [0, Infinity];
  for (const model of names(result)) {
    const found = result.models[model].spectra.find((each) => `${each.label}.${each.signal}` === spectrum);
    if (!found || !found.a.some((value) => value > 0)) continue; // nothing moves
    for (const value of found.a) { top = Math.max(top, value); if (value > 0) low = Math.min(low, value); }
    if (found.s) traces.push(...band(found, model));
    traces.push({ x: found.f, y: found.a, mode: "lines", line: lineOf(model), name: model, hovertemplate: "%{y:.4g} m/s² at %{x:.5g} Hz" });
  }
  for (const { view, words, model } of overlaid(overlay)) {
    const found = view.spectra.find((each) => `${each.label}.${each.signal}` === spectrum);
    if (found) traces.unshift({ x: found.f, y: found.a, mode: "lines", line: ghost(model), name: words, hovertemplate: "%{y:.4g} m/s² at %{x:.5g} Hz" });
  }
  if (overlay?.measured) {
    const { f, a } = overlay.measured;
    for (const value of a) top = Math.max(top, value);
    traces.push({ x: f, y: a, mode: "lines", line: { color: style("rising"), width: 1.2 }, name: plain(overlay.name), hovertemplate: "%{y:.4g} m/s² at %{x:.5g} Hz" });
  }
  const shapes = [];
  const annotations = [];
  const mark = (frequency, text, color, dash) => {
    if (!(frequency > 0)) return;
    const level = 1 - 0.07 * annotations.length; // one below the other: lines may lie close
    shapes.push({ type: "line", x0: frequency, x1: frequency, yref: "paper", y0: 0, y1: 1, line: { color, width: 1, dash }, layer: "below" });
    annotations.push({ x: Math.log10(frequency), y: level, yref: "paper", text, showarrow: false, font: { size: 11, color }, xanchor: "left", yanchor: "top" });
  };
  for (const [name, frequency] of Object.entries(result.lines)) if (!name.startsWith("shaft")) mark(frequency, plain(name), style("soft"), "dot");
  for (const each of result.test) mark(each.frequency, `test ${plain(each.line)}`, style("mark"), "dash");
  const y = scale === "log" ? { type: "log", range: top > 0 ? [Math.max(Math.log10(top) - 5, Math.log10(low) - 0.2), Math.log10(top) + 0.5] : [-6, 0], dtick: 1 } : { type: "linear", rangemode: "tozero" };
  return Plotly.react("spectrum", traces, layout({ ...roomFor(overlay), uirevision: `${spectrum}${scale}`, shapes, annotations,
    xaxis: axis("frequency [Hz]", { type: "log" }), yaxis: axis("amplitude of acceleration [m/s²]", y) }), CONFIG);
}

/** Return the two edges of a spectrum's spread over the members, filled between. */
function band({ f, a, s }, model) {
  const edge = (sign) => ({ x: f, y: Float64Array.from(a, (value, i) => value * 10 ** (sign * s[i])), mode: "lines", line: { width: 0 }, hoverinfo: "skip", showlegend: false });
  return [edge(-1), { ...edge(1), fill: "tonexty", fillcolor: `${style(model)}33` }];
}

/** Return the time axis that all histories of a run share. */
function timeAxis(result) {
  const { t } = result.models[names(result)[0]].frames;
  return axis("time [s]", { anchor: "y2", range: t.length ? [t[0], t[t.length - 1]] : undefined });
}

function drawBacklash(result, { mesh }) {
  const traces = [];
  for (const model of names(result)) {
    for (const { signal, label, t, v } of result.models[model].histories) {
      if (label !== mesh || !["backlash", "center_distance"].includes(signal)) continue;
      const upper = signal === "backlash";
      traces.push({ x: t, y: scaled(v, upper ? 1e6 : 1e3), mode: "lines", line: lineOf(model), yaxis: upper ? "y" : "y2", name: model,
        legendgroup: model, showlegend: upper, hovertemplate: upper ? "%{y:.4g} µm at %{x:.5f} s" : "%{y:.5f} mm at %{x:.5f} s" });
    }
  }
  return Plotly.react("backlash", traces, layout({ uirevision: `${mesh}`, xaxis: timeAxis(result), yaxis: axis("backlash [µm]", { domain: [0.55, 1] }),
    yaxis2: axis("centres [mm]", { domain: [0, 0.45], tickformat: ".4f" }) }), CONFIG);
}

/** Draw the forces of a sleeve and of both flanks of a mesh, and below when each was closed. Colours say the model, dashes the contact. */
function drawForces(result, { sleeve, mesh }) {
  const traces = [];
  const ticks = [];
  const wanted = new Map([[sleeve, "sleeve"], [`${mesh}:drive`, "drive"], [`${mesh}:back`, "back"]]);
  for (const model of names(result)) {
    const first = model === names(result)[0];
    for (const { signal, label, t, v } of result.models[model].histories) {
      const { words, dash } = SIGNALS[signal] ?? {};
      if (!words || label !== (signal === "sleeve_force" ? sleeve : mesh)) continue;
      traces.push({ x: t, y: v, mode: "lines", line: lineOf(model, dash), name: words, legendgroup: words, showlegend: first,
        hovertemplate: `${words === "sleeve" ? words : `${words} flank`}, ${model}: %{y:.4g} N at %{x:.5f} s<extra></extra>` });
    }
    for (const { label, spans } of result.models[model].strip) {
      if (!wanted.has(label)) continue;
      const x = [];
      const y = [];
      for (let i = 0; i < spans.length; i += 2) { x.push(spans[i], spans[i + 1], null); y.push(ticks.length, ticks.length, null); }
      traces.push({ x, y, mode: "lines+markers", marker: { size: 3, symbol: "line-ns", line: { width: 1.5, color: style(model) } },
        line: { color: style(model), width: 7 }, yaxis: "y2", showlegend: false, hovertemplate: `${plain(label)}, ${model}: closed at %{x:.5f} s<extra></extra>` });
      ticks.push(wanted.get(label));
    }
  }
  return Plotly.react("forces", traces, layout({ uirevision: `${sleeve}${mesh}`, xaxis: timeAxis(result), yaxis: axis("force [N]", { domain: [0.45, 1] }),
    yaxis2: axis("in contact", { domain: [0, 0.36], tickmode: "array", tickvals: ticks.map((_, i) => i), ticktext: ticks, range: [-0.6, ticks.length - 0.4],
      tickfont: { size: 10 }, zeroline: false }) }), CONFIG);
}

/** Fill the table of contacts; return what is to be said of it. */
export function fillStatistics(table, result) {
  const head = ["model", "contact", "share of time", "impacts", "impacts [1/s]", "rms impact speed [mm/s]", "largest force [N]"];
  const row = (cells, kind) => {
    const line = document.createElement("tr");
    for (const text of cells) {
      const cell = document.createElement(kind);
      if (kind === "th") cell.scope = "col";
      cell.textContent = text;
      line.append(cell);
    }
    return line;
  };
  const rows = [row(head, "th")];
  for (const model of names(result)) {
    for (const each of result.models[model].statistics) {
      rows.push(row([model, each.contact, `${(100 * each.share_of_time).toPrecision(3)} %`, String(each.impacts), each.impacts_per_second.toPrecision(3),
        `${(1e3 * each.rms_impact_speed).toPrecision(3)}${each.angular ? " mrad/s" : ""}`,
        `${each.peak_force.toPrecision(3)}${each.angular ? " N m" : ""}`], "td"));
    }
  }
  table.replaceChildren(...rows);
  const counts = names(result).flatMap((model) => result.models[model].statistics.map((each) => each.impacts)).filter((count) => count > 0);
  const few = counts.length > 0 && Math.max(...counts) < FEW;
  const of = result.members > 1 ? `Spectra and contacts are averages over ${result.members} members; the other views are of the first. ` : "";
  return `${of}${few ? `Only ${Math.max(...counts)} impacts: such numbers, and the spectrum, change from run to run. Lengthen run: duration, or raise ensemble.` : ""}`;
}
