"""Ramps between two speeds, and runs that go on where another ended: the same motion as in one run."""

from typing import Any

import numpy as np
import pytest

import gearplay as gp
from building import Measured
from gearplay.parts.mesh.train.rolling import nominal_speeds, starting_speeds
from gearplay.solver.simulate import run_one

RPM = np.pi / 30.0
MOVING = {
    "run.transient": 0.0,
    "run.sampling": 1e4,
    "run.tolerance": 1e-11,
    "rotors.ring.initial": {"vx": 0.02, "vy": -0.03},
    "meshes.0.transmission_error": [{"order": 1, "amplitude": "3 um"}],
    "rotors.ring.runout": {"amplitude": "5 um"},
    "rotors.pinion.runout": {"amplitude": "5 um"},
}


def ramp(low: float, high: float, time: float) -> dict[str, Any]:
    """Return the changes for a run that ramps from ``low`` to ``high`` [rpm] in ``time`` [s], and no longer."""
    drive = {"kind": "speed", "speed": high * RPM, "start_speed": low * RPM, "ramp": time}
    return {**MOVING, "rotors.pinion.drive": drive, "run.duration": time}


@pytest.mark.parametrize("name", ["han2021", "pinion-idler-ring"])
def test_two_carried_runs_are_one(name: str, measured: Measured) -> None:
    """A ramp in one run against the same ramp in two halves, over 10 ms; angles and speeds in absolute terms."""
    base = gp.load_case(name)
    changes = [ramp(100.0, 200.0, 0.01), ramp(100.0, 150.0, 0.005), ramp(150.0, 200.0, 0.005)]
    if name != "han2021":
        changes = [{k: v for k, v in c.items() if "ring" not in k} for c in changes]
    whole, first, second = (gp.replace(base, c) for c in changes)
    expected = run_one(whole)
    half = run_one(first)
    found = run_one(second, origin=half.end)
    assert expected.success
    assert found.success
    assert expected.counters.events > 4
    worst = float(np.max(np.abs(found.end.state - expected.end.state)[: 3 * len(base.rotors)]))
    assert worst < 1e-9
    measured("two continued runs against one over 10 ms [m, rad]", worst, "1e-9")


def test_the_start_of_a_ramp_rolls() -> None:
    case = gp.replace(gp.load_case("han2021"), ramp(60.0, 120.0, 0.1))
    speeds = dict(zip(case.rotors, starting_speeds(case, nominal_speeds(case)), strict=True))
    assert speeds["pinion"] == pytest.approx(60.0 * RPM)
    assert speeds["ring"] == pytest.approx(20.0 * RPM)
    run = run_one(gp.replace(case, {"run.duration": 0.2, "run.sampling": 1e3}), signals=["pinion.omega"])
    expected = (60.0 + 60.0 * np.minimum(run.time / 0.1, 1.0)) * RPM
    assert np.allclose(run.signal("omega", "pinion"), expected, rtol=1e-10)


def test_a_servo_follows_its_ramp() -> None:
    """A stiff servo without a load lags its target by acceleration x inertia / gain."""
    servo = {
        "kind": "servo", "speed": 20.0, "start_speed": 10.0, "ramp": 1.0,
        "proportional_gain": 5.0, "integral_gain": 0.0, "torque_limit": 100.0,
    }  # fmt: skip
    document = {
        "rotors": {"shaft": {"mass": 1.0, "inertia": 0.1, "drive": servo}},
        "run": {"duration": 0.9, "sampling": 100.0, "tolerance": 1e-10},
    }
    run = run_one(gp.load_case(document), signals=["shaft.omega"])
    late = run.time > 0.5
    lag = (10.0 + 10.0 * run.time - run.signal("omega", "shaft"))[late]
    assert np.allclose(lag, 10.0 * 0.1 / 5.0, rtol=1e-6)


def test_a_start_speed_without_a_ramp_is_refused() -> None:
    with pytest.raises(gp.InputError, match=r"start_speed = .*must be 0 for a drive without a ramp"):
        gp.replace(gp.load_case("han2021"), {"rotors.pinion.drive.start_speed": 1.0})
