// Overlays in the plots of a run: an earlier run, or an uploaded measurement.

import { $, request, state } from "./page.js";
import { redraw } from "./runs.js";
import { decode } from "./wire.js";

const MOST_BYTES = 64 * 1024 * 1024; // of a measurement
const OWN = "own ";

/** Offer the runs that are kept; the channels of a measurement that was read stay in the list. */
export function offerOverlays(runs) {
  const own = state.measured.map(({ name }, k) => new Option(name, `${OWN}${k}`));
  $("overlay").replaceChildren(new Option("nothing", ""), ...own, ...runs.map(([key, words]) => new Option(words, key)));
  $("overlay").value = state.overlay?.key ?? "";
}

/** Overlay an earlier run or a channel of a measurement, by its key; "" removes the overlay. */
export async function overlay(key) {
  if (key.startsWith(OWN)) {
    const channel = state.measured[Number(key.slice(OWN.length))];
    state.overlay = { measured: channel, name: channel.name, key };
  } else state.overlay = key ? { ...decode(await (await request(`/api/results/${key}`)).arrayBuffer()), key } : null;
  redraw();
}

/** Read a measurement, as `gearplay analyze` does, and overlay its first channel. */
export async function measured(file) {
  if (!file) return;
  if (file.size > MOST_BYTES) throw new Error(`${file.name}: must have at most 64 MB. Shorten it.`);
  const query = new URLSearchParams({ name: file.name, unit: $("measured-unit").value });
  const { channels } = decode(await (await request(`/api/measurement?${query}`, file)).arrayBuffer());
  const runs = [...$("overlay").options].filter(({ value }) => value && !value.startsWith(OWN)).map(({ value, text }) => [value, text]);
  state.measured = channels;
  state.overlay = { measured: channels[0], name: channels[0].name, key: `${OWN}0` };
  offerOverlays(runs);
  redraw();
}
