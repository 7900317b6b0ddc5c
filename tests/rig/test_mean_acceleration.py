"""What a sensor feels on a housing that moves: exact means over sampling intervals, whatever the sampling rate."""

import math
from functools import partial
from typing import Any

import numpy as np
import pytest
from scipy.integrate import quad

import gearplay as gp
from building import Document, Floats, Measured, case_of, simulate_one
from gearplay.kernels.housing_motion import base_acceleration
from gearplay.kernels.housing_response import behind
from gearplay.model.pack import pack
from gearplay.solver.housing import HousingMotion
from gearplay.solver.trajectory import Trajectory

ANGLE = 0.7  # rad, direction of the motion
KINDS: dict[str, Document] = {
    "sine": {"kind": "harmonic", "amplitude": 9.0, "frequency": 230.0, "phase": 0.4},
    "shock": {"kind": "half-sine", "amplitude": 80.0, "duration": 0.0137, "start": 0.0213},
    "record": {
        "kind": "record",
        "values": [3.0, -20.0, 14.0, 30.0, -9.0, 2.0, 40.0],
        "sampling": 180.0,
        "start": 0.0212,
    },
    "random": {"kind": "spectral-density", "density": [[5.0, 2.0], [300.0, 1.0]]},
}
RATES = (150.0, 500.0, 2000.0, 1e5)


def run_of(motion: Document, rate: float, **rotor: Any) -> Trajectory:
    """Return a run of a disc on a moving housing, 0.1 s after 0.01 s."""
    document = {
        "rotors": {"disc": {"mass": 1.0, "inertia": 1e-3, **rotor}},
        "base": {"acceleration": {**motion, "direction": ANGLE}},
        "run": {"duration": 0.1, "transient": 0.01, "sampling": rate, "tolerance": 1e-10},
    }
    return simulate_one(document)


@pytest.mark.parametrize("kind", KINDS)
def test_a_free_body_feels_nothing(kind: str, measured: Measured) -> None:
    """It rests in space: the increments of its velocity are those of the housing turned round."""
    for rate in RATES:
        run = run_of(KINDS[kind], rate, floating=True)
        worst = float(np.max(np.abs(run.mean_acceleration("disc"))))
        measured(f"mean acceleration of a free body on a housing [m/s^2], {kind}", worst, "1e-9")
        assert worst < 1e-9 < 1.0 < np.max(np.abs(run.relative_mean_acceleration("ax", "disc")))


@pytest.mark.parametrize("kind", KINDS)
def test_a_held_body_feels_the_mean_of_the_housing(kind: str) -> None:
    """Against the closed form of the kernels and, where it is smooth, adaptive quadrature."""
    for rate in RATES:
        run = run_of(KINDS[kind], rate)
        document = {
            "rotors": {"disc": {"mass": 1.0, "inertia": 1e-3}},
            "base": {"acceleration": {**KINDS[kind], "direction": ANGLE}},
            "run": {"duration": 0.11, "sampling": rate},
        }
        system = pack(case_of(document)).system
        h, along = 1.0 / rate, np.array([[math.cos(ANGLE)], [math.sin(ANGLE)]])
        times = run.time[:: max(1, run.time.size // 200)][:-1]
        exact = np.array([-behind(system, 0.0, float(t), h)[1] * rate for t in times])
        found = run.mean_acceleration("disc")[:, :: max(1, run.time.size // 200)][:, : exact.size]
        assert np.max(np.abs(found - along * exact)) < 1e-9 < np.max(np.abs(exact))
        if kind == "sine":
            t = float(times[3])
            integral = quad(partial(base_acceleration, system), t, t + h, epsabs=1e-13, limit=200)[0]
            assert found[0, 3] == pytest.approx(integral * rate * math.cos(ANGLE), rel=1e-9)


def test_the_mean_of_a_sine_is_that_of_its_integral() -> None:
    """A (cos u_0 - cos u_1) / (w h); the trapezoid of two samples is off by |cos x - sin x / x|, x = pi f / f_s."""
    a, f, rate = 9.0, 230.0, 2000.0
    run = run_of({"kind": "harmonic", "amplitude": a, "frequency": f, "phase": 0.4}, rate)
    w, edges = 2.0 * math.pi * f, run.time
    exact = a * -np.diff(np.cos(w * edges + 0.4)) / (w / rate)
    assert np.allclose(run.mean_acceleration("disc")[0], exact * math.cos(ANGLE), rtol=0.0, atol=1e-11)
    values, x = a * np.sin(w * edges + 0.4), math.pi * f / rate
    off = np.max(np.abs(0.5 * (values[1:] + values[:-1]) - exact))
    assert off == pytest.approx(a * abs(math.cos(x) - math.sin(x) / x), rel=2e-2)


@pytest.mark.parametrize("kind", KINDS)
def test_means_of_parts_add_up(kind: str) -> None:
    """The mean over an interval is that of the means over its parts, also where they are cut unevenly."""
    document = {
        "rotors": {"disc": {"mass": 1.0, "inertia": 1e-3}},
        "base": {"acceleration": {**KINDS[kind], "direction": ANGLE}},
        "run": {"duration": 0.15, "sampling": 1e4},
    }
    motion = HousingMotion.of(pack(case_of(document)).system)
    assert motion is not None
    times = np.cumsum(np.random.default_rng(1).uniform(1e-5, 2e-3, 100))
    parts: Floats = motion.means(times) * np.diff(times)
    total = motion.means(times[[0, -1]])[:, 0] * (times[-1] - times[0])
    assert np.allclose(parts.sum(axis=1), total, rtol=0.0, atol=1e-13)


def test_a_rig_on_a_free_body_records_what_it_records_at_rest() -> None:
    """The same noise and nothing else: the housing's motion does not show, whatever the collector's rate."""
    rig = {
        "accelerometers": {"shaft": {"rotor": "disc", "sensitivity": "1 mV/(m/s^2)"}},
        "collector": {"sampling": 2000.0},
    }
    document: Document = {
        "rotors": {"disc": {"mass": 1.0, "inertia": 1e-3, "floating": True}},
        "run": {"duration": 0.1, "transient": 0.05, "sampling": 1e4},
    }
    shaking = {"acceleration": {"kind": "harmonic", "amplitude": 9.0, "frequency": 230.0}}
    still, shaken = (gp.measure(case_of(d), rig) for d in (document, {**document, "base": shaking}))
    assert len(still.channels) == len(shaken.channels) > 1
    for at_rest, moved in zip(still.channels, shaken.channels, strict=True):
        off = np.abs(at_rest.values - moved.values)
        count = 10.0 / 2**16 / 1e-3  # m/s^2, of 5 V either way in 16 bits; rounding may fall either way
        assert np.max(off) <= 1.001 * count
        assert np.mean(off > 1e-9) < 0.01
