// Bifurcation diagrams, maps and lost motion: requests, drawing, clicks.

import { paceOf } from "./averages.js";
import { drawBifurcation, drawMap } from "./diagrams.js";
import { diagramWords, faultOf, mapWords, sayCost } from "./forms.js";
import { drawLostMotion, lostMotionWords } from "./lost_motion.js";
import { $, current, note, state, showMessage } from "./page.js";
import { hideProgress, showProgress } from "./runs.js";

const named = (path) => state.controls.find((each) => each.path === path);
const WORDS = { bifurcation: diagramWords, map: mapWords, lost_motion: lostMotionWords };
const pathsOf = (result) => result.paths ?? [result.path];

/** Ask for a diagram, a map or the lost motion from its form. */
export function submit(kind, form) {
  const fault = faultOf(form, state.controls);
  if (fault) { showMessage(fault); return; }
  longJob(kind, { case: current(), note: note(), ...WORDS[kind](form, state.controls) });
}

/** Say how long the map may take, by the steps of the last run. */
export function estimate() {
  if (state.result) sayCost($("map-form"), paceOf(state.result), state.result.case.run);
}

/** Do a long job; one that is lost with the server is submitted again once that is back. */
export async function longJob(kind, words) {
  if (state.job) { showMessage("One diagram, map or lost motion at a time: cancel the one that runs."); return; }
  showMessage("");
  const { generation } = state;
  const began = performance.now();
  const job = state.wire.submit(kind, words, (done) => showProgress(done, job.number, began));
  state.job = job;
  showProgress(0, job.number, began);
  try {
    const result = await job;
    state.kept();
    if (generation === state.generation) await showDiagram(result, JSON.stringify(words.case));
    else showMessage(`The ${kind.replace("_", " ")} that ran is of another case: see Results.`);
  } catch (error) {
    if (error.kind === "gone") state.lost = { kind, words };
    else showMessage(error.message);
  } finally {
    state.job = null;
    hideProgress();
  }
}

/** Show a diagram or map; `of` is the case that it was computed of, as text, by which the page knows when it is no longer the current one. */
export async function showDiagram(result, of) {
  state.diagrams[result.kind] = { ...result, of };
  if (result.kind === "lost_motion") { await drawLostMotion(result); markDiagrams(); return; }
  if (result.kind === "map") await drawMap(result, ...result.paths.map(named));
  else await drawBifurcation(result, named(result.path));
  $(result.kind).removeAllListeners?.("plotly_click");
  $(result.kind).on("plotly_click", ({ points: [{ x, y }] }) => state.goTo(pathsOf(result).map((path, at) => [path, [x, y][at]])));
  markDiagrams();
}

/** Say of each diagram what it is of, and whether the case has changed since. */
export function markDiagrams() {
  for (const [kind, result] of Object.entries(state.diagrams)) {
    $(`${kind}-stale`).hidden = result.of === JSON.stringify(current());
    if (kind === "lost_motion") { $("lost_motion-words").textContent = `${result.message}.`; continue; }
    const failed = kind === "map" ? result.reasons : result.failed ? [`${result.failed} values failed`] : [];
    const { members = 1, duration, transient } = result;
    const words = [`${result.case.backlash_model} model, ${members > 1 ? `${members} members of ${duration} s after ${transient} s, from drawn starts; ± holds 95 %` : "one member"}`];
    if (kind === "bifurcation") words.push("a point per mesh period, carried up and down");
    if (result.not_carried?.length) words.push(`not carried everywhere: ${result.not_carried.join("; ")}`);
    if (result.doubtful?.some((each) => each)) words.push(`hatched: fewer than ${result.few} impacts, or a spread of more than half the value, run it longer`);
    words.push("click a point to run it");
    if (failed.length) words.push(`not all was computed: ${failed.join("; ")}`);
    $(`${kind}-words`).textContent = `${words.join("; ")}.`;
  }
}
