// What all plots share: plotly.js and what draws before it is there, units and texts.

import { style } from "./colors.js";
import { sketch, unsketch } from "./sketch.js";

export const MODELS = ["coupled", "uncoupled"];
export const CONFIG = { responsive: true, displaylogo: false, modeBarButtonsToRemove: ["lasso2d", "select2d", "autoScale2d", "sendChartToCloud"],
  displayModeBar: matchMedia("(hover: none)").matches ? false : "hover", // where nothing hovers it would lie over the legend
  toImageButtonOptions: { format: "svg", filename: "gearplay" } };

// Text from a case must show as it is: plotly takes <b> and its like for formatting.
export const plain = (text) => String(text).replace(/&/g, "&amp;").replace(/</g, "&lt;").replace(/>/g, "&gt;");
export const micro = (text) => text.replace(/\bu(?=(m|W)\b)/g, "µ").replace("degC", "°C");
export const shownUnit = (unit) => micro(unit || "1");
export const scaled = (array, factor, offset = 0) => Float64Array.from(array, (value) => value * factor + offset);

// SI as results are, to what is read easily: unit and factor.
const SHOWN = { m: ["µm", 1e6], "m/s": ["mm/s", 1e3], rad: ["mrad", 1e3], "m/s^2": ["m/s²", 1], 1: ["%", 100] };
export const shownAs = (unit) => SHOWN[unit] ?? [unit, 1];

const painted = () => new Promise((resolve) => { requestAnimationFrame(() => setTimeout(resolve)); setTimeout(resolve, 100); });
let fetched = null;
const IDLE = 400; // ms after a move, in which the next one may come

/** Fetch plotly.js, once. It keeps the browser busy for a while, so what is drawn already is shown before. */
export async function plotly() {
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

const HURRIES = ["pointerover", "pointerdown", "focusin", "wheel"];

/** Wait until plotly.js is needed: a pointer on a plot, or an idle browser. */
function plotsWanted() {
  return new Promise((resolve) => {
    const done = () => {
      for (const kind of HURRIES) document.removeEventListener(kind, hurry);
      resolve();
    };
    const hurry = ({ target }) => { if (target.closest?.(".plot")) done(); };
    for (const kind of HURRIES) document.addEventListener(kind, hurry, { passive: true });
    setTimeout(() => (window.requestIdleCallback ? requestIdleCallback(done, { timeout: 1000 }) : done()), IDLE);
  });
}

const sketched = new Map(); // traces and layouts that plotly.js has still to draw, by name
export const pause = () => new Promise((resolve) => { setTimeout(resolve); });

/**
 * Draw a plot of a run as a sketch, in a tenth of the time that plotly.js takes; that draws it by `takeOver`. One that its user has
 * zoomed, or of which curves are hidden, is drawn by plotly.js at once, which keeps that.
 */
export function draw(name, traces, given) {
  sketched.set(name, [traces, given]);
  if (document.getElementById(name).edited === given.uirevision) return finish(name);
  sketch(name, traces, given);
}

async function finish(name) {
  const [place, [traces, given]] = [document.getElementById(name), sketched.get(name)];
  sketched.delete(name);
  unsketch(name);
  const first = !place.data;
  await Plotly.react(name, traces, given, CONFIG);
  if (!first) return;
  const edit = () => { place.edited = place.layout.uirevision; };
  place.on("plotly_restyle", edit);
  place.on("plotly_relayout", (changes) => { if (Object.keys(changes).some((key) => key.includes("axis"))) edit(); });
}

/** Have plotly.js draw what was sketched, one plot after the other while `wanted()` returns true; return whether all are drawn. */
export async function takeOver(wanted = () => true) {
  await plotly();
  for (const name of sketched.keys()) {
    if (!wanted()) return false;
    if (document.getElementById(name).offsetParent === null) continue; // on a tab that is not shown: drawn when it is
    await finish(name);
    await pause();
  }
  return wanted();
}

/** The same, once somebody needs it or the browser is idle. */
export async function takeOverSoon(wanted) {
  await plotsWanted();
  return wanted() && takeOver(wanted);
}

/** Return an axis in the colours of the page. */
export const axis = (words, more = {}) => ({ gridcolor: style("grid"), zerolinecolor: style("line"), linecolor: style("line"), exponentformat: "power",
  title: { text: words }, ...more });

/** Return a layout in the colours of the page; `uirevision` in it says what of zoom and legend is kept from drawing to drawing. */
export function layout(more) {
  return {
    paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)", font: { color: style("ink"), size: 12 },
    margin: { l: 74, r: 14, t: 30, b: 42, autoexpand: false }, showlegend: true,
    legend: { orientation: "h", y: 1.02, yanchor: "bottom", x: 0, itemsizing: "constant", traceorder: "normal" }, hovermode: "closest", ...more,
  };
}
