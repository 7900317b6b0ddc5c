// What the parts of the page share: the case as it stands, what is shown, and words to the user.

import { micro } from "./plotting.js";

export const $ = (name) => document.getElementById(name);

export const state = {
  base: null, changes: new Map(), controls: [], note: "", // the case, its changed fields (SI), their controls, what was changed before
  result: null, diagrams: {}, // what is shown
  told: false, unkept: false, generation: 0, running: null, again: false, job: null, lost: null, tab: "run",
  moved: 0, began: 0, asked: 0, whole: false, // times [ms] of the last move and run, and whether all its plots are drawn
};
window.gearplay = { state, latencies: [], whole: [] }; // times of runs [ms]: to the plots in view, to all of them

/** Tell the user something, "" to take it back; what a run says is taken back by the next one. */
export function tell(words, ofRun = false) {
  state.told = ofRun;
  $("message").textContent = words;
  $("message").hidden = !words;
}

/** The case as it stands: the base with the changes in place. */
export function current() {
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

/** What has been changed, in words; the first few fields. */
export function note() {
  const words = [...state.changes].map(([path, value]) => {
    const { owner, label, unit, factor, kind } = state.controls.find((each) => each.path === path);
    const shown = kind === "number" ? `${Number((value * factor).toPrecision(6))} ${micro(unit)}`.trim() : value;
    return `${owner} ${label} ${shown}`.trim();
  });
  const rest = words.length > 4 ? `, and ${words.length - 4} more` : "";
  return [state.note, words.slice(0, 4).join(", ") + rest].filter(Boolean).join(", ");
}

export function showTitle() {
  $("title").textContent = state.base.title || "untitled";
  const words = note();
  $("changes").textContent = words && `changed: ${words}`;
}

/** Fetch from the server; errors are sentences for the user. */
export async function ask(path, body) {
  const options = body === undefined ? {} : { method: "POST", body: JSON.stringify(body), headers: { "content-type": "application/json" } };
  let answer;
  try { answer = await fetch(path, options); } catch { throw new Error("The server is gone. Try again when it is back."); }
  if (answer.ok) return answer;
  let words = `The server answered ${answer.status}.`;
  try { words = (await answer.json()).error ?? words; } catch { /* no words came with it */ }
  throw new Error(words);
}

export const askJson = async (path, body) => (await ask(path, body)).json();
