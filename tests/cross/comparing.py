"""Runs of the package beside those of the independent reference."""

import math

import numpy as np

from cross.planetary_systems import expanded
from cross.reference import Reference
from cross.riding import ridden
from gearplay.model.case import Case
from gearplay.model.initial import initial_state
from gearplay.model.pack import pack
from gearplay.solver.simulate import run_members
from gearplay.solver.trajectory import Trajectory

DURATION = 0.01  # s: beyond some 20 ms the motion is chaotic and trajectories may not be compared
RUN = {"duration": DURATION, "sampling": 1e4, "tolerance": 1e-11}


def simulated(document: dict, duration: float = DURATION) -> tuple[Case, Trajectory]:
    """Simulate with the package; angles that the reference takes as 0 are said to be 0.

    Beside given speeds the others are said too: the reference takes them as nominal, the package as matching.
    """
    speeds = _nominal_starts(document)
    run = {**RUN, "duration": duration}
    document = {**document, "run": run, "rotors": {k: dict(v) for k, v in document["rotors"].items()}}
    for name, rotor in document["rotors"].items():
        if rotor.get("drive", {}).get("kind") != "speed":
            rotor["initial"] = {"theta": 0.0, **speeds.get(name, {}), **rotor.get("initial", {})}
    case = Case.model_validate(document)
    return case, run_members(case, [0])[0]


def _nominal_starts(document: dict) -> dict[str, dict[str, float]]:
    """Return the speeds at which the reference starts the rotors of a document that gives some of them."""
    if not any("omega" in rotor.get("initial", {}) for rotor in document["rotors"].values()):
        return {}
    reference = Reference(ridden(document))
    relative = reference.initial_state()[3 * reference.n : 6 * reference.n].reshape(-1, 3)[:, 2]
    return {
        rotor.name: {"omega": float(rotor.nominal_speed + speed)}
        for rotor, speed in zip(reference.rotors, relative, strict=True)
    }


def worst_difference(document: dict, *, events: int = 8, duration: float = DURATION) -> float:
    """Return the largest difference [m] from the reference; fail where a place or a speed differs too much.

    The run must go through so many events at least.
    """
    case, run = simulated(document, duration)
    arm = 0.1  # m, larger than any toothing here: turns angles into lengths
    return _worst(run, Reference(ridden(document)), {name: (name, arm) for name in case.rotors}, events)


def worst_difference_of_sets(document: dict, *, duration: float, events: int) -> float:
    """Return the same of a document with planetary sets, which the reference takes at length.

    Both begin where the package lets the sets begin; angles count at base circles, of a carrier at its pins.
    """
    case = Case.model_validate({**document, "run": {**RUN, "duration": duration}})
    run = run_members(case, [0])[0]
    arms = {}
    for name, table in document["planetary"].items():
        half, base = 0.5 * table["module"], 0.5 * table["module"] * math.cos(table["pressure_angle"])
        arms[f"{name}.carrier"] = half * (table["sun"]["teeth"] + table["planets"]["teeth"])
        arms |= {f"{name}.{member}": base * table[member]["teeth"] for member in ("sun", "ring")}
        for k in range(1, table["planets"]["count"] + 1):
            arms[f"{name}.planet{k}"] = base * table["planets"]["teeth"]
    assert set(arms) == set(case.rotors)
    rotors = {name: (name.replace(".", "/"), arm) for name, arm in arms.items()}
    return _worst(run, Reference(begun(document)), rotors, events)


def begun(document: dict) -> dict:
    """Return what a document with planetary sets stands for, begun where the package lets it begin."""
    plain = expanded(document)
    for name, start in _starts(Case.model_validate({**document, "run": RUN})).items():
        plain["rotors"][name.replace(".", "/")]["initial"] = start
    return plain


def _starts(case: Case) -> dict[str, dict[str, float]]:
    """Return where and how fast every rotor begins, in fixed axes, its full speed."""
    packed = pack(case)
    places, speeds = initial_state(case, packed)[: 6 * len(case.rotors)].reshape(2, -1, 3)
    nominal = packed.system.rotors["nominal_speed"]
    found = {}
    for name, place, speed, turning in zip(case.rotors, places, speeds, nominal, strict=True):
        numbers = (*place, speed[0], speed[1], speed[2] + turning)
        found[name] = dict(zip(("x", "y", "theta", "vx", "vy", "omega"), map(float, numbers), strict=True))
    return found


def _worst(run: Trajectory, reference: Reference, rotors: dict[str, tuple[str, float]], events: int) -> float:
    """Compare all rotors of a run with the reference's, called as said; arms [m] turn angles into lengths."""
    assert run.success, run.message
    expected = reference.trajectory(run.time)
    assert run.counters.events >= events, "the comparison must go through contacts"
    worst = 0.0
    for name, (called, arm) in rotors.items():
        i = reference.index[called]
        for signal, size in (("x", 1.0), ("y", 1.0), ("theta", arm)):
            error = size * np.max(np.abs(run.signal(signal, name) - expected[signal][:, i]))
            assert error < 1e-9, (name, signal, error)
            worst = max(worst, float(error))
        for signal, size in (("vx", 1.0), ("vy", 1.0), ("omega", arm)):
            error = size * np.max(np.abs(run.signal(signal, name) - expected[signal][:, i]))
            assert error < 1e-6, (name, signal, error)
    return worst
