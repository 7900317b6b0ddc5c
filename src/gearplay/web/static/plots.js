// The plots of a result, drawn with plotly.js in the colours of the page.

const style = (name) => getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
export const MODELS = ["coupled", "uncoupled"];
const CONFIG = { responsive: true, displaylogo: false, modeBarButtonsToRemove: ["lasso2d", "select2d", "autoScale2d"],
  toImageButtonOptions: { format: "svg", filename: "gearplay" } };
const SIGNALS = {
  backlash: { words: "backlash", unit: "µm", factor: 1e6 },
  center_distance: { words: "centre distance", unit: "mm", factor: 1e3 },
  drive_force: { words: "drive", unit: "N", factor: 1 },
  back_force: { words: "back", unit: "N", factor: 1 },
  sleeve_force: { words: "sleeve", unit: "N", factor: 1 },
};
// Text from a case must show as it is: plotly takes <b> and its like for formatting.
export const plain = (text) => String(text).replace(/&/g, "&amp;").replace(/</g, "&lt;").replace(/>/g, "&gt;");
export const shownUnit = (unit) => (unit || "1").replace("um", "µm");
// SI as results are, to what is read easily: unit and factor.
const SHOWN = { m: ["µm", 1e6], "m/s": ["mm/s", 1e3], rad: ["mrad", 1e3], "m/s^2": ["m/s²", 1], 1: ["%", 100] };
const shownAs = (unit) => SHOWN[unit] ?? [unit, 1];
const scaled = (array, factor) => Float64Array.from(array, (value) => value * factor);

function layout(more = {}) {
  const axis = { gridcolor: style("grid"), zerolinecolor: style("line"), linecolor: style("line"), exponentformat: "e" };
  const { xaxis, yaxis, ...rest } = more;
  return {
    paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)", font: { color: style("ink"), size: 12 },
    margin: { l: 66, r: 14, t: 30, b: 42, autoexpand: false }, showlegend: true, legend: { orientation: "h", y: 1.02, yanchor: "bottom", x: 0 },
    hovermode: "closest", uirevision: "keep", xaxis: { ...axis, ...xaxis }, yaxis: { ...axis, ...yaxis }, ...rest,
  };
}

const lineOf = (model, dash) => ({ color: style(model), width: 1.1, dash });
const names = (result) => MODELS.filter((model) => model in result.models);

const pause = () => new Promise((resolve) => { setTimeout(resolve); });
const painted = () => new Promise((resolve) => { requestAnimationFrame(() => setTimeout(resolve)); setTimeout(resolve, 100); });

/** Fetch plotly.js, once. It keeps the browser busy for a while, so what is drawn already is shown before. */
let fetched = null;
async function plotly() {
  if (window.Plotly) return;
  fetched ??= painted().then(() => new Promise((resolve, reject) => {
    const script = document.createElement("script");
    script.src = "/plotly.js";
    script.onload = resolve;
    script.onerror = () => { fetched = null; reject(new Error("The plots need /plotly.js, which did not come. Load the page again.")); };
    document.head.append(script);
  }));
  await fetched;
}

const inView = (name) => {
  const { top, bottom, height } = document.getElementById(name).getBoundingClientRect();
  return height > 0 && bottom > 0 && top < window.innerHeight;
};

/** Draw a run, first the plots that are seen; return what draws the others, one by one, while `wanted()` says so. */
export async function drawRun(result, options) {
  await plotly();
  const draws = { orbit: drawOrbit, spectrum: (run) => drawSpectrum(run, options), backlash: drawBacklash, forces: drawForces };
  const [near, far] = [Object.keys(draws).filter(inView), Object.keys(draws).filter((name) => !inView(name))];
  for (const name of near) await draws[name](result);
  return async (wanted) => {
    for (const name of far) {
      await pause();
      if (!wanted()) return false;
      await draws[name](result);
    }
    return true;
  };
}

function drawOrbit(result) {
  const traces = [];
  const angle = Float64Array.from({ length: 181 }, (_, i) => (i * Math.PI) / 90);
  const shown = new Set();
  for (const model of names(result)) {
    for (const orbit of result.models[model].orbits) {
      const c = 1e6 * orbit.clearance;
      if (!shown.has(orbit.name)) {
        shown.add(orbit.name);
        traces.push({ x: angle.map((a) => c * Math.cos(a)), y: angle.map((a) => c * Math.sin(a)), mode: "lines", hoverinfo: "skip",
          line: { color: style("soft"), width: 1.2 }, name: `clearance of ${plain(orbit.name)}` });
      }
      traces.push({ x: scaled(orbit.x, 1e6), y: scaled(orbit.y, 1e6), mode: "lines", line: { ...lineOf(model), width: 0.9 },
        name: `${plain(orbit.name)}, ${model}` });
    }
  }
  return Plotly.react("orbit", traces, layout({ xaxis: { title: { text: "x [µm]" }, scaleanchor: "y" }, yaxis: { title: { text: "y [µm]" } } }), CONFIG);
}

export async function drawSpectrum(result, { of, scale }) {
  await plotly();
  const traces = [];
  let top = 0;
  for (const model of names(result)) {
    const found = result.models[model].spectra.find((each) => `${each.label}.${each.signal}` === of);
    if (!found) continue;
    for (const value of found.a) top = Math.max(top, value);
    traces.push({ x: found.f, y: found.a, mode: "lines", line: lineOf(model), name: model });
  }
  const shapes = [];
  const annotations = [];
  const mark = (frequency, text, color, dash, level) => {
    shapes.push({ type: "line", x0: frequency, x1: frequency, yref: "paper", y0: 0, y1: 1, line: { color, width: 1, dash }, layer: "below" });
    annotations.push({ x: Math.log10(frequency), y: level, yref: "paper", text, showarrow: false, font: { size: 11, color }, xanchor: "left", yanchor: "top" });
  };
  for (const [name, frequency] of Object.entries(result.lines)) if (!name.startsWith("shaft")) mark(frequency, plain(name), style("soft"), "dot", 1);
  for (const each of result.test) mark(each.frequency, `test ${plain(each.line)}`, style("mark"), "dash", 0.9);
  const y = scale === "log" ? { type: "log", range: top > 0 ? [Math.log10(top) - 5, Math.log10(top) + 0.3] : undefined, dtick: 1 } : { type: "linear", rangemode: "tozero" };
  return Plotly.react("spectrum", traces, layout({ uirevision: `${of}${scale}`, shapes, annotations,
    xaxis: { title: { text: "frequency [Hz]" }, type: "log" }, yaxis: { title: { text: "acceleration [m/s²]" }, ...y } }), CONFIG);
}

function history(result, signals) {
  const traces = [];
  const many = result.mechanism.meshes.length + result.mechanism.sleeves.length > 2;
  for (const model of names(result)) {
    for (const each of result.models[model].histories) {
      const [place, dash] = signals[each.signal] ?? [];
      if (!place) continue;
      const { words, unit, factor } = SIGNALS[each.signal];
      traces.push({ x: each.t, y: scaled(each.v, factor), mode: "lines", line: lineOf(model, dash), yaxis: place,
        name: `${words}${many ? ` ${plain(each.label)}` : ""}, ${model}`, hovertemplate: `%{y:.4g} ${unit} at %{x:.5f} s` });
    }
  }
  return traces;
}

function drawBacklash(result) {
  const traces = history(result, { backlash: ["y", "solid"], center_distance: ["y2", "solid"] });
  for (const trace of traces) if (trace.yaxis === "y2") trace.showlegend = false;
  const axis = { gridcolor: style("grid"), exponentformat: "e" };
  return Plotly.react("backlash", traces, layout({ showlegend: traces.length <= 6,
    xaxis: { title: { text: "time [s]" }, anchor: "y2" }, yaxis: { title: { text: "backlash [µm]" }, domain: [0.55, 1] },
    yaxis2: { ...axis, title: { text: "centres [mm]" }, domain: [0, 0.45], tickformat: ".4f" } }), CONFIG);
}

function drawForces(result) {
  const traces = history(result, { drive_force: ["y", "solid"], back_force: ["y", "dot"], sleeve_force: ["y", "dash"] });
  const axis = { gridcolor: style("grid"), exponentformat: "e" };
  const labels = [];
  for (const model of names(result)) {
    for (const { label, spans } of result.models[model].strip) {
      const x = [];
      const y = [];
      for (let i = 0; i < spans.length; i += 2) { x.push(spans[i], spans[i + 1], null); y.push(labels.length, labels.length, null); }
      traces.push({ x, y, mode: "lines+markers", marker: { size: 3, symbol: "line-ns", line: { width: 1.5, color: style(model) } }, line: { color: style(model), width: 7 }, yaxis: "y2",
        showlegend: false, name: `${plain(label)}, ${model}`, hovertemplate: `${plain(label)} closed at %{x:.5f} s` });
      labels.push(plain(label.includes(":") ? label.split(":")[1] : label));
    }
  }
  return Plotly.react("forces", traces, layout({ showlegend: traces.length <= 12,
    xaxis: { title: { text: "time [s]" }, anchor: "y2" }, yaxis: { title: { text: "force [N]" }, domain: [0.45, 1] },
    yaxis2: { ...axis, domain: [0, 0.36], tickmode: "array", tickvals: labels.map((_, i) => i), ticktext: labels, range: [-0.6, labels.length - 0.4], tickfont: { size: 10 } } }), CONFIG);
}

export function fillStatistics(table, result) {
  const head = ["model", "contact", "share of time", "impacts [1/s]", "rms impact speed [mm/s]", "largest force [N]"];
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
      rows.push(row([model, each.contact, `${(100 * each.share_of_time).toPrecision(3)} %`, each.impacts_per_second.toPrecision(4),
        (1e3 * each.rms_impact_speed).toPrecision(3), each.peak_force.toPrecision(4)], "td"));
    }
  }
  table.replaceChildren(...rows);
}

export async function drawBifurcation(result, axis) {
  await plotly();
  const [unit, factor] = shownAs(result.unit);
  const traces = ["up", "down"].map((way) => {
    const [count, keep] = result[way].shape;
    const x = new Float64Array(count * keep);
    for (let i = 0; i < count; i++) x.fill(result.x[i] * axis.factor, i * keep, (i + 1) * keep);
    return { x, y: scaled(result[way], factor), mode: "markers", type: "scatter", name: way === "up" ? "up →" : "← down",
      marker: { size: 2, color: style(way === "up" ? "coupled" : "uncoupled"), opacity: 0.7 } };
  });
  return Plotly.react("bifurcation", traces, layout({ uirevision: result.path, xaxis: { title: { text: plain(`${axis.owner} ${axis.label} [${shownUnit(axis.unit)}]`.trim()) } },
    yaxis: { title: { text: plain(`${result.signal} [${unit}]`) } } }), CONFIG);
}

export async function drawMap(result, first, second) {
  await plotly();
  const [rows, columns] = result.values.shape;
  const [unit, factor] = shownAs(result.unit);
  const z = Array.from({ length: rows }, (_, i) => scaled(result.values.subarray(i * columns, (i + 1) * columns), factor));
  const words = (each) => plain(`${each.owner} ${each.label} [${shownUnit(each.unit)}]`.trim());
  return Plotly.react("map", [{ type: "heatmap", x: scaled(result.x, first.factor), y: scaled(result.y, second.factor), z, colorscale: "Viridis",
    colorbar: { title: { text: plain(`${result.measure} [${unit}]`), side: "right" } } }],
  layout({ showlegend: false, margin: { l: 66, r: 120, t: 12, b: 42, autoexpand: false }, uirevision: result.paths.join(), xaxis: { title: { text: words(first) } }, yaxis: { title: { text: words(second) } } }), CONFIG);
}
