"""Findings about the start: penetrating flanks, initial impacts, twisted couplings."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from gearplay.integrate.switches import make_memory
from gearplay.kernels.layout import omega_of
from gearplay.model.initial import initial_state
from gearplay.model.matching import matching_speeds
from gearplay.model.touch import gaps_of_mesh
from gearplay.parts.drive.schema import SpeedDrive
from gearplay.parts.mesh.mesh_stiffness import pack_stiffness
from gearplay.parts.mesh.train import geometry, rolling
from gearplay.parts.mesh.train.linear_conditions import matrix_of
from gearplay.parts.registry import MESH
from gearplay.schema.finding import Finding
from gearplay.vocabulary.errors import join_path

if TYPE_CHECKING:
    from gearplay.model.case import Case
    from gearplay.model.pack import Packed
    from gearplay.parts.protocol import Joint

Floats = NDArray[np.float64]

MISFIT: Final = 1e-3
"""Relative difference of speeds that is more than the rounding of a given value."""

INSIDE: Final = 1e-9
"""Depth [m] of one flank in another that is more than rounding."""


def start_findings(case: Case, packed: Packed) -> Iterator[Finding]:
    """Yield warnings about the start of member 0.

    Raises `InputError` where its centres cannot mesh.
    """
    case = case.operating
    y = initial_state(case, packed)
    speeds = packed.system.rotors["nominal_speed"]
    omega = {n: float(y[omega_of(packed.system, i)] + speeds[i]) for i, n in enumerate(case.rotors)}
    for j in range(len(case.meshes)):
        yield from _overlap(case, packed, j, y)
    for j in range(len(case.meshes)):
        yield from _meeting(case, packed, j, omega)
    for path, name, joint in case.named_joints():
        yield from _twisting(case, path, name, joint, omega)


def _overlap(case: Case, packed: Packed, j: int, y: Floats) -> Iterator[Finding]:
    """Compare the flanks of a mesh at the start."""
    p_d, b_t = gaps_of_mesh(packed, j, y, make_memory(packed.system))
    depths = {"drive": p_d, "back": -b_t - p_d}
    pressed = {flank: depth for flank, depth in depths.items() if depth > INSIDE}
    if (
        not pressed or geometry.installed_backlash(case, j) < 0.0
    ):  # wedged whatever the start, which is another finding
        return
    where = " and ".join(f"the {flank} flanks by {1e6 * depth:.4g} um" for flank, depth in pressed.items())
    mesh = case.meshes[j]
    given = [n for n in _train(case, set(mesh.rotors)) if case.rotors[n].initial.theta is not None]
    if b_t < 0.0:
        cause, cure = f"meshes.{j}", "Move initial.x, initial.y of its rotors, or raise the backlash."
        why = f"the backlash is {1e6 * b_t:.4g} um where its gears start"
    elif given:
        cause = case.field_path(given[0], "initial", "theta")
        paths = " and ".join(case.field_path(name, "initial", "theta") for name in given)
        why = f"{paths} and the prescribed rotations leave no room"
        cure = "Leave one initial.theta out, or change it."
    else:
        cause, why = f"meshes.{j}", "no rotation of the free rotors leaves room at every mesh of its loop"
        cure = "Check runouts, pin errors and phases of the loop, or raise the backlash."
    yield Finding(
        "warning",
        cause,
        f"teeth of {mesh.label} are inside each other at the start, {where}: {why}. {cure}",
    )


def _meeting(case: Case, packed: Packed, j: int, omega: dict[str, float]) -> Iterator[Finding]:
    """Compare the speeds of the two base circles of a mesh."""
    m, names = packed.system.records[MESH][j], list(case.rotors)
    against = omega[names[m.frame]] if m.frame >= 0 else 0.0
    ends = {names[m.a]: float(m.rho_a), names[m.b]: float(m.rho_b)}
    parts = [m.sigma * radius * (omega[name] - against) for name, radius in ends.items()]
    speed = float(sum(parts))
    if abs(speed) <= MISFIT * max(map(abs, parts)):
        return
    rotors = {*ends} | ({names[m.frame]} if m.frame >= 0 else set())
    flank = "drive flanks at once" if speed > 0.0 else "back flanks, across the backlash"
    yield _shock(
        case,
        f"meshes.{j}",
        f"the teeth of {case.meshes[j].label} meet at the start{_blow(case, packed, j, abs(speed))} at {abs(speed):.4g} m/s "
        f"({flank})",
        rotors,
        omega,
    )


def _twisting(case: Case, path: str, label: str, joint: Joint, omega: dict[str, float]) -> Iterator[Finding]:
    """Compare the speeds of the rotors that a joint connects."""
    factors = joint.rolling()
    parts = [factor * omega[name] for name, factor in factors.items()]
    if parts and abs(sum(parts)) > MISFIT * max(map(abs, parts)):
        words = f"{label} twists at the start at {abs(sum(parts)):.4g} rad/s"
        yield _shock(case, path, words, set(factors), omega)


def _blow(case: Case, packed: Packed, j: int, speed: float) -> str:
    """Return a text on the force of flanks that meet at a speed [m/s], undamped and without other forces."""
    m, rotors = packed.system.records[MESH][j], packed.system.rotors
    free = sum(radius**2 * float(rotors[i].inv_inertia) for i, radius in ((m.a, m.rho_a), (m.b, m.rho_b)))
    if free <= 0.0:
        return ""
    return f" with up to {speed * float(np.sqrt(pack_stiffness(case, j).average / free)):.4g} N"


def _shock(case: Case, path: str, words: str, rotors: set[str], omega: dict[str, float]) -> Finding:
    """Return the finding that rotors do not roll together at the start, with its cause and cure."""
    at = [f"{omega[name]:.6g} rad/s of {name}" for name in omega if name in rotors]
    train = _train(case, rotors)
    given = [name for name in train if case.rotors[name].initial.omega is not None]
    drives = {n: case.rotors[n].drive for n in train}
    fields = [case.field_path(n, "initial", "omega") for n in given]
    fields += [
        case.field_path(
            n, "drive", *(["ripple"] if drive.ripple and drive.first_speed != drive.speed else [])
        )
        for n, drive in drives.items()
        if isinstance(drive, SpeedDrive)
    ]
    fields += [
        case.settable_path(join_path([table, n, "torsional_stiffness"]))
        for table, n, part in case.every_holder()
        if n in train and part.holds_rotation()
    ]
    return Finding(
        "warning" if case.run.transient == 0.0 else "note",
        path,
        f"{words}, since {' and '.join(at)} do not roll together. The cause: {', '.join(fields)}. "
        f"{_cure(case, given)}",
    )


def _cure(case: Case, given: list[str]) -> str:
    """Return the cure for a given speed: one at which the train rolls."""
    places = {name: i for i, name in enumerate(case.rotors)}
    rolls = matrix_of(rolling.conditions(case, places, held=True), len(places))
    nominal = rolling.nominal_speeds(case)
    for name in given:
        matching = matching_speeds(case, nominal, without=name)
        if float(np.max(np.abs(rolls @ matching))) <= 1e-6 * float(np.max(np.abs(matching))):
            path = case.field_path(name, "initial", "omega")
            return f"Leave {path} out, or give the matching speed, {matching[places[name]]:.6g} rad/s."
    if not given:  # a ripple that does not begin at 0
        return "Give phases with which the ripple is 0 at t = 0, or a transient."
    return "Give one initial.omega for each way in which the train can turn."


def _train(case: Case, rotors: set[str]) -> list[str]:
    """Return the rotors that turn with some by meshes, joints or springs, these first."""
    names = list(case.rotors)
    places = {name: i for i, name in enumerate(names)}
    near = {places[name] for name in rotors}
    reached = set(near)
    rows = [{place for place, _ in row} for row in rolling.conditions(case, places, held=True)]
    while more := {place for row in rows if row & reached for place in row} - reached:
        reached |= more
    return [names[i] for i in sorted(reached, key=lambda i: (i not in near, i))]
