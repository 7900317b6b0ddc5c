// Sliders and fields from the server's description of a case; a change calls back with path and SI value.

import { micro } from "./plotting.js";

/** Return a number to six digits; one from a million on as 1e8, which its field is wide enough for. */
function digits(value) {
  const rounded = Number(value.toPrecision(6));
  return Math.abs(rounded) < 1e6 ? String(rounded) : rounded.toExponential().replace("+", "");
}

const STEPS = 1000;

function toSlider(control, value) {
  const { low, high, logarithmic } = control;
  if (!(high > low)) return 0;
  const share = logarithmic && value > 0 ? Math.log(value / low) / Math.log(high / low) : (value - low) / (high - low);
  return Math.round(Math.min(1, Math.max(0, share)) * STEPS);
}

function fromSlider(control, place) {
  const { low, high, logarithmic, kind } = control;
  const share = place / STEPS;
  const value = logarithmic ? low * (high / low) ** share : low + (high - low) * share;
  return kind === "integer" ? Math.round(value) : Number(value.toPrecision(4));
}

/** Return what is wrong with a value in the unit that is shown, "" where nothing is. */
export function outOfBounds(control, value) {
  if (!Number.isFinite(value)) return "must be a number";
  if (control.kind === "integer" && !Number.isInteger(value)) return "must be a whole number";
  if (control.least !== null && value < control.least) return `must be at least ${digits(control.least)} ${control.unit}`.trim();
  if (control.most !== null && value > control.most) return `must be at most ${digits(control.most)} ${control.unit}`.trim();
  return "";
}

/** Return a field's bounds in words, "" where it has none. */
function boundsOf({ least, most, unit }) {
  const shown = micro(unit);
  if (least !== null && most !== null) return `from ${digits(least)} to ${digits(most)} ${shown}`.trim();
  if (least !== null) return `at least ${digits(least)} ${shown}`.trim();
  return most === null ? "" : `at most ${digits(most)} ${shown}`.trim();
}

export class Controls {
  /** `onChange` gets a path and its new value, SI; `onFault` a sentence. */
  constructor(place, onChange, onFault) {
    this.place = place;
    this.onChange = onChange;
    this.onFault = onFault;
    this.rows = new Map();
  }

  build(list, open = ["Sleeves", "Mesh", "Drive and load"]) {
    const opened = new Set([...this.place.querySelectorAll("details[open]")].map((each) => each.dataset.group));
    const first = this.rows.size === 0;
    this.place.replaceChildren();
    this.rows.clear();
    const groups = new Map();
    for (const control of list) {
      if (!groups.has(control.group)) groups.set(control.group, new Map());
      const owners = groups.get(control.group);
      if (!owners.has(control.owner)) owners.set(control.owner, []);
      owners.get(control.owner).push(control);
    }
    for (const [group, owners] of groups) {
      const details = document.createElement("details");
      details.dataset.group = group;
      details.open = first ? open.includes(group) : opened.has(group);
      const summary = document.createElement("summary");
      summary.textContent = group;
      details.append(summary);
      for (const [owner, controls] of owners) {
        if (owner) {
          const title = document.createElement("div");
          title.className = "owner";
          title.textContent = owner;
          details.append(title);
        }
        for (const control of controls.filter(({ basic }) => basic)) details.append(this.row(control));
        const rest = controls.filter(({ basic }) => !basic);
        if (rest.length) details.append(this.folded(rest, opened.has(`${group}/${owner}`), `${group}/${owner}`, rest.length < controls.length));
      }
      this.place.append(details);
    }
    if (list.length && !this.place.querySelector(":scope > details[open]")) this.place.querySelector("details").open = true;
  }

  /** Return the rows of a part that are seldom changed, folded. */
  folded(controls, open, name, isRest) {
    const more = document.createElement("details");
    more.className = "more";
    more.dataset.group = name;
    more.open = open;
    const summary = document.createElement("summary");
    summary.textContent = isRest ? `${controls.length} more` : `${controls.length} fields`;
    more.append(summary, ...controls.map((control) => this.row(control)));
    return more;
  }

  row(control) {
    const row = document.createElement("div");
    row.className = "control";
    const name = `c-${this.rows.size}`;
    const label = document.createElement("label");
    label.className = "wide-label";
    label.textContent = control.label;
    label.title = [control.about || control.label, boundsOf(control), control.path].filter(Boolean).join("; ");
    label.htmlFor = name;
    const undo = document.createElement("button");
    undo.type = "button";
    undo.className = "undo";
    undo.textContent = "reset";
    undo.setAttribute("aria-label", `Reset ${control.owner} ${control.label}`.replace("  ", " "));
    undo.hidden = true;
    row.append(label, undo);
    const entry = { control, row, undo, start: control.value };
    undo.onclick = () => {
      entry.show(entry.start);
      changed(entry.start);
      row.querySelector(`[id="${name}"]`).focus();
    };
    const inSI = (value) => (typeof value === "number" && control.kind === "number" ? (value - control.offset) / control.factor : value);
    entry.startSI = inSI(control.value);
    const changed = (value) => {
      row.classList.toggle("changed", value !== entry.start);
      undo.hidden = value === entry.start;
      this.onChange(control.path, inSI(value));
    };
    entry.changed = changed;
    if (control.kind === "choice") {
      const select = document.createElement("select");
      for (const choice of control.choices) select.append(new Option(choice, choice, false, choice === control.value));
      select.id = name;
      select.onchange = () => changed(select.value);
      entry.show = (value) => { select.value = value; };
      select.classList.add("wide-label");
      row.append(select);
    } else if (control.kind === "switch") {
      const box = document.createElement("input");
      box.type = "checkbox";
      box.id = name;
      box.checked = control.value;
      box.onchange = () => changed(box.checked);
      entry.show = (value) => { box.checked = value; };
      row.append(box);
    } else {
      const slider = document.createElement("input");
      slider.type = "range";
      slider.min = 0;
      slider.max = STEPS;
      slider.value = toSlider(control, control.value);
      slider.setAttribute("aria-label", `${control.owner} ${control.label}, slider`.trim());
      const field = document.createElement("input");
      field.type = "number";
      field.step = "any";
      field.id = name;
      field.value = digits(control.value);
      field.dataset.path = control.path;
      slider.dataset.slider = control.path;
      slider.setAttribute("aria-valuetext", `${digits(control.value)} ${control.unit}`);
      slider.oninput = () => {
        const value = fromSlider(control, Number(slider.value));
        const fault = outOfBounds(control, value);
        if (fault) return;
        field.value = digits(value);
        slider.setAttribute("aria-valuetext", `${digits(value)} ${control.unit}`);
        field.removeAttribute("aria-invalid");
        changed(value);
      };
      field.onchange = () => {
        const value = field.value.trim() === "" ? NaN : Number(field.value);
        const fault = outOfBounds(control, value);
        field.setAttribute("aria-invalid", fault ? "true" : "false");
        field.title = fault ? `${control.label} = ${field.value}: ${fault}.` : "";
        if (fault) { this.onFault(`${control.path} = ${field.value || "empty"}: ${fault}. Correct it.`); return; }
        slider.value = toSlider(control, value);
        changed(value);
      };
      entry.show = (value) => {
        field.value = digits(value);
        field.removeAttribute("aria-invalid");
        slider.value = toSlider(control, value);
      };
      const unit = document.createElement("span");
      unit.className = "unit";
      unit.textContent = micro(control.unit);
      row.append(slider, field, unit);
    }
    this.rows.set(control.path, entry);
    return row;
  }

  /** Return the value that a field had at first, SI. */
  startOf(path) { return this.rows.get(path)?.startSI; }

  /** Set a field to a value in the unit that is shown. */
  set(path, value) {
    const { show, changed } = this.rows.get(path);
    show(value);
    changed(value);
  }

  reset() {
    for (const { row, undo, start, show } of this.rows.values()) { show(start); row.classList.remove("changed"); undo.hidden = true; }
  }

  /** Show the rows whose words contain a text; return whether there is any. */
  find(text) {
    const wanted = text.trim().toLowerCase();
    for (const { control, row } of this.rows.values()) {
      const words = `${control.label} ${control.owner} ${control.path} ${control.about}`.toLowerCase();
      row.hidden = wanted !== "" && !words.includes(wanted);
    }
    for (const details of this.place.querySelectorAll("details")) {
      const any = [...details.querySelectorAll(".control")].some((row) => !row.hidden);
      details.hidden = !any;
      if (wanted && any) details.open = true;
    }
    return [...this.rows.values()].some(({ row }) => !row.hidden);
  }
}
