// Ranges and ticks of axes, chosen as plotly.js chooses them: nothing may jump when it takes over what was sketched.

const NONE = { x: [-1, 6], y: [-1, 4] };
const SHARE = 0.05; // of an axis that stays free on either side of what is drawn, vertically
const APART = { x: 80, y: 40 }; // px between ticks
const MINUS = "\u2212";

/** Return the least and the largest of many arrays as an axis counts them; null where there is nothing. */
function spanOf(arrays, log) {
  let [least, largest] = [Infinity, -Infinity];
  for (const array of arrays) {
    for (const value of array) {
      if (value === null || !Number.isFinite(value) || (log && value <= 0)) continue;
      if (value < least) least = value;
      if (value > largest) largest = value;
    }
  }
  if (least > largest) return null;
  return log ? [Math.log10(least), Math.log10(largest)] : [least, largest];
}

/** Return the range of an axis, "x" or "y", over the arrays drawn along it; `given` is the axis of the layout. */
export function rangeOf(letter, given, arrays) {
  if (given.range) return given.range;
  const span = spanOf(arrays, given.type === "log");
  if (!span) return NONE[letter];
  const [low, high] = span;
  if (low === high) return [low - 1, high + 1];
  if (given.rangemode === "tozero" && low >= 0) return [0, high / (1 - SHARE)];
  const free = letter === "y" ? (SHARE * (high - low)) / (1 - 2 * SHARE) : 0;
  return [low - free, high + free];
}

/** Widen one of two ranges so that both axes have one scale; lengths in px. */
export function sameScale([x, width], [y, height]) {
  const [across, up] = [(x[1] - x[0]) / width, (y[1] - y[0]) / height];
  const scale = Math.max(across, up);
  const about = ([low, high], half) => [0.5 * (low + high) - half, 0.5 * (low + high) + half];
  return [about(x, 0.5 * scale * width), about(y, 0.5 * scale * height)];
}

const roundUp = (value) => {
  const base = 10 ** Math.floor(Math.log10(value));
  return base * ([2, 5].find((each) => each >= value / base) ?? 10);
};

/** Return the ticks of an axis: `at` as it counts, `text`, and of a power of ten its `power`; `size` is that of the text as a share. */
export function ticksOf(letter, given, range, length) {
  if (given.tickvals) return given.tickvals.map((at, i) => ({ at, text: given.ticktext[i], size: 1 })).filter(({ at }) => within(at, range));
  const count = Math.min(9, Math.max(4, length / APART[letter])) + 1;
  const rough = Math.abs(range[1] - range[0]) / count;
  if (given.type === "log") return logTicks(range, given.dtick ?? (rough > 0.7 ? Math.ceil(rough) : rough > 0.3 ? "D2" : "D1"));
  const step = given.dtick ?? roundUp(rough);
  return multiples(range, step).map((at) => ({ at, text: textOf(at, step, range, given.tickformat), size: 1 }));
}

const within = (at, [low, high]) => at >= low - 1e-4 * (high - low) && at <= high + 1e-4 * (high - low);

function multiples(range, step) {
  const found = [];
  for (let k = Math.ceil(range[0] / step - 1e-4); within(k * step, range) && found.length < 1000; k++) found.push(k * step);
  return found;
}

function logTicks(range, step) {
  const whole = (power) => (power === 0 ? { text: "1" } : power === 1 ? { text: "10" } : { text: "10", power: String(power).replace("-", MINUS) });
  if (typeof step === "number") return multiples(range, step).map((at) => ({ at, size: 1.25, ...whole(Math.round(at)) }));
  const digits = step === "D2" ? [1, 2, 5] : [1, 2, 3, 4, 5, 6, 7, 8, 9];
  const found = [];
  for (let power = Math.floor(range[0]); power <= range[1] + 1; power++) {
    for (const digit of digits) {
      const at = power + Math.log10(digit);
      if (within(at, range)) found.push(digit === 1 ? { at, size: 1.25, ...whole(power) } : { at, size: 0.75, text: String(digit) });
    }
  }
  return found;
}

/** Return a number as a tick says it: two digits beyond the step, a power of ten where the axis is large or small. */
function textOf(value, step, range, format) {
  const sign = (text, negative) => (negative ? MINUS : "") + text;
  if (format) return sign(Math.abs(value).toFixed(Number(format.slice(1, -1))), value < 0);
  const largest = Math.max(Math.abs(range[0]), Math.abs(range[1]));
  const magnitude = Math.floor(Math.log10(largest) + 0.01);
  const power = Math.abs(magnitude) > 3 ? magnitude : 0;
  const digits = Math.max(0, 2 - Math.floor(Math.log10(step) + 0.01) + power);
  const size = Math.abs(value) / 10 ** power;
  if (size < 0.5 * 10 ** -digits) return "0";
  const [before, after] = String(Number(size.toFixed(Math.min(digits, 20)))).split(".");
  const grouped = after || before.length > 4 ? before.replace(/\B(?=(\d{3})+$)/g, ",") : before;
  const text = after ? `${grouped}.${after}` : grouped;
  return sign(power ? `${text}×10^${power}` : text, value < 0);
}
