"""What a run leaves behind: sampled rows, contact tallies, the log of contacts."""

import numpy as np
from numpy.typing import NDArray

from gearplay.kernels.compiled import compiled, compiled_inline
from gearplay.kernels.flight import SHORT, decay, flight_rates, short_decay
from gearplay.kernels.layout import FLYING, FORCE, LOADED, OPEN, PENETRATION, System
from gearplay.kernels.motion import right_hand_side
from gearplay.kernels.observe import observe_mesh, observe_rotor, observe_sleeve
from gearplay.kernels.ripple import ripple
from gearplay.kernels.roster import fly_listed
from gearplay.kernels.run_state import (
    DEPTH_MAX,
    FORCE_MAX,
    FORCES,
    LAST_SAMPLE,
    LOGGED,
    NEXT_SAMPLE,
    ONSETS,
    PER_ROTOR,
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


@compiled_inline
def sample_is_due(motion: Motion, t_new: float) -> bool:
    """Return whether a sample time lies at or before t_new [s]."""
    clock, counts = motion.clock, motion.counts
    t = clock[SAMPLE_START] + counts[NEXT_SAMPLE] * clock[SAMPLE_INTERVAL]
    return bool(counts[NEXT_SAMPLE] <= counts[LAST_SAMPLE] and t <= t_new)


@compiled
def record_samples(system: System, motion: Motion, h: float, t_new: float) -> None:
    """Write the samples of all times up to t_new: from the step's interpolant, or from the flights."""
    clock, counts, roster = motion.clock, motion.counts, motion.roster
    while sample_is_due(motion, t_new):
        t = clock[SAMPLE_START] + counts[NEXT_SAMPLE] * clock[SAMPLE_INTERVAL]
        if roster.active[0] == 0:
            record_flights(system, motion, t_new)
            continue
        fly_listed(system, roster, motion.wanted_rotors, t, motion.y_try)
        x = min(max((t - clock[T]) / h, 0.0), 1.0)
        interpolate(roster, x, h, motion.y, motion.y_new, motion.stages, motion.y_try)
        if counts[FORCES] == 1:
            right_hand_side(
                system,
                roster,
                t,
                motion.y_try,
                motion.modes,
                motion.latch,
                motion.dy_try,
                motion.contacts_try,
                motion.force,
                motion.out,
            )
        for c in range(1, motion.wanted_rotors[0] + 1):
            observe_rotor(system, motion, motion.wanted_rotors[c], t)
        observe_elements(system, motion, t)
        for c in range(motion.columns.size):
            motion.rows[c, counts[ROWS]] = motion.row[motion.columns[c]]
        counts[ROWS] += 1
        counts[NEXT_SAMPLE] += 1


@compiled_inline
def observe_elements(system: System, motion: Motion, t: float) -> None:
    """Fill ``row`` for the wanted sleeves and meshes from y_try."""
    for c in range(1, motion.wanted_sleeves[0] + 1):
        observe_sleeve(system, motion, motion.wanted_sleeves[c], t)
    for c in range(1, motion.wanted_meshes[0] + 1):
        observe_mesh(system, motion, motion.wanted_meshes[c], t)


@compiled_inline
def record_flights(system: System, motion: Motion, t_new: float) -> None:
    """Write one block of samples up to t_new while every rotor flies: column by column, so that loops vectorise."""
    clock, counts, roster, times = motion.clock, motion.counts, motion.roster, motion.times
    count = 0
    while count < times.size and counts[NEXT_SAMPLE] + count <= counts[LAST_SAMPLE]:
        t = clock[SAMPLE_START] + (counts[NEXT_SAMPLE] + count) * clock[SAMPLE_INTERVAL]
        if t > t_new:
            break
        times[count] = t
        count += 1
    first, rotor_columns = counts[ROWS], PER_ROTOR * system.rotors.size
    for c in range(motion.columns.size):
        if motion.columns[c] < rotor_columns:
            fill_rotor_column(system, motion, motion.columns[c], motion.rows[c, first : first + count])
    if motion.wanted_sleeves[0] + motion.wanted_meshes[0] > 0:
        for s in range(count):
            fly_listed(system, roster, motion.wanted_rotors, times[s], motion.y_try)
            observe_elements(system, motion, times[s])
            for c in range(motion.columns.size):
                if motion.columns[c] >= rotor_columns:
                    motion.rows[c, first + s] = motion.row[motion.columns[c]]
    counts[ROWS] += count
    counts[NEXT_SAMPLE] += count


@compiled_inline
def fill_rotor_column(system: System, motion: Motion, column: int, samples: Floats) -> None:
    """Fill one rotor signal of a block of samples in flight (formulas and order of signals: `flight`, `layout`)."""
    n, i, signal = system.rotors.size, column // PER_ROTOR, column % PER_ROTOR
    r, roster, times = system.rotors[i], motion.roster, motion.times
    axis = signal - 6 if signal >= 6 else signal % 3
    if axis == 2 and r.ripple_count > 0:
        for s in range(samples.size):
            theta, omega, _ = ripple(system, i, times[s])
            turned = r.nominal_speed * times[s] + theta
            samples[s] = turned if signal == 2 else r.nominal_speed + omega
        return
    since, source = 0.0, motion.y
    a_x, a_y, alpha, gamma = 0.0, 0.0, 0.0, 0.0
    if roster.roles[i] == FLYING:
        since, source = roster.since[i], roster.origin
        v = 3 * (n + i)
        a_x, a_y, alpha = flight_rates(system, i, source[v], source[v + 1], source[v + 2])
        gamma = r.drag * r.inv_inertia if axis == 2 else r.radial_damping * r.inv_mass
    a = a_x if axis == 0 else a_y if axis == 1 else alpha
    x, v_0 = source[3 * i + axis], source[3 * (n + i) + axis]
    turning = r.nominal_speed if axis == 2 else 0.0
    short = samples.size > 0 and gamma * (times[samples.size - 1] - since) < SHORT
    for s in range(samples.size):
        tau = times[s] - since
        z = gamma * tau
        if short:
            phi_2 = short_decay(z)
            phi_1 = 1.0 - z * phi_2
        else:
            phi_1, phi_2 = decay(z)
        if signal < 3:
            samples[s] = turning * times[s] + (x + tau * (v_0 + a * tau * phi_2))
        elif signal < 6:
            samples[s] = turning + (v_0 + a * tau * phi_1)
        else:
            samples[s] = a * (1.0 - z * phi_1)


@compiled_inline
def tally_step(motion: Motion, h: float) -> None:
    """Add one accepted step to the contact statistics."""
    roster = motion.roster
    for c in range(1, roster.sleeves[0] + 1):
        tally_contact(motion, roster.sleeves[c], h)
    first = motion.latch.size
    for c in range(1, roster.meshes[0] + 1):
        for flank in range(2):
            tally_contact(motion, first + 2 * roster.meshes[c] + flank, h)


@compiled_inline
def tally_contact(motion: Motion, k: int, h: float) -> None:
    """Add h [s] to contact k's time if it touches, and note its largest force and depth."""
    if motion.modes[k] == OPEN:
        return
    tally = motion.tallies[k]
    tally[TIME] += h
    tally[FORCE_MAX] = max(tally[FORCE_MAX], motion.contacts[k, FORCE])
    tally[DEPTH_MAX] = max(tally[DEPTH_MAX], motion.contacts[k, PENETRATION])


@compiled_inline
def tally_change(motion: Motion, t: float, k: int, mode_before: int, rate: float) -> None:
    """Log an onset or release of contact k at time t [s], at a rate of penetration [m/s], and count it."""
    now = motion.modes[k]
    if (mode_before == OPEN) == (now == OPEN):
        return
    if now == LOADED:
        tally = motion.tallies[k]
        tally[ONSETS] += 1.0
        tally[SPEED_SUM] += rate
        tally[SPEED_SQUARES] += rate * rate
        tally[SPEED_MAX] = max(tally[SPEED_MAX], rate)
    row = motion.log[motion.counts[LOGGED]]
    row[0], row[1], row[2], row[3] = t, float(k), 1.0 if now == LOADED else 0.0, rate
    motion.counts[LOGGED] += 1
