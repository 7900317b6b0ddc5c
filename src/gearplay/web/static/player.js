// A page that holds one result's motion and plays it, without a server; written by `gearplay animate --out motion.html`.

import { Stage } from "./mechanism.js";

const $ = (id) => document.getElementById(id);
const result = JSON.parse($("result").textContent);
const [frames] = Object.values(result.models).map((each) => each.frames);
const stage = new Stage($("stage"), moved);

function moved() {
  $("scrub").value = stage.at;
  $("clock").textContent = `${(result.start + stage.time).toPrecision(6)} s`;
}

function playing(on) {
  stage.playing = on;
  $("play").textContent = on ? "Pause" : "Play";
}

function magnified() {
  stage.magnify = 10 ** Number($("magnify").value);
  $("factor").textContent = `${stage.factor.toPrecision(3)} times as large`;
  stage.draw();
}

function offer(id, names, chosen) {
  $(id).replaceChildren(...names.map((name) => new Option(name, name)));
  if (names.includes(chosen)) $(id).value = chosen;
  $(id).parentElement.hidden = names.length < 2;
  $(id).addEventListener("input", () => { stage.look = { sleeve: $("sleeve").value, mesh: $("mesh").value }; stage.draw(); });
}

const slowest = (frames.t[frames.t.length - 1] - frames.t[0]) / 10; // all of it in ten seconds
const speeds = [1, 0.2, 0.05, 0.01, 0.002];
$("slow").replaceChildren(...speeds.map((speed) => new Option(speed === 1 ? "1" : `1/${Math.round(1 / speed)}`, speed)));
$("slow").value = speeds.find((speed) => speed <= slowest) ?? speeds[speeds.length - 1];
$("slow").addEventListener("input", () => { stage.speed = Number($("slow").value); });
$("play").addEventListener("click", () => playing(!stage.playing));
$("scrub").addEventListener("input", () => { playing(false); stage.at = Math.min(0.9999, Number($("scrub").value)); stage.draw(); moved(); });
$("magnify").value = Math.log10(result.magnify);
$("magnify").addEventListener("input", magnified);
$("carrier").addEventListener("input", () => { stage.turning = $("carrier").value === "turning"; stage.draw(); });
$("carrier").parentElement.hidden = !frames.orbit.some((angle) => angle);

stage.look = result.look;
stage.show(result);
offer("sleeve", result.mechanism.sleeves.map((each) => each.name), result.look.sleeve);
offer("mesh", result.mechanism.meshes.map((each) => each.name), result.look.mesh);
stage.speed = Number($("slow").value);
playing(stage.playing);
$("arrows").textContent = stage.peak > 1e-6 ? `arrows: forces, the longest ${Number(stage.peak.toPrecision(3))} N` : "no contact bears a force";
magnified();
moved();
