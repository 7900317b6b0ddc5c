"""The integrator: embedded Runge-Kutta steps on smooth branches, restarted at every located switch.

An error estimate does not see a kink, so each step is searched for switches (docs/theory, "Events"). A step that
contains one is taken again so that it ends there, the mode changes, and the method starts afresh. All state lives
in the arrays of `Motion`: `advance` can return at any step and be called again without a trace in the result.
"""

import math

import numpy as np
from numpy.typing import NDArray

from gearplay.kernels.compiled import compiled
from gearplay.kernels.events import attempt, first_switch, retake
from gearplay.kernels.layout import System
from gearplay.kernels.mesh import follow_orbits, mesh_phase
from gearplay.kernels.motion import right_hand_side
from gearplay.kernels.recording import record_samples, tally_change, tally_step
from gearplay.kernels.run_state import (
    BLOW_UP,
    BURST,
    BURST_START,
    CALLS,
    CANNOT_MESH,
    CHATTER,
    DONE,
    EVENTS,
    H_RESTART,
    LOGGED,
    NOT_FINITE,
    PAUSED,
    REJECTED,
    ROWS,
    SAMPLE_INTERVAL,
    STEP_TOO_SMALL,
    STEPS,
    T_END,
    H,
    Motion,
    T,
)
from gearplay.kernels.runge_kutta import ORDER, STAGES, error_norm
from gearplay.kernels.switches import contact_count, settle_margins, settle_modes, switch_mode, switch_values

Floats = NDArray[np.float64]

BURST_EVENTS = 10_000
FURTHEST = 1e9  # in units of the error scale's natural size: beyond it a run has blown up


@compiled
def evaluate(system: System, motion: Motion, t: float) -> int:
    """Evaluate f, contacts and switches at (t, y) into row 0 of the stages and the ``_0`` tables."""
    motion.counts[CALLS] += 1
    failed = right_hand_side(
        system,
        t,
        motion.y,
        motion.modes,
        motion.latch,
        motion.stages[0],
        motion.contacts_0,
        motion.force,
        motion.out,
    )
    if failed == 0:
        switch_values(system, t, motion.y, motion.modes, motion.contacts_0, motion.g_0)
    return failed


@compiled
def begin(system: System, motion: Motion) -> int:
    """Find the modes of the initial state; return a status."""
    t = motion.clock[T]
    for k in range(system.sleeves.size):
        motion.latch[k] = system.sleeves[k].minimum_speed
    if evaluate(system, motion, t) != 0:
        return CANNOT_MESH
    settle_modes(system, t, motion.y, motion.modes, motion.contacts_0, motion.latch)
    evaluate(system, motion, t)
    settle_margins(system, motion.modes, motion.contacts_0)
    evaluate(system, motion, t)
    motion.clock[H] = motion.clock[H_RESTART]
    motion.clock[BURST_START] = t
    return DONE


@compiled
def longest_step(system: System, motion: Motion) -> float:
    """Return the longest step [s] that still resolves every forcing term and fits the sample buffer."""
    n = system.rotors.size
    fastest = 1e-9
    for j in range(system.meshes.size):
        m = system.meshes[j]
        _, rate = mesh_phase(m, system, motion.clock[T], motion.y)
        fastest = max(fastest, abs(rate) * m.highest_order)
    for i in range(n):
        omega = system.rotors[i].nominal_speed + motion.y[3 * (n + i) + 2]
        fastest = max(fastest, abs(omega))
    # Half the sample buffer, whatever its fill, so that emptying it leaves no trace in the steps.
    return min(0.5 / fastest, (motion.rows.shape[0] // 2) * motion.clock[SAMPLE_INTERVAL])


@compiled
def next_stop(motion: Motion) -> float:
    """Return the next time [s] that a step must not pass."""
    for i in range(motion.stops.size):
        if motion.stops[i] > motion.clock[T]:
            return min(motion.stops[i], motion.clock[T_END])
    return motion.clock[T_END]


@compiled
def change_modes(system: System, motion: Motion, t: float, first: int) -> None:
    """Apply switch ``first`` and every other one that is positive at the same state."""
    n_c = contact_count(system)
    for k in range(motion.g_1.size):
        if k != first and not (motion.g_1[k] > 0.0 and motion.g_0[k] <= 0.0):
            continue
        motion.counts[EVENTS] += 1
        before = motion.modes[:n_c].copy()
        switch_mode(system, k, t, motion.y_new, motion.modes, motion.contacts, motion.latch)
        for c in range(n_c):
            tally_change(system, motion, t, c, before[c])


@compiled
def check_state(motion: Motion) -> int:
    """Return a status for the present state: finite and within all reason."""
    for i in range(motion.y.size):
        if not math.isfinite(motion.y[i]):
            return NOT_FINITE
        if abs(motion.y[i]) > FURTHEST * motion.natural[i]:
            return BLOW_UP
    return DONE


@compiled
def take_step(system: System, motion: Motion) -> int:
    """Take one accepted step, with at most one switch at its end; return a status."""
    clock, counts = motion.clock, motion.counts
    t, stop = clock[T], next_stop(motion)
    h = min(clock[H], longest_step(system, motion))
    reason = STEP_TOO_SMALL
    while True:
        to_stop = h >= (stop - t) * (1.0 - 1e-12)
        if to_stop:
            h = stop - t
        if h <= 1e-15 * max(abs(t), 1e-6):
            return reason
        if attempt(system, motion, h) != 0:
            reason = CANNOT_MESH if np.all(np.isfinite(motion.y_new)) else NOT_FINITE
            counts[REJECTED] += 1
            h *= 0.25
            continue
        error = error_norm(h, motion.stages, motion.scale)
        if error <= 1.0:
            break
        reason = STEP_TOO_SMALL if math.isfinite(error) else NOT_FINITE
        counts[REJECTED] += 1
        h *= max(0.1, 0.9 * error ** (-1.0 / ORDER)) if math.isfinite(error) else 0.1
    growth = min(5.0, 0.9 * error ** (-1.0 / ORDER)) if error > 1e-12 else 5.0

    t_new = stop if to_stop else t + h
    switch_values(system, t_new, motion.y_new, motion.modes, motion.contacts, motion.g_1)
    first, place = first_switch(system, motion, h)
    taken = h
    if first >= 0 and place < 1.0:
        taken = retake(system, motion, h, first, place)
        if taken < 0.0:
            return CANNOT_MESH
        t_new = t + taken
        to_stop = False
    record_samples(system, motion, taken, t_new)
    tally_step(system, motion, taken)
    counts[STEPS] += 1
    clock[T] = t_new
    if first >= 0:
        change_modes(system, motion, t_new, first)
    motion.y[:] = motion.y_new
    follow_orbits(system, motion.y)
    status = check_state(motion)
    if status != DONE:
        return status
    if first >= 0 or (to_stop and stop < clock[T_END]):
        return restart(system, motion)
    motion.stages[0, :] = motion.stages[STAGES - 1]
    motion.contacts_0[:] = motion.contacts
    motion.g_0[:] = motion.g_1
    clock[H] = h * growth
    return DONE


@compiled
def restart(system: System, motion: Motion) -> int:
    """Evaluate the new branch, shorten the step and watch for endless chatter; return a status."""
    clock, counts = motion.clock, motion.counts
    n_r = system.rotors.size
    base = motion.modes.size - n_r
    for i in range(n_r):
        if clock[T] >= system.rotors[i].ramp_time:
            motion.modes[base + i] = 0
    if evaluate(system, motion, clock[T]) != 0:
        return CANNOT_MESH
    clock[H] = clock[H_RESTART]
    counts[BURST] += 1
    if counts[BURST] >= BURST_EVENTS:
        if clock[T] - clock[BURST_START] < 0.02 * BURST_EVENTS * clock[H_RESTART]:
            return CHATTER
        counts[BURST], clock[BURST_START] = 0, clock[T]
    return DONE


@compiled
def advance(system: System, motion: Motion, steps: int) -> int:
    """Advance until T_END, for at most ``steps`` steps, or until a buffer is full; return a status."""
    clock, counts = motion.clock, motion.counts
    spare = 2 * motion.g_0.size + 2
    for _ in range(steps):
        if clock[T] >= clock[T_END]:
            return DONE
        if (
            counts[ROWS] + motion.rows.shape[0] // 2 + 2 > motion.rows.shape[0]
            or counts[LOGGED] + spare > motion.log.shape[0]
        ):
            return PAUSED
        status = take_step(system, motion)
        if status != DONE:
            return status
    return DONE if clock[T] >= clock[T_END] else PAUSED
