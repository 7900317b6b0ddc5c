// The page put together: its fields and buttons, and what they do.

import { Controls } from "./controls.js";
import { estimate, longJob, markDiagrams, showDiagram, submit } from "./jobs.js";
import { adopt, attempt, choose, fromLink, link, listResults, recall, save, upload } from "./keeping.js";
import { $, current, showTitle, state, showMessage } from "./page.js";
import { plotly } from "./plotting.js";
import { measured, overlay } from "./overlays.js";
import { begin, magnified, moved, redraw, redrawSpectrum, run, stage, toNextImpact } from "./runs.js";
import { Wire } from "./wire.js";

const TABS = ["run", "bifurcation", "map", "lost_motion"];

state.select = (name) => {
  state.tab = name;
  for (const each of TABS) {
    const chosen = each === name;
    $(`tab-${each}`).setAttribute("aria-selected", String(chosen));
    $(`tab-${each}`).tabIndex = chosen ? 0 : -1;
    $(`panel-${each}`).hidden = !chosen;
  }
  if (name === "map") estimate();
  if (name === "run") redraw();
  for (const each of [name, `${name}-turn`]) if ($(each)?.data) Plotly.Plots.resize(each);
};

for (const [at, name] of TABS.entries()) {
  $(`tab-${name}`).onclick = () => state.select(name);
  $(`tab-${name}`).onkeydown = (event) => {
    const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
    if (!step) return;
    const other = TABS[(at + step + TABS.length) % TABS.length];
    state.select(other);
    $(`tab-${other}`).focus();
  };
}

// Parameters ----------------------------------------------------------------------------------------------------------------

state.panel = new Controls($("controls"), (path, value) => {
  state.changes.set(path, value);
  if (value === state.panel.startOf(path)) state.changes.delete(path);
  state.moved = performance.now();
  showMessage("");
  changed();
}, showMessage);

/** Show that the case has changed, and run it. */
function changed() {
  showTitle();
  markDiagrams();
  run();
}

/** Set fields, in the units that the page shows, and run what they give. */
state.goTo = (values) => {
  for (const [path, value] of values) state.panel.set(path, Number(value.toPrecision(5)));
  state.select("run");
};

$("find").oninput = () => { $("none").hidden = state.panel.find($("find").value); };
$("reset").onclick = () => { state.panel.reset(); state.changes.clear(); changed(); };
$("compare").onchange = run;

// Cases and results ---------------------------------------------------------------------------------------------------------

$("case").onchange = () => attempt(() => choose($("case").value));
for (const [name, act] of [["upload", ({ files }) => upload(files[0])], ["save", ({ value }) => save(value)], ["history", ({ value }) => recall(value)]]) {
  $(name).onchange = () => attempt(async () => { try { await act($(name)); } finally { $(name).value = ""; } });
}
$("history").onblur = listResults;
let listing = 0;
/** Bring the list of results up to date, soon; not while its user is in it. */
state.kept = () => {
  clearTimeout(listing);
  listing = setTimeout(() => { if (document.activeElement !== $("history")) listResults(); }, 400);
};
$("share").onclick = async () => {
  history.replaceState(null, "", link());
  try { await navigator.clipboard.writeText(link()); $("share").textContent = "Copied"; } catch { $("share").textContent = "Link is in the address"; }
  setTimeout(() => { $("share").textContent = "Copy link"; }, 2000);
};
window.addEventListener("hashchange", () => attempt(fromLink));
for (const kind of ["bifurcation", "map", "lost_motion"]) $(`${kind}-form`).onsubmit = (event) => { event.preventDefault(); submit(kind, event.target); };

$("map-form").oninput = () => { $("map-form").dataset.touched = "1"; estimate(); };

// Views ---------------------------------------------------------------------------------------------------------------------

$("play").onclick = () => { stage.playing = !stage.playing; $("play").textContent = stage.playing ? "Pause" : "Play"; };
$("play").textContent = stage.playing ? "Pause" : "Play";
$("scrub").oninput = () => {
  stage.playing = false;
  $("play").textContent = "Play";
  stage.at = Math.min(0.9999, Number($("scrub").value));
  stage.draw();
  if (state.result) moved();
};
$("impact").onclick = () => { stage.playing = false; $("play").textContent = "Play"; toNextImpact(); };
$("fold").onclick = () => {
  const folded = document.querySelector("aside").classList.toggle("folded");
  $("fold").textContent = folded ? "Parameters" : "Hide";
  $("fold").setAttribute("aria-expanded", String(!folded));
};
$("overlay").onchange = () => attempt(() => overlay($("overlay").value));
$("measured").onchange = () => attempt(async () => { try { await measured($("measured").files[0]); } finally { $("measured").value = ""; } });
$("slow").onchange = () => { stage.speed = Number($("slow").value); };
$("carrier").onchange = () => { stage.turning = $("carrier").value === "turning"; stage.draw(); };
$("magnify").oninput = () => { stage.magnify = 10 ** Number($("magnify").value); stage.draw(); magnified(); };
$("spectrum-of").onchange = $("spectrum-scale").onchange = redrawSpectrum;
$("sleeve-of").onchange = $("mesh-of").onchange = redraw;

function setTheme(dark) {
  document.documentElement.dataset.theme = dark ? "dark" : "light";
  $("theme").textContent = dark ? "Light" : "Dark";
  for (const each of Object.values(state.diagrams)) showDiagram(each, each.of);
  redraw();
}
$("theme").onclick = () => setTheme(document.documentElement.dataset.theme !== "dark");
setTheme(matchMedia("(prefers-color-scheme: dark)").matches);

// The server ----------------------------------------------------------------------------------------------------------------

state.wire = new Wire((open) => {
  $("gone").hidden = open;
  $("link-state").textContent = open ? "connected" : "server gone";
  state.upToDate &&= open;
  if (!open) return;
  if (state.base && !state.upToDate) run();
  state.kept();
  const { lost } = state;
  state.lost = null;
  if (lost) longJob(lost.kind, lost.words);
}, (ready) => { $("warming").hidden = ready; }, (reason) => { showMessage(reason); state.unkept = true; });

setTimeout(() => { if (!$("warming").hidden) plotly().catch((error) => showMessage(error.message)); }, 1500); // while kernels compile
const { cases, name: first, described, result } = JSON.parse($("start").textContent);
$("case").append(...cases.map((name) => new Option(name, name)));
let [opened, fault] = [false, ""];
try { opened = await fromLink(); } catch (error) { fault = error.message; }
if (!opened) { adopt(described, first); await attempt(() => begin(result)); if (fault) showMessage(fault); }
