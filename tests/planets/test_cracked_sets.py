"""Planetary sets with pairs of teeth and a cracked tooth: times between the events of the tooth in the planets' rotations."""

import math

import numpy as np
import pytest

from building import Document, Floats, Measured, simulate_one
from gearplay.signals import event_periods
from laws.test_gear_faults import delay
from planetary_sets import planetary_document

WIDE = {"facewidth": 0.01}


def set_document(
    teeth: tuple[int, int, int], planets: int, speed: float, faults: list[Document], duration: float
) -> Document:
    """Return a loaded set of module 4 mm with its ring fixed and its sun driven at a speed [rad/s]."""
    sun, planet, ring = teeth
    found = planetary_document(
        stiffness={"kind": "teeth", "method": "iso6336", "line_load": 1e6, "mean": None, "amplitude": None},
        contact="pairs",
        damping={"kind": "constant", "value": 3000.0, "ratio": None},
        sun={"teeth": sun, "drive": {"kind": "speed", "speed": speed}, **WIDE},
        planets={"teeth": planet, "count": planets, **WIDE},
        ring={"teeth": ring, **WIDE},
        carrier={"load": {"torque": 400.0}},
        support={"damping": [2e4, 2e4]},
    )
    found |= {"gravity": [0.0, 0.0], "faults": faults}
    return found | {"run": {"duration": duration, "sampling": 1e5, "transient": 0.0, "tolerance": 1e-8}}


def crack_response(
    teeth: tuple[int, int, int], planets: int, speed: float, crack: Document, duration: float
) -> tuple[Floats, Floats]:
    """Return times [s] and what a crack changes in the rotations of the planets [rad], shape [planet, time]."""
    healthy, cracked = (
        simulate_one(set_document(teeth, planets, speed, faults, duration)) for faults in ([], [crack])
    )
    names = [f"stage.planet{k + 1}" for k in range(planets)]
    changed = [cracked.signal("theta", name) - healthy.signal("theta", name) for name in names]
    return healthy.time, np.array(changed)


SETS = [
    pytest.param((17, 37, 91), 3, 800.0, (0.029670, 0.193730), id="17-37-91"),
    pytest.param((24, 30, 84), 4, 1200.0, (0.016071, 0.080357), id="24-30-84", marks=pytest.mark.slow),
]
"""Teeth of sun, planets and ring; planets; speed of the sun [rpm]; events of a sun tooth and of a planet's flank [s]."""
DEPTH = 2.5e-3


@pytest.mark.many
@pytest.mark.parametrize(("teeth", "planets", "rpm", "periods"), SETS)
def test_cracked_sun_tooth__passes_from_planet_to_planet(
    teeth: tuple[int, int, int], planets: int, rpm: float, periods: tuple[float, float], measured: Measured
) -> None:
    """The tooth meets planets every 1 / (N (f_sun - f_carrier)), each as the one before; in between the set hardly notices."""
    speed, tooth = rpm * math.pi / 30.0, 3
    period = 1.0 / (planets * speed / (2.0 * math.pi) * (1.0 - teeth[0] / (teeth[0] + teeth[2])))
    assert period == pytest.approx(event_periods(*teeth, planets, speed).sun, rel=1e-12)
    assert period == pytest.approx(periods[0], abs=5e-7)
    crack = {"kind": "crack", "at": "stage.sun", "tooth": tooth, "depth": DEPTH}
    time, turned = crack_response(teeth, planets, speed, crack, (planets + 2.0) * period)
    found = [
        delay(time, turned[k], turned[(k + 1) % planets], period, 0.8 * period, planets * period)
        for k in range(planets)
    ]
    off = float(np.max(np.abs(np.array(found) - period)))
    measured("cracked sun tooth: time between its events against the closed form, s", off, "1e-6")
    assert off < 1e-7
    mesh_period = planets * period / teeth[0]
    for k in range(planets):
        centre = (k - planets * tooth / teeth[0]) % planets * period  # the tooth points at the planet
        near = np.abs((time - centre + 0.5 * planets * period) % (planets * period) - 0.5 * planets * period)
        assert np.max(np.abs(turned[k])[near > 1.5 * mesh_period]) < 0.2 * np.max(np.abs(turned[k]))


@pytest.mark.slow
@pytest.mark.many
@pytest.mark.parametrize(("teeth", "planets", "rpm", "periods"), SETS)
def test_cracked_planet_tooth__meets_the_sun_once_a_turn_of_the_planet(
    teeth: tuple[int, int, int], planets: int, rpm: float, periods: tuple[float, float]
) -> None:
    speed = rpm * math.pi / 30.0
    period = event_periods(*teeth, planets, speed).planet
    assert period == pytest.approx(periods[1], abs=5e-7)
    crack = {"kind": "crack", "at": "stage.planet2", "tooth": 5, "depth": DEPTH, "flank": "left"}
    time, turned = crack_response(teeth, planets, speed, crack, 2.2 * period)
    found = delay(time, turned[1], turned[1], period, 0.1 * period, period)
    assert found == pytest.approx(period, abs=1e-7)
