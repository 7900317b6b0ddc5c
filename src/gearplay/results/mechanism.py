"""Geometry and motion of the mechanism for drawings: gears, sleeves and meshes, frame by frame."""

import math
from collections.abc import Callable
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from gearplay.model.case import Case
from gearplay.model.pack import pack
from gearplay.parts.mesh.train.geometry import (
    carrier_of,
    centres,
    full_name,
    gears_of,
    gears_of_pair,
    installed_backlash,
    jam_ratio,
    pair_of,
    toothings,
)
from gearplay.parts.mesh.train.rolling import mesh_frequency, nominal_speeds, rolling_ratios, senses
from gearplay.parts.protocol import Holder
from gearplay.parts.registry import KINDS
from gearplay.pictures.planes import apart
from gearplay.solver.frames import CarrierFrames, turned
from gearplay.toothing.gear import ADDENDUM, DEDENDUM, DrawnGear

Floats = NDArray[np.float64]
FRAMES = 900
WITHOUT_MESH: Final = {
    "module": None,
    "pressure_angle": None,
    "addendum": ADDENDUM,
    "dedendum": DEDENDUM,
    "shift": 0.0,
}
"""Teeth of a gear that meshes with nothing, which are not drawn."""


def mechanism_of(case: Case) -> dict[str, Any]:
    """Return the data for a drawing of the mechanism: gears with teeth and rotors, sleeves, meshes and joints.

    Gears are placed as drawn: stages that lie one behind the other are placed side by side.
    """
    return apart(placed(case))


def placed(case: Case) -> dict[str, Any]:
    """Return the mechanism for the drawing, gears at their actual positions, one stage behind the other."""
    case = case.operating
    places, turning = centres(case), senses(case, nominal_speeds(case))
    first: dict[str, Any] = {}
    for j in range(len(case.meshes)):
        for called, drawn in zip(gears_of_pair(case, j), gears_of(case, j), strict=True):
            first.setdefault(full_name(case, called), _outline_of(drawn))
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
            **first.get(name, WITHOUT_MESH),
        }
        for i, rotor in enumerate(case.rotors)
        for name, gear in toothings(case, rotor).items()
    ]
    return {
        "gears": gears,
        "sleeves": [
            {"name": name, "kind": kind, "clearance": part.clearance() or 0.0, "on": part.on}
            for kind, name, part in _bushes(case)
        ],
        "supports": [
            {"name": name, "stiffness": list(support.axial_stiffness), "on": support.on}
            for name, support in case.supports.items()
        ],
        "carried": [
            {"rotor": name, "on": on} for name in case.rotors if (on := carrier_of(case, name)) is not None
        ],
        "couplings": [
            {"name": name, "between": list(joint.named_rotors().values())}
            for _, name, joint in case.named_joints()
        ],
        "meshes": [
            {
                "name": mesh.label,
                "driver": full_name(case, mesh.driver),
                "driven": full_name(case, mesh.driven),
                "backlash": installed_backlash(case, j),
                "pressure_angle": pair_of(case, j).working_angle,
                "frequency": mesh_frequency(case, j),
                "jam_ratio": jam_ratio(case, j),
            }
            for j, mesh in enumerate(case.meshes)
        ],
    }


def _outline_of(gear: DrawnGear) -> dict[str, float]:
    """Return the transverse outline data of a gear's teeth; ``shift`` is the half angle added by the profile shift [rad]."""
    module, sign = gear.transverse_module, gear.sign
    return {
        "module": module,
        "pressure_angle": gear.transverse_angle,
        "addendum": sign * (gear.tip - gear.reference_radius) / module,
        "dedendum": sign * (gear.reference_radius - gear.root) / module,
        "shift": 2.0 * gear.profile_shift * math.tan(gear.pressure_angle) / gear.teeth,
    }


def _bushes(case: Case) -> list[tuple[str, str, Holder]]:
    """Return the parts that hold a rotor with clearance, plain and rolling bearings, with their kinds and their rotors."""
    return [
        (KINDS[part.kind].name, name, part) for _, name, part in case.every_holder() if part.has_clearance
    ]


def frames_of(
    case: Case,
    frames: CarrierFrames,
    time: Floats,
    signal: Callable[[str, str], Floats],
    *,
    start: float = 0.0,
    most: int = FRAMES,
) -> dict[str, Any]:
    """Return the motion for the drawing: positions and rotations of all rotors, forces of all contacts; ``most`` instants.

    ``frames`` are those of the case. ``time`` [s] is that of the samples, counted from ``start``; ``signal`` returns a signal of
    an element: ``x`` of a rotor.

    A planetary set is in the frame of its carrier, which has actually turned by ``orbit`` [rad], shape [rotor, frame]; 0 for all
    others. ``turns`` are the rotations by rolling with the leading rotor, less the carrier's, within a turn; those in ``rotors``
    are relative to them: 32 bits would not resolve a backlash after some turns. ``bushes`` are the displacements of the sleeves'
    bushes from the nominal centres [m], shape [sleeve, 2, frame]. Forces are the largest since the frame before, so that a short
    impact is seen.
    """
    at = np.unique(np.linspace(0, max(0, len(time) - 1), min(most, len(time))).astype(np.int64))
    lead, ratios = rolling_ratios(case)
    names = list(case.rotors)
    led, leads = (frames.leads >= 0)[:, None], frames.leads
    angles = np.array([signal("theta", name)[at] for name in names])
    rolled = ratios[:, None] * signal("theta", lead)[at]
    turns = np.where(ratios[:, None] == 0.0, angles, rolled)
    orbit, carried = np.where(led, angles[leads], 0.0), np.where(led, turns[leads], 0.0)
    arms = frames.places[:, :, None]
    moved = np.array([[signal(axis, name)[at] for axis in "xy"] for name in names])
    places = np.stack([turned(each, -angle) for each, angle in zip(moved + arms, orbit, strict=True)]) - arms
    parts = _bushes(case)
    held = [names.index(name) for _, name, _ in parts]
    bushes = [_bush(frames, i, places, orbit) for i in held]
    sleeves = [
        turned(np.array(_strongest([signal(f"{kind}_force_{axis}", name) for axis in "xy"], at)), -orbit[i])
        for (kind, name, _), i in zip(parts, held, strict=True)
    ]
    meshes = [
        [_peaks(signal(f"{flank}_force", mesh.label), at) for flank in ("drive", "back")]
        for mesh in case.meshes
    ]
    return {
        "t": time[at],
        "orbit": np.mod(orbit, 2.0 * math.pi),
        "turns": np.mod(turns - carried, 2.0 * math.pi),
        "rotors": np.concatenate([places, (angles - turns - orbit + carried)[:, None]], axis=1),
        "bushes": np.array(bushes).reshape(len(held), 2, at.size),
        "sleeves": np.array(sleeves).reshape(len(held), 2, at.size),
        "meshes": np.array(meshes).reshape(len(case.meshes), 2, at.size),
    }


def _bush(frames: CarrierFrames, i: int, places: Floats, orbit: Floats) -> Floats:
    """Return the displacement of rotor i's bush [m] in the frame of ``orbit`` [rad], shape [2, frame]."""
    hub, seat = frames.hubs[i], np.broadcast_to(frames.seats[i][:, None], places[i].shape)
    return places[hub] + seat if hub >= 0 else turned(seat, -orbit[i])


def _peaks(values: Floats, at: NDArray[np.int64]) -> Floats:
    """Return the largest value between each frame and the one before."""
    return np.maximum.reduceat(values[: at[-1] + 1], np.r_[0, at[:-1] + 1]) if at.size else values[:0]


def _strongest(parts: list[Floats], at: NDArray[np.int64]) -> list[Floats]:
    """Return a force, by its components, where it is largest between each frame and the one before.

    >>> x, y = _strongest([np.array([1.0, 0.0, 3.0, 0.0]), np.array([0.0, 2.0, 0.0, 0.0])], np.array([1, 3]))
    >>> x.tolist(), y.tolist()
    ([0.0, 3.0], [2.0, 0.0])
    """
    if not at.size:
        return [part[:0] for part in parts]
    size = np.nan_to_num(np.sum(np.square(parts), axis=0), nan=np.inf)
    largest = np.repeat(_peaks(size, at), np.diff(at, prepend=-1))
    places = np.flatnonzero(size[: at[-1] + 1] == largest)
    where = places[np.searchsorted(places, np.r_[0, at[:-1] + 1])]
    return [part[where] for part in parts]


def motion_of(
    case: Case, rotor: str, time: Floats, signal: Callable[[str, str], Floats]
) -> dict[str, Floats]:
    """Return ``x``, ``y`` [m], ``vx``, ``vy`` [m/s] of a rotor's centre, shape [time].

    A carried rotor is relative to its pin, in axes that turn with the actual carrier; another rotor of a planetary set in axes
    that turn with the carrier's nominal speed. ``time`` [s] counts from the start of the run; ``signal`` returns a signal of an
    element at these times.
    """
    frames, names = CarrierFrames(pack(case).system), list(case.rotors)
    at = names.index(rotor)
    place, velocity = (np.array([signal(f"{kind}{axis}", rotor) for axis in "xy"]) for kind in ("", "v"))
    if frames.hubs[at] >= 0:
        hub = names[frames.hubs[at]]
        moved, rate = (np.array([signal(f"{kind}{axis}", hub) for axis in "xy"]) for kind in ("", "v"))
        angle, speed = signal("theta", hub), signal("omega", hub)
        relative = frames.beside_seat(at, place, moved, angle)
        found = relative, frames.rate_beside_seat(at, relative, velocity, rate, angle, speed)
    else:
        angle, speed = frames.speeds[at] * time, frames.speeds[at]
        place = turned(place, -angle)
        found = place, turned(velocity, -angle) - speed * np.stack([-place[1], place[0]])
    return dict(zip(("x", "y", "vx", "vy"), np.concatenate(found), strict=True))


def orbit_of(
    case: Case, frames: CarrierFrames, rotor: str, signal: Callable[[str, str], Floats]
) -> tuple[Floats, Floats]:
    """Return the path x, y [m] of a rotor's centre, shape [time].

    In a sleeve it counts from the centre of the bush; a carried rotor's from its pin, in axes that turn with the actual
    carrier. ``frames`` are those of the case; ``signal`` returns a signal of an element.
    """
    names = list(case.rotors)
    at = names.index(rotor)
    place = np.array([signal(axis, rotor) for axis in "xy"])
    if frames.hubs[at] < 0:
        seat = frames.seats[at] if any(rotor == name for _, name, _ in _bushes(case)) else np.zeros(2)
        return place[0] - seat[0], place[1] - seat[1]
    hub = names[frames.hubs[at]]
    moved = np.array([signal(axis, hub) for axis in "xy"])
    x, y = frames.beside_seat(at, place, moved, signal("theta", hub))
    return x, y
