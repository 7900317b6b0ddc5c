// What all plots share: plotly.js and what draws before it is there, units and texts.

import { style } from "./colors.js";
import { sketch } from "./sketch.js";

export const MODELS = ["coupled", "uncoupled"];
export const CONFIG = { responsive: true, displaylogo: false, modeBarButtonsToRemove: ["lasso2d", "select2d", "autoScale2d", "sendChartToCloud"],
  toImageButtonOptions: { format: "svg", filename: "gearplay" } };

// Text from a case must show as it is: plotly takes <b> and its like for formatting.
export const plain = (text) => String(text).replace(/&/g, "&amp;").replace(/</g, "&lt;").replace(/>/g, "&gt;");
export const micro = (unit) => unit.replace("um", "µm").replace("degC", "°C");
export const shownUnit = (unit) => micro(unit || "1");
export const scaled = (array, factor, offset = 0) => Float64Array.from(array, (value) => value * factor + offset);

// SI as results are, to what is read easily: unit and factor.
const SHOWN = { m: ["µm", 1e6], "m/s": ["mm/s", 1e3], rad: ["mrad", 1e3], "m/s^2": ["m/s²", 1], 1: ["%", 100] };
export const shownAs = (unit) => SHOWN[unit] ?? [unit, 1];

const painted = () => new Promise((resolve) => { requestAnimationFrame(() => setTimeout(resolve)); setTimeout(resolve, 100); });
let fetched = null;
const IDLE = 400; // ms without which nobody has seen the first plots

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
export function plotsWanted() {
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

/** Draw a plot of a run: by plotly.js where it is there, else as a sketch, which goes when that takes over. */
export async function draw(name, traces, given) {
  if (!window.Plotly) { sketch(name, traces, given); return; }
  await Plotly.react(name, traces, given, CONFIG);
  document.querySelector(`#${name} > .sketch`)?.remove();
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
