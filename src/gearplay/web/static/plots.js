// The plots of a run: orbit, spectrum, backlash, forces and contacts; and the table of contacts.

import { MODELS, axis, draw, layout, micro, pause, plain, scaled } from "./plotting.js";
import { style } from "./colors.js";

const SIGNALS = {
  drive_force: { words: "drive", dash: "solid" },
  back_force: { words: "back", dash: "dot" },
  sleeve_force: { words: "sleeve", dash: "dash" },
  bearing_force: { words: "bearing", dash: "dash" },
};
const FEW = 30; // impacts
const lineOf = (model, dash = "solid", width = 1.1) => ({ color: style(model), width, dash });
const names = (result) => MODELS.filter((model) => model in result.models);
const loudness = (curves) => curves.flatMap((curve) => Array.from(curve)).reduce((sum, value) => sum + (Number.isFinite(value) ? Math.abs(value) : 0), 0);
/** Return the models, the quieter last, which is drawn over the other; `curvesOf` a view says what is drawn of it. */
function quietLast(result, curvesOf) {
  const sizes = Object.fromEntries(names(result).map((model) => [model, loudness(curvesOf(result.models[model]))]));
  return names(result).sort((one, other) => sizes[other] - sizes[one]);
}
/** Return the views that hold averages: of the members that were run beside, where they are in, else of the run itself. */
const averaged = (result) => result.average?.models ?? result.models;
const rank = (model) => 1 + MODELS.indexOf(model); // in legends, whatever lies on top

const inView = (name) => {
  const { top, bottom, height } = document.getElementById(name).getBoundingClientRect();
  return height > 0 && bottom > 0 && top < window.innerHeight;
};

/**
 * Draw a run while `wanted()` returns true, first the plots that are seen; return what draws the others, one by one.
 * `look` names the sleeve and the mesh that are looked at, and the spectrum (`spectrum`, `scale`).
 */
export async function drawRun(result, look, wanted) {
  const draws = { orbit: drawOrbit, spectrum: drawSpectrum, backlash: drawBacklash, forces: drawForces };
  const [near, far] = [Object.keys(draws).filter(inView), Object.keys(draws).filter((name) => !inView(name))];
  for (const name of near) if (wanted()) await draws[name](result, look);
  return async () => {
    for (const name of far) {
      await pause();
      if (!wanted()) return false;
      if (document.getElementById(name).offsetParent === null) continue; // on a tab that is not shown: drawn when it is
      await draws[name](result, look);
    }
    return wanted();
  };
}

/** Return the views of an earlier run that lies beside this one, with words for its models. */
const overlaid = (overlay) => Object.entries(overlay?.models ?? {}).map(([model, view]) => ({ model, view, words: `earlier, ${model}` }));
const ghost = (model) => ({ color: `${style(model)}70`, width: 0.9 }); // behind what is of now
const roomFor = (overlay) => (overlay ? { margin: { l: 74, r: 14, t: 52, b: 42, autoexpand: false } } : {}); // for a second row of the legend

function drawOrbit(result, { sleeve, overlay }) {
  const traces = [];
  for (const model of quietLast(result, (view) => view.orbits.filter((each) => each.name === sleeve).flatMap((each) => [each.x, each.y]))) {
    const orbit = result.models[model].orbits.find((each) => each.name === sleeve);
    if (!orbit) continue;
    if (!traces.length) {
      const [c, angle] = [1e6 * orbit.clearance, Array.from({ length: 181 }, (_, i) => (i * Math.PI) / 90)];
      traces.push({ x: angle.map((a) => c * Math.cos(a)), y: angle.map((a) => c * Math.sin(a)), mode: "lines", hoverinfo: "skip",
        line: { color: style("soft"), width: 1.2 }, showlegend: false });
    }
    traces.push({ x: scaled(orbit.x, 1e6), y: scaled(orbit.y, 1e6), mode: "lines", line: lineOf(model, "solid", 0.9), name: model, legendrank: rank(model),
      hovertemplate: "%{x:.4g}, %{y:.4g} µm" });
  }
  for (const { view, words, model } of overlaid(overlay)) {
    const orbit = view.orbits.find((each) => each.name === sleeve);
    if (orbit) traces.unshift({ x: scaled(orbit.x, 1e6), y: scaled(orbit.y, 1e6), mode: "lines", line: ghost(model), name: words });
  }
  if (!traces.length) return draw("orbit", [], layout({ uirevision: "none", xaxis: axis("", { visible: false, range: [0, 1] }), yaxis: axis("", { visible: false, range: [0, 1] }),
    annotations: [{ x: 0.02, y: 0.95, yref: "paper", text: "held: no orbit to draw", showarrow: false, font: { size: 12, color: style("soft") }, xanchor: "left", yanchor: "top" }] }));
  const on = Object.values(result.models)[0].orbits.find((each) => each.name === sleeve)?.on;
  const beside = on ? " beside the pin" : ""; // in axes that turn with the carrier
  return draw("orbit", traces, layout({ ...roomFor(overlay), uirevision: `${sleeve}`, xaxis: axis(`x${beside} [µm]`, { scaleanchor: "y" }), yaxis: axis(`y${beside} [µm]`) }));
}

export function drawSpectrum(result, { spectrum, scale, overlay }) {
  const traces = [];
  let [top, low] = [0, Infinity];
  const chosen = (view) => view.spectra.filter((each) => `${each.label}.${each.signal}` === spectrum);
  const views = averaged(result);
  for (const model of quietLast({ models: views }, (view) => chosen(view).map(({ a }) => a))) {
    const [found] = chosen(views[model]);
    if (!found || !found.a.some((value) => value > 0)) continue; // nothing moves
    for (const value of found.a) { top = Math.max(top, value); if (value > 0) low = Math.min(low, value); }
    if (found.s) traces.push(...band(found, model));
    traces.push({ x: found.f, y: found.a, mode: "lines", line: lineOf(model), name: model, legendrank: rank(model),
      hovertemplate: "%{y:.4g} m/s² at %{x:.5g} Hz" });
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
  const marks = Object.entries(result.lines).filter(([name]) => !name.startsWith("shaft")).map(([name, frequency]) => ({ frequency, text: plain(name), color: style("soft"), dash: "dot" }));
  marks.push(...result.test.map((each) => ({ frequency: each.frequency, text: `test ${plain(each.line)}`, color: style("mark"), dash: "dash" })));
  const [shapes, annotations] = marked(marks.filter(({ frequency }) => frequency > 0), traces.map(({ x }) => x));
  const y = scale === "log" ? { type: "log", range: top > 0 ? [Math.max(Math.log10(top) - 5, Math.log10(low) - 0.2), Math.log10(top) + 0.5] : [-6, 0], dtick: 1 } : { type: "linear", rangemode: "tozero" };
  return draw("spectrum", traces, layout({ ...roomFor(overlay), uirevision: `${spectrum}${scale}`, shapes, annotations,
    xaxis: axis("frequency [Hz]", { type: "log" }), yaxis: axis("amplitude of acceleration [m/s²]", y) }));
}

const [LETTER, ROWS, ROW] = [6.4, 9, 0.07]; // px of a letter; rows of names, and the height of one as a share of the plot

/**
 * Return lines at frequencies and their names: each in the first row in which it lies over no other. One for which no row has room
 * has a line alone.
 */
function marked(marks, curves) {
  const known = [...marks.map(({ frequency }) => frequency), ...curves.flatMap((x) => (x?.length ? [x[0], x[x.length - 1]] : []))].filter((f) => f > 0);
  const [low, high] = [Math.log10(Math.min(...known)), Math.log10(Math.max(...known))];
  const length = document.getElementById("spectrum").clientWidth - 88;
  const rooms = marks.map(({ frequency, text }) => ((Math.log10(frequency) - low) * length) / (length - LETTER * text.length)); // decades for the last name to fit
  const scale = length / Math.max(high - low, ...rooms, 1e-9); // px of a decade
  const ends = Array(ROWS).fill(-Infinity);
  const annotations = [];
  for (const { frequency, text, color } of [...marks].sort((one, other) => one.frequency - other.frequency)) {
    const at = scale * (Math.log10(frequency) - low);
    const row = ends.findIndex((end) => at > end);
    if (row < 0) continue;
    ends[row] = at + LETTER * text.length + 6;
    annotations.push({ x: Math.log10(frequency), y: 1 - ROW * row, yref: "paper", text, showarrow: false, font: { size: 11, color }, xanchor: "left", yanchor: "top" });
  }
  const shapes = marks.map(({ frequency, color, dash }) => ({ type: "line", x0: frequency, x1: frequency, yref: "paper", y0: 0, y1: 1, line: { color, width: 1, dash }, layer: "below" }));
  return [shapes, annotations];
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
  const swings = (view) => view.histories.filter((each) => each.label === mesh && each.signal === "backlash").map(({ v }) => v.map((value) => value - v[0]));
  for (const model of quietLast(result, swings)) {
    for (const { signal, label, t, v } of result.models[model].histories) {
      if (label !== mesh || !["backlash", "center_distance"].includes(signal)) continue;
      const upper = signal === "backlash";
      traces.push({ x: t, y: scaled(v, upper ? 1e6 : 1e3), mode: "lines", line: lineOf(model), yaxis: upper ? "y" : "y2", name: model,
        legendrank: rank(model), legendgroup: model, showlegend: upper, hovertemplate: upper ? "%{y:.4g} µm at %{x:.5f} s" : "%{y:.5f} mm at %{x:.5f} s" });
    }
  }
  const distances = traces.filter(({ yaxis }) => yaxis === "y2").map(({ y }) => y);
  const span = Math.max(...distances.map((y) => Math.max(...y))) - Math.min(...distances.map((y) => Math.min(...y)));
  const digits = span > 0 ? Math.min(6, Math.max(0, 1 - Math.floor(Math.log10(span)))) : 3; // a tenth of what the distance does
  const size = distances.length && distances[0][0].toFixed(digits).length > 7 ? 9 : 12; // px
  return draw("backlash", traces, layout({ uirevision: `${mesh}`, xaxis: timeAxis(result), yaxis: axis("backlash [µm]", { domain: [0.55, 1] }),
    yaxis2: axis("centres [mm]", { domain: [0, 0.45], tickformat: `.${digits}f`, tickfont: { size } }) }));
}

/** Draw the forces of a sleeve or bearing and of both flanks of a mesh, and below when each was closed. Colours say the model, dashes the contact. */
function drawForces(result, { sleeve, mesh }) {
  const traces = [];
  const ticks = [];
  const wanted = { [sleeve]: "sleeve", [`${mesh}:drive`]: "drive", [`${mesh}:back`]: "back" };
  const rowOf = (label) => wanted[label] ?? (label.startsWith(`${sleeve}:element`) ? label.slice(sleeve.length + 1) : undefined);
  const drawn = ({ signal, label }) => signal in SIGNALS && label === (["drive_force", "back_force"].includes(signal) ? mesh : sleeve);
  for (const model of quietLast(result, (view) => view.histories.filter(drawn).map(({ v }) => v))) {
    const first = model === names(result)[0];
    for (const { signal, t, v } of result.models[model].histories.filter(drawn)) {
      const { words, dash } = SIGNALS[signal];
      traces.push({ x: t, y: v, mode: "lines", line: lineOf(model, dash), name: words, legendgroup: words, showlegend: first,
        hovertemplate: `${["drive", "back"].includes(words) ? `${words} flank` : words}, ${model}: %{y:.4g} N at %{x:.5f} s<extra></extra>` });
    }
  }
  for (const model of names(result)) {
    for (const { label, spans } of result.models[model].strip) {
      if (!rowOf(label)) continue;
      const x = [];
      const y = [];
      for (let i = 0; i < spans.length; i += 2) { x.push(spans[i], spans[i + 1], null); y.push(ticks.length, ticks.length, null); }
      traces.push({ x, y, mode: "lines+markers", marker: { size: 3, symbol: "line-ns", line: { width: 1.5, color: style(model) } },
        line: { color: style(model), width: 7 }, yaxis: "y2", showlegend: false, hovertemplate: `${plain(label)}, ${model}: closed at %{x:.5f} s<extra></extra>` });
      ticks.push(rowOf(label));
    }
  }
  return draw("forces", traces, layout({ uirevision: `${sleeve}${mesh}`, xaxis: timeAxis(result), yaxis: axis("force [N]", { domain: [0.45, 1] }),
    yaxis2: axis("in contact", { domain: [0, 0.36], tickmode: "array", tickvals: ticks.map((_, i) => i), ticktext: ticks, range: [-0.6, ticks.length - 0.4],
      tickfont: { size: 10 }, zeroline: false }) }));
}

/** Return a number to three digits, as it is read: 0.100, 12.0, 1260. */
const threeDigits = (value) => (Math.abs(value) < 999.5 || Math.abs(value) >= 1e6 ? value.toPrecision(3) : String(Number(value.toPrecision(3))));

/** Return a number with half its 95 % interval, where there is one, to the digit that this leaves sense. */
function known(value, half) {
  if (!(half > 0)) return threeDigits(value);
  const digits = Math.min(8, Math.max(0, 1 - Math.floor(Math.log10(half))));
  return `${value.toFixed(digits)} ± ${half.toFixed(digits)}`;
}

/** Return a row of a table with these cells. */
function row(cells, kind) {
  const line = document.createElement("tr");
  for (const text of cells) {
    const cell = document.createElement(kind);
    if (kind === "th") cell.scope = "col";
    cell.textContent = text;
    line.append(cell);
  }
  return line;
}

/** Fill the list of key numbers of the output shaft, a value for each model; return its title and what is to be said of it. */
export function fillOutput(list, result) {
  const shafts = names(result).map((model) => [model, new Map(result.models[model].output.rows)]);
  const kinds = new Set(shafts.flatMap(([, rows]) => [...rows.keys()]));
  const made = (kind, text, model) => Object.assign(document.createElement(kind), { textContent: text, className: model && shafts.length > 1 ? `${model}-text` : "", title: model ?? "" });
  list.replaceChildren(...[...kinds].map((kind) => {
    const tile = document.createElement("div");
    tile.append(made("dt", kind), ...shafts.map(([model, rows]) => made("dd", micro(rows.get(kind) ?? ""), model)));
    return tile;
  }));
  const { title, note } = result.models[names(result)[0]].output;
  return { title, note };
}

/** Fill the table of contacts, those with impacts first; return what is to be said of it. */
export function fillStatistics(table, result) {
  const head = ["model", "contact", "share of time", "impacts", "impacts [1/s]", "rms impact speed [mm/s]", "largest force [N]"];
  const rows = [row(head, "th")];
  const views = averaged(result);
  for (const model of names(result)) {
    for (const each of [...views[model].statistics].sort((a, b) => b.impacts - a.impacts || b.share_of_time - a.share_of_time)) {
      const shown = (name, factor) => known(factor * each[name], factor * (each.half?.[name] ?? 0));
      rows.push(row([model, each.contact, `${shown("share_of_time", 100)} %`, String(each.impacts), shown("impacts_per_second", 1),
        `${shown("rms_impact_speed", 1e3)}${each.angular ? " mrad/s" : ""}`,
        `${threeDigits(each.peak_force)}${each.angular ? " N m" : ""}`], "td"));
    }
  }
  table.replaceChildren(...rows);
  return wordsOf(result);
}

/** Say what the table and the spectrum are of, and how far they are to be trusted. */
function wordsOf(result) {
  const { average, members } = result;
  if (average) {
    return `Contacts are means over ${average.members} members of ${average.duration} s after ${average.transient} s, from drawn starts; ± holds 95 %. `
      + `The spectrum is the average of ${average.records} members as long as the run shown, its band one standard deviation of a member. The other views are of one run.`;
  }
  const counts = Object.values(result.models).flatMap(({ statistics }) => statistics.map((each) => each.impacts)).filter((count) => count > 0);
  const few = counts.length > 0 && Math.max(...counts) < FEW;
  const of = members > 1 ? `Spectra and contacts are averages over ${members} members, ± holds 95 %; the other views are of the first. ` : "";
  return `${of}${few ? `Only ${Math.max(...counts)} impacts: such numbers, and the spectrum, change from run to run. Lengthen run: duration, or raise ensemble.` : ""}`;
}
