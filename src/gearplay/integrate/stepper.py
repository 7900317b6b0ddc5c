"""The hybrid integrator: closed-form free motion between contacts, embedded Runge-Kutta steps of bodies in contact.

An error estimate does not see a kink, so each step is searched for switches (docs/theory, "Events"). A step that
contains one is taken again so that it ends there, the mode changes, and the method starts afresh. Rotors that nothing touches
are not integrated; their next touch is found by conservative advancement (`advancement`). All state lives in the arrays of
`Run`: `advance` can return at any step and be called again without a trace in the result.
"""

import math

from gearplay.integrate import dispatch
from gearplay.integrate.active_set import state_of
from gearplay.integrate.events import end_at_switch, first_switch
from gearplay.integrate.fixed_steps import take_fixed_step
from gearplay.integrate.implicit import H_EXPLICIT, QUIET
from gearplay.integrate.local_tolerance import refine
from gearplay.integrate.method_choice import NOT_TAKEN, is_quiet, take_quiet_step
from gearplay.integrate.next_touch import apply_touch, next_touch, something_is_due
from gearplay.integrate.restart import begin, check_states, failure, restart
from gearplay.integrate.run import (
    BEGUN,
    CANNOT_MESH,
    DONE,
    ERROR_SHARE,
    FIXED,
    H_BEGIN,
    H_RESTART,
    LOGGED,
    NOT_FINITE,
    PAUSED,
    REJECTED,
    STEP_TOO_SMALL,
    STEPS,
    T_END,
    H,
    Run,
    T,
)
from gearplay.integrate.runge_kutta import ORDER, error_norm
from gearplay.integrate.sampling import record_samples, sample_is_due
from gearplay.integrate.step_end import accept, go_on
from gearplay.integrate.switches import switch_values
from gearplay.integrate.trial_step import attempt
from gearplay.kernels.compiled import compiled_inline
from gearplay.kernels.compiled_once import compiled_once
from gearplay.kernels.housing_motion import RATE, shakes
from gearplay.kernels.layout import ACTIVE, System, spin_of

GROWTH = 5.0  # of a step over the one before, at most


@compiled_inline
def longest_step(system: System, run: Run) -> float:
    """Return the longest step [s] that resolves every forcing term of acting and watched elements."""
    active_set, t, y = run.active_set, run.clock[T], run.y
    fastest = max(system.base[RATE], 1e-9) if shakes(system, t) else 1e-9
    for c in range(1, active_set.acting[0] + 1):
        fastest = max(fastest, dispatch.forcing_rate(system, active_set.acting[c], t, y))
    for c in range(1, active_set.watched[0] + 1):
        fastest = max(fastest, dispatch.forcing_rate(system, active_set.watched[c], t, y))
    for c in range(1, active_set.active[0] + 1):
        i = active_set.active[c]
        fastest = max(fastest, abs(spin_of(system, i, y)), system.rotors[i].ripple_rate)
    for c in range(1, active_set.near[0] + 1):
        i = active_set.near[c]
        fastest = max(fastest, system.rotors[i].ripple_rate, system.rotors[i].modal_rate)
    return 0.5 / fastest


@compiled_inline
def next_stop(run: Run) -> float:
    """Return the next time [s] that a step must not pass."""
    for i in range(run.stops.size):
        if run.stops[i] > run.clock[T]:
            return min(run.stops[i], run.clock[T_END])
    return run.clock[T_END]


@compiled_once
def take_flight(system: System, run: Run) -> int:
    """Fly, all rotors untouched, to the next touch or stop; return a status."""
    clock = run.clock
    stop = next_stop(run)
    e, t, status = next_touch(system, run, stop)
    if sample_is_due(run, t):
        record_samples(system, run, 1.0, t)
    run.counts[STEPS] += 1
    clock[T] = t
    if status != DONE:
        return status
    if e == run.active_set.due.size and (t < stop or stop >= clock[T_END]):
        return DONE  # it stays free, or the run ends
    return end_free_motion(system, run, e, t)


@compiled_inline
def learn_beginning(run: Run, h: float, growth: float, rejected: bool) -> None:
    """Learn from the first step after a switch, h [s] in the end, how long the next such step may be.

    It was as long as had been learnt, or longer ones were rejected; one that errs 2e-4 of what it may is far too short.
    """
    if rejected:
        run.clock[H_BEGIN] = max(h, run.clock[H_RESTART])
    elif growth >= GROWTH:
        run.clock[H_BEGIN] = 2.0 * h


@compiled_once
def take_step(system: System, run: Run) -> int:
    """Take one accepted step of the active rotors, with at most one switch at its end; return a status."""
    clock, counts, active_set = run.clock, run.counts, run.active_set
    refine(system, run)
    t, stop = clock[T], next_stop(run)
    h = min(clock[H], longest_step(system, run))
    begins = run.implicit.numbers[QUIET] == 0 and h == clock[H_BEGIN]
    touching = active_set.due.size
    if something_is_due(run, min(t + h, stop)):
        touching, t_touch, status = next_touch(system, run, min(t + h, stop))
        if status != DONE:
            return status
        if touching < active_set.due.size or t_touch < t + h:
            stop = min(stop, t_touch)
    elif is_quiet(system, run):
        for c in range(1, active_set.acting[0] + 1):
            dispatch.start_step(system, active_set.acting[c], t, run.y, run.branch)
        status = take_quiet_step(system, run, stop, 2.0 * longest_step(system, run))
        if status != NOT_TAKEN:
            return status
        h = min(clock[H], h)
    if stop - t <= 2e-15 * max(abs(t), 1e-6):  # nothing that a step could resolve
        clock[T] = stop
        if touching < active_set.due.size:
            return end_free_motion(system, run, touching, stop)
        return DONE if stop >= clock[T_END] else restart(system, run)
    for c in range(1, active_set.acting[0] + 1):
        dispatch.start_step(system, active_set.acting[c], t, run.y, run.branch)
    reason, rejected = STEP_TOO_SMALL, counts[REJECTED]
    while True:
        to_stop = h >= (stop - t) * (1.0 - 1e-12)
        if to_stop:
            h = stop - t
        if h <= 1e-15 * max(abs(t), 1e-6):
            return reason
        if attempt(system, run, h) != 0:
            reason = failure(system, run)
            counts[REJECTED] += 1
            h *= 0.25
            continue
        error = error_norm(active_set, h, run.stages, run.scale) / clock[ERROR_SHARE]
        if error <= 1.0:
            break
        reason = STEP_TOO_SMALL if math.isfinite(error) else NOT_FINITE
        counts[REJECTED] += 1
        h *= max(0.1, 0.9 * error ** (-1.0 / ORDER)) if math.isfinite(error) else 0.1
    most = GROWTH if counts[REJECTED] == rejected else 1.0
    growth = min(most, 0.9 * error ** (-1.0 / ORDER)) if error > 1e-12 else most

    t_new = stop if to_stop else t + h
    switch_values(system, active_set, t_new, run.y_new, run.branch, run.loads, run.g_1)
    first, place = first_switch(system, run, h, True)
    taken = h
    if first >= 0 and place < 1.0:
        first, taken = end_at_switch(system, run, h, first, place)
        if taken < 0.0:
            return failure(system, run)
        t_new = t + taken
        to_stop = False
    status = accept(system, run, taken, t_new, first)
    if status != DONE:
        return status
    if to_stop and touching < active_set.due.size:
        return end_free_motion(system, run, touching, t_new)
    if first >= 0 or (to_stop and stop < clock[T_END]):
        return restart(system, run)
    go_on(system, run)
    clock[H] = h * growth
    if begins and not to_stop:
        learn_beginning(run, h, growth, counts[REJECTED] > rejected)
    run.implicit.numbers[QUIET] += 1
    if not to_stop:
        run.implicit.sizes[H_EXPLICIT] = h
    return DONE


@compiled_once
def end_free_motion(system: System, run: Run, e: int, t: float) -> int:
    """Close the contact of dormant element e at t [s], or end a closed form, and restart; return a status."""
    if e < run.active_set.element_states.size and apply_touch(system, run, e, t) != 0:
        return CANNOT_MESH
    return restart(system, run)


@compiled_once
def synchronise(system: System, run: Run) -> int:
    """Evaluate y of every rotor at the present time; return a status. The closed forms keep their origins."""
    for i in range(system.rotors.size):
        if run.active_set.body_states[i] != ACTIVE:
            state_of(system, run.active_set, i, run.clock[T], run.y, run.y)
    return check_states(run)


@compiled_inline
def log_is_full(run: Run) -> bool:
    """Return whether the log may not hold all contact changes of another step."""
    return bool(run.counts[LOGGED] + 2 * run.g_0.size + 2 > run.log.shape[0])


@compiled_once
def advance(system: System, run: Run, steps: int) -> int:
    """Advance until T_END, for at most ``steps`` steps, or until the log is full; return a status."""
    clock = run.clock
    if run.counts[BEGUN] == 0:
        status = begin(system, run)
        if status != DONE:
            return status
    for _ in range(steps):
        if clock[T] >= clock[T_END]:
            return synchronise(system, run)
        if log_is_full(run):
            return PAUSED
        if run.active_set.active[0] == 0:
            status = take_flight(system, run)
        elif clock[FIXED] > 0.0:
            status = take_fixed_step(system, run, next_stop(run))
        else:
            status = take_step(system, run)
        if status != DONE:
            worse = synchronise(system, run)
            return status if worse == DONE else worse
    return synchronise(system, run) if clock[T] >= clock[T_END] else PAUSED
