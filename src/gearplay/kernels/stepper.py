"""The hybrid integrator: closed-form flight between contacts, embedded Runge-Kutta steps of what is touched.

An error estimate does not see a kink, so each step is searched for switches (docs/theory, "Events"). A step that
contains one is taken again so that it ends there, the mode changes, and the method starts afresh. Rotors that nothing touches
are not integrated; their next touch is found by conservative advancement (`advancement`). All state lives in the arrays of
`Motion`: `advance` can return at any step and be called again without a trace in the result.
"""

import math

from gearplay.kernels.compiled import compiled, compiled_inline
from gearplay.kernels.events import attempt, first_switch, retake
from gearplay.kernels.fixed_steps import take_fixed_step
from gearplay.kernels.layout import ACTIVE, System
from gearplay.kernels.mesh import know_angles, mesh_phase
from gearplay.kernels.recording import record_samples, sample_is_due
from gearplay.kernels.restart import begin, check_states, failure, restart
from gearplay.kernels.roster import state_of
from gearplay.kernels.run_state import (
    BEGUN,
    CANNOT_MESH,
    DONE,
    FIXED,
    LOGGED,
    NOT_FINITE,
    PAUSED,
    REJECTED,
    STEP_TOO_SMALL,
    STEPS,
    T_END,
    H,
    Motion,
    T,
)
from gearplay.kernels.runge_kutta import ORDER, error_norm
from gearplay.kernels.step_end import accept, go_on
from gearplay.kernels.switches import switch_values
from gearplay.kernels.touch import next_touch, something_is_due, touch_down


@compiled_inline
def longest_step(system: System, motion: Motion) -> float:
    """Return the longest step [s] that still resolves every forcing term of what is integrated or watched."""
    n, roster = system.rotors.size, motion.roster
    fastest = 1e-9
    for watched in range(2):
        meshes = roster.watched_meshes if watched == 1 else roster.meshes
        for c in range(1, meshes[0] + 1):
            m = system.meshes[meshes[c]]
            _, rate = mesh_phase(m, system, motion.clock[T], motion.y)
            fastest = max(fastest, abs(rate) * m.highest_order)
    for c in range(1, roster.active[0] + 1):
        i = roster.active[c]
        omega = system.rotors[i].nominal_speed + motion.y[3 * (n + i) + 2]
        fastest = max(fastest, abs(omega), system.rotors[i].ripple_rate)
    for c in range(1, roster.near[0] + 1):
        fastest = max(fastest, system.rotors[roster.near[c]].ripple_rate)
    return 0.5 / fastest


@compiled_inline
def next_stop(motion: Motion) -> float:
    """Return the next time [s] that a step must not pass."""
    for i in range(motion.stops.size):
        if motion.stops[i] > motion.clock[T]:
            return min(motion.stops[i], motion.clock[T_END])
    return motion.clock[T_END]


@compiled
def take_flight(system: System, motion: Motion) -> int:
    """Fly, all rotors untouched, to the next touch or stop; return a status."""
    clock = motion.clock
    stop = next_stop(motion)
    e, t, status = next_touch(system, motion, stop)
    if sample_is_due(motion, t):
        record_samples(system, motion, 1.0, t)
    motion.counts[STEPS] += 1
    clock[T] = t
    if status != DONE:
        return status
    if e == motion.roster.due.size and stop >= clock[T_END]:
        return DONE
    return land(system, motion, e, t)


@compiled
def take_step(system: System, motion: Motion) -> int:
    """Take one accepted step of the active rotors, with at most one switch at its end; return a status."""
    clock, counts, roster = motion.clock, motion.counts, motion.roster
    t, stop = clock[T], next_stop(motion)
    h = min(clock[H], longest_step(system, motion))
    touching = roster.due.size
    if something_is_due(motion, min(t + h, stop)):
        touching, t_touch, status = next_touch(system, motion, min(t + h, stop))
        if status != DONE:
            return status
        if touching < roster.due.size:
            stop = t_touch
    if stop - t <= 2e-15 * max(abs(t), 1e-6):  # nothing that a step could resolve
        clock[T] = stop
        if touching < roster.due.size:
            return land(system, motion, touching, stop)
        return DONE if stop >= clock[T_END] else restart(system, motion)
    for c in range(1, roster.meshes[0] + 1):
        know_angles(system, roster.meshes[c], t, motion.y)
    reason, rejected = STEP_TOO_SMALL, counts[REJECTED]
    while True:
        to_stop = h >= (stop - t) * (1.0 - 1e-12)
        if to_stop:
            h = stop - t
        if h <= 1e-15 * max(abs(t), 1e-6):
            return reason
        if attempt(system, motion, h) != 0:
            reason = failure(motion)
            counts[REJECTED] += 1
            h *= 0.25
            continue
        error = error_norm(roster, h, motion.stages, motion.scale)
        if error <= 1.0:
            break
        reason = STEP_TOO_SMALL if math.isfinite(error) else NOT_FINITE
        counts[REJECTED] += 1
        h *= max(0.1, 0.9 * error ** (-1.0 / ORDER)) if math.isfinite(error) else 0.1
    most = 5.0 if counts[REJECTED] == rejected else 1.0
    growth = min(most, 0.9 * error ** (-1.0 / ORDER)) if error > 1e-12 else most

    t_new = stop if to_stop else t + h
    switch_values(system, roster, t_new, motion.y_new, motion.modes, motion.contacts, motion.g_1)
    first, place = first_switch(system, motion, h)
    taken = h
    if first >= 0 and place < 1.0:
        taken = retake(system, motion, h, first, place)
        if taken < 0.0:
            return CANNOT_MESH
        t_new = t + taken
        to_stop = False
    status = accept(system, motion, taken, t_new, first)
    if status != DONE:
        return status
    if to_stop and touching < roster.due.size:
        return land(system, motion, touching, t_new)
    if first >= 0 or (to_stop and stop < clock[T_END]):
        return restart(system, motion)
    go_on(system, motion)
    clock[H] = h * growth
    return DONE


@compiled
def land(system: System, motion: Motion, e: int, t: float) -> int:
    """Let dormant element e touch at t [s], or a flight's closed form end, and start afresh; return a status."""
    if e < motion.roster.doings.size and touch_down(system, motion, e, t) != 0:
        return CANNOT_MESH
    return restart(system, motion)


@compiled
def synchronise(system: System, motion: Motion) -> int:
    """Bring y up to the present time for every rotor; return a status. Flights go on from where they began."""
    for i in range(system.rotors.size):
        if motion.roster.roles[i] != ACTIVE:
            state_of(system, motion.roster, i, motion.clock[T], motion.y, motion.y)
    return check_states(motion)


@compiled_inline
def log_is_full(motion: Motion) -> bool:
    """Return whether the log may not hold all contact changes of another step."""
    return bool(motion.counts[LOGGED] + 2 * motion.g_0.size + 2 > motion.log.shape[0])


@compiled
def advance(system: System, motion: Motion, steps: int) -> int:
    """Advance until T_END, for at most ``steps`` steps, or until the log is full; return a status."""
    clock = motion.clock
    if motion.counts[BEGUN] == 0:
        status = begin(system, motion)
        if status != DONE:
            return status
    for _ in range(steps):
        if clock[T] >= clock[T_END]:
            return synchronise(system, motion)
        if log_is_full(motion):
            return PAUSED
        if motion.roster.active[0] == 0:
            status = take_flight(system, motion)
        elif clock[FIXED] > 0.0:
            status = take_fixed_step(system, motion, next_stop(motion))
        else:
            status = take_step(system, motion)
        if status != DONE:
            worse = synchronise(system, motion)
            return status if worse == DONE else worse
    return synchronise(system, motion) if clock[T] >= clock[T_END] else PAUSED
