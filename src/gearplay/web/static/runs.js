// Runs of the case as it stands, and all views of the last one.

import { averageOf, dropAverage } from "./averages.js";
import { moveCursors } from "./cursors.js";
import { Stage } from "./mechanism.js";
import { $, confess, current, note, showTitle, state, showMessage } from "./page.js";
import { drawRun, drawSpectrum, fillOutput, fillStatistics } from "./plots.js";
import { takeOver, takeOverSoon } from "./plotting.js";
import { decode } from "./wire.js";

const LONGEST_RUN = 1000; // ms before a run gives way to a newer one
export const stage = new Stage($("stage"), moved);

export const models = () => ($("compare").checked ? ["coupled", "uncoupled"] : [current().backlash_model]);

/**
 * Run the case as it stands. While one runs the next waits, and only the last of those; one that takes long gives way to it. The next
 * begins before the result is drawn.
 */
export async function run() {
  const { wire } = state;
  state.upToDate = false; // until a connection that is not there yet runs it
  if (!state.base) return;
  if (!wire?.ready) { outdate(); return; }
  if (state.running) {
    const { running } = state;
    if (!state.again) setTimeout(() => { if (state.running === running && state.again) wire.cancel(running.number); }, state.began + LONGEST_RUN - performance.now());
    state.again = true;
    return;
  }
  dropAverage();
  if (state.unkept) { state.unkept = false; showMessage(""); }
  const { generation } = state;
  const began = state.moved || performance.now();
  state.moved = 0;
  state.began = performance.now();
  const words = { case: current(), models: models(), note: note() }; // before anything is noted as running: it may fail
  const job = wire.submit("run", words, (done) => showProgress(done, job.number, state.began));
  state.running = job;
  try {
    const result = await job;
    state.running = null;
    next();
    if (generation !== state.generation) return; // of a case that is no longer there
    state.requested = began;
    await showRun(result);
    window.gearplay.latencies.push(performance.now() - began);
    state.kept();
    if (state.ofRun) showMessage("");
  } catch (error) {
    if (error.kind === "full") setTimeout(() => { state.again = true; next(); }, 500);
    else if (!error.kind) { confess(error); outdate(); }
    else if (error.kind !== "cancelled" && wire.ready) { showMessage(error.message, true); if (generation === state.generation) outdate(); }
  } finally {
    if (state.running === job) { state.running = null; next(); }
    if (!state.job && !state.running) hideProgress();
  }
}

/** Show the result that came with the page; where there is none, or of another choice of models, run the case. */
export async function begin(given) {
  if (!given || $("compare").checked) return run();
  const began = performance.now();
  const { buffer } = Uint8Array.from(atob(given.frame), (letter) => letter.charCodeAt(0));
  state.upToDate = true;
  state.requested = began;
  await showRun({ ...decode(buffer), key: given.key });
  window.gearplay.latencies.push(performance.now() - began);
}

function next() {
  if (state.again && !state.running) { state.again = false; run(); }
}

/** Grey what is shown, since it is not of the case as it stands, and say so; take that back with a new result. */
export function outdate(old = true) {
  $("stale").hidden = !old || !state.result;
  $("panel-run").classList.toggle("outdated", old);
}

/** Tell the warnings about a case, as `gearplay check` has them. */
function tellNotes({ warnings = [] }) {
  $("notes").hidden = warnings.length === 0;
  $("notes").querySelector("summary").textContent = warnings.length === 1 ? "1 warning about this case" : `${warnings.length} warnings about this case`;
  $("notes").querySelector("ul").replaceChildren(...warnings.map((words) => Object.assign(document.createElement("li"), { textContent: words })));
}

/** Offer choices in a list, keep the one that is chosen where it is still there, and return it. */
function offer(select, choices) {
  const chosen = choices.includes(select.value) ? select.value : choices[0] ?? "";
  if ([...select.options].map((each) => each.value).join() !== choices.join()) select.replaceChildren(...choices.map((each) => new Option(each, each)));
  select.value = chosen;
  return chosen;
}

/** Return what of a result is looked at: a shaft, a mesh, a spectrum; lists with one choice are not shown. */
function lookAt(result) {
  const { sleeves, meshes } = result.mechanism;
  const free = Object.values(result.models).flatMap((view) => view.orbits.map((each) => each.name));
  const shafts = [...new Set([...sleeves.map((each) => each.name), ...free])];
  const spectra = Object.values(result.models).flatMap((view) => view.spectra.map((each) => `${each.label}.${each.signal}`));
  $("look-sleeve").hidden = shafts.length < 2;
  $("look-mesh").hidden = meshes.length < 2;
  return {
    sleeve: offer($("sleeve-of"), shafts), mesh: offer($("mesh-of"), meshes.map((each) => each.name)),
    spectrum: offer($("spectrum-of"), [...new Set(spectra)]), scale: $("spectrum-scale").value, overlay: state.overlay,
  };
}

/** Count the times of a result from the start of the simulation, once; they come as 32 bits from the first sample on. */
function settle(result) {
  if (result.settled) return;
  result.settled = true;
  for (const view of Object.values(result.models)) {
    const shifted = (times) => Float64Array.from(times, (t) => t + view.start);
    view.frames.t = shifted(view.frames.t);
    for (const each of view.histories) each.t = shifted(each.t);
    for (const each of view.strip) each.spans = shifted(each.spans);
  }
}

export async function showRun(result) {
  settle(result);
  state.result = result;
  outdate(false);
  tellNotes(result);
  const look = lookAt(result);
  stage.look = look;
  stage.show(result);
  moved();
  magnified();
  showTitle();
  $("backlash-card").hidden = !result.mechanism.meshes.length;
  $("forces-models").hidden = Object.keys(result.models).length < 2;
  $("carrier-row").hidden = !Object.values(result.models).some(({ frames }) => frames.orbit?.some((angle) => angle));
  $("arrows").textContent = `arrows: forces, the longest ${Number(stage.peak.toPrecision(3))} N`;
  const { title, note: noted } = fillOutput($("output"), result);
  $("output-title").textContent = title;
  $("output-note").textContent = noted;
  $("few").textContent = fillStatistics($("statistics"), result);
  const words = Object.entries(result.models).map(([model, view]) => `${model}: ${view.finished ? "" : `${view.status} `}${view.steps} steps, ${view.events} events, ${(1e3 * view.wall_time).toFixed(0)} ms`);
  $("status").textContent = words.join("; ");
  window.gearplay.moving ??= performance.now();
  state.whole = false;
  const wanted = () => stage.look === look;
  const drawRest = await drawRun(result, look, wanted);
  window.gearplay.first ??= performance.now();
  moved();
  drawOthers(drawRest, result, wanted);
}

/** Draw the plots that are not in view, then all of them with plotly.js, and request averages; unless a newer result comes. */
async function drawOthers(drawRest, result, wanted) {
  try {
    if (!(await drawRest())) return;
    moved();
    window.gearplay.whole.push(performance.now() - state.requested);
    if (!(await takeOverSoon(wanted))) return;
    moved();
    state.whole = true;
    if (await averageOf(result) && wanted()) {
      $("few").textContent = fillStatistics($("statistics"), result);
      await redrawSpectrum();
    }
  } catch (error) { showMessage(error.message); }
}

export const redraw = () => { if (state.result) showRun(state.result).catch((error) => showMessage(error.message)); };

/** Draw the spectrum of the result that is shown anew. */
export async function redrawSpectrum() {
  if (!state.result) return;
  try {
    await drawSpectrum(state.result, lookAt(state.result));
    await takeOver();
  } catch (error) { showMessage(error.message); }
}

/** Show the progress of a job, and an estimate of its end once there is one. */
export function showProgress(done, number, began) {
  if (state.job && state.job.number !== number) return; // a diagram keeps the bar
  $("progress").value = done;
  $("cancel").onclick = () => { state.wire.cancel(number); $("left").textContent = "cancelling"; };
  const spent = (performance.now() - began) / 1000;
  const left = Math.max(1, spent * (1 / done - 1));
  $("left").textContent = done > 0.02 && spent > 1 ? `about ${left.toPrecision(left < 9.5 ? 1 : 2)} s left` : "";
  $("job").hidden = false;
}

export function hideProgress() { $("job").hidden = true; }

/** Show where the motion is: on the clock, the slider and the plots. */
export function moved() {
  $("scrub").value = stage.at;
  $("clock").textContent = `${stage.time.toFixed(4)} s`;
  moveCursors(state.result, stage.look.sleeve, stage.time);
}

/** Go to the next time that a contact which is looked at closes, in any model; from the last one to the first. */
export function toNextImpact() {
  if (!state.result) return;
  const { sleeve, mesh } = stage.look;
  const wanted = [sleeve, `${mesh}:drive`, `${mesh}:back`];
  const [begin, end] = stage.span;
  const strips = Object.values(state.result.models).flatMap(({ strip }) => strip.filter(({ label }) => wanted.includes(label)));
  const onsets = strips.flatMap(({ spans }) => Array.from(spans).filter((_, i) => i % 2 === 0)).filter((t) => t > begin && t <= end).sort((a, b) => a - b);
  const frame = (end - begin) / 900;
  const next = onsets.find((t) => t > stage.time + 0.5 * frame) ?? onsets[0];
  if (next === undefined) { showMessage("No contact that is looked at closes in this run.", true); return; }
  stage.at = Math.min(0.9999, (next - begin) / (end - begin));
  stage.draw();
  moved();
}

export function magnified() { if (state.result) $("factor").textContent = `${stage.factor.toPrecision(3)} times as large`; }
