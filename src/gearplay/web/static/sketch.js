// A plot drawn at once, on a canvas, from what plotly.js is given, so that nobody waits for its 5 MB or its some 60 ms to see new
// curves. It looks the same, has no zoom, and goes when plotly.js takes over.

import { rangeOf, sameScale, ticksOf } from "./scales.js";

const FAMILY = '"Open Sans", verdana, arial, sans-serif';
const [SMALL, LARGE] = [12, 14]; // px of ticks and of titles
const DASHES = { dot: [1, 1], dash: [3, 3] };
const written = (text) => String(text).replace(/&lt;/g, "<").replace(/&gt;/g, ">").replace(/&amp;/g, "&");
const sharp = (at) => Math.round(at - 0.5) + 0.5; // the middle of a pixel

/** What plots are drawn with: lines, and texts by their baseline. */
class Pen {
  constructor(canvas, width, height, color) {
    const ratio = window.devicePixelRatio || 1;
    Object.assign(canvas, { width: Math.round(width * ratio), height: Math.round(height * ratio) }); // which clears it
    Object.assign(canvas.style, { width: `${width}px`, height: `${height}px` });
    this.c = canvas.getContext("2d");
    this.c.scale(ratio, ratio);
    this.color = color;
  }

  /** Draw the path that `trace` makes. */
  stroke(trace, { color, width = 1, dash }) {
    const { c } = this;
    const unit = Math.max(width, 3);
    c.strokeStyle = color;
    c.lineWidth = width;
    c.setLineDash((DASHES[dash] ?? []).map((times) => times * unit));
    c.beginPath();
    trace(c);
    c.stroke();
  }

  /** Draw a line along an axis, as sharp as pixels are. */
  line(from, to, color) {
    const upright = from[0] === to[0];
    const ends = [from, to].map(([x, y]) => (upright ? [sharp(x), y] : [x, sharp(y)]));
    this.stroke((c) => { c.moveTo(...ends[0]); c.lineTo(...ends[1]); }, { color });
  }

  /** Write a text; `align` says which of its ends is at x. */
  text(text, x, y, { size = SMALL, color = this.color, align = "left" } = {}) {
    const { c } = this;
    c.font = `${size}px ${FAMILY}`;
    c.fillStyle = color;
    c.textAlign = align;
    c.fillText(written(text), x, y);
  }

  /** Return the width of a text [px]. */
  widthOf(text, size = SMALL) {
    this.c.font = `${size}px ${FAMILY}`;
    return this.c.measureText(written(text)).width;
  }
}

/** Return how an axis lies: its range, and where a value is [px] from its beginning. */
function axisOf(letter, given, range, offset, length) {
  const log = given.type === "log";
  const [low, high] = range;
  const along = (at) => ((at - low) / (high - low)) * length;
  const l2p = letter === "x" ? along : (at) => length - along(at);
  return { given, range, _offset: offset, _length: length, l2p, d2p: (value) => l2p(log ? Math.log10(value) : value), ticks: ticksOf(letter, given, range, length) };
}

/** Remove the sketch in the place of a name; what plotly.js has drawn there is seen again. */
export function unsketch(name) {
  const place = document.getElementById(name);
  place.querySelector(":scope > .sketch")?.remove();
  place.classList.remove("covered");
  delete place.sketched;
}

/** Return the canvas of a sketch, the one that is there or a new one. */
function canvasIn(place, words) {
  let canvas = place.querySelector(":scope > .sketch");
  if (!canvas) {
    canvas = Object.assign(document.createElement("canvas"), { className: "sketch" });
    canvas.setAttribute("role", "img");
    place.append(canvas);
  }
  if (canvas.getAttribute("aria-label") !== words) canvas.setAttribute("aria-label", words);
  return canvas;
}

/** Draw traces in the place of a name, over what plotly.js has drawn there; cursors find its axes as `sketched`. */
export function sketch(name, traces, layout) {
  const place = document.getElementById(name);
  const { clientWidth: width, clientHeight: height } = place;
  const { l, r, t, b } = layout.margin;
  const [w, h] = [width - l - r, height - t - b];
  if (w < 20 || h < 20) { unsketch(name); return; }
  const words = traces.filter((trace) => trace.showlegend !== false && trace.name).map((trace) => trace.name);
  const pen = new Pen(canvasIn(place, `${name}: ${[...new Set(words)].join(", ")}`), width, height, layout.font.color);
  const rangeAlong = (letter, id) => rangeOf(letter, layout[`${letter}axis${id}`], traces.filter((trace) => letter === "x" || (trace.yaxis ?? "y") === `y${id}`).map((trace) => trace[letter]).concat(letter === "x" && layout.shapes?.length ? [layout.shapes.map(({ x0 }) => x0)] : []));
  const lies = ({ domain: [from, to] = [0, 1] }) => [t + (1 - to) * h, (to - from) * h];
  let [across, up] = [rangeAlong("x", ""), rangeAlong("y", "")];
  if (!layout.xaxis.range) across[1] = roomFor(pen, layout.annotations ?? [], across, w);
  if (layout.xaxis.scaleanchor) [across, up] = sameScale([across, w], [up, h]);
  const x = axisOf("x", layout.xaxis, across, l, w);
  const ys = { y: axisOf("y", layout.yaxis, up, ...lies(layout.yaxis)) };
  if (layout.yaxis2) ys.y2 = axisOf("y", layout.yaxis2, rangeAlong("y", "2"), ...lies(layout.yaxis2));
  place.classList.add("covered");
  place.sketched = { xaxis: x, yaxis: ys.y, yaxis2: ys.y2, _size: { l, t, h } };
  const seen = layout.xaxis.visible !== false;
  for (const y of Object.values(ys)) if (seen) grid(pen, x, y);
  for (const { x0, line } of layout.shapes ?? []) {
    const at = l + x.d2p(x0);
    if (at >= l && at <= l + w) pen.stroke((c) => { c.moveTo(at, t); c.lineTo(at, t + h); }, line);
  }
  for (const [id, y] of Object.entries(ys)) {
    pen.c.save();
    pen.c.beginPath();
    pen.c.rect(l, y._offset, w, y._length);
    pen.c.clip();
    let before;
    for (const trace of traces.filter((each) => (each.yaxis ?? "y") === id)) {
      curve(pen, trace, before, x, y);
      before = trace;
    }
    pen.c.restore();
  }
  for (const { x: at, y, text, font } of layout.annotations ?? []) {
    if (at >= across[0] && at <= across[1]) pen.text(text, l + x.l2p(at) + 2, t + (1 - y) * h + 12, font);
  }
  if (!seen) return;
  for (const { given, _offset: top, _length: length } of Object.values(ys)) pen.line([l - 0.5, top], [l - 0.5, top + length], given.linecolor);
  pen.line([l, t + h + 0.5], [l + w, t + h + 0.5], x.given.linecolor);
  ticks(pen, x, Object.values(ys), t + h);
  legend(pen, traces, l);
}

/** Return where an axis ends that its annotations, to the right of their places, fit on. */
function roomFor(pen, annotations, [low, high], length) {
  const ends = annotations.map(({ x, text, font }) => low + ((x - low) * length) / (length - pen.widthOf(text, font.size) - 4));
  return Math.max(high, ...ends);
}

function grid(pen, x, y) {
  const color = (at, { given }) => (at === 0 && given.zeroline !== false && given.type !== "log" ? given.zerolinecolor : given.gridcolor);
  for (const { at } of x.ticks) pen.line([x._offset + x.l2p(at), y._offset], [x._offset + x.l2p(at), y._offset + y._length], color(at, x));
  for (const { at } of y.ticks) pen.line([x._offset, y._offset + y.l2p(at)], [x._offset + x._length, y._offset + y.l2p(at)], color(at, y));
}

/** Return the places [px] of a trace's points one after the other, NaN where it is interrupted. */
function placesOf({ x, y }, across, up) {
  const made = new Float64Array(2 * x.length);
  for (let i = 0; i < x.length; i++) {
    const gap = x[i] === null || y[i] === null;
    made[2 * i] = gap ? NaN : across._offset + across.d2p(x[i]);
    made[2 * i + 1] = gap ? NaN : up._offset + up.d2p(y[i]);
  }
  return made;
}

/** Draw a curve; one that is filled, down to the curve before it. */
function curve(pen, trace, before, x, y) {
  const made = placesOf(trace, x, y);
  const along = (c) => {
    let joined = false;
    for (let i = 0; i < made.length; i += 2) {
      const known = made[i] === made[i] && made[i + 1] === made[i + 1];
      if (known) { if (joined) c.lineTo(made[i], made[i + 1]); else c.moveTo(made[i], made[i + 1]); }
      joined = known;
    }
  };
  if (trace.fill === "tonexty" && before) {
    const { c } = pen;
    const back = placesOf(before, x, y);
    c.fillStyle = trace.fillcolor;
    c.beginPath();
    along(c);
    for (let i = back.length - 2; i >= 0; i -= 2) c.lineTo(back[i], back[i + 1]);
    c.fill();
  }
  pen.c.miterLimit = 2;
  if (trace.line.width > 0) pen.stroke(along, trace.line);
  if (!trace.mode.includes("markers")) return;
  const half = 0.7 * trace.marker.size;
  pen.stroke((c) => {
    for (let i = 0; i < made.length; i += 2) { c.moveTo(made[i], made[i + 1] - half); c.lineTo(made[i], made[i + 1] + half); }
  }, trace.marker.line);
}

/** Write ticks and titles of all axes; a vertical title gives way to ticks that are wide. */
function ticks(pen, x, ys, bottom) {
  /** Write a tick, its middle or its end at x; return its width. */
  const write = (tick, axis, at, y, align) => {
    const size = tick.size * (axis.given.tickfont?.size ?? SMALL);
    const [text, raised] = tick.text.split("^");
    const power = tick.power ?? raised?.replace("-", "\u2212");
    const own = pen.widthOf(text, size);
    const width = own + (power === undefined ? 0 : pen.widthOf(power, 0.7 * size));
    const left = at - (align === "middle" ? 0.5 : 1) * width;
    const baseline = y + (align === "middle" ? 1 : 0.35) * size;
    pen.text(text, left, baseline, { size });
    if (power !== undefined) pen.text(power, left + own, baseline - 0.42 * size, { size: 0.7 * size });
    return width;
  };
  for (const tick of x.ticks) write(tick, x, x._offset + x.l2p(tick.at), bottom + 3.4, "middle");
  pen.text(x.given.title.text, x._offset + x._length / 2, bottom + 39, { size: LARGE, align: "center" });
  for (const y of ys) {
    const wide = y.ticks.map((tick) => write(tick, y, x._offset - 3.4, y._offset + y.l2p(tick.at), "end"));
    const middle = y._offset + y._length / 2;
    const half = 0.5 * pen.widthOf(y.given.title.text, LARGE) + SMALL / 2;
    const beside = wide.filter((_, i) => Math.abs(y._offset + y.l2p(y.ticks[i].at) - middle) < half);
    const at = Math.max(13, Math.min(36, ...beside.map((each) => x._offset - 3.4 - each - 5)));
    pen.c.save();
    pen.c.translate(at, middle);
    pen.c.rotate(-Math.PI / 2);
    pen.text(y.given.title.text, 0, 0, { size: LARGE, align: "center" });
    pen.c.restore();
  }
}

function legend(pen, traces, left) {
  const seen = new Set();
  for (const { name, line, legendgroup, showlegend } of [...traces].sort((one, other) => (one.legendrank ?? 1000) - (other.legendrank ?? 1000))) {
    const key = legendgroup ?? name;
    if (showlegend === false || !name || seen.has(key)) continue;
    seen.add(key);
    const from = left + 5;
    pen.stroke((c) => { c.moveTo(from, 9.94); c.lineTo(from + 30, 9.94); }, { ...line, width: 5 });
    pen.text(name, left + 40, 14.6);
    left += 45 + pen.widthOf(name);
  }
}
