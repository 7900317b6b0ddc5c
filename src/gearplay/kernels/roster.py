"""Who takes part in a step: rotors that are touched are integrated, all others fly.

A rotor is FLYING (closed form since ``since``), ACTIVE (integrated) or KNOWN (prescribed and held: always at its nominal
state). An element is ACTING, WATCHED (open, beside an active rotor: looked at after each step) or DORMANT (open between
flying rotors: sure to stay open until ``due``).
"""

from dataclasses import dataclass

import numpy as np

from gearplay.kernels.arrays import Floats, Ints
from gearplay.kernels.by_address import Group
from gearplay.kernels.compiled import compiled_inline
from gearplay.kernels.compiled_once import compiled_once
from gearplay.kernels.flight import NEVER, closed_form_span, fly, is_known, must_be_integrated
from gearplay.kernels.joined import find_rates, fly_joined
from gearplay.kernels.layout import (
    ACTING,
    ACTIVE,
    DORMANT,
    FLYING,
    KNOWN,
    TOUCH,
    WATCHED,
    Branch,
    System,
    is_acting,
    members,
    ramp_of,
    vx_of,
    x_of,
)
from gearplay.kernels.ripple import follow_ripple


@dataclass(frozen=True, eq=False)
class Roster(Group):
    """Roles, and lists of those that a step concerns; a list's first entry is its length."""

    roles: Ints  # per rotor
    doings: Ints  # per element
    since: Floats  # [s], per rotor: start of its flight
    origin: Floats  # [state] at that time
    swing: Floats  # rates with which joined rotors took off (see `joined`)
    grounds: Ints  # per group of joined rotors: 1 where it is integrated
    due: Floats  # [s], per element, then per rotor: nothing happens to it before
    active: Ints  # rotors
    states: Ints  # their places in y, and those of acting elements
    acting: Ints  # elements
    watched: Ints  # elements
    near: Ints  # flying rotors beside a watched element
    switches: Ints  # switch functions of acting and watched elements
    hiding: Ints  # those of them that a step may hide
    joining: Ints  # elements that join rotors in flight
    grounded: Ints  # [1]: 1 where nobody flies, touched or not, 2 where every element acts too


def make_roster(system: System, states: int) -> Roster:
    """Allocate a roster in which every rotor is active and every element acts."""
    n, elements = system.rotors.size, system.elements.size

    def full(count: int) -> Ints:
        return np.array([count, *range(count)], dtype=np.int64)

    return Roster(
        roles=np.full(n, ACTIVE, dtype=np.int64),
        doings=np.full(elements, ACTING, dtype=np.int64),
        since=np.zeros(n),
        origin=np.zeros(states),
        swing=np.zeros(2 * int(system.joined.chains["count"].sum())),
        grounds=np.zeros(n, dtype=np.int64),
        due=np.full(elements + n, NEVER),
        active=full(n),
        states=full(states),
        acting=full(elements),
        watched=np.zeros(elements + 1, dtype=np.int64),
        near=np.zeros(n + 1, dtype=np.int64),
        switches=np.zeros(system.switches.size + 1, dtype=np.int64),
        hiding=np.zeros(system.switches.size + 1, dtype=np.int64),
        joining=np.zeros(elements + 1, dtype=np.int64),
        grounded=np.zeros(1, dtype=np.int64),
    )


@compiled_inline
def add(items: Ints, item: int) -> None:
    """Append to a list that starts with its length."""
    items[0] += 1
    items[items[0]] = item


@compiled_inline
def copy_list(source: Ints, target: Ints) -> None:
    """Copy a list that starts with its length."""
    for c in range(source[0] + 1):
        target[c] = source[c]


@compiled_inline
def copy_rotor(system: System, i: int, source: Floats, target: Floats) -> None:
    """Copy rotor i's entries of a state."""
    x, vx = x_of(i), vx_of(system, i)
    for axis in range(3):
        target[x + axis] = source[x + axis]
        target[vx + axis] = source[vx + axis]


@compiled_inline
def fly_on(system: System, roster: Roster, i: int, t: float, y: Floats) -> None:
    """Fill rotor i's entries of ``y`` with its state at t [s]; it flies, and turns as its drive ripples."""
    fly(system, i, roster.since[i], t - roster.since[i], roster.origin, y)
    if system.rotors[i].group >= 0:
        fly_joined(system, i, t - roster.since[i], roster.origin, roster.swing, y)
    if system.rotors[i].ripple_count > 0:
        follow_ripple(system, i, t, y)


@compiled_inline
def state_of(system: System, roster: Roster, i: int, t: float, y: Floats, result: Floats) -> None:
    """Fill rotor i's entries of ``result`` with its state at t [s]; ``y`` holds those that do not fly."""
    if roster.roles[i] == FLYING:
        fly_on(system, roster, i, t, result)
    else:
        copy_rotor(system, i, y, result)


@compiled_inline
def states_of(system: System, roster: Roster, e: int, t: float, y: Floats, result: Floats) -> None:
    """Do what `state_of` does for every rotor of element e."""
    a, b, c = members(system, e)
    state_of(system, roster, a, t, y, result)
    if b >= 0:
        state_of(system, roster, b, t, y, result)
    if c >= 0:
        state_of(system, roster, c, t, y, result)


@compiled_inline
def take_off(system: System, roster: Roster, i: int, t: float, y: Floats) -> None:
    """Let rotor i fly from its state in ``y`` at t [s]."""
    roster.roles[i] = FLYING
    roster.since[i] = t
    copy_rotor(system, i, y, roster.origin)
    roster.due[system.elements.size + i] = t + closed_form_span(system, i, t, y)


@compiled_inline
def must_land(system: System, roster: Roster, i: int, t: float, y: Floats, modes: Ints, touched: int) -> bool:
    """Return whether rotor i, and with it all that springs join to it, must be integrated from t [s] on."""
    ramping = modes[ramp_of(system, modes, i)]
    if is_known(system, i, y, ramping):
        return False
    if roster.roles[i] == FLYING:
        return bool(touched == 1 or roster.due[system.elements.size + i] <= t)
    return bool(touched == 1 or roster.grounded[0] != 0 or must_be_integrated(system, i, t, y, ramping))


@compiled_once
def land_together(system: System, roster: Roster, t: float, y: Floats, modes: Ints) -> None:
    """Spread to all joined rotors, and to the elements between them, that one of them is touched (`assign_roles`)."""
    touched, acts, grounds = roster.near, roster.watched, roster.grounds
    for g in range(grounds.size):
        grounds[g] = 0
    for i in range(system.rotors.size):
        g = system.rotors[i].group
        if g >= 0 and must_land(system, roster, i, t, y, modes, touched[i + 1]):
            grounds[g] = 1
    for i in range(system.rotors.size):
        g = system.rotors[i].group
        if g >= 0 and grounds[g] == 1:
            touched[i + 1] = 1
    for e in range(system.elements.size):
        if system.elements[e].joins == 1 and grounds[system.rotors[system.elements[e].a].group] == 1:
            acts[e + 1] = 1


@compiled_inline
def assign_roles(system: System, roster: Roster, t: float, y: Floats, branch: Branch) -> None:
    """Decide at t [s] who is integrated; bring ``y`` up to date for rotors that stop flying."""
    n, elements, modes = system.rotors.size, system.elements.size, branch.modes
    # As scratch: 1 where a rotor is touched, an element acts.
    touched, acts = roster.near, roster.watched
    for i in range(n):
        touched[i + 1] = 0
    for e in range(elements):
        acts[e + 1] = 0
        if roster.grounded[0] == 2 or is_acting(system, e, modes):
            acts[e + 1] = 1
            a, b, c = members(system, e)
            touched[a + 1] = 1
            if b >= 0:
                touched[b + 1] = 1
            if c >= 0:
                touched[c + 1] = 1
    if system.joined.chains.size > 0:
        land_together(system, roster, t, y, modes)
    for i in range(n):
        if roster.roles[i] == FLYING:
            if touched[i + 1] == 0 and roster.due[elements + i] > t:
                continue  # flies on
            fly_on(system, roster, i, t, y)
        roster.due[elements + i] = NEVER
        ramping = modes[ramp_of(system, modes, i)]
        if is_known(system, i, y, ramping):
            roster.roles[i] = KNOWN
        elif touched[i + 1] == 1 or roster.grounded[0] != 0 or must_be_integrated(system, i, t, y, ramping):
            roster.roles[i] = ACTIVE
        else:
            take_off(system, roster, i, t, y)
    for c in range(system.joined.chains.size):
        i = system.joined.coordinates[system.joined.chains[c].first] // 3
        if roster.roles[i] == FLYING and roster.since[i] == t:
            find_rates(system, c, y, 1.0, roster.swing)


@compiled_inline
def has_active(system: System, roster: Roster, e: int) -> bool:
    """Return whether a rotor of element e is integrated."""
    a, b, c = members(system, e)
    roles = roster.roles
    return bool(roles[a] == ACTIVE or (b >= 0 and roles[b] == ACTIVE) or (c >= 0 and roles[c] == ACTIVE))


@compiled_inline
def has_just_taken_off(system: System, roster: Roster, e: int, t: float) -> bool:
    """Return whether a rotor of element e flies since t [s]."""
    a, b, c = members(system, e)
    since = roster.since
    return bool(since[a] == t or (b >= 0 and since[b] == t) or (c >= 0 and since[c] == t))


@compiled_once
def muster(system: System, roster: Roster, t: float, y: Floats, branch: Branch) -> None:
    """Assign roles at t [s] and fill the lists."""
    assign_roles(system, roster, t, y, branch)
    roster.active[0] = roster.states[0] = roster.near[0] = 0
    roster.acting[0] = roster.watched[0] = roster.switches[0] = roster.hiding[0] = roster.joining[0] = 0
    for i in range(system.rotors.size):
        if roster.roles[i] != ACTIVE:
            continue
        add(roster.active, i)
        for axis in range(3):
            add(roster.states, x_of(i) + axis)
        for axis in range(3):
            add(roster.states, vx_of(system, i) + axis)
    for e in range(system.elements.size):
        element, before = system.elements[e], roster.doings[e]
        roster.doings[e] = DORMANT
        acts = roster.watched[e + 1]  # by `assign_roles`; later entries are not yet written over
        if element.joins == 1 and acts == 0:
            add(roster.joining, e)
        if acts == 1:
            roster.doings[e] = ACTING
            add(roster.acting, e)
            for slot in range(element.state, element.state + element.states):
                add(roster.states, slot)
            for s in range(element.switch, element.switch + element.switches):
                add(roster.switches, s)
                if system.switches[s].hides == 1:
                    add(roster.hiding, s)
        elif has_active(system, roster, e):
            roster.doings[e] = WATCHED
            add(roster.watched, e)
            for s in range(element.switch, element.switch + element.switches):
                if system.switches[s].role == TOUCH:
                    add(roster.switches, s)
            a, b, c = members(system, e)
            note_near(roster, a)
            note_near(roster, b)
            note_near(roster, c)
        elif before != DORMANT or has_just_taken_off(system, roster, e, t):
            roster.due[e] = t
        if roster.doings[e] != DORMANT or element.contacts == 0:
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
