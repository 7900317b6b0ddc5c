"""Limit cycles of loops with play: published numbers, an independent simulation by matrix exponentials, branches over a gain."""

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gearplay as gp
from building import Measured
from gearplay.vocabulary.errors import InputError, SimulationError
from servo_loops import Axis, cycle, multipliers

BASE = {"J1": 1e-3, "J2": 4e-3, "b": 2e-3, "d1": 1e-3}
TABLE: list[tuple[Axis, float, float, list[float]]] = [
    (
        Axis(**BASE, k=10.0, Kp=4.0, Kd=0.05, Ki=0.0, d2=2e-3),
        0.213976139882,
        4.2280973812e-3,
        [0.61409841, 0.45472494, 5.864e-5],
    ),
    (
        Axis(**BASE, k=5.0, Kp=2.0, Kd=0.1, Ki=0.0, d2=0.01),
        0.344694277289,
        2.9767254995e-3,
        [0.1825228, 6.217e-5, 0.0],
    ),
    (
        Axis(**BASE, k=5.0, Kp=4.0, Kd=0.05, Ki=0.0, d2=0.01),
        0.200513233655,
        7.5104895031e-3,
        [0.55916026, 0.02254846, 0.00173969],
    ),
    (
        Axis(**BASE, k=10.0, Kp=4.0, Kd=0.1, Ki=10.0, d2=2e-3),
        0.219384202568,
        4.6449276883e-3,
        [0.55796788, 0.26362086, 0.0055051, 2.6e-7],
    ),
]
GAIN = "rotors.motor.drive.proportional_gain"


@pytest.mark.compiled
@pytest.mark.parametrize(("axis", "period", "amplitude", "largest"), TABLE)
def test_limit_cycle__numbers_of_exact_flow(
    axis: Axis, period: float, amplitude: float, largest: list[float], measured: Measured
) -> None:
    """Two inertias, a load-side position with the motor's speed: shooting on the exact piecewise linear flow."""
    orbit = gp.periodic_orbit(axis.case(), autonomous=True, settle=40)
    errors = {
        "period": abs(orbit.period / period - 1.0),
        "amplitude": abs(orbit.amplitude("load.theta") / amplitude - 1.0),
        "multipliers": float(np.max(np.abs(np.sort(np.abs(orbit.multipliers))[::-1] - largest))),
    }
    for name, error in errors.items():
        measured(f"limit cycle of a position loop with play: {name}, relative", error, "1e-6")
    assert max(errors.values()) < 1e-6
    assert orbit.stable
    assert len(orbit.contacts) == 4  # each flank closes and opens once


@pytest.mark.compiled
def test_limit_cycle__stiff_contact(measured: Measured) -> None:
    """Where contact is stiff the describing function is wrong by a factor of two, the orbit is not."""
    axis = Axis(**BASE, k=400.0, Kp=8.0, Kd=0.5, Ki=100.0, d2=2e-3)
    orbit = gp.periodic_orbit(axis.case(1e-11), autonomous=True, settle=40)
    errors = abs(orbit.period / 0.2866712040 - 1.0), abs(orbit.amplitude("load.theta") / 3.345016e-3 - 1.0)
    measured("limit cycle of a PI loop, stiff contact: period and amplitude, relative", max(errors), "1e-6")
    assert max(errors) < 1e-6
    estimate = gp.describing_function(axis.case(1e-9), at="load", hold="motor", torque=2.0)
    assert float(estimate.ds["cycle_period"][0]) == pytest.approx(0.1443, abs=1e-4)
    assert estimate.errors(orbit)["period"] < -0.45


@pytest.mark.slow
@pytest.mark.compiled
def test_limit_cycle__pi_loop_against_matrix_exponentials(measured: Measured) -> None:
    """A loop with an integral: the settled motion, and its return map differentiated by differences."""
    axis = Axis(J1=2e-3, J2=5e-3, k=14.0, b=1.5e-3, d1=1e-3, d2=3e-3, Kp=5.0, Kd=0.12, Ki=20.0)
    state, period, amplitude = cycle(axis)
    orbit = gp.periodic_orbit(axis.case(), autonomous=True, settle=40, section="motor-load:forward:opens")
    exact = np.abs(multipliers(axis, state))[:3]
    errors = {
        "period": abs(orbit.period / period - 1.0),
        "amplitude": abs(orbit.amplitude("load.theta", samples=4000) / amplitude - 1.0),
        "multipliers": float(np.max(np.abs(np.abs(orbit.multipliers)[:3] - exact))),
    }
    for name, error in errors.items():
        measured(f"limit cycle of a PI loop with play against another simulation: {name}", error, "1e-6")
    assert errors["period"] < 1e-8
    assert max(errors.values()) < 1e-6
    at = orbit.states[0]  # angles, speeds, integral at the opening
    signs = [1.0, 1.0, 1.0, 1.0, -1.0]  # the integral is that of the error, less the angle
    assert np.allclose(at[:-1], state[[0, 2, 1, 3, 4]] * signs, rtol=1e-6, atol=1e-9)


@pytest.mark.slow
@pytest.mark.compiled
def test_branch_over_a_gain__steps_and_another_simulation(measured: Measured) -> None:
    """Whatever the steps, periods are those of orbits sought at the same gain from a start of their own."""
    axis = TABLE[0][0]
    worst = 0.0
    for size in (0.8, 0.4):
        found = gp.branch(
            axis.case(), GAIN, 3.3, 4.2, autonomous=True, settle=40, upwards=False, orbits=40, size=size
        )
        assert "left its bounds" in found.ended
        assert np.all(found.stable)
        for one in found.orbits[2:-1:6]:
            alone = gp.periodic_orbit(axis.with_gain(one.parameter).case(), autonomous=True, settle=40)
            worst = max(worst, abs(alone.period / one.period - 1.0))
    measured("branch of limit cycles over a gain: period, relative", worst, "1e-8")
    assert worst < 1e-8
    last = found.orbits[-1]
    _, period, _ = cycle(axis.with_gain(last.parameter))
    assert last.period == pytest.approx(period, rel=1e-8)


def _saved(result: Any, path: Path) -> Path:
    result.save(path)
    return path


def test_limit_cycle__round_trip_and_words(tmp_path: Path) -> None:
    orbit = gp.periodic_orbit(TABLE[2][0].case(1e-9), autonomous=True, settle=20)
    again: Any = gp.read_result(_saved(orbit, tmp_path / "orbit.nc"))
    assert again.period == orbit.period
    assert "limit cycle of period 0.2005" in again.message
    motion = orbit.motion(["load.theta"], samples=100)
    assert motion["load.theta"].values[0] == pytest.approx(motion["load.theta"].values[-1], abs=1e-9)
    branch = gp.branch(TABLE[2][0].case(1e-9), GAIN, 3.9, 4.1, autonomous=True, settle=20, orbits=3)
    table: Any = gp.read_result(_saved(branch, tmp_path / "branch.nc"))
    assert [each.period for each in table.orbits] == [each.period for each in branch.orbits]
    assert len(table.table(["load.theta"])["period"]) == 3


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"section": "nobody:opens"}, r"section.*CONTACT:opens"),
        ({"section": "motor-load:forward:waits"}, "section"),
        ({"order": 2}, r"order.*must be 1 for a limit cycle"),
        ({"autonomous": False, "section": "motor-load:forward:opens"}, r"section.*left out"),
    ],
)
def test_limit_cycle__refused_arguments(changes: dict[str, Any], words: str) -> None:
    with pytest.raises(InputError, match=words):
        gp.periodic_orbit(TABLE[0][0].case(1e-9), **({"autonomous": True} | changes))


def test_limit_cycle__refused_cases() -> None:
    case = TABLE[0][0].case(1e-9)
    shaken = gp.replace(
        case,
        {
            "rotors.load.drive": {
                "kind": "torque",
                "torque": 0.0,
                "terms": [{"frequency": 50.0, "amplitude": 0.1}],
            }
        },
    )
    with pytest.raises(InputError, match=r"autonomous.*excites the case, here at 50 Hz"):
        gp.periodic_orbit(shaken, autonomous=True)
    tight = gp.replace(case, {"couplings.0.play": 0.0})
    with pytest.raises(InputError, match="without a contact"):
        gp.periodic_orbit(tight, autonomous=True)
    quiet = gp.replace(case, {GAIN: 0.2, "rotors.motor.drive.derivative_gain": 0.5, "run.duration": 0.2})
    with pytest.raises(SimulationError, match="comes to rest"):
        gp.periodic_orbit(quiet, autonomous=True, settle=500)


def test_period_of_a_forced_orbit_is_none() -> None:
    assert math.isnan(gp.periodic_orbit(gp.torsional_pair(0.7, force=0.05), settle=300).period)
