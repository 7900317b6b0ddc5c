// Where cases come from and where results go: bundled cases, files, links, earlier results, what is saved.

import { fillForms } from "./forms.js";
import { showDiagram } from "./jobs.js";
import { fillLostMotion } from "./lost_motion.js";
import { offerOverlays } from "./overlays.js";
import { $, request, requestJson, current, note, showTitle, state, showMessage } from "./page.js";
import { style } from "./colors.js";
import { plain, takeOver } from "./plotting.js";
import { magnified, models, outdate, run, showRun, stage } from "./runs.js";
import { decode } from "./wire.js";

const MOST_LINK = 64 * 1024;
const MOST_FILE = 256 * 1024;

/** Show where the case comes from: one of the list, or words of its own. */
function showSource(name) {
  const select = $("case");
  select.querySelector("[data-own]")?.remove();
  if (![...select.options].some((each) => each.value === name)) {
    const own = new Option(name, name);
    own.dataset.own = "";
    select.append(own);
  }
  select.value = name;
  state.name = name;
}

/** Take a case over, as the server describes it; what to show of it comes after. */
export function adopt(described, name, note = "") {
  if (state.running) state.wire.cancel(state.running.number);
  Object.assign(state, { generation: state.generation + 1, again: false, base: described.case, controls: described.controls, source: described.source, diagrams: {}, note });
  state.changes.clear();
  state.panel.build(described.controls);
  state.panel.find($("find").value);
  fillForms($("bifurcation-form"), $("map-form"), described);
  fillLostMotion($("lost_motion-form"), described);
  $("magnify").value = 0;
  stage.magnify = 1;
  magnified();
  for (const kind of ["bifurcation", "map", "lost_motion"]) { window.Plotly?.purge(kind); $(`${kind}-words`).textContent = ""; $(`${kind}-stale`).hidden = true; }
  $("lost_motion-rows").replaceChildren();
  outdate();
  showSource(name);
  showTitle();
  showMessage("");
}

/** Do something that may fail, and say so. */
export async function attempt(act) {
  try { await act(); } catch (error) { showMessage(error.message); } finally { if (state.name) $("case").value = state.name; }
}

export async function choose(name) {
  if (name === state.name) return;
  adopt(await requestJson(`/api/cases/${encodeURIComponent(name)}`), name);
  run();
}

/** Return the text of a file, which must be UTF-8. */
async function textOf(file) {
  const bytes = await file.arrayBuffer();
  try { return new TextDecoder("utf-8", { fatal: true }).decode(bytes); } catch { throw new Error(`${file.name}: must be UTF-8 text. Save the file as UTF-8.`); }
}

export async function upload(file) {
  if (!file) return;
  if (file.size > MOST_FILE || !/\.toml$/i.test(file.name)) throw new Error(`${file.name}: must be a case file, TOML of at most 256 kB. Choose another.`);
  const toml = await textOf(file);
  const described = await requestJson("/api/case", { toml }).catch(({ message }) => { throw new Error(message.replace(/^upload: /, `${file.name}: `)); });
  adopt(described, file.name);
  run();
}

// Links ---------------------------------------------------------------------------------------------------------------------

const packText = (text) => btoa(Array.from(new TextEncoder().encode(text), (byte) => String.fromCharCode(byte)).join("")).replaceAll("+", "-").replaceAll("/", "_").replace(/=+$/, "");
const unpackText = (text) => new TextDecoder().decode(Uint8Array.from(atob(text.replaceAll("-", "+").replaceAll("_", "/")), (c) => c.charCodeAt(0)));

export const link = () => `${location.origin}/#case=${packText(JSON.stringify(current()))}`;

/** Open the case that the address carries; false where it carries none. */
export async function fromLink() {
  if (!location.hash.startsWith("#case=")) return false;
  const text = location.hash.slice(6);
  let given;
  try {
    if (text.length > MOST_LINK) throw new Error("too long");
    given = JSON.parse(unpackText(text));
  } catch { throw new Error("The link is damaged or cut off: its case cannot be read. Ask for it again."); }
  try { adopt(await requestJson("/api/case", { case: given }), "case of a link"); } catch (error) { throw new Error(`The link's case cannot be used. ${error.message}`); }
  run();
  return true;
}

// Results -------------------------------------------------------------------------------------------------------------------

export async function listResults() {
  try {
    const found = await requestJson("/api/results");
    const words = ({ kind, title, note, written }) => [kind.replace("_", " "), title || "untitled", note, new Date(1000 * written).toLocaleTimeString()].filter(Boolean).join(", ");
    offerOverlays(found.filter(({ kind }) => kind === "run").map((each) => [each.key, words(each)]));
    $("history").replaceChildren(new Option("earlier ones", ""), ...found.map((each) => new Option(words(each), each.key)));
  } catch { /* the banner says that the server is gone */ }
}

/** Show a result that is kept, and put its case back. */
export async function recall(key) {
  if (!key) return;
  const result = { ...decode(await (await request(`/api/results/${key}`)).arrayBuffer()), key };
  adopt(await requestJson("/api/case", { case: result.case }), "an earlier result", result.note);
  state.select(result.kind);
  if (result.kind !== "run") { await showDiagram(result, JSON.stringify(current())); run(); return; }
  $("compare").checked = Object.keys(result.models).length > 1;
  await showRun(result);
}

async function download(response, name) {
  const anchor = document.createElement("a");
  anchor.href = URL.createObjectURL(await response.blob());
  anchor.download = name;
  anchor.click();
  setTimeout(() => URL.revokeObjectURL(anchor.href), 10_000);
}

/** Return a plot with a title over it, on the colour of the page, as it is saved. */
function titled({ data, layout }, title) {
  const margin = { ...layout.margin, t: (layout.margin?.t ?? 30) + 40 };
  return { data, layout: { ...layout, margin, paper_bgcolor: style("paper"), plot_bgcolor: style("paper"),
    title: { text: plain(title), x: 0.01, xanchor: "left", y: 0.98, yanchor: "top", font: { size: 15 } } } };
}

/** Save what the tab shows: both models of a run, each as a file; a diagram; pictures; or the case. */
export async function save(form) {
  if (!form) return;
  showMessage("");
  const name = ((state.base.title || "gearplay").toLowerCase().match(/[a-z0-9]+/g) ?? ["gearplay"]).join("-").slice(0, 48);
  const { [state.tab]: shown } = state.diagrams;
  if (form === "toml") await download(await request("/api/export/toml", { case: current(), ...(state.source && { source: state.source, changes: Object.fromEntries(state.changes) }) }), `${name}.toml`);
  else if (form === "png" || form === "svg") {
    if (state.tab === "run") await takeOver();
    const plots = state.tab === "run" ? ["orbit", "spectrum", "backlash", "forces"] : [state.tab];
    const drawn = plots.filter((each) => $(each).data);
    if (!drawn.length) throw new Error("There is nothing to save here yet: compute it first.");
    const title = [state.base.title || "untitled", note()].filter(Boolean).join("; ");
    if (state.tab === "run" && form === "png") await download(new Response(await stage.picture(title)), `${name}-mechanism.png`);
    for (const each of drawn) await Plotly.downloadImage(titled($(each), title), { format: form, filename: `${name}-${each}`, width: 900, height: 540, scale: form === "png" ? 2 : 1 });
  } else if (state.tab === "run") {
    for (const model of models()) await download(await request(`/api/export/${form}`, { case: { ...current(), backlash_model: model } }), `${name}-${model}.${form}`);
  } else if (shown) await download(await request(`/api/results/${shown.key}/${form}`), `${name}-${state.tab}.${form}`);
  else throw new Error("There is nothing to save here yet: compute it first.");
}
