"""Runs of the package beside those of the independent reference."""

import numpy as np

from cross.reference import Reference
from cross.riding import ridden
from gearplay.model.case import Case
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


def worst_difference(document: dict, *, events: int = 8) -> float:
    """Return the largest difference [m] from the reference; fail where a place or a speed differs too much.

    The run must go through so many events at least.
    """
    case, run = simulated(document)
    assert run.success, run.message
    expected = Reference(ridden(document)).trajectory(run.time)
    assert run.counters.events >= events, "the comparison must go through contacts"
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
