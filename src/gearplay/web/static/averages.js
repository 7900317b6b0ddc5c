// Ensemble averages for the run shown: a short run of a chaotic motion is not representative.

import { state } from "./page.js";

const MEMBERS = [16, 8]; // the fewer where more would take long
const RECORDED = 5; // s of each member, where that is soon done
const SHORTEST = 0.5; // s
const BEFORE = 1; // s, at least
const LONGEST = 10; // s that the averages may take
const STEP = 6.5e-6; // s that a step takes on a usual machine
const SECOND = 3e-4; // s for what else a simulated second costs
let running = null;

/** Return how long one simulated second of a model takes [s], by the steps of a result. */
export function paceOf({ models, case: { run } }) {
  const [view] = Object.values(models);
  return SECOND + (STEP * view.steps) / ((run.transient + run.duration) * run.ensemble);
}

/** Cancel a running average. */
export function dropAverage() {
  if (running) state.wire.cancel(running.number);
  running = null;
}

/** Request the averages of a result, once at a time, and add them to it; false where they add nothing, would take long or fail. */
export function averageOf(result) {
  result.averaging ??= average(result).finally(() => { result.averaging = null; });
  return result.averaging;
}

async function average(result) {
  const { run, sleeves } = result.case;
  const rattles = Object.values(sleeves).some((each) => each.radial_clearance > 0);
  if (result.average || result.members > 1 || !rattles || !state.wire.ready) return false;
  const models = Object.keys(result.models);
  const transient = Math.max(BEFORE, run.transient);
  const affordable = (count) => LONGEST / (count * models.length * paceOf(result)) - transient - run.duration;
  const members = MEMBERS.find((count) => affordable(count) >= SHORTEST);
  if (!members) return false;
  const duration = Math.min(RECORDED, Number(affordable(members).toPrecision(1)));
  const job = state.wire.submit("average", { case: result.case, models, members, duration, transient });
  running = job;
  try {
    result.average = await job;
    return true;
  } catch { // the run alone is shown
    return false;
  } finally {
    if (running === job) running = null;
  }
}
