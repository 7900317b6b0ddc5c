// What lies beside a run in its plots: an earlier run, or a measurement of one's own.

import { $, ask, state } from "./page.js";
import { redraw } from "./runs.js";
import { decode } from "./wire.js";

const MOST_TEXT = 32 * 1024 * 1024; // bytes of a measurement
const MOST_SAMPLES = 2 ** 20;

/** Offer the runs that are kept; a measurement that was read stays in the list. */
export function offerOverlays(runs) {
  const { overlay: now } = state;
  const own = now?.measured ? [new Option(now.name, "own")] : [];
  $("overlay").replaceChildren(new Option("nothing", ""), ...own, ...runs.map(([key, words]) => new Option(words, key)));
  $("overlay").value = now?.key ?? "";
}

/** Lay an earlier run beside, by its key; "" takes away what is there. */
export async function overlay(key) {
  if (key === "own") return;
  state.overlay = key ? { ...decode(await (await ask(`/api/results/${key}`)).arrayBuffer()), key } : null;
  redraw();
}

/** Lay a measurement beside: CSV of frequencies [Hz] and amplitudes, or of times [s] and accelerations [m/s²], two columns. */
export async function measured(file) {
  if (!file) return;
  if (file.size > MOST_TEXT) throw new Error(`${file.name}: must have at most 32 MB. Shorten it.`);
  const lines = (await file.text()).split(/\r?\n/).filter((line) => line.trim());
  const split = (line) => line.split(/[;,\t]| +/).map((each) => each.trim()).filter((each) => each !== "");
  const rows = lines.map((line) => split(line).slice(0, 2).map(Number)).filter((row) => row.length === 2 && row.every(Number.isFinite));
  const rising = rows.every(([x], i) => i === 0 || x > rows[i - 1][0]);
  if (rows.length < 8 || !rising) {
    throw new Error(`${file.name}: must have two columns of numbers, 8 lines or more, the first rising: frequency [Hz] or time [s], then acceleration [m/s^2]. Correct it.`);
  }
  const timed = /^\W*(t\b|time|zeit|seconds?\b|s\b)/i.test(lines[0]);
  const found = timed ? spectrumOf(rows) : { f: rows.map(([f]) => f), a: rows.map(([, a]) => a) };
  state.overlay = { measured: found, name: file.name, key: "own" };
  offerOverlays([...$("overlay").options].filter(({ value }) => value && value !== "own").map(({ value, text }) => [value, text]));
  redraw();
}

/** Return the amplitude spectrum of a record with a Hann window, of its first 2^n samples. */
function spectrumOf(rows) {
  const n = Math.min(MOST_SAMPLES, 2 ** Math.floor(Math.log2(rows.length)));
  const step = (rows[n - 1][0] - rows[0][0]) / (n - 1);
  const mean = rows.slice(0, n).reduce((sum, [, value]) => sum + value, 0) / n;
  const window = Float64Array.from({ length: n }, (_, i) => 0.5 - 0.5 * Math.cos((2 * Math.PI * i) / n));
  const re = window.map((each, i) => each * (rows[i][1] - mean));
  const im = new Float64Array(n);
  transform(re, im);
  const f = [];
  const a = [];
  for (let k = 1; k < n / 2; k++) { f.push(k / (n * step)); a.push((2 * Math.hypot(re[k], im[k])) / (0.5 * n)); }
  return { f, a };
}

/** Fourier transform in place, of 2^n numbers. */
function transform(re, im) {
  const n = re.length;
  for (let i = 1, j = 0; i < n; i++) {
    let bit = n >> 1;
    for (; j & bit; bit >>= 1) j ^= bit;
    j ^= bit;
    if (i < j) { [re[i], re[j]] = [re[j], re[i]]; [im[i], im[j]] = [im[j], im[i]]; }
  }
  for (let size = 2; size <= n; size <<= 1) {
    const half = size >> 1;
    for (let k = 0; k < half; k++) {
      const [c, s] = [Math.cos((2 * Math.PI * k) / size), -Math.sin((2 * Math.PI * k) / size)];
      for (let i = k; i < n; i += size) {
        const j = i + half;
        const [x, y] = [re[j] * c - im[j] * s, re[j] * s + im[j] * c];
        [re[j], im[j], re[i], im[i]] = [re[i] - x, im[i] - y, re[i] + x, im[i] + y];
      }
    }
  }
}
