"""Speeds and torques of a load case: drives, loads, the nominal speed of every body."""

from dataclasses import dataclass, field
from typing import Final

import numpy as np
import numpy.typing as npt

from gearplay.rexs.bodies import GROUND, Bodies
from gearplay.rexs.notes import Notes
from gearplay.rexs.placement import Plane
from gearplay.rexs.records import POWER, Component, Gearbox
from gearplay.rexs.sets import PlanetSet
from gearplay.rexs.teeth import Pair
from gearplay.vocabulary import quantities as q

AGREES: Final = 1e-3
"""Relative difference of speeds or torques below which they agree."""
Array = npt.NDArray[np.float64]
Row = dict[int, float]


@dataclass
class Motion:
    """Nominal speeds [rad/s], counter-clockwise positive, and torques [N m] on bodies, by the component that represents each."""

    speeds: dict[int, float] = field(default_factory=dict)
    drives: dict[int, float] = field(default_factory=dict)
    """Bodies that drive beside the first, with their torques."""
    loads: dict[int, float] = field(default_factory=dict)
    driver: int | None = None


def motion_of(
    box: Gearbox, bodies: Bodies, plane: Plane, sets: list[PlanetSet], pairs: list[Pair], notes: Notes
) -> Motion:
    """Return speeds and torques: given ones, and those that follow from the teeth and from the balance of power."""
    rows = _constraints(bodies, sets, pairs)
    order = sorted({root for row in rows for root in row})
    place = {root: k for k, root in enumerate(order)}
    matrix = np.array([[row.get(root, 0.0) for root in order] for row in rows]).reshape(len(rows), len(order))
    free = _null_space(matrix)
    motion = Motion()
    given = _speeds(box, bodies, plane, place)
    if not given:
        notes.assume("no speed in the file: no drive is written; add drive to the rotor that drives")
        return motion
    chosen = np.array([free[place[root]] for root in given]).reshape(len(given), -1)
    wanted = np.array(list(given.values()))
    factors, _, rank, _ = np.linalg.lstsq(chosen, wanted, rcond=1e-9)
    speeds = free @ factors
    if np.abs(chosen @ factors - wanted).max() > AGREES * np.abs(wanted).max():
        notes.assume(
            "speeds of the file contradict its numbers of teeth: the nearest ones that agree are taken"
        )
    if rank < free.shape[1]:
        loose = [root for root, k in place.items() if np.abs(free[k]).max() > 1e-9 and root not in given]
        names = ", ".join(str(box.components[root]) for root in loose[:4])
        notes.assume(
            f"the speeds of the file leave bodies free ({names}): they turn as little as possible at the start"
        )
    motion.speeds = {root: float(speeds[k]) + 0.0 for root, k in place.items()}
    torques, open_ends = _torques(box, bodies, plane, motion.speeds, notes)
    _balance(box, free, place, torques, open_ends, notes)
    _share_out(motion, torques, given, notes)
    return motion


def _constraints(bodies: Bodies, sets: list[PlanetSet], pairs: list[Pair]) -> list[Row]:
    """Return the conditions on the speeds of the bodies, whose sum of factor times speed is 0."""
    rows: list[Row] = [{root: 1.0} for root in bodies.fixed]
    for pair in pairs:
        first, second = (bodies.find(each.component.id) for each in (pair.first, pair.second))
        sign = -1.0 if pair.first.internal or pair.second.internal else 1.0
        rows.append(_row((first, float(pair.first.teeth)), (second, sign * pair.second.teeth)))
    for found in sets:
        assert found.sun is not None
        assert found.ring is not None
        sun, ring, carrier = (bodies.find(found.members[each]) for each in ("sun", "ring", "carrier"))
        z_s, z_r = float(found.sun.teeth), float(found.ring.teeth)
        rows.append(_row((sun, z_s), (ring, z_r), (carrier, -z_s - z_r)))
        for planet in found.planets:
            own = bodies.find(planet.component.id)
            rows.append(_row((sun, z_s), (carrier, -z_s - planet.teeth), (own, float(planet.teeth))))
    rows += [_row((bodies.find(link.inner), 1.0), (bodies.find(link.outer), -1.0)) for link in bodies.links]
    return [{root: factor for root, factor in row.items() if root != GROUND} for row in rows]


def _row(*terms: tuple[int, float]) -> Row:
    row: Row = {}
    for root, factor in terms:
        row[root] = row.get(root, 0.0) + factor
    return row


def _null_space(matrix: Array) -> Array:
    """Return the motions that the conditions leave, as columns."""
    if not matrix.size:
        return np.eye(matrix.shape[1])
    scale = np.abs(matrix).max(axis=1, keepdims=True)
    _, values, basis = np.linalg.svd(matrix / np.where(scale > 0.0, scale, 1.0))
    rank = int((values > 1e-9 * values[0]).sum()) if values.size else 0
    return np.asarray(basis[rank:].T)


def _speeds(box: Gearbox, bodies: Bodies, plane: Plane, place: dict[int, int]) -> dict[int, float]:
    """Return given speeds of bodies [rad/s]: of shafts that define one, else of all that have one."""
    found: dict[bool, dict[int, float]] = {True: {}, False: {}}
    for shaft in box.of_type("shaft"):
        speed, root = box.number(shaft, q.ANGULAR_SPEED, "rotational_speed"), bodies.find(shaft.id)
        if speed is not None and root in place:
            defines = box.flag(shaft, "defines_speed") is True
            found[defines].setdefault(root, speed * plane.sense(shaft.id))
    return found[True] or found[False]


def _torques(
    box: Gearbox, bodies: Bodies, plane: Plane, speeds: dict[int, float], notes: Notes
) -> tuple[dict[int, float], list[int]]:
    """Return given torques on bodies [N m], and bodies on which one acts that is not given."""
    torques: dict[int, float] = {}
    open_ends: list[int] = []
    for load in box.of_type("external_load"):
        shafts = box.assemblies(load.id)
        roots = [bodies.find(shaft.id) for shaft in shafts if shaft.id in bodies.root]
        _note_forces(box, load, notes)
        if not roots or box.flag(load, "transmits_torque") is False or roots[0] not in speeds:
            continue
        root, sense = roots[0], plane.sense(shafts[0].id)
        torque = box.number(load, q.TORQUE, "torque_around_u_axis", "torque_u")
        power = box.number(load, POWER, "power")
        box.flag(load, "defines_torque")  # says which of several is given; a torque that is there is
        if torque is None and power is not None and speeds[root] != 0.0:
            torque = power / speeds[root] * sense
        if torque is None:
            open_ends.append(root)
        else:
            torques[root] = torques.get(root, 0.0) + torque * sense
    return torques, [root for root in open_ends if root not in torques]


def _note_forces(box: Gearbox, load: Component, notes: Notes) -> None:
    forces = [box.number(load, q.FORCE, f"force_{axis}_direction") for axis in "uvw"]
    tilts = [box.number(load, q.TORQUE, f"torque_around_{axis}_axis") for axis in "vw"]
    acting = [f"{force:.6g} N along {axis}" for axis, force in zip("uvw", forces, strict=True) if force]
    acting += [f"{tilt:.6g} N m about {axis}" for axis, tilt in zip("vw", tilts, strict=True) if tilt]
    if acting:
        notes.leave_out(
            f"{load}: {', '.join(acting)}: a case has no constant force on a rotor; its bearings are less preloaded"
        )


def _balance(
    box: Gearbox,
    free: Array,
    place: dict[int, int],
    torques: dict[int, float],
    open_ends: list[int],
    notes: Notes,
) -> None:
    """Find the torques that are not given from the balance of power in every free motion."""
    known = sum((torque * free[place[root]] for root, torque in torques.items()), np.zeros(free.shape[1]))
    size = float(np.abs(known).max(initial=0.0))
    if open_ends and size > 0.0:
        turning = [
            root for root in dict.fromkeys(open_ends) if np.abs(free[place[root]]).max(initial=0.0) > 1e-12
        ]
        if turning:
            columns = np.array([free[place[root]] for root in turning]).T
            found = np.linalg.lstsq(columns, -known, rcond=1e-9)[0]
            torques.update({root: float(each) for root, each in zip(turning, found, strict=True)})
            known = known + columns @ found
            if len(turning) > free.shape[1]:
                names = ", ".join(str(box.components[root]) for root in turning)
                notes.assume(f"torques on {names} are not in the file: shared out so that power is balanced")
    if torques and np.abs(known).max(initial=0.0) > AGREES * size:
        notes.assume("the loads of the file are not in balance: the drive makes up for the difference")


def _share_out(motion: Motion, torques: dict[int, float], given: dict[int, float], notes: Notes) -> None:
    """Make the body of the largest power the driver, at its speed; bodies that absorb power have loads."""
    power = {root: torque * motion.speeds[root] for root, torque in torques.items()}
    first = next(iter(given))
    if len(power) > 1 and first in power and min(power.values()) > 0.0:
        notes.assume(
            "every torque of the file drives: those beside the one on the shaft that defines the speed are loads"
        )
        power = {root: each if root == first else -each for root, each in power.items()}
    motion.driver = max(power, key=lambda root: power[root]) if power and max(power.values()) > 0.0 else first
    for root, torque in torques.items():
        if root == motion.driver:
            continue
        if power[root] > 0.0:
            motion.drives[root] = torque
        elif power[root] < 0.0:
            motion.loads[root] = abs(torque)
    if not motion.loads:
        notes.assume(
            "no torque takes power in this load case: the gearbox runs without load, and its teeth may rattle"
        )
