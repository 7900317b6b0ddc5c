"""The integrator: embedded Runge-Kutta steps on smooth branches, restarted at every located switch.

An error estimate does not see a kink, so each step is searched for switches (docs/theory, "Events"). A step that
contains one is taken again so that it ends there, the mode changes, and the method starts afresh. All state lives
in the arrays of `Motion`: `advance` can return at any step and be called again without a trace in the result.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gearplay.kernels.compiled import compiled
from gearplay.kernels.layout import FORCE, LOADED, OPEN, PENETRATION, RATE, System
from gearplay.kernels.motion import right_hand_side
from gearplay.kernels.observe import observe
from gearplay.kernels.runge_kutta import ORDER, STAGES, error_norm, interpolate, step
from gearplay.kernels.switches import (
    contact_count,
    mode_count,
    settle_margins,
    settle_modes,
    switch_count,
    switch_mode,
    switch_values,
)

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

# Status of a run; the solver turns it into words.
DONE, PAUSED = 0, 1
NOT_FINITE, STEP_TOO_SMALL, CHATTER, CANNOT_MESH, BLOW_UP = 10, 11, 12, 13, 14

# Slots of Motion.clock [s] and Motion.counts.
T, H, T_END, SAMPLE_START, SAMPLE_INTERVAL, H_RESTART, BURST_START = 0, 1, 2, 3, 4, 5, 6
STEPS, REJECTED, EVENTS, CALLS, NEXT_SAMPLE, LAST_SAMPLE, ROWS, LOGGED, BURST = 0, 1, 2, 3, 4, 5, 6, 7, 8

# Columns of Motion.tallies, one row per contact.
TIME, ONSETS, SPEED_SUM, SPEED_SQUARES, SPEED_MAX, FORCE_MAX, DEPTH_MAX = 0, 1, 2, 3, 4, 5, 6

BURST_EVENTS = 10_000
FURTHEST = 1e9  # in units of the error scale's natural size: beyond it a run has blown up


class Motion(NamedTuple):
    """A run in progress, as plain arrays; made by `make_motion`."""

    clock: Floats  # [s], slots above
    counts: Ints
    y: Floats
    y_new: Floats
    y_try: Floats
    stages: Floats  # [7, state]
    dy_try: Floats
    modes: Ints
    latch: Floats  # [m/s], per sleeve
    contacts: Floats  # at the end of the last step tried
    contacts_0: Floats  # at its start
    contacts_try: Floats
    force: Floats
    out: Floats
    g_0: Floats
    g_1: Floats
    g_try: Floats
    scale: Floats  # allowed local error per state
    natural: Floats  # natural size per state
    stops: Floats  # [s], sorted times where the right-hand side jumps
    tallies: Floats
    columns: Ints  # which signals to keep
    row: Floats
    rows: Floats  # [capacity, columns] sampled signals
    log: Floats  # [capacity, 4] contact changes: time, contact, 1 onset / 0 release, rate [m/s]


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
        omega = system.rotors[m.driver].nominal_speed + motion.y[3 * (n + m.driver) + 2]
        fastest = max(fastest, abs(m.z_driver * omega) * m.highest_order)
    for i in range(n):
        omega = system.rotors[i].nominal_speed + motion.y[3 * (n + i) + 2]
        fastest = max(fastest, abs(omega))
    room = motion.rows.shape[0] - motion.counts[ROWS] - 2
    return min(0.5 / fastest, room * motion.clock[SAMPLE_INTERVAL])


@compiled
def next_stop(motion: Motion) -> float:
    """Return the next time [s] that a step must not pass."""
    for i in range(motion.stops.size):
        if motion.stops[i] > motion.clock[T]:
            return min(motion.stops[i], motion.clock[T_END])
    return motion.clock[T_END]


@compiled
def look(system: System, motion: Motion, h: float, x: float) -> bool:
    """Evaluate contacts and switches on the step's interpolant at t + x h; False where a pair cannot mesh."""
    t = motion.clock[T] + x * h
    interpolate(x, h, motion.y, motion.y_new, motion.stages, motion.y_try)
    motion.counts[CALLS] += 1
    failed = right_hand_side(
        system,
        t,
        motion.y_try,
        motion.modes,
        motion.latch,
        motion.dy_try,
        motion.contacts_try,
        motion.force,
        motion.out,
    )
    if failed != 0:
        return False
    switch_values(system, t, motion.y_try, motion.modes, motion.contacts_try, motion.g_try)
    return True


@compiled
def locate_root(system: System, motion: Motion, h: float, k: int, high: float, g_high: float) -> float:
    """Return the end x of the smallest bracket in (0, high] on which switch k turns positive (Illinois)."""
    low, g_low = 0.0, min(motion.g_0[k], 0.0)
    side = 0
    width = max(1e-14, 4e-16 * abs(motion.clock[T]) / h)
    for _ in range(80):
        if high - low <= width:
            break
        x = (low * g_high - high * g_low) / (g_high - g_low) if g_high > g_low else 0.5 * (low + high)
        if not (low + 0.25 * width < x < high - 0.25 * width):
            # The secant sits on an end: step off it by just more than the wanted width.
            x = low + 0.75 * width if x - low < high - x else high - 0.75 * width
        if not look(system, motion, h, x):
            return x
        g = motion.g_try[k]
        if g > 0.0:
            high, g_high = x, g
            if side == 1:
                g_low *= 0.5
            side = 1
        else:
            low, g_low = x, g
            if side == -1:
                g_high *= 0.5
            side = -1
    return high


@compiled
def locate_peak(system: System, motion: Motion, h: float, k: int) -> float:
    """Return the x in (0, 1) where penetration switch k peaks, by bisection on its rate, or 1 if it stays negative.

    Called only when the rate changes sign inside the step while both ends are negative: the grazing touch that
    looking at step ends alone would skip. Stops as soon as a positive value is seen.
    """
    sign = 1.0 if motion.modes[k] == OPEN else -1.0
    low, high = 0.0, 1.0
    reach = abs(motion.contacts_0[k, RATE]) + abs(motion.contacts[k, RATE])
    for _ in range(60):
        x = 0.5 * (low + high)
        if not look(system, motion, h, x):
            return 1.0
        if motion.g_try[k] > 0.0:
            return x
        if motion.g_try[k] + reach * (high - low) * h < 0.0:
            return 1.0
        if sign * motion.contacts_try[k, RATE] > 0.0:
            low = x
        else:
            high = x
        if high - low < 1e-10:
            break
    return 1.0


@compiled
def first_switch(system: System, motion: Motion, h: float) -> tuple[int, float]:
    """Return the first switch of the step just taken and its place x in (0, 1]; (-1, 1) without one."""
    n_c = contact_count(system)
    first, place = -1, 1.0
    for k in range(motion.g_0.size):
        high, g_high = place, motion.g_1[k]
        if first >= 0 and (motion.g_1[k] > 0.0 or k < n_c):
            if not look(system, motion, h, place):
                continue
            g_high = motion.g_try[k]
        if g_high > 0.0:
            # A switch that was never on its own side changes over at the end.
            x = high if motion.g_0[k] > 0.0 else locate_root(system, motion, h, k, high, g_high)
            if first < 0 or x < place:
                first, place = k, x
        elif k < n_c and motion.g_0[k] < 0.0:
            sign = 1.0 if motion.modes[k] == OPEN else -1.0
            if sign * motion.contacts_0[k, RATE] > 0.0 and sign * motion.contacts[k, RATE] < 0.0:
                peak = locate_peak(system, motion, h, k)
                if peak < place:
                    look(system, motion, h, peak)
                    first, place = k, locate_root(system, motion, h, k, peak, motion.g_try[k])
    return first, place


@compiled
def retake(system: System, motion: Motion, h: float, k: int, x: float) -> float:
    """Take the step again so that it ends just past switch k; return its length [s], or -1 on failure."""
    short = x * h
    nudge = max(1e-15 * h, 4e-16 * abs(motion.clock[T]))
    for _ in range(8):
        motion.counts[CALLS] += STAGES - 1
        failed = step(
            system,
            motion.clock[T],
            short,
            motion.y,
            motion.stages,
            motion.modes,
            motion.latch,
            motion.y_new,
            motion.contacts,
            motion.force,
            motion.out,
        )
        if failed != 0:
            return -1.0
        switch_values(
            system, motion.clock[T] + short, motion.y_new, motion.modes, motion.contacts, motion.g_1
        )
        if motion.g_1[k] >= 0.0 or motion.g_0[k] > 0.0:
            break
        # The interpolant was a little early: go on by what the rate asks for, and a little more each time.
        if k < contact_count(system) and abs(motion.contacts[k, RATE]) > 0.0:
            short += min(1.5 * abs(motion.g_1[k] / motion.contacts[k, RATE]), 0.01 * h)
        short += nudge
        nudge *= 8.0
    return short


@compiled
def record_samples(system: System, motion: Motion, h: float, t_new: float) -> None:
    """Write the rows of all sample times up to t_new from the step's interpolant."""
    clock, counts = motion.clock, motion.counts
    while counts[NEXT_SAMPLE] <= counts[LAST_SAMPLE] and counts[ROWS] < motion.rows.shape[0]:
        t = clock[SAMPLE_START] + counts[NEXT_SAMPLE] * clock[SAMPLE_INTERVAL]
        if t > t_new:
            break
        x = (t - clock[T]) / h
        interpolate(min(max(x, 0.0), 1.0), h, motion.y, motion.y_new, motion.stages, motion.y_try)
        observe(
            system,
            t,
            motion.y_try,
            motion.modes,
            motion.latch,
            motion.dy_try,
            motion.contacts_try,
            motion.force,
            motion.out,
            motion.row,
        )
        for c in range(motion.columns.size):
            motion.rows[counts[ROWS], c] = motion.row[motion.columns[c]]
        counts[ROWS] += 1
        counts[NEXT_SAMPLE] += 1


@compiled
def tally_step(system: System, motion: Motion, h: float) -> None:
    """Add one accepted step to the contact statistics."""
    for k in range(contact_count(system)):
        if motion.modes[k] != OPEN:
            tally = motion.tallies[k]
            tally[TIME] += h
            tally[FORCE_MAX] = max(tally[FORCE_MAX], motion.contacts[k, FORCE])
            tally[DEPTH_MAX] = max(tally[DEPTH_MAX], motion.contacts[k, PENETRATION])


@compiled
def tally_change(system: System, motion: Motion, t: float, k: int, mode_before: int) -> None:
    """Log an onset or release of contact k at time t [s] and count it."""
    now = motion.modes[k]
    if (mode_before == OPEN) == (now == OPEN):
        return
    rate = motion.contacts[k, RATE]
    if now == LOADED:
        tally = motion.tallies[k]
        tally[ONSETS] += 1.0
        tally[SPEED_SUM] += rate
        tally[SPEED_SQUARES] += rate * rate
        tally[SPEED_MAX] = max(tally[SPEED_MAX], rate)
    row = motion.log[motion.counts[LOGGED]]
    row[0], row[1], row[2], row[3] = t, float(k), 1.0 if now == LOADED else 0.0, rate
    motion.counts[LOGGED] += 1


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
        counts[CALLS] += STAGES - 1
        failed = step(
            system,
            t,
            h,
            motion.y,
            motion.stages,
            motion.modes,
            motion.latch,
            motion.y_new,
            motion.contacts,
            motion.force,
            motion.out,
        )
        if failed != 0:
            reason = CANNOT_MESH
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
        if counts[ROWS] + 4 > motion.rows.shape[0] or counts[LOGGED] + spare > motion.log.shape[0]:
            return PAUSED
        status = take_step(system, motion)
        if status != DONE:
            return status
    return DONE if clock[T] >= clock[T_END] else PAUSED


def make_motion(
    system: System,
    y_0: Floats,
    natural: Floats,
    restart_step: float,
    stops: Floats,
    columns: Ints,
    row_capacity: int,
    log_capacity: int,
    tolerance: float,
) -> Motion:
    """Allocate a run at t = 0 from initial state ``y_0``; ``natural`` are the states' natural sizes."""
    n, n_c, n_g = y_0.size, contact_count(system), switch_count(system)
    n_r = system.rotors.size
    signals = 8 * n_r + 3 * system.sleeves.size + 9 * system.meshes.size

    def table() -> Floats:
        return np.zeros((n_c, 6))

    clock = np.zeros(8)
    clock[H_RESTART] = restart_step
    clock[SAMPLE_INTERVAL] = np.inf
    counts = np.zeros(9, dtype=np.int64)
    counts[LAST_SAMPLE] = -1
    return Motion(
        clock=clock,
        counts=counts,
        y=np.array(y_0, dtype=np.float64),
        y_new=np.zeros(n),
        y_try=np.zeros(n),
        stages=np.zeros((STAGES, n)),
        dy_try=np.zeros(n),
        modes=np.zeros(mode_count(system), dtype=np.int64),
        latch=np.zeros(system.sleeves.size),
        contacts=table(),
        contacts_0=table(),
        contacts_try=table(),
        force=np.zeros((n_r, 3)),
        out=np.zeros(20),
        g_0=np.zeros(n_g),
        g_1=np.zeros(n_g),
        g_try=np.zeros(n_g),
        scale=tolerance * natural,
        natural=np.array(natural, dtype=np.float64),
        stops=np.array(stops, dtype=np.float64),
        tallies=np.zeros((n_c, 7)),
        columns=np.array(columns, dtype=np.int64),
        row=np.zeros(signals),
        rows=np.zeros((row_capacity, len(columns))),
        log=np.zeros((log_capacity, 4)),
    )
