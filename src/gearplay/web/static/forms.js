// What to compute over fields of a case: the forms of a bifurcation diagram and of a map, and the words of a job from them.

import { outOfBounds } from "./controls.js";
import { shownUnit } from "./plotting.js";

const SIGNALS = ["x", "y", "vx", "vy", "theta", "omega"];
const rounded = (value) => Number(value.toPrecision(3));

export function field(form, name, words, element) {
  const label = document.createElement("label");
  label.textContent = words;
  element.name = name;
  label.append(element);
  form.append(label);
  return element;
}

export function numberField(form, name, words, value) {
  const input = document.createElement("input");
  input.type = "number";
  input.step = "any";
  input.required = true;
  input.value = value;
  return field(form, name, words, input);
}

/** A field of the case with its two ends; these start where its slider does not yet touch nothing. */
function pathField(whole, name, words, numbers, chosen) {
  const form = document.createElement("span");
  form.className = "group";
  whole.append(form);
  const select = document.createElement("select");
  for (const each of numbers) select.append(new Option(`${each.owner} ${each.label}`.trim(), each.path, false, each.path === chosen));
  field(form, name, words, select);
  const [low, high] = [numberField(form, `${name}-low`, "from", 0), numberField(form, `${name}-high`, "to", 1)];
  const fill = () => {
    const each = numbers.find(({ path }) => path === select.value);
    if (!each) return;
    low.value = rounded(each.offset ? each.low : each.low > 0 ? each.low * 3 : each.low || each.high / 20);
    high.value = rounded(each.logarithmic ? each.high / 3 : each.high);
    for (const [end, text] of [[low, "from"], [high, "to"]]) end.parentElement.firstChild.textContent = `${text} [${shownUnit(each.unit)}]`;
  };
  select.onchange = fill;
  fill();
}

export function submitButton(form, text) {
  const made = document.createElement("button");
  made.type = "submit";
  made.textContent = text;
  form.append(made);
}

/** Make both forms for a case, as the server describes it. */
export function fillForms(diagram, map, { case: { sleeves, run }, controls, measures, rotors, displacements }) {
  const numbers = controls.filter((each) => each.kind === "number" && each.group !== "Run");
  const pathOf = (end, at) => numbers.find(({ path }) => path.endsWith(end))?.path ?? numbers[at]?.path;
  const [speed, clearance] = [pathOf("drive.speed", 0), pathOf("radial_clearance", 1)];
  const moving = Object.keys(sleeves)[0] ?? rotors.at(-1);
  const names = [moving, ...rotors.filter((each) => each !== moving)];

  diagram.replaceChildren();
  pathField(diagram, "axis", "over", numbers, speed);
  const signal = field(diagram, "signal", "signal", document.createElement("select"));
  const moves = SIGNALS.flatMap((each) => names.map((name) => `${name}.${each}`));
  const signals = displacements.includes("x") ? [...displacements, ...moves] : [...moves, ...displacements]; // x: of a torsional pair
  signal.append(...signals.map((each) => new Option(each)));
  numberField(diagram, "count", "values", 100);
  numberField(diagram, "settle", "mesh periods before", 200);
  numberField(diagram, "keep", "mesh periods kept", 60);
  submitButton(diagram, "Draw the diagram");

  map.replaceChildren();
  delete map.dataset.touched;
  pathField(map, "first", "across", numbers, speed);
  pathField(map, "second", "up", numbers, clearance);
  const select = field(map, "measure", "show", document.createElement("select"));
  for (const of of new Set(measures.map((each) => each.of))) {
    const group = document.createElement("optgroup");
    group.label = of;
    for (const each of measures.filter((one) => one.of === of)) {
      const first = of === moving && each.measure === "rms";
      group.append(new Option(`${each.words}, ${of}`, JSON.stringify([each.measure, of]), first, first));
    }
    select.append(group);
  }
  numberField(map, "columns", "columns", 16);
  numberField(map, "rows", "rows", 12);
  const rattles = Object.values(sleeves).some((each) => each.radial_clearance > 0); // such a motion has to be averaged
  numberField(map, "members", "members of a cell", rattles ? 8 : 1);
  numberField(map, "duration", "each recorded for [s]", rattles ? 5 : run.duration);
  numberField(map, "transient", "after [s]", rattles ? 1 : run.transient);
  const cost = document.createElement("span");
  cost.id = "map-cost";
  submitButton(map, "Run the map");
  map.append(cost);
}

const LONGEST = 600; // s that the server gives a map
const PATIENT = 60; // s that a map may take as the page suggests it

/** Return how long the map of a form may take [s]; `pace` is how many seconds one simulated second of one run takes. */
function costOf(form, pace) {
  const [columns, rows, members, duration, transient] = ["columns", "rows", "members", "duration", "transient"].map((name) => Number(form.elements[name].value));
  return columns * rows * members * (duration + transient) * pace;
}

/** Say how long the map of a form may take; one that nobody has changed yet is made short enough to wait for. */
export function sayCost(form, pace, { transient }) {
  const { members, duration, columns, rows, transient: before } = form.elements;
  if (!form.dataset.touched && costOf(form, pace) > PATIENT) {
    [members.value, before.value, columns.value, rows.value] = [4, transient, 12, 8];
    const each = PATIENT / (12 * 8 * 4 * pace) - transient;
    duration.value = Math.max(0.1, Math.min(5, Number(each.toPrecision(1))));
    form.dataset.touched = "1";
  }
  const seconds = costOf(form, pace);
  const place = form.querySelector("#map-cost");
  place.textContent = seconds > 0 ? `about ${seconds < 60 ? `${Math.ceil(seconds)} s` : `${Math.ceil(seconds / 60)} min`}` : "";
  place.className = seconds > LONGEST ? "alert" : "";
}

/** Return what is wrong with the ends that a form's fields are to run between, in a sentence, "" where nothing is. */
export function faultOf(form, controls) {
  const data = new FormData(form);
  for (const name of ["axis", "first", "second"].filter((each) => data.has(each))) {
    const control = controls.find((each) => each.path === data.get(name));
    const [low, high] = ["low", "high"].map((end) => Number(data.get(`${name}-${end}`)));
    const words = `${control.owner} ${control.label}`.trim();
    const unit = shownUnit(control.unit);
    for (const value of [low, high]) {
      const fault = outOfBounds(control, value);
      if (fault) return `${words} = ${value} ${unit}: ${fault}. Correct it.`;
    }
    if (!(low < high)) return `${words}: from, ${low} ${unit}, must be below to, ${high} ${unit}. Correct one.`;
  }
  return "";
}

function axisOf(data, name, controls) {
  const { path, factor, offset } = controls.find((each) => each.path === data.get(name));
  const end = (which) => (Number(data.get(`${name}-${which}`)) - offset) / factor;
  return { path, low: end("low"), high: end("high") };
}

export function diagramWords(form, controls) {
  const data = new FormData(form);
  const [count, settle, keep] = ["count", "settle", "keep"].map((name) => Number(data.get(name)));
  return { axis: axisOf(data, "axis", controls), signal: data.get("signal"), count, settle, keep };
}

export function mapWords(form, controls) {
  const data = new FormData(form);
  const [measure, of] = JSON.parse(data.get("measure"));
  const [columns, rows, members, duration, transient] = ["columns", "rows", "members", "duration", "transient"].map((name) => Number(data.get(name)));
  return { first: axisOf(data, "first", controls), second: axisOf(data, "second", controls), measure, of, columns, rows, members, duration, transient };
}
