"""What drawings of the mechanism need, whatever draws them: its gears, sleeves and meshes, and its motion frame by frame."""

import math
from collections.abc import Callable
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gearplay.model.case import Case
from gearplay.model.geometry import (
    ADDENDUM,
    DEDENDUM,
    carrier_of,
    centres,
    full_name,
    installed_backlash,
    jam_ratio,
    toothings,
)
from gearplay.model.pack import pack
from gearplay.model.rolling import mesh_frequency, nominal_speeds, rolling_ratios, senses
from gearplay.pictures.planes import apart
from gearplay.solver.frames import CarrierFrames

Floats = NDArray[np.float64]
FRAMES = 900


def mechanism_of(case: Case) -> dict[str, Any]:
    """Return what the drawing of the mechanism needs: gears with teeth and rotors, sleeves, meshes, what joins them.

    Gears stand where they are drawn: stages that lie one behind the other beside each other.
    """
    case = case.operating
    places, turning = centres(case), senses(case, nominal_speeds(case))
    module: dict[str, float] = {}
    angle: dict[str, float] = {}
    for mesh in case.meshes:
        for called in (mesh.driver, mesh.driven):
            module.setdefault(full_name(case, called), mesh.module)
            angle.setdefault(full_name(case, called), mesh.pressure_angle)
    alone = next(iter(case.planetary), "") if len(case.planetary) == 1 else ""
    gears = [
        {
            "name": name,
            "shown": name.removeprefix(f"{alone}.") if alone else name,
            "rotor": rotor,
            "index": i,
            "x": float(places[rotor][0]),
            "y": float(places[rotor][1]),
            "sense": float(turning[i]),
            "teeth": gear.teeth,
            "internal": gear.internal,
            "module": module.get(name),
            "pressure_angle": angle.get(name),
            "addendum": ADDENDUM,
            "dedendum": DEDENDUM,
        }
        for i, rotor in enumerate(case.rotors)
        for name, gear in toothings(case, rotor).items()
    ]
    drawn = {
        "gears": gears,
        "sleeves": [
            {"name": name, "clearance": sleeve.radial_clearance, "on": sleeve.on}
            for name, sleeve in case.sleeves.items()
        ],
        "supports": [
            {"name": name, "stiffness": list(support.stiffness or (0.0, 0.0)), "on": support.on}
            for name, support in case.supports.items()
        ],
        "carried": [
            {"rotor": name, "on": on} for name in case.rotors if (on := carrier_of(case, name)) is not None
        ],
        "couplings": [{"name": each.label, "between": list(each.between)} for each in case.couplings],
        "meshes": [
            {
                "name": mesh.label,
                "driver": full_name(case, mesh.driver),
                "driven": full_name(case, mesh.driven),
                "backlash": installed_backlash(case, j),
                "pressure_angle": mesh.pressure_angle,
                "frequency": mesh_frequency(case, j),
                "jam_ratio": jam_ratio(case, j),
            }
            for j, mesh in enumerate(case.meshes)
        ],
    }
    return apart(drawn)


def frames_of(
    case: Case, time: Floats, signal: Callable[[str, str], Floats], *, start: float = 0.0, most: int = FRAMES
) -> dict[str, Any]:
    """Return the motion for the drawing: places and rotations of all rotors, forces of all contacts; ``most`` instants.

    ``time`` [s] is that of the samples, counted from ``start``; ``signal`` returns a signal of an element: ``x`` of a
    rotor.

    ``turns`` are the rotations by rolling with the leading rotor, within a turn; those in ``rotors`` are beside them: 32 bits
    would not resolve a backlash after some turns. Forces are the largest since the frame before, so that a short impact is seen.
    A planetary set is as its carrier sees it, which has turned by ``orbit``, shape [rotor, frame]; 0 for all others.
    """
    at = np.unique(np.linspace(0, len(time) - 1, min(most, len(time))).astype(np.int64))
    if len(time) == 0:
        at = np.zeros(0, dtype=np.int64)
    lead, ratios = rolling_ratios(case)
    frames, names = CarrierFrames(pack(case).system), list(case.rotors)
    orbit = frames.speeds[:, None] * (start + time[at])
    angles = np.array([signal("theta", name)[at] for name in names])
    rolled = ratios[:, None] * signal("theta", lead)[at]
    turns = np.where(ratios[:, None] == 0.0, angles, rolled)
    arms = frames.arms[:, :, None]
    places = np.array([[signal(axis, name)[at] for axis in "xy"] for name in names])
    places = _turned(places + arms, -orbit) - arms
    sleeves = [
        _strongest([signal(f"sleeve_force_{axis}", name) for axis in "xy"], at) for name in case.sleeves
    ]
    forces = np.array(sleeves).reshape(len(case.sleeves), 2, at.size)
    meshes = [
        [_peaks(signal(f"{flank}_force", mesh.label), at) for flank in ("drive", "back")]
        for mesh in case.meshes
    ]
    return {
        "t": time[at],
        "orbit": np.mod(orbit, 2.0 * math.pi),
        "turns": np.mod(turns - orbit, 2.0 * math.pi),
        "rotors": np.concatenate([places, (angles - turns)[:, None]], axis=1),
        "sleeves": _turned(forces, -orbit[[names.index(name) for name in case.sleeves]]),
        "meshes": np.array(meshes).reshape(len(case.meshes), 2, at.size),
    }


def _turned(vectors: Floats, angle: Floats) -> Floats:
    """Return vectors, shape [rotor, 2, frame], turned by angles [rad], shape [rotor, frame]."""
    c, s = np.cos(angle), np.sin(angle)
    return np.stack([c * vectors[:, 0] - s * vectors[:, 1], s * vectors[:, 0] + c * vectors[:, 1]], axis=1)


def _peaks(values: Floats, at: NDArray[np.int64]) -> Floats:
    """Return the largest value between each frame and the one before."""
    return np.maximum.reduceat(values, np.r_[0, at[:-1] + 1]) if at.size else values[:0]


def _strongest(parts: list[Floats], at: NDArray[np.int64]) -> list[Floats]:
    """Return a force, by its components, where it is largest between each frame and the one before."""
    size = np.sqrt(np.sum(np.square(parts), axis=0))
    where = [low + 1 + int(np.argmax(size[low + 1 : high + 1])) for low, high in pairwise([-1, *at.tolist()])]
    return [part[where] for part in parts]


def motion_of(
    case: Case, rotor: str, time: Floats, signal: Callable[[str, str], Floats]
) -> dict[str, Floats]:
    """Return ``x``, ``y`` [m], ``vx``, ``vy`` [m/s] of a rotor's centre, in a planetary set as the turning carrier sees it.

    ``time`` [s] counts from the start of the run; ``signal`` returns a signal of an element at these times.
    """
    frames, at = CarrierFrames(pack(case).system), list(case.rotors).index(rotor)
    arm, speed = frames.arms[at][None, :, None], float(frames.speeds[at])
    angle = -speed * time[None, :]
    place = _turned(np.array([[signal(axis, rotor) for axis in "xy"]]) + arm, angle)[0]
    velocity = _turned(np.array([[signal(f"v{axis}", rotor) for axis in "xy"]]), angle)[0]
    velocity = velocity - speed * np.array([-place[1], place[0]])
    x, y = place - arm[0]
    return {"x": x, "y": y, "vx": velocity[0], "vy": velocity[1]}


def orbit_of(
    case: Case, rotor: str, time: Floats, signal: Callable[[str, str], Floats]
) -> tuple[Floats, Floats]:
    """Return the path x, y [m] of a rotor's centre as `motion_of` does, of one on a carrier beside that carrier's centre."""
    path, on = motion_of(case, rotor, time, signal), carrier_of(case, rotor)
    if on is None:
        return path["x"], path["y"]
    hub = motion_of(case, on, time, signal)
    return path["x"] - hub["x"], path["y"] - hub["y"]
