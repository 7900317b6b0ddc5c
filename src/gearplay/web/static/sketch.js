// A plot drawn at once, as SVG, from what plotly.js is given, so that nobody waits for its 5 MB or its some 60 ms to see new curves. It
// looks the same, has no zoom, and goes when plotly.js takes over.

import { rangeOf, sameScale, ticksOf } from "./scales.js";

const SPACE = "http://www.w3.org/2000/svg";
const FAMILY = '"Open Sans", verdana, arial, sans-serif';
const [SMALL, LARGE] = [12, 14]; // px of ticks and of titles
const DASHES = { dot: [1, 1], dash: [3, 3] };
const ruler = document.createElement("canvas").getContext("2d"); // measures texts without a layout of the page
const written = (text) => String(text).replace(/&lt;/g, "<").replace(/&gt;/g, ">").replace(/&amp;/g, "&");

/** Make an element; presentation attributes alone, since the page's policy lets no styles in. */
function put(parent, name, attributes, text) {
  const made = document.createElementNS(SPACE, name);
  for (const [key, value] of Object.entries(attributes)) if (value !== undefined) made.setAttribute(key, value);
  if (text !== undefined) made.textContent = written(text);
  parent.append(made);
  return made;
}

/** Return the width of a text [px]. */
function widthOf(text, size) {
  ruler.font = `${size}px ${FAMILY}`;
  return ruler.measureText(written(text)).width;
}

function dashed(dash, width = 1) {
  const unit = Math.max(width, 3);
  return DASHES[dash]?.map((times) => times * unit).join();
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

/** Draw traces in the place of a name, over what plotly.js has drawn there; cursors find its axes as `sketched`. */
export function sketch(name, traces, layout) {
  const place = document.getElementById(name);
  const { clientWidth: width, clientHeight: height } = place;
  place.querySelector(":scope > .sketch")?.remove();
  const { l, r, t, b } = layout.margin;
  const [w, h] = [width - l - r, height - t - b];
  if (w < 20 || h < 20) return;
  const words = traces.filter((trace) => trace.showlegend !== false && trace.name).map((trace) => trace.name);
  const root = put(place, "svg", { class: "sketch", width, height, role: "img", "aria-label": `${name}: ${[...new Set(words)].join(", ")}`, "font-family": FAMILY, "font-size": SMALL, fill: layout.font.color });
  const rangeAlong = (letter, id) => rangeOf(letter, layout[`${letter}axis${id}`], traces.filter((trace) => letter === "x" || (trace.yaxis ?? "y") === `y${id}`).map((trace) => trace[letter]).concat(letter === "x" && layout.shapes?.length ? [layout.shapes.map(({ x0 }) => x0)] : []));
  const lies = ({ domain: [from, to] = [0, 1] }) => [t + (1 - to) * h, (to - from) * h];
  let [across, up] = [rangeAlong("x", ""), rangeAlong("y", "")];
  if (!layout.xaxis.range) across[1] = roomFor(layout.annotations ?? [], across, w);
  if (layout.xaxis.scaleanchor) [across, up] = sameScale([across, w], [up, h]);
  const x = axisOf("x", layout.xaxis, across, l, w);
  const ys = { y: axisOf("y", layout.yaxis, up, ...lies(layout.yaxis)) };
  if (layout.yaxis2) ys.y2 = axisOf("y", layout.yaxis2, rangeAlong("y", "2"), ...lies(layout.yaxis2));
  place.classList.add("covered");
  place.sketched = { xaxis: x, yaxis: ys.y, yaxis2: ys.y2, _size: { l, t, h } };
  const seen = layout.xaxis.visible !== false;
  for (const y of Object.values(ys)) if (seen) grid(root, x, y);
  for (const { x0, line } of layout.shapes ?? []) {
    const at = l + x.d2p(x0);
    if (at >= l && at <= l + w) put(root, "path", { d: `M${at},${t}v${h}`, stroke: line.color, "stroke-width": line.width, "stroke-dasharray": dashed(line.dash, line.width) });
  }
  for (const [id, y] of Object.entries(ys)) {
    const clip = put(put(root, "clipPath", { id: `clip-${name}-${id}` }), "rect", { x: l, y: y._offset, width: w, height: y._length }).parentNode;
    const area = put(root, "g", { "clip-path": `url(#${clip.id})` });
    let before;
    for (const trace of traces) {
      if ((trace.yaxis ?? "y") !== id) continue;
      curve(area, trace, before, x, y);
      before = trace;
    }
  }
  for (const { x: at, y, text, font } of layout.annotations ?? []) {
    if (at >= across[0] && at <= across[1]) put(root, "text", { x: l + x.l2p(at) + 2, y: t + (1 - y) * h + 12, "font-size": font.size, fill: font.color }, text);
  }
  if (!seen) return;
  for (const { given, _offset: top, _length: length } of Object.values(ys)) put(root, "path", { d: `M${l - 0.5},${top}v${length}`, stroke: given.linecolor, "shape-rendering": "crispEdges" });
  put(root, "path", { d: `M${l},${t + h + 0.5}h${w}`, stroke: x.given.linecolor, "shape-rendering": "crispEdges" });
  ticks(root, x, Object.values(ys), t + h);
  legend(root, traces, l);
}

/** Return where an axis ends that its annotations, to the right of their places, fit on. */
function roomFor(annotations, [low, high], length) {
  const ends = annotations.map(({ x, text, font }) => low + ((x - low) * length) / (length - widthOf(text, font.size) - 4));
  return Math.max(high, ...ends);
}

function grid(root, x, y) {
  const line = (d, color) => put(root, "path", { d, stroke: color, "shape-rendering": "crispEdges" });
  const zero = (axis) => axis.given.zeroline !== false && axis.given.type !== "log";
  for (const { at } of x.ticks) line(`M${x._offset + x.l2p(at)},${y._offset}v${y._length}`, at === 0 && zero(x) ? x.given.zerolinecolor : x.given.gridcolor);
  for (const { at } of y.ticks) line(`M${x._offset},${y._offset + y.l2p(at)}h${x._length}`, at === 0 && zero(y) ? y.given.zerolinecolor : y.given.gridcolor);
}

/** Draw a curve; one that is filled, down to the curve before it. */
function curve(area, trace, before, x, y) {
  const points = (of) => Array.from(of.x, (value, i) => (value === null || of.y[i] === null || Number.isNaN(of.y[i]) ? null : [x._offset + x.d2p(value), y._offset + y.d2p(of.y[i])]));
  const made = points(trace);
  let d = "";
  for (const [i, point] of made.entries()) if (point) d += `${d && made[i - 1] ? "L" : "M"}${point[0].toFixed(2)},${point[1].toFixed(2)}`;
  if (!d) return;
  if (trace.fill === "tonexty" && before) {
    const back = points(before).reverse().map(([px, py]) => `L${px.toFixed(2)},${py.toFixed(2)}`).join("");
    put(area, "path", { d: `${d}${back}Z`, fill: trace.fillcolor });
  }
  const { color, width, dash } = trace.line;
  if (width > 0) put(area, "path", { d, fill: "none", stroke: color, "stroke-width": width, "stroke-dasharray": dashed(dash, width), "stroke-miterlimit": 2 });
  if (!trace.mode.includes("markers")) return;
  const half = 0.7 * trace.marker.size;
  put(area, "path", { d: made.filter(Boolean).map(([px, py]) => `M${px.toFixed(2)},${(py - half).toFixed(2)}v${2 * half}`).join(""), stroke: trace.marker.line.color, "stroke-width": trace.marker.line.width });
}

/** Write ticks and titles of all axes; a vertical title gives way to ticks that are wide. */
function ticks(root, x, ys, bottom) {
  /** Write a tick; return its width. */
  const write = (tick, axis, attributes, dy) => {
    const size = tick.size * (axis.given.tickfont?.size ?? SMALL);
    const text = tick.text.replace(/\^.*/, "");
    const made = put(root, "text", { ...attributes(size), "font-size": size }, text);
    const power = tick.power ?? (tick.text.includes("^") ? tick.text.split("^")[1].replace("-", "\u2212") : undefined);
    if (power === undefined) return widthOf(text, size);
    put(made, "tspan", { dy: -0.42 * size, "font-size": 0.7 * size }, power);
    return widthOf(text, size) + widthOf(power, 0.7 * size);
  };
  for (const tick of x.ticks) write(tick, x, (size) => ({ x: x._offset + x.l2p(tick.at), y: bottom + 3.4 + size, "text-anchor": "middle" }));
  put(root, "text", { x: x._offset + x._length / 2, y: bottom + 39, "text-anchor": "middle", "font-size": LARGE }, x.given.title.text);
  for (const y of ys) {
    const wide = y.ticks.map((tick) => write(tick, y, (size) => ({ x: x._offset - 3.4, y: y._offset + y.l2p(tick.at) + 0.35 * size, "text-anchor": "end" })));
    const middle = y._offset + y._length / 2;
    const title = put(root, "text", { y: middle, "text-anchor": "middle", "font-size": LARGE }, y.given.title.text);
    const half = 0.5 * widthOf(y.given.title.text, LARGE) + SMALL / 2;
    const beside = wide.filter((_, i) => Math.abs(y._offset + y.l2p(y.ticks[i].at) - middle) < half);
    const at = Math.max(13, Math.min(36, ...beside.map((each) => x._offset - 3.4 - each - 5)));
    title.setAttribute("x", at);
    title.setAttribute("transform", `rotate(-90,${at},${middle})`);
  }
}

function legend(root, traces, left) {
  const seen = new Set();
  for (const { name, line, legendgroup, showlegend } of [...traces].sort((one, other) => (one.legendrank ?? 1000) - (other.legendrank ?? 1000))) {
    const key = legendgroup ?? name;
    if (showlegend === false || !name || seen.has(key)) continue;
    seen.add(key);
    put(root, "path", { d: `M${left + 5},9.94h30`, stroke: line.color, "stroke-width": 5, "stroke-dasharray": dashed(line.dash, 5) });
    put(root, "text", { x: left + 40, y: 14.6 }, name);
    left += 45 + widthOf(name, SMALL);
  }
}
