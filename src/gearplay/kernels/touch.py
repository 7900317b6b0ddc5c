"""The next touch of rotors in flight: when it comes, and what it changes."""

import math

from gearplay.kernels.advancement import FAILS, TOUCHES
from gearplay.kernels.compiled import compiled_inline
from gearplay.kernels.compiled_once import compiled_once
from gearplay.kernels.elements import table
from gearplay.kernels.layout import OPEN, PENETRATION, RATE, TOUCH, System
from gearplay.kernels.restart import change_mode
from gearplay.kernels.roster import states_of
from gearplay.kernels.run import CALLS, CANNOT_MESH, CHATTER, DONE, NOT_FINITE, T_END, Run

BURST_LOOKS = 200_000  # at gaps within one flight: beyond it a contact hovers without touching


@compiled_inline
def something_is_due(run: Run, limit: float) -> bool:
    """Return whether a dormant element or a flight must be looked at before ``limit`` [s]."""
    first = limit
    for e in range(run.roster.due.size):
        first = min(first, run.roster.due[e])
    return bool(first < limit)


@compiled_once
def next_touch(system: System, run: Run, limit: float) -> tuple[int, float, int]:
    """Return the first dormant element that touches before ``limit`` [s], or a flight whose closed form ends there.

    Returns (its place in ``due``; time; status); the length of ``due`` and ``limit`` without one.
    """
    roster = run.roster
    nothing = roster.due.size
    for _ in range(BURST_LOOKS):
        first, t = nothing, limit
        for e in range(roster.due.size):
            if roster.due[e] < t:
                first, t = e, roster.due[e]
        if first >= system.elements.size:
            return first, t, DONE
        run.counts[CALLS] += 1
        states_of(system, roster, first, t, run.y, run.y_try)
        # Far enough ahead to be of use whatever comes next, near enough to end with the run.
        longest = run.clock[T_END] - t + 1e-9
        doing, span = table.stay_open(system, first, t, run.y_try, run.branch, longest, run.loads.out)
        if doing == FAILS:
            return first, t, CANNOT_MESH
        if doing == TOUCHES:
            return first, t, DONE
        if not math.isfinite(span):
            return first, t, NOT_FINITE
        roster.due[first] = t + max(span, 4e-16 * abs(t) + 1e-18)
    return nothing, limit, CHATTER


@compiled_once
def touch_down(system: System, run: Run, e: int, t: float) -> int:
    """Change the modes of dormant element e that touches at t [s]; return 1 where it cannot mesh."""
    y, contacts = run.y_try, run.loads.contacts
    states_of(system, run.roster, e, t, run.y, y)
    if table.press(system, e, t, y, run.branch, run.loads) != 0:
        return 1
    element = system.elements[e]
    for s in range(element.switch, element.switch + element.switches):
        k = system.switches[s].contact
        if system.switches[s].role != TOUCH or run.branch.modes[k] != OPEN:
            continue
        if contacts[k, PENETRATION] >= 0.0 and contacts[k, RATE] > 0.0:
            change_mode(system, run, s, t, y, run.loads)
    return 0
