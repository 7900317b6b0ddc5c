"""Partition of the bodies for the next step: bodies in contact are integrated, free bodies use the closed-form solution.

A rotor is FREE (closed form since ``since``), ACTIVE (integrated) or KNOWN (prescribed and held: always at its nominal
state). An element is ACTING, WATCHED (open, beside an active rotor: evaluated after each step) or DORMANT (open between
free rotors: sure to stay open until ``due``).
"""

from dataclasses import dataclass

import numpy as np

from gearplay.kernels.arrays import Floats, Ints
from gearplay.kernels.by_address import Group
from gearplay.kernels.compiled import compiled_inline
from gearplay.kernels.compiled_once import compiled_once
from gearplay.kernels.free_motion import (
    NEVER,
    closed_form_span,
    first_axis,
    is_known,
    must_be_integrated,
    propagate,
)
from gearplay.kernels.joined import find_rates, propagate_joined
from gearplay.kernels.layout import (
    ACTING,
    ACTIVE,
    DORMANT,
    FREE,
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
from gearplay.kernels.prescribed import follow_drive


@dataclass(frozen=True, eq=False)
class ActiveSet(Group):
    """States of bodies and elements, and index lists of the next step; a list's first entry is its length."""

    body_states: Ints  # per rotor
    element_states: Ints  # per element
    since: Floats  # [s], per rotor: start of its free motion
    origin: Floats  # [state] at that time
    modal_rates: Floats  # initial modal rates of joined rotors (see `joined`)
    integrated_groups: Ints  # per group of joined rotors: 1 where it is integrated
    due: Floats  # [s], per element, then per rotor: nothing happens to it before
    active: Ints  # rotors
    states: Ints  # their places in y but for centres that stay at rest, and those of acting elements
    acting: Ints  # elements
    watched: Ints  # elements
    near: Ints  # free rotors beside a watched element
    switches: Ints  # switch functions of acting and watched elements
    hiding: Ints  # those of them that a step may hide
    joining: Ints  # elements that join free rotors
    forced: Ints  # [1]: 1 to integrate all bodies, 2 to apply all elements too


def make_active_set(system: System, states: int) -> ActiveSet:
    """Allocate an active set in which every rotor is active and every element acts."""
    n, elements = system.rotors.size, system.elements.size

    def full(count: int) -> Ints:
        return np.array([count, *range(count)], dtype=np.int64)

    return ActiveSet(
        body_states=np.full(n, ACTIVE, dtype=np.int64),
        element_states=np.full(elements, ACTING, dtype=np.int64),
        since=np.zeros(n),
        origin=np.zeros(states),
        modal_rates=np.zeros(2 * int(system.joined.chains["count"].sum())),
        integrated_groups=np.zeros(n, dtype=np.int64),
        due=np.full(elements + n, NEVER),
        active=full(n),
        states=full(states),
        acting=full(elements),
        watched=np.zeros(elements + 1, dtype=np.int64),
        near=np.zeros(n + 1, dtype=np.int64),
        switches=np.zeros(system.switches.size + 1, dtype=np.int64),
        hiding=np.zeros(system.switches.size + 1, dtype=np.int64),
        joining=np.zeros(elements + 1, dtype=np.int64),
        forced=np.zeros(1, dtype=np.int64),
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
def propagate_body(system: System, active_set: ActiveSet, i: int, t: float, y: Floats) -> None:
    """Fill rotor i's entries of ``y`` with its closed-form state at t [s], ripple of its drive included."""
    propagate(system, i, active_set.since[i], t - active_set.since[i], active_set.origin, y)
    if system.rotors[i].group >= 0:
        propagate_joined(system, i, t - active_set.since[i], active_set.origin, active_set.modal_rates, y)
    if system.rotors[i].varying == 1:
        follow_drive(system, i, t, y)


@compiled_inline
def state_of(system: System, active_set: ActiveSet, i: int, t: float, y: Floats, result: Floats) -> None:
    """Fill rotor i's entries of ``result`` with its state at t [s]; ``y`` holds those that are integrated."""
    if active_set.body_states[i] == FREE:
        propagate_body(system, active_set, i, t, result)
    else:
        copy_rotor(system, i, y, result)


@compiled_inline
def states_of(system: System, active_set: ActiveSet, e: int, t: float, y: Floats, result: Floats) -> None:
    """Apply `state_of` to every rotor of element e."""
    a, b, c = members(system, e)
    state_of(system, active_set, a, t, y, result)
    if b >= 0:
        state_of(system, active_set, b, t, y, result)
    if c >= 0:
        state_of(system, active_set, c, t, y, result)


@compiled_inline
def start_free_motion(system: System, active_set: ActiveSet, i: int, t: float, y: Floats) -> None:
    """Start the closed form of rotor i from its state in ``y`` at t [s]."""
    active_set.body_states[i] = FREE
    active_set.since[i] = t
    copy_rotor(system, i, y, active_set.origin)
    active_set.due[system.elements.size + i] = t + closed_form_span(system, i, t, y)


@compiled_inline
def needs_integration(
    system: System, active_set: ActiveSet, i: int, t: float, y: Floats, modes: Ints, touched: int
) -> bool:
    """Return whether rotor i, and all rotors joined to it by springs, must be integrated from t [s] on."""
    ramping = modes[ramp_of(system, modes, i)]
    if is_known(system, i, y, ramping):
        return False
    if active_set.body_states[i] == FREE:
        return bool(touched == 1 or active_set.due[system.elements.size + i] <= t)
    return bool(touched == 1 or active_set.forced[0] != 0 or must_be_integrated(system, i, t, y, ramping))


@compiled_once
def integrate_joined(system: System, active_set: ActiveSet, t: float, y: Floats, modes: Ints) -> None:
    """Mark all rotors joined to a touched rotor as touched, and the elements between them as acting."""
    touched, acts, integrated_groups = active_set.near, active_set.watched, active_set.integrated_groups
    for g in range(integrated_groups.size):
        integrated_groups[g] = 0
    for i in range(system.rotors.size):
        g = system.rotors[i].group
        if g >= 0 and needs_integration(system, active_set, i, t, y, modes, touched[i + 1]):
            integrated_groups[g] = 1
    for i in range(system.rotors.size):
        g = system.rotors[i].group
        if g >= 0 and integrated_groups[g] == 1:
            touched[i + 1] = 1
    for e in range(system.elements.size):
        if (
            system.elements[e].joins == 1
            and integrated_groups[system.rotors[system.elements[e].a].group] == 1
        ):
            acts[e + 1] = 1


@compiled_inline
def assign_body_states(system: System, active_set: ActiveSet, t: float, y: Floats, branch: Branch) -> None:
    """Assign body states at t [s]; update ``y`` for rotors whose closed form ends."""
    n, elements, modes = system.rotors.size, system.elements.size, branch.modes
    # Scratch: 1 for touched rotors and for acting elements.
    touched, acts = active_set.near, active_set.watched
    for i in range(n):
        touched[i + 1] = 0
    for e in range(elements):
        acts[e + 1] = 0
        if active_set.forced[0] == 2 or is_acting(system, e, modes):
            acts[e + 1] = 1
            a, b, c = members(system, e)
            touched[a + 1] = 1
            if b >= 0:
                touched[b + 1] = 1
            if c >= 0:
                touched[c + 1] = 1
    if system.joined.chains.size > 0:
        integrate_joined(system, active_set, t, y, modes)
    for i in range(n):
        if active_set.body_states[i] == FREE:
            if touched[i + 1] == 0 and active_set.due[elements + i] > t:
                continue  # stays free
            propagate_body(system, active_set, i, t, y)
        active_set.due[elements + i] = NEVER
        ramping = modes[ramp_of(system, modes, i)]
        if is_known(system, i, y, ramping):
            active_set.body_states[i] = KNOWN
        elif touched[i + 1] == 1 or active_set.forced[0] != 0 or must_be_integrated(system, i, t, y, ramping):
            active_set.body_states[i] = ACTIVE
        else:
            start_free_motion(system, active_set, i, t, y)
    for c in range(system.joined.chains.size):
        i = system.joined.coordinates[system.joined.chains[c].first] // 3
        if active_set.body_states[i] == FREE and active_set.since[i] == t:
            find_rates(system, c, y, 1.0, active_set.modal_rates)


@compiled_inline
def has_active(system: System, active_set: ActiveSet, e: int) -> bool:
    """Return whether a rotor of element e is integrated."""
    a, b, c = members(system, e)
    body_states = active_set.body_states
    return bool(
        body_states[a] == ACTIVE
        or (b >= 0 and body_states[b] == ACTIVE)
        or (c >= 0 and body_states[c] == ACTIVE)
    )


@compiled_inline
def is_newly_free(system: System, active_set: ActiveSet, e: int, t: float) -> bool:
    """Return whether the closed form of a rotor of element e starts at t [s]."""
    a, b, c = members(system, e)
    since = active_set.since
    return bool(since[a] == t or (b >= 0 and since[b] == t) or (c >= 0 and since[c] == t))


@compiled_once
def rebuild(system: System, active_set: ActiveSet, t: float, y: Floats, branch: Branch) -> None:
    """Partition bodies and elements at t [s]: assign their states and fill the lists."""
    assign_body_states(system, active_set, t, y, branch)
    for e in range(system.elements.size):
        before = active_set.element_states[e]
        active_set.element_states[e] = DORMANT
        if active_set.watched[e + 1] == 1:  # by `assign_body_states`
            active_set.element_states[e] = ACTING
        elif has_active(system, active_set, e):
            active_set.element_states[e] = WATCHED
        elif before != DORMANT or is_newly_free(system, active_set, e, t):
            active_set.due[e] = t
        if active_set.element_states[e] != DORMANT or system.elements[e].contacts == 0:
            active_set.due[e] = NEVER
    fill_lists(system, active_set, y)


@compiled_once
def fill_lists(system: System, active_set: ActiveSet, y: Floats) -> None:
    """Fill the lists of indices from the states of bodies and elements, at state y."""
    active_set.active[0] = active_set.states[0] = active_set.near[0] = active_set.acting[0] = 0
    active_set.watched[0] = active_set.switches[0] = active_set.hiding[0] = active_set.joining[0] = 0
    for i in range(system.rotors.size):
        if active_set.body_states[i] != ACTIVE:
            continue
        add(active_set.active, i)
        first = first_axis(system, i, y)
        for axis in range(first, 3):
            add(active_set.states, x_of(i) + axis)
        for axis in range(first, 3):
            add(active_set.states, vx_of(system, i) + axis)
    for e in range(system.elements.size):
        element, state = system.elements[e], active_set.element_states[e]
        if element.joins == 1 and state != ACTING:
            add(active_set.joining, e)
        if state == ACTING:
            add(active_set.acting, e)
            for slot in range(element.state, element.state + element.states):
                add(active_set.states, slot)
            for s in range(element.switch, element.switch + element.switches):
                add(active_set.switches, s)
                if system.switches[s].hides == 1:
                    add(active_set.hiding, s)
        elif state == WATCHED:
            add(active_set.watched, e)
            for s in range(element.switch, element.switch + element.switches):
                if system.switches[s].role == TOUCH:
                    add(active_set.switches, s)
            a, b, c = members(system, e)
            note_near(active_set, a)
            note_near(active_set, b)
            note_near(active_set, c)


@compiled_inline
def note_near(active_set: ActiveSet, i: int) -> None:
    """Add rotor i to the free rotors of watched elements."""
    if i < 0 or active_set.body_states[i] != FREE:
        return
    for k in range(1, active_set.near[0] + 1):
        if active_set.near[k] == i:
            return
    add(active_set.near, i)


@compiled_inline
def propagate_listed(system: System, active_set: ActiveSet, rotors: Ints, t: float, y: Floats) -> None:
    """Fill ``y`` with the closed-form states at t [s] of the listed rotors."""
    for c in range(1, rotors[0] + 1):
        i = rotors[c]
        if active_set.body_states[i] == FREE:
            propagate_body(system, active_set, i, t, y)
