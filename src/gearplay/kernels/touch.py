"""The next touch of rotors in flight: when it comes, and what it changes."""

import math

from gearplay.kernels.advancement import FAILS, TOUCHES
from gearplay.kernels.compiled import compiled_inline
from gearplay.kernels.compiled_once import compiled_once
from gearplay.kernels.elements import table
from gearplay.kernels.joined import bound_joined
from gearplay.kernels.layout import FLYING, OPEN, PENETRATION, RATE, TOUCH, System, members
from gearplay.kernels.restart import change_mode
from gearplay.kernels.roster import states_of
from gearplay.kernels.run import CALLS, CANNOT_MESH, CHATTER, DONE, NOT_FINITE, T_END, Run

BURST_LOOKS = (
    200_000  # at gaps, one after the other: then the time that is cleared is told, or that a contact hovers
)
HOVER = 1e-9  # s that a look clears, in the mean, where a contact only hovers


@compiled_inline
def something_is_due(run: Run, limit: float) -> bool:
    """Return whether a dormant element or a flight must be looked at before ``limit`` [s]."""
    first = limit
    for e in range(run.roster.due.size):
        first = min(first, run.roster.due[e])
    return bool(first < limit)


@compiled_inline
def bound_accelerations(system: System, run: Run, e: int, t: float) -> None:
    """Fill bounds, from t [s] on, of what joined rotors of element e do in flight."""
    roster = run.roster
    for i in members(system, e):
        if i >= 0 and system.rotors[i].group >= 0 and roster.roles[i] == FLYING:
            bound_joined(system, i, t - roster.since[i], roster.swing, run.branch.bends)


@compiled_once
def next_touch(system: System, run: Run, limit: float) -> tuple[int, float, int]:
    """Return the first dormant element that touches before ``limit`` [s], or a flight whose closed form ends there.

    Returns (its place in ``due``; time; status); without one the length of ``due`` and the time until which all stay open,
    which is ``limit`` unless that takes too many looks.
    """
    roster = run.roster
    nothing, begun = roster.due.size, -1.0
    for _ in range(BURST_LOOKS):
        first, t = nothing, limit
        for e in range(roster.due.size):
            if roster.due[e] < t:
                first, t = e, roster.due[e]
        if first >= system.elements.size:
            return first, t, DONE
        if begun < 0.0:
            begun = t
        run.counts[CALLS] += 1
        states_of(system, roster, first, t, run.y, run.y_try)
        if system.joined.chains.size > 0:
            bound_accelerations(system, run, first, t)
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
    cleared = limit
    for e in range(roster.due.size):
        cleared = min(cleared, roster.due[e])
    return nothing, cleared, DONE if cleared - begun > BURST_LOOKS * HOVER else CHATTER


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
