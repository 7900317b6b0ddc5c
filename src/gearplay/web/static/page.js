// State shared by the parts of the page: the current case, the results shown, messages to the user.

import { micro } from "./plotting.js";

export const $ = (name) => document.getElementById(name);

export const state = {
  base: null, changes: new Map(), controls: [], note: "", // the case, its changed fields (SI), their controls, earlier changes
  result: null, diagrams: {}, measured: [], // what is shown, and channels of the user's own
  ofRun: false, unkept: false, generation: 0, running: null, again: false, job: null, lost: null, tab: "run",
  moved: 0, began: 0, requested: 0, whole: false, // times [ms] of the last move and run, and whether all its plots are drawn
  upToDate: false, // whether the result that came with the page is of the case as it stands
};
window.gearplay = { state, latencies: [], whole: [] }; // times of runs [ms]: to the plots in view, to all of them

/** Show a message, or none for ""; that of a run is removed by the next run. */
export function showMessage(words, ofRun = false) {
  state.ofRun = ofRun;
  $("message").textContent = words;
  $("message").hidden = !words;
}

/** Return the list that a case leaves out, as its controls have it. */
function listOf(path) {
  const own = state.controls.filter((each) => each.path.startsWith(`${path}.`) && /^\d+$/.test(each.path.slice(path.length + 1)));
  return own.map((each) => state.panel.startOf(each.path));
}

/** The case as it stands: the base with the changes in place; tables and lists that it leaves out are made on the way. */
export function current() {
  const made = structuredClone(state.base);
  for (const [path, value] of state.changes) {
    const parts = path.split(".");
    const last = parts.pop();
    let place = made;
    for (const [at, part] of parts.entries()) {
      place[part] ??= /^\d+$/.test(parts[at + 1] ?? last) ? listOf(parts.slice(0, at + 1).join(".")) : {};
      place = place[part];
    }
    place[last] = value;
  }
  return made;
}

/** Show a fault of the page itself, wherever it comes from; everything else continues. */
export function confess(error) {
  const words = error?.message ?? String(error);
  showMessage(`The page has a fault: ${words}. This is a fault of the program, not of your input. What you see may be of the case before; load the page again if it stays.`);
}
window.addEventListener("error", ({ error, message }) => confess(error ?? message));
window.addEventListener("unhandledrejection", ({ reason }) => confess(reason));

/** Return the first few changes as text. */
export function note() {
  const words = [...state.changes].map(([path, value]) => {
    const { owner, label, unit, factor, offset, kind } = state.controls.find((each) => each.path === path);
    const shown = kind === "number" ? `${Number((value * factor + offset).toPrecision(6))} ${micro(unit)}`.trim() : value;
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

/** Fetch from the server, a file as it is; errors are sentences for the user. */
export async function request(path, body) {
  const [kind, sent] = body instanceof Blob ? ["application/octet-stream", body] : ["application/json", JSON.stringify(body)];
  const options = body === undefined ? {} : { method: "POST", body: sent, headers: { "content-type": kind } };
  let response;
  try { response = await fetch(path, options); } catch { throw new Error("The server is gone. Try again when it is back."); }
  if (response.ok) return response;
  let words = `The server returned status ${response.status}.`;
  try { words = (await response.json()).error ?? words; } catch { /* no words came with it */ }
  throw new Error(words);
}

export const requestJson = async (path, body) => (await request(path, body)).json();
