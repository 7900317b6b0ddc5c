"""Diagnosis of bearings with what measured records have: a narrow load zone, a speed off the given one, short length, hum."""

import numpy as np
import pytest
from scipy.signal import butter, sosfilt

import gearplay as gp
from gearplay.diagnosis.hypotheses import HEALTHY
from gearplay.signals import bearing_orders
from machine_records import event_times, ringing

NICE = bearing_orders(8, 0.235 * 0.0254, 1.245 * 0.0254)
MOTOR = bearing_orders(9, 0.3126 * 0.0254, 1.537 * 0.0254)
NAMES = {
    "inner": "bearing, inner ring",
    "outer": "bearing, outer ring",
    "element": "bearing, rolling element",
}
TURN = 24.75
"""Turns a second of the rig whose speed is given as 1500 rpm, 1 % too fast."""


def motor(part: str | None, seconds: float, seed: int = 0) -> gp.Channel:
    """Return a record as CWRU's of a 6205 at 1796 rpm, given as 1797: 12 kHz, slip of 1 %, resonances at 2.8 and 3.4 kHz, mains.

    Inner ring: heights follow the turn; element: it meets both rings, heights follow the cage. None: no defect.
    """
    rng, rate, turn = np.random.default_rng(seed), 12_000.0, 1796.0 / 60.0
    n = int(rate * seconds)
    t = np.arange(n) / rate
    x = 0.07 * rng.standard_normal(n)
    for place, a in ((turn, 0.01), (2 * turn, 0.015), (60.0, 0.01), (120.0, 0.02), (1036.0, 0.06)):
        x += a * np.cos(2 * np.pi * place * t + rng.uniform(0, 6))
    if part is None:
        return gp.Channel("X097_DE_time", x, rate, "g")
    order = {"inner": MOTOR.bpfi, "outer": MOTOR.bpfo, "element": 2.0 * MOTOR.bsf}[part]
    times = event_times(0.99 * order * turn, seconds, 0.005, rng)
    swing = {"inner": turn, "outer": 0.0, "element": MOTOR.ftf * turn}[part]
    heights = (
        0.6 * (1.0 + 0.5 * np.cos(2 * np.pi * swing * times)) * (1.0 + 0.1 * rng.standard_normal(times.size))
    )
    for resonance in (2800.0, 3400.0):
        x += ringing(times, heights, n, rate, resonance, 700.0)
    return gp.Channel("X105_DE_time", x, rate, "g")


@pytest.mark.parametrize("seconds", [0.5, 10.0])
@pytest.mark.parametrize("part", NAMES)
def test_motor__its_part_is_stated(part: str, seconds: float) -> None:
    for healthy in (None, motor(None, 10.0, 9)):
        found = gp.diagnose(motor(part, seconds), bearings="6205", speed="1797 rpm", healthy=healthy)
        assert (found.hypotheses()[0]["name"], found.told) == (NAMES[part], True)


@pytest.mark.parametrize("seconds", [0.5, 10.0])
def test_motor__nothing_is_stated_of_a_sound_one(seconds: float) -> None:
    for seed, healthy in ((0, None), (1, motor(None, 10.0, 9))):
        found = gp.diagnose(motor(None, seconds, seed), bearings="6205", speed="1797 rpm", healthy=healthy)
        assert (found.hypotheses()[0]["name"], found.told) == (HEALTHY, False)


def test_peaks_within_slip_of_two_parts__are_those_of_the_stated_one() -> None:
    """Three times BPFO and twice BPFI of a 6205 are 0.7 % apart, six times BPFO and four times BPFI too."""
    rng, rate, seconds, line = np.random.default_rng(0), 12_000.0, 0.35, 1.004 * MOTOR.bpfo * 29.95
    times = event_times(line, seconds, 0.0005, rng)
    x = ringing(times, np.ones(times.size), 4200, rate, 3000.0, 600.0) + 0.01 * rng.standard_normal(4200)
    found = gp.diagnose(gp.Channel("acc", x, rate, "g"), bearings="6205", speed="1797 rpm")
    assert found.hypotheses()[0]["name"] == NAMES["outer"]
    for h in (1, 2, 3, 4, 6):
        peak = min(found.lines("envelope"), key=lambda each: abs(each["frequency"] - h * line))
        assert peak["name"] == ("BPFO" if h == 1 else f"{h} x BPFO")
        assert peak["frequency"] == pytest.approx(h * line, abs=1.5 / seconds)


def test_sidebands_of_a_ring__are_named() -> None:
    found = gp.diagnose(narrow_load_zone(0), bearings="NICE", speed="1500 rpm")
    names = {each["name"]: each["frequency"] for each in found.lines("envelope")}
    ring = 1.002 * NICE.bpfi * TURN
    for m in (-3, -2, 2):
        name = f"BPFI {'+' if m > 0 else '-'} {abs(m)} x turn"
        assert names[name] == pytest.approx(ring + m * TURN, abs=0.6)


def narrow_load_zone(seed: int) -> gp.Channel:
    """Return three seconds of an inner ring hit in a fifth of each turn, without a line of the shaft in the spectrum.

    The envelope has multiples of BPFI and of the turn with five sidebands: some lie at lines of the other parts within slip.
    """
    rng, rate, seconds = np.random.default_rng(seed), 24_000.0, 3.0
    times = event_times(1.002 * NICE.bpfi * TURN, seconds, 0.0005, rng)
    heights = np.exp(8.0 * (np.cos(2 * np.pi * TURN * times) - 1.0)) * (
        1.0 + 0.03 * rng.standard_normal(times.size)
    )
    n = int(rate * seconds)
    rumble = sosfilt(butter(4, 200.0, fs=rate, output="sos"), 0.2 * rng.standard_normal(n))
    x = ringing(times, heights, n, rate, 3000.0, 900.0) + rumble + 0.0005 * rng.standard_normal(n)
    return gp.Channel("acc", x, rate, "g")


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_narrow_load_zone__its_sidebands_are_no_evidence_of_another_part(seed: int) -> None:
    found = gp.diagnose(narrow_load_zone(seed), bearings="NICE", speed="1500 rpm")
    first, *others = found.hypotheses()
    assert (first["name"], found.told) == (NAMES["inner"], True)
    heights = [each["evidence"][0]["value"] for each in others if each["evidence"]]
    assert max(heights) < 0.1 * first["evidence"][0]["value"]


def test_speed__is_found_from_turns_in_an_envelope() -> None:
    found = gp.diagnose(narrow_load_zone(0), bearings="NICE", speed="1500 rpm")
    assert found.ds.attrs["speed_source"] == "envelope"
    assert float(found.ds["shaft_speed"]) == pytest.approx(TURN, rel=1e-3)
    assert "by its turns in an envelope" in found.message
