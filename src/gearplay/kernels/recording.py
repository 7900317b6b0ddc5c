"""What a run leaves behind: sampled rows, contact tallies, the log of contacts."""

import numpy as np
from numpy.typing import NDArray

from gearplay.kernels.compiled import compiled
from gearplay.kernels.layout import FORCE, LOADED, OPEN, PENETRATION, RATE, System
from gearplay.kernels.observe import observe, observe_rotors
from gearplay.kernels.run_state import (
    DEPTH_MAX,
    FORCE_MAX,
    LAST_SAMPLE,
    LOGGED,
    NEXT_SAMPLE,
    ONSETS,
    ROWS,
    SAMPLE_INTERVAL,
    SAMPLE_START,
    SPEED_MAX,
    SPEED_SQUARES,
    SPEED_SUM,
    STATES_ONLY,
    TIME,
    Motion,
    T,
)
from gearplay.kernels.runge_kutta import interpolate
from gearplay.kernels.switches import contact_count

Floats = NDArray[np.float64]


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
        if counts[STATES_ONLY] == 1:
            observe_rotors(system, t, motion.y_try, motion.row)
        else:
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
