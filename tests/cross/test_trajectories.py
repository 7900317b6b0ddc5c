"""The compiled kernels against an independent reference: plain Python, SciPy's DOP853, every event located."""

import numpy as np
import pytest

from building import Measured
from cross.random_systems import random_case
from cross.reference import Reference
from cross.staged_systems import staged_case
from gearplay.model.case import Case
from gearplay.model.geometry import centres
from gearplay.solver.simulate import run_members
from gearplay.solver.trajectory import Trajectory

DURATION = 0.01  # s: beyond some 20 ms the motion is chaotic and trajectories may not be compared
RUN = {"duration": DURATION, "sampling": 1e4, "tolerance": 1e-11}


def simulated(document: dict) -> tuple[Case, Trajectory]:
    """Simulate with the package; angles that the reference takes as 0 are said to be 0."""
    document = {**document, "run": RUN, "rotors": {k: dict(v) for k, v in document["rotors"].items()}}
    for rotor in document["rotors"].values():
        if rotor.get("drive", {}).get("kind") != "speed":
            rotor["initial"] = {"theta": 0.0, **rotor.get("initial", {})}
    case = Case.model_validate(document)
    return case, run_members(case, [0])[0]


def ridden(document: dict) -> dict:
    """Return the document as the reference takes it: displacements and velocities of carried rotors in fixed axes."""
    rotors = {
        name: {**rotor, "initial": dict(rotor.get("initial", {}))}
        for name, rotor in document["rotors"].items()
    }
    places = centres(Case.model_validate({**document, "run": RUN}))
    for name, sleeve in document["sleeves"].items():
        if sleeve.get("on") is None:
            continue
        start, carrier = rotors[name]["initial"], rotors[sleeve["on"]]
        arm = [places[name][k] - places[sleeve["on"]][k] for k in range(2)]
        own = carrier["initial"]
        assert own.get("theta", 0.0) == 0.0
        spin = own.get("omega", 0.0)
        for key, more in (
            ("x", own.get("x", 0.0)),
            ("y", own.get("y", 0.0)),
            ("vx", own.get("vx", 0.0) - spin * arm[1]),
            ("vy", own.get("vy", 0.0) + spin * arm[0]),
        ):
            start[key] = start.get(key, 0.0) + more
    return {**document, "rotors": rotors}


def worst_difference(document: dict) -> float:
    """Return the largest difference [m] from the reference; fail where a place or a speed differs by too much."""
    case, run = simulated(document)
    assert run.success, run.message
    expected = Reference(ridden(document)).trajectory(run.time)
    assert run.counters.events >= 8, "the comparison must go through contacts"
    worst = 0.0
    for i, name in enumerate(case.rotors):
        arm = 0.1  # m, larger than any toothing here: turns angles into lengths
        for signal, size in (("x", 1.0), ("y", 1.0), ("theta", arm)):
            error = size * np.max(np.abs(run.signal(signal, name) - expected[signal][:, i]))
            assert error < 1e-9, (name, signal, error)
            worst = max(worst, float(error))
        for signal, size in (("vx", 1.0), ("vy", 1.0), ("omega", arm)):
            error = size * np.max(np.abs(run.signal(signal, name) - expected[signal][:, i]))
            assert error < 1e-6, (name, signal, error)
    return worst


# 43 and 58: a damped flank lets go and takes hold again within one step, just before it opens.
@pytest.mark.parametrize("seed", [*range(20), 43, 58])
def test_trajectory_equals_the_independent_reference(seed: int, measured: Measured) -> None:
    worst = worst_difference(random_case(seed))
    measured("largest difference over 10 ms from an independent SciPy simulator [m]", worst, "1e-9")


@pytest.mark.parametrize("seed", range(12))
def test_trains_of_stages_equal_the_independent_reference(seed: int, measured: Measured) -> None:
    """Shafts with several gears, runouts of each, meshes at angles."""
    worst = worst_difference(staged_case(seed))
    measured("largest difference over 10 ms of a train of stages from SciPy's [m]", worst, "1e-9")


RIPPLE = [
    {"order": 1, "amplitude": 0.05, "phase": 0.4},
    {"order": 9, "amplitude": 0.03, "phase": 2.0},
    {"order": 40, "amplitude": 0.02, "phase": -1.0},
]  # in 10 ms the highest order has one to three periods


@pytest.mark.parametrize("seed", [0, 1, 2, 3, 5, 6, 9, 11, 13, 16, 17, 18])
def test_a_rippling_drive_equals_the_independent_reference(seed: int, measured: Measured) -> None:
    document = random_case(seed)
    drives = [r["drive"] for r in document["rotors"].values() if "drive" in r]
    assert [d["kind"] for d in drives] == ["speed"]
    drives[0]["ripple"] = RIPPLE
    worst = worst_difference(document)
    measured("largest difference over 10 ms of a rippling drive from SciPy's [m]", worst, "1e-9")


@pytest.mark.parametrize("seed", [0, 2, 5, 11])
def test_forces_equal_the_independent_reference(seed: int) -> None:
    document = random_case(seed)
    case, run = simulated(document)
    reference = Reference(document)
    expected = reference.trajectory(run.time)
    for at in range(0, len(run.time), 7):
        forces = reference.forces(float(run.time[at]), expected["state"][at], expected["impact_speed"][at])
        for mesh in case.meshes:
            label = f"{mesh.driver}-{mesh.driven}"
            found = forces["mesh"][label]
            for signal, key in (
                ("drive_penetration", "p_d"),
                ("back_penetration", "p_b"),
                ("backlash", "b_t"),
                ("center_distance", "A"),
            ):
                assert abs(run.signal(signal, label)[at] - found[key]) < 1e-11
            for signal, key in (("drive_force", "F_d"), ("back_force", "F_b")):
                assert run.signal(signal, label)[at] == pytest.approx(found[key], rel=1e-5, abs=1e-3)
