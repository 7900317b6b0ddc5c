"""Who takes part in a step: rotors that are touched are integrated, all others fly.

A rotor is FLYING (closed form since ``since``), ACTIVE (integrated) or KNOWN (prescribed and held: always at its nominal
state). A sleeve or mesh is TOUCHING, WATCHED (open, beside an active rotor: looked at after each step) or DORMANT (open
between flying rotors: sure to stay open until ``due``). Elements are numbered sleeves first, then meshes.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gearplay.kernels.compiled import compiled, compiled_inline
from gearplay.kernels.flight import NEVER, closed_form_span, fly, is_known, must_be_integrated
from gearplay.kernels.layout import (
    ACTIVE,
    DORMANT,
    DRIVE_SERVO,
    FLYING,
    KNOWN,
    OPEN,
    STIFFNESS_SQUARE,
    TOUCHING,
    WATCHED,
    System,
    contact_count,
    switch_count,
)
from gearplay.kernels.ripple import follow_ripple

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


class Roster(NamedTuple):
    """Roles, and lists of those that a step concerns; a list's first entry is its length."""

    roles: Ints  # per rotor
    doings: Ints  # per element
    since: Floats  # [s], per rotor: start of its flight
    origin: Floats  # [state] at that time
    due: Floats  # [s], per element, then per rotor: nothing happens to it before
    active: Ints  # rotors
    states: Ints  # their places in y
    sleeves: Ints  # touching
    meshes: Ints
    watched_sleeves: Ints
    watched_meshes: Ints
    near: Ints  # flying rotors beside a watched element
    switches: Ints  # switch functions of touching and watched elements and of servos
    grounded: Ints  # [1]: 1 where nobody flies, touched or not


def make_roster(system: System, states: int) -> Roster:
    """Allocate a roster in which every rotor is active and every element touches."""
    n, n_s, n_m = system.rotors.size, system.sleeves.size, system.meshes.size

    def full(count: int) -> Ints:
        return np.array([count, *range(count)], dtype=np.int64)

    return Roster(
        roles=np.full(n, ACTIVE, dtype=np.int64),
        doings=np.full(n_s + n_m, TOUCHING, dtype=np.int64),
        since=np.zeros(n),
        origin=np.zeros(states),
        due=np.full(n_s + n_m + n, NEVER),
        active=full(n),
        states=full(states),
        sleeves=full(n_s),
        meshes=full(n_m),
        watched_sleeves=np.zeros(n_s + 1, dtype=np.int64),
        watched_meshes=np.zeros(n_m + 1, dtype=np.int64),
        near=np.zeros(n + 1, dtype=np.int64),
        switches=np.zeros(switch_count(system) + 1, dtype=np.int64),
        grounded=np.zeros(1, dtype=np.int64),
    )


@compiled_inline
def add(items: Ints, item: int) -> None:
    """Append to a list that starts with its length."""
    items[0] += 1
    items[items[0]] = item


@compiled_inline
def members(system: System, e: int) -> tuple[int, int, int]:
    """Return the rotors of element e, -1 for none: journal and bush, or both gears and their carrier."""
    n_s = system.sleeves.size
    if e < n_s:
        return system.sleeves[e].journal, system.sleeves[e].bush, -1
    mesh = system.meshes[e - n_s]
    return mesh.a, mesh.b, mesh.frame


@compiled_inline
def is_touching(system: System, e: int, modes: Ints) -> bool:
    """Return whether element e is in contact."""
    n_s = system.sleeves.size
    if e < n_s:
        return bool(modes[e] != OPEN)
    drive = n_s + 2 * (e - n_s)
    return bool(modes[drive] != OPEN or modes[drive + 1] != OPEN)


@compiled_inline
def fly_on(system: System, roster: Roster, i: int, t: float, y: Floats) -> None:
    """Fill rotor i's entries of ``y`` with its state at t [s]; it flies, and turns as its drive ripples."""
    fly(system, i, t - roster.since[i], roster.origin, y)
    if system.rotors[i].ripple_count > 0:
        follow_ripple(system, i, t, y)


@compiled_inline
def state_of(system: System, roster: Roster, i: int, t: float, y: Floats, result: Floats) -> None:
    """Fill rotor i's entries of ``result`` with its state at t [s]; ``y`` holds those that do not fly."""
    if roster.roles[i] == FLYING:
        fly_on(system, roster, i, t, result)
        return
    n = system.rotors.size
    for c in range(3):
        result[3 * i + c] = y[3 * i + c]
        result[3 * (n + i) + c] = y[3 * (n + i) + c]


@compiled_inline
def take_off(system: System, roster: Roster, i: int, t: float, y: Floats) -> None:
    """Let rotor i fly from its state in ``y`` at t [s]."""
    n = system.rotors.size
    roster.roles[i] = FLYING
    roster.since[i] = t
    for c in range(3):
        roster.origin[3 * i + c] = y[3 * i + c]
        roster.origin[3 * (n + i) + c] = y[3 * (n + i) + c]
    roster.due[system.sleeves.size + system.meshes.size + i] = t + closed_form_span(system, i, y)


@compiled_inline
def assign_roles(system: System, roster: Roster, t: float, y: Floats, modes: Ints) -> None:
    """Decide at t [s] who is integrated; bring ``y`` up to date for rotors that stop flying."""
    n, elements = system.rotors.size, system.sleeves.size + system.meshes.size
    ramps = modes.size - n
    touched = roster.near  # as scratch: 1 where a rotor is touched
    for i in range(n):
        touched[i + 1] = 0
    for e in range(elements):
        if is_touching(system, e, modes):
            a, b, c = members(system, e)
            touched[a + 1] = 1
            if b >= 0:
                touched[b + 1] = 1
            if c >= 0:
                touched[c + 1] = 1
    for i in range(n):
        if roster.roles[i] == FLYING:
            if touched[i + 1] == 0 and roster.due[elements + i] > t:
                continue  # flies on
            fly_on(system, roster, i, t, y)
        roster.due[elements + i] = NEVER
        if is_known(system, i, y, modes[ramps + i]):
            roster.roles[i] = KNOWN
        elif (
            touched[i + 1] == 1
            or roster.grounded[0] == 1
            or must_be_integrated(system, i, y, modes[ramps + i])
        ):
            roster.roles[i] = ACTIVE
        else:
            take_off(system, roster, i, t, y)


@compiled
def muster(system: System, roster: Roster, t: float, y: Floats, modes: Ints) -> None:
    """Assign roles at t [s] and fill the lists."""
    assign_roles(system, roster, t, y, modes)
    n, n_s = system.rotors.size, system.sleeves.size
    elements = n_s + system.meshes.size
    roster.active[0] = roster.states[0] = roster.near[0] = 0
    roster.sleeves[0] = roster.meshes[0] = roster.watched_sleeves[0] = roster.watched_meshes[0] = 0
    roster.switches[0] = 0
    n_c, n_m = contact_count(system), system.meshes.size
    for i in range(n):
        if roster.roles[i] != ACTIVE:
            continue
        add(roster.active, i)
        for c in range(3):
            add(roster.states, 3 * i + c)
        for c in range(3):
            add(roster.states, 3 * (n + i) + c)
        if system.rotors[i].drive == DRIVE_SERVO:
            add(roster.states, system.rotors[i].servo_slot)
            add(roster.switches, 2 * n_c + 3 * n_m + i)
    for e in range(elements):
        a, b, c = members(system, e)
        before = roster.doings[e]
        if is_touching(system, e, modes):
            roster.doings[e] = TOUCHING
            if e < n_s:
                add(roster.sleeves, e)
                add(roster.switches, e)
                add(roster.switches, n_c + e)
            else:
                j = e - n_s
                add(roster.meshes, j)
                for f in range(2 * j, 2 * j + 2):
                    add(roster.switches, n_s + f)
                    add(roster.switches, n_c + n_s + f)
                    add(roster.switches, 2 * n_c + f)
                if system.meshes[j].stiffness_kind == STIFFNESS_SQUARE:
                    add(roster.switches, 2 * n_c + 2 * n_m + j)
        elif (
            roster.roles[a] == ACTIVE
            or (b >= 0 and roster.roles[b] == ACTIVE)
            or (c >= 0 and roster.roles[c] == ACTIVE)
        ):
            roster.doings[e] = WATCHED
            if e < n_s:
                add(roster.watched_sleeves, e)
                add(roster.switches, e)
            else:
                j = e - n_s
                add(roster.watched_meshes, j)
                add(roster.switches, n_s + 2 * j)
                add(roster.switches, n_s + 2 * j + 1)
            note_near(roster, a)
            note_near(roster, b)
            note_near(roster, c)
        else:
            roster.doings[e] = DORMANT
            fresh = (
                roster.since[a] == t or (b >= 0 and roster.since[b] == t) or (c >= 0 and roster.since[c] == t)
            )
            if before != DORMANT or fresh:
                roster.due[e] = t
        if roster.doings[e] != DORMANT:
            roster.due[e] = NEVER


@compiled_inline
def note_near(roster: Roster, i: int) -> None:
    """Add rotor i to the flying rotors beside watched elements."""
    if i < 0 or roster.roles[i] != FLYING:
        return
    for k in range(1, roster.near[0] + 1):
        if roster.near[k] == i:
            return
    add(roster.near, i)


@compiled_inline
def fly_listed(system: System, roster: Roster, rotors: Ints, t: float, y: Floats) -> None:
    """Fill ``y`` with the states at t [s] of those listed rotors that fly."""
    for c in range(1, rotors[0] + 1):
        i = rotors[c]
        if roster.roles[i] == FLYING:
            fly_on(system, roster, i, t, y)
