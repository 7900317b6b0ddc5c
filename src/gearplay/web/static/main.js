// The page: a case, its controls, and what is computed from them.

import { Controls } from "./controls.js";
import { diagramWords, fillForms, mapWords } from "./forms.js";
import { drawBifurcation, drawMap } from "./diagrams.js";
import { moveCursors } from "./cursors.js";
import { drawRun, drawSpectrum, fillStatistics } from "./plots.js";
import { Stage } from "./mechanism.js";
import { Wire, decode, fetchJson } from "./wire.js";

const $ = (name) => document.getElementById(name);
const MOST_LINK = 64 * 1024;
const PATIENCE = 1000; // ms before a run gives way to a newer one
const state = { base: null, changes: new Map(), controls: [], result: null, measures: [], diagrams: {}, running: null, again: false, job: null, tab: "run", moved: 0, began: 0, asked: 0, whole: false };
window.gearplay = { state, latencies: [], whole: [] }; // times of runs [ms]: to the plots in view, to all of them

// Messages ------------------------------------------------------------------------------------------------------------------

function tell(words) {
  $("message").textContent = words;
  $("message").hidden = !words;
}

// The case ------------------------------------------------------------------------------------------------------------------

/** The case as it stands: the base with the changes in place. */
function current() {
  const made = structuredClone(state.base);
  for (const [path, value] of state.changes) {
    const parts = path.split(".");
    const last = parts.pop();
    let place = made;
    for (const part of parts) place = place[part];
    place[last] = value;
  }
  return made;
}

/** Take a case over, as the server describes it; what to show of it comes after. */
function adopt(described) {
  state.base = described.case;
  state.changes.clear();
  state.controls = described.controls;
  state.diagrams = {};
  panel.build(described.controls);
  panel.find($("find").value);
  $("title").textContent = described.title || "untitled";
  fillForms($("bifurcation-form"), $("map-form"), described);
  tell("");
}

function start(described) {
  adopt(described);
  run();
}

async function choose(name) {
  try { start(await fetchJson(`/api/cases/${encodeURIComponent(name)}`)); } catch (error) { tell(error.message); }
}

async function upload(file) {
  if (!file) return;
  if (file.size > 256 * 1024) { tell(`${file.name}: a case file has at most 256 kB. Shorten it.`); return; }
  try { start(await fetchJson("/api/case", { toml: await file.text() })); $("case").value = ""; } catch (error) { tell(error.message); }
}

const packText = (text) => btoa(String.fromCharCode(...new TextEncoder().encode(text))).replaceAll("+", "-").replaceAll("/", "_").replace(/=+$/, "");
const unpackText = (text) => new TextDecoder().decode(Uint8Array.from(atob(text.replaceAll("-", "+").replaceAll("_", "/")), (c) => c.charCodeAt(0)));

function link() { return `${location.origin}/#case=${packText(JSON.stringify(current()))}`; }

async function fromLink() {
  const found = /^#case=([A-Za-z0-9_-]+)$/.exec(location.hash);
  if (!found || found[1].length > MOST_LINK) return false;
  try {
    start(await fetchJson("/api/case", { case: JSON.parse(unpackText(found[1])) }));
    $("case").value = "";
  } catch (error) {
    tell(`The link's case cannot be used. ${error.message}`);
    return false;
  }
  return true;
}

// Runs ----------------------------------------------------------------------------------------------------------------------

function models() { return $("compare").checked ? ["coupled", "uncoupled"] : [current().backlash_model]; }

/** Run the case as it stands. While one runs the next waits, and only the last of those; one that takes long gives way to it. */
async function run() {
  if (!wire.ready || !state.base) return;
  if (state.running) {
    state.again = true;
    if (performance.now() - state.began > PATIENCE) wire.cancel(state.running.number);
    return;
  }
  const began = state.moved || performance.now();
  state.moved = 0;
  state.began = performance.now();
  const job = wire.ask("run", { case: current(), models: models() }, (done) => showProgress(done, job.number, state.began));
  state.running = job;
  try {
    const result = await job;
    state.asked = began;
    await showRun(result);
    window.gearplay.latencies.push(performance.now() - began);
    tell("");
  } catch (error) {
    if (error.kind === "full") setTimeout(() => { state.again = true; next(); }, 500);
    else if (error.kind !== "cancelled" && wire.ready) tell(error.message);
  } finally {
    state.running = null;
    hideProgress();
    next();
  }
}

function next() {
  if (state.again && !state.running) { state.again = false; run(); }
}

/** Offer choices in a list, keep the one that is chosen where it is still there, and return it. */
function offer(select, choices) {
  const chosen = choices.includes(select.value) ? select.value : choices[0] ?? "";
  if ([...select.options].map((each) => each.value).join() !== choices.join()) select.replaceChildren(...choices.map((each) => new Option(each, each)));
  select.value = chosen;
  return chosen;
}

/** Return what of a result is looked at: a sleeve, a mesh, a spectrum; lists with one choice are not shown. */
function lookAt(result) {
  const { sleeves, meshes } = result.mechanism;
  const spectra = Object.values(result.models).flatMap((view) => view.spectra.map((each) => `${each.label}.${each.signal}`));
  $("look-sleeve").hidden = sleeves.length < 2;
  $("look-mesh").hidden = meshes.length < 2;
  return {
    sleeve: offer($("sleeve-of"), sleeves.map((each) => each.name)), mesh: offer($("mesh-of"), meshes.map((each) => each.name)),
    spectrum: offer($("spectrum-of"), [...new Set(spectra)]), scale: $("spectrum-scale").value,
  };
}

async function showRun(result) {
  state.result = result;
  const look = lookAt(result);
  stage.look = look;
  stage.show(result);
  moved();
  magnified();
  fillStatistics($("statistics"), result);
  const words = Object.entries(result.models).map(([model, view]) => `${model}: ${view.finished ? "done" : view.status} ${view.steps} steps, ${view.events} events, ${(1e3 * view.wall_time).toFixed(0)} ms`);
  $("status").textContent = words.join("; ");
  window.gearplay.moving ??= performance.now();
  state.whole = false;
  const drawRest = await drawRun(result, look);
  window.gearplay.first ??= performance.now();
  moved();
  drawOthers(drawRest, result);
}

/** Draw the plots that are not in view, unless a newer result comes. */
async function drawOthers(drawRest, result) {
  try {
    if (!(await drawRest(() => state.result === result))) return;
    state.whole = true;
    window.gearplay.whole.push(performance.now() - state.asked);
  } catch (error) { tell(error.message); }
}

/** Show how far a job is that began when asked, and an estimate once there is something to estimate from. */
function showProgress(done, number, began) {
  $("progress").value = done;
  $("cancel").onclick = () => wire.cancel(number);
  const spent = (performance.now() - began) / 1000;
  const left = Math.max(1, spent * (1 / done - 1));
  $("left").textContent = done > 0.02 && spent > 1 ? `about ${left.toPrecision(left < 9.5 ? 1 : 2)} s left` : "";
  $("job").hidden = false;
}

function hideProgress() { $("job").hidden = true; }

// Diagrams and maps ---------------------------------------------------------------------------------------------------------

async function longJob(kind, words) {
  if (state.job) { tell("One diagram or map at a time: cancel the one that runs."); return; }
  tell("");
  const began = performance.now();
  const job = wire.ask(kind, { case: current(), ...words }, (done) => showProgress(done, job.number, began));
  state.job = job;
  showProgress(0, job.number, began);
  try {
    await showDiagram(await job);
    listResults();
  } catch (error) {
    tell(error.message);
  } finally {
    state.job = null;
    hideProgress();
  }
}

async function showDiagram(result) {
  state.diagrams[result.kind] = result;
  const named = (path) => state.controls.find((each) => each.path === path);
  if (result.kind === "map") await drawMap(result, ...result.paths.map(named));
  else await drawBifurcation(result, named(result.path));
  const failed = result.kind === "map" ? result.reasons : result.failed ? [`${result.failed} values failed`] : [];
  $(`${result.kind}-words`).textContent = failed.length ? `Not all was computed: ${failed.join("; ")}` : "";
}

for (const kind of ["bifurcation", "map"]) {
  $(`${kind}-form`).onsubmit = (event) => {
    event.preventDefault();
    longJob(kind, (kind === "map" ? mapWords : diagramWords)(event.target, state.controls));
  };
}

// Results that are kept -----------------------------------------------------------------------------------------------------

async function listResults() {
  try {
    const found = await fetchJson("/api/results");
    const options = found.map((each) => new Option(`${each.kind}, ${each.title || "untitled"}, ${new Date(1000 * each.written).toLocaleTimeString()}`, each.key));
    $("history").replaceChildren(new Option("earlier ones", ""), ...options);
  } catch { /* the banner says that the server is gone */ }
}

/** Show a result that is kept, and put its case back. */
async function recall(key) {
  if (!key) return;
  const answer = await fetch(`/api/results/${key}`);
  if (!answer.ok) { tell((await answer.json()).error); return; }
  const result = { ...decode(await answer.arrayBuffer()), key };
  adopt(await fetchJson("/api/case", { case: result.case }));
  $("case").value = "";
  select(result.kind);
  if (result.kind !== "run") { await showDiagram(result); run(); return; }
  $("compare").checked = Object.keys(result.models).length > 1;
  await showRun(result);
}

async function save(form) {
  if (!form) return;
  if (form === "png" || form === "svg") {
    const shown = state.tab === "run" ? ["orbit", "spectrum", "backlash", "forces"] : [state.tab];
    for (const name of shown) if ($(name).data) await Plotly.downloadImage(name, { format: form, filename: `gearplay-${name}`, width: 900, height: 500, scale: form === "png" ? 2 : 1 });
    return;
  }
  const shown = state.diagrams[state.tab];
  if (form !== "toml" && state.tab !== "run" && !shown) { tell("There is nothing to save here yet: compute it first."); return; }
  const answer = form !== "toml" && state.tab !== "run" ? await fetch(`/api/results/${shown.key}/${form}`)
    : await fetch(`/api/export/${form}`, { method: "POST", body: JSON.stringify({ case: current() }), headers: { "content-type": "application/json" } });
  if (!answer.ok) { tell((await answer.json()).error); return; }
  const anchor = document.createElement("a");
  anchor.href = URL.createObjectURL(await answer.blob());
  anchor.download = `gearplay.${form}`;
  anchor.click();
  setTimeout(() => URL.revokeObjectURL(anchor.href), 10_000);
}

// Tabs, theme, player -------------------------------------------------------------------------------------------------------

const TABS = ["run", "bifurcation", "map"];

function select(name) {
  state.tab = name;
  for (const each of TABS) {
    const chosen = each === name;
    $(`tab-${each}`).setAttribute("aria-selected", String(chosen));
    $(`tab-${each}`).tabIndex = chosen ? 0 : -1;
    $(`panel-${each}`).hidden = !chosen;
  }
}

for (const [at, name] of TABS.entries()) {
  $(`tab-${name}`).onclick = () => select(name);
  $(`tab-${name}`).onkeydown = (event) => {
    const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
    if (!step) return;
    const other = TABS[(at + step + TABS.length) % TABS.length];
    select(other);
    $(`tab-${other}`).focus();
  };
}

function setTheme(dark) {
  document.documentElement.dataset.theme = dark ? "dark" : "light";
  $("theme").textContent = dark ? "Light" : "Dark";
  for (const each of Object.values(state.diagrams)) showDiagram(each);
  if (state.result) showRun(state.result);
}

/** Show where the motion is: on the clock, the slider and the plots. */
function moved() {
  $("scrub").value = stage.at;
  $("clock").textContent = `${stage.time.toFixed(4)} s`;
  moveCursors(state.result, stage.look.sleeve, stage.index, stage.time);
}

function magnified() { $("factor").textContent = `${stage.factor.toPrecision(3)} times as large`; }

const stage = new Stage($("stage"), moved);
const panel = new Controls($("controls"), (path, value) => {
  state.changes.set(path, value);
  state.moved = performance.now();
  run();
});
panel.onFault = tell;

$("play").onclick = () => { stage.playing = !stage.playing; $("play").textContent = stage.playing ? "Pause" : "Play"; };
$("play").textContent = stage.playing ? "Pause" : "Play";
$("scrub").oninput = () => {
  stage.playing = false;
  $("play").textContent = "Play";
  stage.at = Math.min(0.9999, Number($("scrub").value));
  stage.draw();
  moved();
};
$("slow").onchange = () => { stage.speed = Number($("slow").value); };
$("magnify").oninput = () => { stage.magnify = 10 ** (Number($("magnify").value) - 1); stage.draw(); magnified(); };
$("theme").onclick = () => setTheme(document.documentElement.dataset.theme !== "dark");
$("compare").onchange = run;
$("find").oninput = () => panel.find($("find").value);
$("reset").onclick = () => { panel.reset(); state.changes.clear(); run(); };
$("case").onchange = () => choose($("case").value);
$("upload").onchange = () => upload($("upload").files[0]);
$("save").onchange = async () => { try { await save($("save").value); } catch (error) { tell(error.message); } finally { $("save").value = ""; } };
$("history").onchange = async () => { await recall($("history").value); $("history").value = ""; };
$("history").onfocus = listResults;
$("spectrum-of").onchange = $("spectrum-scale").onchange = () => { if (state.result) drawSpectrum(state.result, lookAt(state.result)); };
$("sleeve-of").onchange = $("mesh-of").onchange = () => { if (state.result) showRun(state.result); };
$("share").onclick = async () => {
  history.replaceState(null, "", link());
  try { await navigator.clipboard.writeText(link()); $("share").textContent = "Copied"; } catch { $("share").textContent = "Link is in the address"; }
  setTimeout(() => { $("share").textContent = "Copy link"; }, 2000);
};
window.addEventListener("hashchange", fromLink);

setTheme(matchMedia("(prefers-color-scheme: dark)").matches);

const wire = new Wire((open) => {
  $("gone").hidden = open;
  $("link-state").textContent = open ? "connected" : "server gone";
  if (open) { if (state.base) run(); listResults(); }
}, (ready) => { $("warming").hidden = ready; });

const about = await fetchJson("/api/about");
for (const name of about.cases) $("case").append(new Option(name, name));
if (!(await fromLink())) { $("case").value = "han2021"; await choose("han2021"); }
