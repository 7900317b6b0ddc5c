"""Rolling kinematics of a train: nominal and initial speeds, senses of rotation, ratios, mesh frequency."""

import math
from collections.abc import Container
from contextlib import suppress
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from gearplay.parts.mesh.train.geometry import carrier_of, mesh_frame, rotor_of, signed_radii, teeth_of
from gearplay.parts.mesh.train.linear_conditions import Row, matrix_of, picked, solved_by_rank, vanishing
from gearplay.parts.mesh.train.traversal import rotor_order
from gearplay.vocabulary.errors import NO_VALUE, InputError

if TYPE_CHECKING:
    from gearplay.parts.mesh.train.train import Train


def conditions(case: "Train", places: dict[str, int], *, held: bool) -> tuple[Row, ...]:
    """Return the sums of speeds that vanish where every mesh and joint rolls, their largest factor near 1; with ``held`` also
    those of rotors that torsional springs hold.
    """
    rows: list[Row] = []
    for j in range(len(case.meshes)):
        a, b, r_a, r_b = signed_radii(case, j)
        frame, size = mesh_frame(case, j), max(abs(r_a), abs(r_b))
        row: Row = ((places[rotor_of(case, a)], r_a / size), (places[rotor_of(case, b)], r_b / size))
        rows.append(row if frame is None else (*row, (places[frame], -(r_a + r_b) / size)))
    for joint in case.joints:
        if factors := joint.rolling():
            size = max(map(abs, factors.values()))
            rows.append(tuple([(places[name], factor / size) for name, factor in factors.items()]))
    return (*rows, *holds(case, places)) if held else tuple(rows)


def holds(case: "Train", places: dict[str, int], *, without: Container[str] = ()) -> tuple[Row, ...]:
    """Return the sums of speeds that vanish where torsional springs hold rotors, to the ground or to their carrier."""
    rows: list[Row] = []
    for _, name, part in case.every_holder():
        if part.holds_rotation() and name not in without:
            row: Row = ((places[name], 1.0),)
            rows.append(row if part.on is None else (*row, (places[part.on], -1.0)))
    return tuple(rows)


@lru_cache(maxsize=1024)
def _least(
    count: int, conditions: tuple[Row, ...], given: Row, still: tuple[int, ...]
) -> tuple[float, ...] | None:
    """Return the least speeds of ``count`` rotors under conditions, some given, those ``still`` at 0 if they can; None for none.

    Kept, since the cases of a sweep mostly roll alike.
    """
    size = max(1.0, max((abs(speed) for _, speed in given), default=0.0))
    rows = [*conditions, *(((place, 1.0),) for place, _ in given)]
    for extra in (still, ()):
        lines = [*rows, *(((place, 1.0),) for place in extra)]
        if not lines:
            return (0.0,) * count
        matrix, target = matrix_of(lines, count), np.zeros(len(lines))
        target[len(conditions) : len(rows)] = [speed for _, speed in given]
        speeds = np.linalg.lstsq(matrix, target, rcond=None)[0]
        if float(np.max(np.abs(matrix @ speeds - target))) <= 1e-9 * size:
            speeds[np.abs(speeds) < 1e-12 * size] = 0.0
            return tuple(speeds.tolist())
    return None


def _roll(case: "Train", given: dict[str, float], *, held: bool = False) -> NDArray[np.float64]:
    """Return the least speeds [rad/s] that roll at every mesh and take the given values.

    With ``held`` torsional springs hold the speeds of their rotors at 0, or at their carrier's. A carrier that neither meshes nor
    drives force to turn (a differential's free arm) stands still.
    """
    places = {name: i for i, name in enumerate(case.rotors)}
    carriers = {carrier_of(case, name) for name in case.rotors} - {None, *given}
    speeds = _least(
        len(places),
        conditions(case, places, held=held),
        tuple([(places[name], speed) for name, speed in given.items()]),
        tuple(sorted(places[name] for name in carriers if name is not None)),
    )
    if speeds is not None:
        return np.array(speeds)
    named = ", ".join(case.field_path(n, "drive") for n in given)
    if _is_locked(case, places, next(iter(given)), held=held):
        if not _is_locked(case, places, next(iter(given)), held=False):
            rule = "must let the train turn, but a torsional_stiffness holds it fast"
            raise InputError.of("supports", NO_VALUE, rule, "Remove that stiffness, or the prescribed speed")
        rule = (
            "must let the train turn, but a loop of meshes or couplings holds it fast by its numbers of teeth"
        )
        raise InputError.of("meshes", NO_VALUE, rule, "Correct a number of teeth or a ratio")
    rule = "their nominal speeds must roll together through every mesh and coupling"
    speeds_given = ", ".join(f"{speed:.6g} rad/s" for speed in given.values())
    raise InputError.of(named, speeds_given, rule, "Drive fewer rotors, or change a speed")


def rolling_conditions(case: "Train") -> NDArray[np.float64]:
    """Return the matrix A of the conditions A omega = 0 of rolling, shape [condition, rotor].

    First a row for each mesh, pitch radii over the larger one, then those of couplings and of torsional springs that hold rotors.
    """
    places = {name: i for i, name in enumerate(case.rotors)}
    return matrix_of(conditions(case, places, held=True), len(places))


def free_turns(case: "Train") -> NDArray[np.float64]:
    """Return the speeds with which a train can turn as one, prescribed rotations and torsional springs held, shape [rotor, way].

    Orthonormal; none where everything is held.
    """
    fixed = [
        i for i, r in enumerate(case.rotors.values()) if r.drive and (r.drive.prescribes or r.drive.positions)
    ]
    matrix = np.vstack(
        [rolling_conditions(case), np.eye(len(case.rotors))[fixed], np.zeros((1, len(case.rotors)))]
    )
    _, sizes, ways = np.linalg.svd(matrix)
    rank = int(np.sum(sizes > 1e-9 * max(float(sizes[0]), 1.0)))
    return np.ascontiguousarray(ways[rank:].T)


def _is_locked(case: "Train", places: dict[str, int], name: str, *, held: bool) -> bool:
    """Return whether a rotor cannot turn at any speeds of the others."""
    return _least(len(places), conditions(case, places, held=held), ((places[name], 1.0),), ()) is None


def nominal_speeds(case: "Train") -> NDArray[np.float64]:
    """Return every rotor's nominal speed Omega [rad/s], shape [rotor]: prescribed, the rest by rolling.

    Raises `InputError` where the prescribed speeds contradict each other.
    """
    drives = case.rotors.items()
    given = {n: speed for n, r in drives if r.drive and (speed := r.drive.nominal_speed()) is not None}
    return _roll(case, given, held=True)


def starting_speeds(case: "Train", nominal: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return every rotor's speed at t = 0 [rad/s], shape [rotor], as drives start and the train rolls, without ``initial``.

    A drive with a ramp starts at its ``start_speed``, the others at their speed; servos give way where they contradict.
    Without a ramp these are the ``nominal`` speeds. `matching.matching_speeds` counts ``initial.omega`` too.

    Raises `InputError` where prescribed speeds contradict each other at the start.
    """
    drives = {n: r.drive for n, r in case.rotors.items() if r.drive is not None}
    given = {n: speed for n, d in drives.items() if (speed := d.starting_speed()) is not None}
    if all(drives[n].nominal_speed() == speed for n, speed in given.items()):
        return nominal
    try:
        return _roll(case, given, held=True)
    except InputError:
        return _roll(case, {n: speed for n, speed in given.items() if drives[n].prescribes}, held=True)


def rolling_ratios(case: "Train") -> tuple[str, NDArray[np.float64]]:
    """Return a leading rotor and every rotor's speed by rolling per that rotor's, shape [rotor]; 0 for one that it does not move.

    The leading rotor has the highest nominal speed; in a train without a prescribed speed it is the one with a torque, or the
    first that is free to turn. Fixed rotors and torsional springs hold, as far as the train can still turn.
    """
    names, speeds = list(case.rotors), nominal_speeds(case)
    if np.any(speeds):
        at = int(np.argmax(np.abs(speeds)))
        return names[at], speeds / speeds[at]
    held = _still(case)
    driven = [name for name, rotor in case.rotors.items() if rotor.drive is not None and name not in held]
    lead = (driven or [name for name in names if name not in held] or names)[0]
    return lead, _as_far_as_held(case, {lead: 1.0})


def moving_speeds(case: "Train", nominal: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return representative speeds of the train, shape [rotor]: their signs are the senses of rotation.

    The ``nominal`` ones; else those that a torque or a position servo gives by rolling, several of them the accelerations from
    rest; else those that initial speeds give; else, torques in balance, those that the first of them in the train gives. What is
    kept from turning has 0.
    """
    if np.any(nominal):
        return nominal
    pushes: dict[str, float] = {}
    for name, r in case.rotors.items():
        if r.drive is not None:
            at, torque = r.drive.push(name)
            pushes[at] = pushes.get(at, 0.0) + torque
    pushes = {name: torque for name, torque in pushes.items() if torque}
    if len(pushes) == 1:
        return _as_far_as_held(case, {n: math.copysign(1.0, torque) for n, torque in pushes.items()})
    if pushes and np.any(speeds := _accelerations(case, pushes)):
        return speeds
    given = {n: r.initial.omega for n, r in case.rotors.items() if r.initial.omega}
    if pushes and not given:
        first = next(name for name in rotor_order(case) if name in pushes)
        given = {first: math.copysign(1.0, pushes[first])}
    return _as_far_as_held(case, given)


def _accelerations(case: "Train", torques: dict[str, float]) -> NDArray[np.float64]:
    """Return the accelerations [rad/s^2] of the train as it rolls from rest under torques [N m], shape [rotor]."""
    inertias = np.array([rotor.inertia for rotor in case.rotors.values()])
    push = np.array([torques.get(name, 0.0) for name in case.rotors])
    ways = free_turns(case)
    inertias[inertias == 0.0] = (
        1e-6 * float(np.max(inertias)) or 1.0
    )  # only the signs of what results are used
    found = ways @ np.linalg.solve(ways.T @ (inertias[:, None] * ways), ways.T @ push)
    found[np.abs(found) <= 1e-9 * float(np.max(np.abs(push) / inertias))] = 0.0
    return np.asarray(found)


def senses(case: "Train", nominal: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return every rotor's nominal sense of rotation, +1, -1 or 0, shape [rotor]: the signs of `moving_speeds`."""
    return np.sign(moving_speeds(case, nominal))


def _still(case: "Train") -> dict[str, float]:
    """Return the rotors whose drives keep them from turning, with their speed, 0."""
    return {n: 0.0 for n, r in case.rotors.items() if r.drive and r.drive.holds_rotation()}


def _as_far_as_held(case: "Train", given: dict[str, float]) -> NDArray[np.float64]:
    """Return the speeds by rolling, held rotors and torsional springs at rest, or released where that has no solution."""
    for all_given, held in ((_still(case) | given, True), (given, True), (given, False)):
        with suppress(InputError):
            return _roll(case, all_given, held=held)
    places = {name: i for i, name in enumerate(case.rotors)}
    rolls = vanishing(matrix_of(conditions(case, places, held=False), len(places)))
    return solved_by_rank([picked(places, given), rolls], len(places))


def ratio_between(case: "Train", one: str, other: str) -> float:
    """Return the turns of ``other`` per turn of ``one`` as the train rolls, 0 where neither moves the other."""
    speeds = _as_far_as_held(case, {one: 1.0})
    return float(speeds[list(case.rotors).index(other)])


def first_mesh_frequency(case: "Train") -> float:
    """Return the nominal mesh frequency [Hz] of the first mesh, 0 of a case without meshes."""
    return mesh_frequency(case, 0) if case.meshes else 0.0


def mesh_frequency(case: "Train", j: int = 0) -> float:
    """Return the nominal mesh frequency [Hz] of mesh j: teeth times the driver's speed, relative to its carrier."""
    mesh, speeds, names = case.meshes[j], nominal_speeds(case), list(case.rotors)
    frame = mesh_frame(case, j)
    relative = speeds[names.index(mesh.rotors[0])] - (
        speeds[names.index(frame)] if frame is not None else 0.0
    )
    return abs(float(relative)) * teeth_of(case, mesh.driver) / (2.0 * math.pi)
