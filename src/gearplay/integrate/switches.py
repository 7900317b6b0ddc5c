"""Smooth branch of every contact, and the switch functions whose zeros end it.

The motion is piecewise smooth. A *mode* names the branch of a contact (OPEN, LOADED, or SEPARATING: touching without a force)
or of an element, a *switch* is a function that is negative while the branch holds and crosses zero upwards where it ends.
Touch and pull are alike for all contacts; the others belong to their elements.
"""

import numpy as np

from gearplay.integrate import dispatch
from gearplay.integrate.active_set import ActiveSet
from gearplay.kernels.arrays import Floats
from gearplay.kernels.compiled import compiled, compiled_inline
from gearplay.kernels.compiled_once import compiled_once
from gearplay.kernels.layout import (
    LOADED,
    MARGIN,
    MEMORY,
    OPEN,
    PENETRATION,
    PULL,
    RATE,
    SEPARATING,
    TOUCH,
    Branch,
    Loads,
    System,
    ramp_of,
)
from gearplay.parts.registry import KINDS

INACTIVE = -1.0


def make_memory(system: System) -> Floats:
    """Allocate the memory of the elements, shape [element, memory], in its initial state."""
    kinds = system.elements["kind"].tolist()
    memory = np.zeros((len(kinds), MEMORY))
    for e, kind in enumerate(kinds):
        blank = KINDS[kind].file.MEMORY
        memory[e, : len(blank)] = blank
    return memory


def make_branch(system: System) -> Branch:
    """Allocate a branch: all contacts open, no impact speed, no angle."""
    own = sum(KINDS[kind].file.MODES for kind in system.elements["kind"].tolist())
    own += int(system.elements["more_modes"].sum())
    modes = system.contacts.size + own + system.rotors.size
    count = sum(slot >= 0 for slot in system.contacts["impact_slot"].tolist())
    return Branch(
        modes=np.zeros(modes, dtype=np.int64),
        impact_speeds=np.zeros(count),
        memory=make_memory(system),
        acceleration_bounds=np.zeros(3 * system.rotors.size),
    )


@compiled_inline
def is_overruled(system: System, k: int, branch: Branch) -> bool:
    """Return whether open contact k may not close because its partner, which goes first, is loaded."""
    contact = system.contacts[k]
    return bool(contact.yields == 1 and branch.modes[contact.partner] == LOADED)


@compiled_inline
def switch_value(system: System, s: int, t: float, y: Floats, branch: Branch, loads: Loads) -> float:
    """Return switch function s from the state and the contact table of its element."""
    switch = system.switches[s]
    if switch.role == TOUCH:
        k = switch.contact
        p = loads.contacts[k, PENETRATION]
        if branch.modes[k] == OPEN:
            return INACTIVE if is_overruled(system, k, branch) else p
        return -p
    if switch.role == PULL:
        margin, mode = loads.contacts[switch.contact, MARGIN], branch.modes[switch.contact]
        return INACTIVE if mode == OPEN else -margin if mode == LOADED else margin
    return dispatch.own_switch(system, switch.element, switch.local, t, y, branch, loads)


@compiled_once
def switch_values(
    system: System, active_set: ActiveSet, t: float, y: Floats, branch: Branch, loads: Loads, g: Floats
) -> None:
    """Fill ``g`` with the switch functions of the active set from the contact table of the same state."""
    for c in range(1, active_set.switches[0] + 1):
        s = active_set.switches[c]
        g[s] = switch_value(system, s, t, y, branch, loads)


@compiled_inline
def store_impact_speed(system: System, k: int, rate: float, branch: Branch) -> None:
    """Latch the impact speed [m/s] of contact k at an onset, floored, where its law needs one."""
    contact = system.contacts[k]
    if contact.impact_slot >= 0:
        branch.impact_speeds[contact.impact_slot] = max(rate, contact.floor)


@compiled_inline
def update_partners(system: System, e: int, branch: Branch, loads: Loads) -> None:
    """Make two contacts of element e that exclude each other do so: eq. (19) is one force, its drive branch first."""
    element, modes = system.elements[e], branch.modes
    for k in range(element.contact, element.contact + element.contacts):
        contact = system.contacts[k]
        if contact.yields == 0:
            continue
        if modes[contact.partner] == LOADED:
            modes[k] = OPEN
        elif modes[k] == OPEN and loads.contacts[k, PENETRATION] > 0.0:
            modes[k] = LOADED


@compiled_once
def update_modes(system: System, t: float, y: Floats, branch: Branch, loads: Loads) -> None:
    """Set the modes of contacts and elements from the state alone; neither ramps nor samples, which times decide."""
    for k in range(system.contacts.size):
        touches = system.contacts[k].closed == 1 or loads.contacts[k, PENETRATION] > 0.0
        branch.modes[k] = LOADED if touches else OPEN
    for e in range(system.elements.size):
        update_partners(system, e, branch, loads)
        if not dispatch.takes_samples(system, e):
            dispatch.initialise(system, e, t, y, branch, loads)


@compiled_once
def initialise_modes(system: System, t: float, y: Floats, branch: Branch, loads: Loads) -> None:
    """Set every mode from the state alone; used once, at the start of a run.

    A contact that starts closed stores its present rate of penetration, unless it goes on from another run.
    """
    modes = branch.modes
    for k in range(system.contacts.size):
        contact = system.contacts[k]
        if contact.impact_slot >= 0 and branch.impact_speeds[contact.impact_slot] <= contact.floor:
            store_impact_speed(system, k, loads.contacts[k, RATE], branch)
    for i in range(system.rotors.size):
        modes[ramp_of(system, modes, i)] = 1 if t < system.rotors[i].ramp_time else 0
    update_modes(system, t, y, branch, loads)
    for e in range(system.elements.size):
        if dispatch.takes_samples(system, e):
            dispatch.initialise(system, e, t, y, branch, loads)


@compiled
def mark_separating(system: System, branch: Branch, loads: Loads) -> bool:
    """Mark contacts that would pull as separating, after `update_modes`; return whether there are any."""
    pulls = False
    for k in range(system.contacts.size):
        if branch.modes[k] == LOADED and loads.contacts[k, MARGIN] < 0.0:
            branch.modes[k] = SEPARATING
            pulls = True
    return pulls


@compiled
def switch_mode(system: System, s: int, t: float, y: Floats, branch: Branch, loads: Loads) -> None:
    """Apply switch s: change the mode that it guards."""
    switch, modes = system.switches[s], branch.modes
    e, k = switch.element, switch.contact
    if switch.role == TOUCH:  # a penetration crossed zero
        if modes[k] == OPEN:
            store_impact_speed(system, k, loads.contacts[k, RATE], branch)
            modes[k] = LOADED
            dispatch.initialise_touch(system, e, k, t, y, branch, loads)
        else:
            modes[k] = OPEN
        update_partners(system, e, branch, loads)
    elif switch.role == PULL:  # the formula's force crossed zero while touching
        if modes[k] != OPEN:
            modes[k] = SEPARATING if modes[k] == LOADED else LOADED
    else:
        dispatch.switch_own(system, e, switch.local, t, y, branch, loads)
