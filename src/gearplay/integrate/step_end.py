"""End of an accepted step: mode changes, and values that are kept for the next step."""

from gearplay.integrate import dispatch
from gearplay.integrate.events import DEEPEST
from gearplay.integrate.restart import change_mode, check_state
from gearplay.integrate.run import DONE, FIXED, MISSED_SWITCH, STEPS, TOLERANCE, Run, T
from gearplay.integrate.runge_kutta import STAGES
from gearplay.integrate.sampling import record_samples, sample_is_due
from gearplay.integrate.tallies import tally_step
from gearplay.kernels.arrays import Floats
from gearplay.kernels.compiled import compiled, compiled_inline
from gearplay.kernels.compiled_once import compiled_once
from gearplay.kernels.layout import FORCE, MARGIN, PENETRATION, RATE, TOUCH, System


@compiled_once
def change_modes(system: System, run: Run, t: float, first: int) -> None:
    """Apply switch ``first`` and every other one that is positive at the same state."""
    for c in range(1, run.active_set.switches[0] + 1):
        s = run.active_set.switches[c]
        if s == first or (run.g_1[s] > 0.0 and run.g_0[s] <= 0.0):
            change_mode(system, run, s, t, run.y_new, run.loads)


@compiled_inline
def misses_touch(system: System, run: Run, first: int) -> bool:
    """Return whether a contact was open though it pressed, or closed though it gaped, and no switch located where that began.

    By more than the error of a touch. Touches and releases are located (`events`), so the motion beyond it would be false: at a
    touch that comes late a spring appears compressed, with energy from nothing.
    """
    most = max(run.clock[TOLERANCE], DEEPEST)
    for c in range(1, run.active_set.switches[0] + 1):
        s = run.active_set.switches[c]
        if run.g_1[s] <= 0.0:
            continue
        switch = system.switches[s]
        if switch.role != TOUCH:
            continue
        limit = most * system.contacts[switch.contact].natural
        if run.g_1[s] > limit and (first < 0 or run.g_0[s] > limit):
            return True
    return False


@compiled_once
def accept(system: System, run: Run, h: float, t: float, first: int) -> int:
    """Accept the state at the end t [s] of a step of h [s] and apply its switches; return a status.

    ``first`` is the switch that ended the step, -1 for none.
    """
    active_set, status = run.active_set, DONE
    if run.clock[FIXED] == 0.0 and misses_touch(system, run, first):
        return MISSED_SWITCH
    if sample_is_due(run, t):
        record_samples(system, run, h, t)
    if run.tallies.shape[0] > 0:
        tally_step(system, run, h)
    run.counts[STEPS] += 1
    run.clock[T] = t
    if first >= 0:
        change_modes(system, run, t, first)
    for s in range(1, active_set.states[0] + 1):
        run.y[active_set.states[s]] = run.y_new[active_set.states[s]]
        status = max(status, check_state(run, active_set.states[s]))
    for c in range(1, active_set.acting[0] + 1):
        dispatch.end_step(system, active_set.acting[c], run.y, run.branch)
    for c in range(1, active_set.watched[0] + 1):
        dispatch.end_step(system, active_set.watched[c], run.y_new, run.branch)
    return status


@compiled_inline
def copy_contact(source: Floats, target: Floats, k: int) -> None:
    """Copy the values of contact k at the start of a step for the search for switches and peaks."""
    target[k, PENETRATION] = source[k, PENETRATION]
    target[k, RATE] = source[k, RATE]
    target[k, MARGIN] = source[k, MARGIN]
    target[k, FORCE] = source[k, FORCE]


@compiled
def go_on(system: System, run: Run) -> None:
    """Make the end of a step the start of the next, for active rotors and acting elements."""
    active_set = run.active_set
    for c in range(1, active_set.states[0] + 1):
        i = active_set.states[c]
        run.stages[0, i] = run.stages[STAGES - 1, i]
    for c in range(1, active_set.switches[0] + 1):
        s = active_set.switches[c]
        run.g_0[s] = run.g_1[s]
        if system.switches[s].role == TOUCH:
            copy_contact(run.loads.contacts, run.loads_0.contacts, system.switches[s].contact)
