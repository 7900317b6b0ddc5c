"""Which smooth branch every contact is on, and the functions whose zeros end a branch.

The motion is piecewise smooth. A *mode* names the branch of a contact (OPEN, LOADED, or SEPARATING: touching without a force)
or of an element, a *switch* is a function that is negative while the branch holds and crosses zero upwards where it ends.
Touch and pull are alike for all contacts; the others belong to their elements.
"""

import numpy as np

from gearplay.kernels.arrays import Floats
from gearplay.kernels.compiled import compiled, compiled_inline
from gearplay.kernels.compiled_once import compiled_once
from gearplay.kernels.elements import table
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
from gearplay.kernels.roster import Roster

INACTIVE = -1.0


def make_memory(system: System) -> Floats:
    """Allocate what elements remember, shape [element, memory]: nothing yet."""
    kinds = system.elements["kind"].tolist()
    memory = np.zeros((len(kinds), MEMORY))
    for e, kind in enumerate(kinds):
        blank = table.KINDS[kind].file.MEMORY
        memory[e, : len(blank)] = blank
    return memory


def make_branch(system: System) -> Branch:
    """Allocate a branch: all contacts open, nothing latched, no angle known."""
    own = sum(table.KINDS[kind].file.MODES for kind in system.elements["kind"].tolist())
    modes = system.contacts.size + own + system.rotors.size
    latches = sum(latch >= 0 for latch in system.contacts["latch"].tolist())
    return Branch(
        modes=np.zeros(modes, dtype=np.int64),
        latch=np.zeros(latches),
        memory=make_memory(system),
        bends=np.zeros(3 * system.rotors.size),
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
    return table.own_switch(system, switch.element, switch.local, t, y, branch, loads)


@compiled_once
def switch_values(
    system: System, roster: Roster, t: float, y: Floats, branch: Branch, loads: Loads, g: Floats
) -> None:
    """Fill ``g`` with the roster's switch functions from the contact table of the same state."""
    for c in range(1, roster.switches[0] + 1):
        s = roster.switches[c]
        g[s] = switch_value(system, s, t, y, branch, loads)


@compiled_inline
def latch_speed(system: System, k: int, rate: float, branch: Branch) -> None:
    """Latch the impact speed [m/s] of contact k at an onset, floored, where its law needs one."""
    contact = system.contacts[k]
    if contact.latch >= 0:
        branch.latch[contact.latch] = max(rate, contact.floor)


@compiled_inline
def settle_partners(system: System, e: int, branch: Branch, loads: Loads) -> None:
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
def judge_modes(system: System, t: float, y: Floats, branch: Branch, loads: Loads) -> None:
    """Set the modes of contacts and elements from the state alone; neither ramps nor samples, which times decide."""
    for k in range(system.contacts.size):
        touches = system.contacts[k].closed == 1 or loads.contacts[k, PENETRATION] > 0.0
        branch.modes[k] = LOADED if touches else OPEN
    for e in range(system.elements.size):
        settle_partners(system, e, branch, loads)
        if not table.takes_samples(system, e):
            table.settle(system, e, t, y, branch, loads)


@compiled_once
def settle_modes(system: System, t: float, y: Floats, branch: Branch, loads: Loads) -> None:
    """Set every mode from the state alone; used once, at the start of a run.

    A contact that starts closed latches its present rate of penetration, unless it goes on from another run.
    """
    modes = branch.modes
    for k in range(system.contacts.size):
        contact = system.contacts[k]
        if contact.latch >= 0 and branch.latch[contact.latch] <= contact.floor:
            latch_speed(system, k, loads.contacts[k, RATE], branch)
    for i in range(system.rotors.size):
        modes[ramp_of(system, modes, i)] = 1 if t < system.rotors[i].ramp_time else 0
    judge_modes(system, t, y, branch, loads)
    for e in range(system.elements.size):
        if table.takes_samples(system, e):
            table.settle(system, e, t, y, branch, loads)


@compiled
def settle_margins(system: System, branch: Branch, loads: Loads) -> bool:
    """Mark contacts that would pull as separating, after `judge_modes`; return whether there are any."""
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
            latch_speed(system, k, loads.contacts[k, RATE], branch)
            modes[k] = LOADED
            table.settle_touch(system, e, k, t, y, branch, loads)
        else:
            modes[k] = OPEN
        settle_partners(system, e, branch, loads)
    elif switch.role == PULL:  # the formula's force crossed zero while touching
        if modes[k] != OPEN:
            modes[k] = SEPARATING if modes[k] == LOADED else LOADED
    else:
        table.switch_own(system, e, switch.local, t, y, branch, loads)
