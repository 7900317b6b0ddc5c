"""Prediction of the next contact of bodies in free motion, and the mode changes at it."""

import math

from gearplay.integrate import dispatch
from gearplay.integrate.active_set import states_of
from gearplay.integrate.restart import change_mode
from gearplay.integrate.run import AHEAD, CALLS, CANNOT_MESH, CHATTER, DONE, NOT_FINITE, T_END, Run
from gearplay.kernels.advancement import FAILS, TOUCHES
from gearplay.kernels.compiled import compiled_inline
from gearplay.kernels.compiled_once import compiled_once
from gearplay.kernels.joined import bound_joined
from gearplay.kernels.layout import FREE, OPEN, PENETRATION, RATE, TOUCH, System, members

BURST_LOOKS = 200_000  # evaluations of gaps; beyond it the cleared time is returned, or the status of a hovering contact
HOVER = 1e-9  # s cleared per evaluation, in the mean, below which a contact hovers


@compiled_inline
def something_is_due(run: Run, limit: float) -> bool:
    """Return whether a dormant element or a closed form must be evaluated before ``limit`` [s]."""
    first = limit
    for e in range(run.active_set.due.size):
        first = min(first, run.active_set.due[e])
    return bool(first < limit)


@compiled_inline
def bound_accelerations(system: System, run: Run, e: int, t: float) -> None:
    """Fill bounds, from t [s] on, of the free motion of joined rotors of element e."""
    active_set = run.active_set
    for i in members(system, e):
        if i >= 0 and system.rotors[i].group >= 0 and active_set.body_states[i] == FREE:
            bound_joined(
                system, i, t - active_set.since[i], active_set.modal_rates, run.branch.acceleration_bounds
            )


@compiled_once
def next_touch(system: System, run: Run, limit: float) -> tuple[int, float, int]:
    """Return the first dormant element that touches before ``limit`` [s], or the first closed form that ends there.

    Returns (its place in ``due``; time; status); without one the length of ``due`` and the time until which all stay open,
    which is ``limit`` unless that takes too many evaluations.
    """
    active_set = run.active_set
    nothing, begun = active_set.due.size, -1.0
    for _ in range(BURST_LOOKS):
        first, t = nothing, limit
        for e in range(active_set.due.size):
            if active_set.due[e] < t:
                first, t = e, active_set.due[e]
        if first >= system.elements.size:
            return first, t, DONE
        if begun < 0.0:
            begun = t
        run.counts[CALLS] += 1
        states_of(system, active_set, first, t, run.y, run.y_try)
        if system.joined.chains.size > 0:
            bound_accelerations(system, run, first, t)
        # Far enough ahead to be of use whatever comes next, near enough to end with the run.
        longest = run.clock[T_END] - t + run.clock[AHEAD]
        doing, span = dispatch.stay_open(system, first, t, run.y_try, run.branch, longest, run.loads.out)
        if doing == FAILS:
            return first, t, CANNOT_MESH
        if doing == TOUCHES:
            return first, t, DONE
        if not math.isfinite(span):
            return first, t, NOT_FINITE
        active_set.due[first] = t + max(span, 4e-16 * abs(t) + 1e-18)
    cleared = limit
    for e in range(active_set.due.size):
        cleared = min(cleared, active_set.due[e])
    return nothing, cleared, DONE if cleared - begun > BURST_LOOKS * HOVER else CHATTER


@compiled_once
def apply_touch(system: System, run: Run, e: int, t: float) -> int:
    """Change the modes of element e, open until now, that touches at t [s]; return 1 where its geometry fails."""
    y, contacts = run.y_try, run.loads.contacts
    states_of(system, run.active_set, e, t, run.y, y)
    if dispatch.contact_kinematics(system, e, t, y, run.branch, run.loads) != 0:
        return 1
    element = system.elements[e]
    for s in range(element.switch, element.switch + element.switches):
        k = system.switches[s].contact
        if system.switches[s].role != TOUCH or run.branch.modes[k] != OPEN:
            continue
        if contacts[k, PENETRATION] >= 0.0 and contacts[k, RATE] > 0.0:
            change_mode(system, run, s, t, y, run.loads)
    return 0
