"""What a run leaves behind: sampled rows, contact tallies, the log of contacts."""

import numpy as np
from numpy.typing import NDArray

from gearplay.kernels.compiled import compiled
from gearplay.kernels.flight import fly
from gearplay.kernels.layout import FLYING, FORCE, LOADED, OPEN, PENETRATION, RATE, System
from gearplay.kernels.motion import right_hand_side
from gearplay.kernels.observe import observe_mesh, observe_rotor, observe_sleeve
from gearplay.kernels.run_state import (
    DEPTH_MAX,
    FORCE_MAX,
    FORCES,
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
    TIME,
    Motion,
    T,
)
from gearplay.kernels.runge_kutta import interpolate

Floats = NDArray[np.float64]


@compiled
def record_samples(system: System, motion: Motion, h: float, t_new: float) -> None:
    """Write the samples of all times up to t_new: from the step's interpolant, or from the flights."""
    clock, counts, roster, y = motion.clock, motion.counts, motion.roster, motion.y_try
    while counts[NEXT_SAMPLE] <= counts[LAST_SAMPLE]:
        t = clock[SAMPLE_START] + counts[NEXT_SAMPLE] * clock[SAMPLE_INTERVAL]
        if t > t_new:
            break
        for c in range(1, motion.wanted_rotors[0] + 1):
            i = motion.wanted_rotors[c]
            if roster.roles[i] == FLYING:
                fly(system, i, t - roster.since[i], roster.origin, y)
        if roster.active[0] > 0:
            x = min(max((t - clock[T]) / h, 0.0), 1.0)
            interpolate(roster, x, h, motion.y, motion.y_new, motion.stages, y)
            if counts[FORCES] == 1:
                right_hand_side(
                    system,
                    roster,
                    t,
                    y,
                    motion.modes,
                    motion.latch,
                    motion.dy_try,
                    motion.contacts_try,
                    motion.force,
                    motion.out,
                )
        for c in range(1, motion.wanted_rotors[0] + 1):
            observe_rotor(system, motion, motion.wanted_rotors[c], t)
        for c in range(1, motion.wanted_sleeves[0] + 1):
            observe_sleeve(system, motion, motion.wanted_sleeves[c], t)
        for c in range(1, motion.wanted_meshes[0] + 1):
            observe_mesh(system, motion, motion.wanted_meshes[c], t)
        for c in range(motion.columns.size):
            motion.rows[c, counts[ROWS]] = motion.row[motion.columns[c]]
        counts[ROWS] += 1
        counts[NEXT_SAMPLE] += 1


@compiled
def tally_step(motion: Motion, h: float) -> None:
    """Add one accepted step to the contact statistics."""
    roster = motion.roster
    for c in range(1, roster.sleeves[0] + 1):
        tally_contact(motion, roster.sleeves[c], h)
    first = motion.latch.size
    for c in range(1, roster.meshes[0] + 1):
        for flank in range(2):
            tally_contact(motion, first + 2 * roster.meshes[c] + flank, h)


@compiled
def tally_contact(motion: Motion, k: int, h: float) -> None:
    """Add h [s] to contact k's time if it touches, and note its largest force and depth."""
    if motion.modes[k] == OPEN:
        return
    tally = motion.tallies[k]
    tally[TIME] += h
    tally[FORCE_MAX] = max(tally[FORCE_MAX], motion.contacts[k, FORCE])
    tally[DEPTH_MAX] = max(tally[DEPTH_MAX], motion.contacts[k, PENETRATION])


@compiled
def tally_change(motion: Motion, t: float, k: int, mode_before: int) -> None:
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
