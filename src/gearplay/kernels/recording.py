"""What a run leaves behind: sampled rows, contact tallies, the log of contacts."""

from gearplay.kernels.arrays import Floats
from gearplay.kernels.compiled import compiled_inline
from gearplay.kernels.compiled_once import compiled_once
from gearplay.kernels.elements import table
from gearplay.kernels.flight import SHORT, decay, flight_rates, short_decay
from gearplay.kernels.joined import joined_accelerations
from gearplay.kernels.layout import (
    ACTING,
    ACTIVE,
    AX,
    AY,
    DRIVE_TORQUE,
    FLYING,
    FORCE,
    LOAD_TORQUE,
    LOADED,
    OMEGA,
    OPEN,
    PENETRATION,
    PER_ROTOR,
    ROTOR_LOSS,
    THETA,
    VX,
    VY,
    System,
    X,
    Y,
    omega_of,
    signal_of,
    spin_of,
    turn_of,
    vx_of,
    vy_of,
    x_of,
    y_of,
)
from gearplay.kernels.right_hand_side import rates_of
from gearplay.kernels.ripple import follow_ripple, ripple
from gearplay.kernels.roster import copy_rotor, fly_listed, fly_on, state_of
from gearplay.kernels.run import (
    DEPTH_MAX,
    FORCE_MAX,
    FORCES,
    LAST_DEPTH,
    LAST_FORCE,
    LAST_SAMPLE,
    LAST_STEP,
    LOGGED,
    NEXT_SAMPLE,
    NOW_DEPTH,
    NOW_FORCE,
    ONSETS,
    ROWS,
    SAMPLE_INTERVAL,
    SAMPLE_START,
    SPEED_MAX,
    SPEED_SQUARES,
    SPEED_SUM,
    TIME,
    WEDGED,
    Run,
    T,
)
from gearplay.kernels.runge_kutta import interpolate
from gearplay.kernels.shaft_power import applied_torque, shaft_power
from gearplay.kernels.switches import is_overruled


@compiled_inline
def sample_is_due(run: Run, t_new: float) -> bool:
    """Return whether a sample time lies at or before t_new [s]."""
    clock, counts = run.clock, run.counts
    if counts[NEXT_SAMPLE] > counts[LAST_SAMPLE]:
        return False
    return bool(clock[SAMPLE_START] + counts[NEXT_SAMPLE] * clock[SAMPLE_INTERVAL] <= t_new)


@compiled_once
def record_samples(system: System, run: Run, h: float, t_new: float) -> None:
    """Write the samples of all times up to t_new: from the step's interpolant, or from the flights."""
    clock, counts, roster = run.clock, run.counts, run.roster
    while sample_is_due(run, t_new):
        t = clock[SAMPLE_START] + counts[NEXT_SAMPLE] * clock[SAMPLE_INTERVAL]
        if roster.active[0] == 0:
            record_flights(system, run, t_new)
            continue
        fly_listed(system, roster, run.wanted_rotors, t, run.y_try)
        x = min(max((t - clock[T]) / h, 0.0), 1.0)
        interpolate(roster, x, h, run.y, run.y_new, run.stages, run.y_try)
        if counts[FORCES] == 2:
            for i in range(system.rotors.size):
                if roster.roles[i] != ACTIVE:  # elements add to them all the same
                    run.loads_try.rotors[i, 2] = applied_torque(system, i, run.y_try)
            table.act(system, roster.joining, t, run.y_try, run.branch, run.loads_try, run.dy_try)
        if counts[FORCES] >= 1:
            rates_of(system, roster, t, run.y_try, run.branch, run.dy_try, run.loads_try)
        for c in range(1, run.wanted_rotors[0] + 1):
            observe_rotor(system, run, run.wanted_rotors[c], t)
        observe_elements(system, run, t)
        for c in range(run.columns.size):
            run.rows[c, counts[ROWS]] = run.row[run.columns[c]]
        counts[ROWS] += 1
        counts[NEXT_SAMPLE] += 1


@compiled_inline
def observe_elements(system: System, run: Run, t: float) -> None:
    """Fill ``row`` for the wanted elements from y_try."""
    for c in range(1, run.wanted_elements[0] + 1):
        e = run.wanted_elements[c]
        acting = run.roster.doings[e] == ACTING
        table.observe(system, e, t, run.y_try, run.branch, run.loads_try, acting, run.row)


@compiled_inline
def observe_rotor(system: System, run: Run, i: int, t: float) -> None:
    """Fill rotor i's signals in ``row`` from y_try, and from dy_try where it is integrated."""
    y, row, at = run.y_try, run.row, signal_of(i)
    if system.rotors[i].ripple_count > 0:
        follow_ripple(system, i, t, y)  # the interpolant of a step is not exact
    vx, vy, omega = vx_of(system, i), vy_of(system, i), omega_of(system, i)
    row[at + X], row[at + Y], row[at + THETA] = y[x_of(i)], y[y_of(i)], turn_of(system, i, t, y)
    row[at + VX], row[at + VY], row[at + OMEGA] = y[vx], y[vy], spin_of(system, i, y)
    a_x, a_y, alpha = 0.0, 0.0, 0.0
    if run.roster.roles[i] == ACTIVE:
        a_x, a_y, alpha = run.dy_try[vx], run.dy_try[vy], run.dy_try[omega]
    elif run.roster.roles[i] == FLYING:
        a_x, a_y, alpha = accelerations(system, run, i, t, y)
    row[at + AX], row[at + AY] = a_x, a_y
    if run.counts[FORCES] == 2:
        torque = run.loads_try.rotors[i, 2]
        row[at + DRIVE_TORQUE], row[at + LOAD_TORQUE], row[at + ROTOR_LOSS] = shaft_power(
            system, i, t, y, run.branch, torque, a_x, a_y, alpha
        )


@compiled_inline
def accelerations(system: System, run: Run, i: int, t: float, y: Floats) -> tuple[float, float, float]:
    """Return the accelerations [m/s^2, rad/s^2] of rotor i, in flight, at (t, y)."""
    r, roster, out = system.rotors[i], run.roster, run.loads_try.out
    out[0], out[1], out[2] = flight_rates(
        system, i, y[vx_of(system, i)], y[vy_of(system, i)], y[omega_of(system, i)]
    )
    if r.group >= 0:
        joined_accelerations(system, i, t - roster.since[i], roster.swing, out)
    if r.ripple_count > 0:
        _, _, out[2] = ripple(system, i, t)
    return out[0], out[1], out[2]


@compiled_inline
def record_flights(system: System, run: Run, t_new: float) -> None:
    """Write one block of samples up to t_new while every rotor flies: column by column, so that loops vectorise."""
    clock, counts, roster, times = run.clock, run.counts, run.roster, run.times
    count = 0
    while count < times.size and counts[NEXT_SAMPLE] + count <= counts[LAST_SAMPLE]:
        t = clock[SAMPLE_START] + (counts[NEXT_SAMPLE] + count) * clock[SAMPLE_INTERVAL]
        if t > t_new:
            break
        times[count] = t
        count += 1
    first, rotor_columns = counts[ROWS], PER_ROTOR * system.rotors.size
    for c in range(run.columns.size):
        if run.columns[c] < rotor_columns:
            fill_rotor_column(system, run, run.columns[c], run.rows[c, first : first + count])
    if run.wanted_elements[0] > 0:
        for s in range(count):
            fly_listed(system, roster, run.wanted_rotors, times[s], run.y_try)
            observe_elements(system, run, times[s])
            for c in range(run.columns.size):
                if run.columns[c] >= rotor_columns:
                    run.rows[c, first + s] = run.row[run.columns[c]]
    counts[ROWS] += count
    counts[NEXT_SAMPLE] += count


@compiled_inline
def fill_rotor_column(system: System, run: Run, column: int, samples: Floats) -> None:
    """Fill one rotor signal of a block of samples in flight (formulas and order of signals: `flight`, `layout`)."""
    i, signal = column // PER_ROTOR, column % PER_ROTOR
    r, roster, times = system.rotors[i], run.roster, run.times
    if signal > AY:
        fill_power_column(system, run, i, signal - DRIVE_TORQUE, samples)
        return
    if r.group >= 0:
        fill_joined_column(system, run, i, signal, samples)
        return
    axis = signal - AX if signal >= AX else signal % VX
    if axis == THETA and r.ripple_count > 0:
        for s in range(samples.size):
            theta, omega, _ = ripple(system, i, times[s])
            turned = r.nominal_speed * times[s] + theta
            samples[s] = turned if signal == THETA else r.nominal_speed + omega
        return
    since, source = 0.0, run.y
    a_x, a_y, alpha, gamma = 0.0, 0.0, 0.0, 0.0
    if roster.roles[i] == FLYING:
        since, source = roster.since[i], roster.origin
        v_x, v_y, omega = source[vx_of(system, i)], source[vy_of(system, i)], source[omega_of(system, i)]
        a_x, a_y, alpha = flight_rates(system, i, v_x, v_y, omega)
        gamma = r.drag * r.inv_inertia if axis == THETA else r.radial_damping * r.inv_mass
    a = a_x if axis == X else a_y if axis == Y else alpha
    x, v_0 = source[x_of(i) + axis], source[vx_of(system, i) + axis]
    turning = r.nominal_speed if axis == THETA else 0.0
    short = samples.size > 0 and gamma * (times[samples.size - 1] - since) < SHORT
    for s in range(samples.size):
        tau = times[s] - since
        z = gamma * tau
        if short:
            phi_2 = short_decay(z)
            phi_1 = 1.0 - z * phi_2
        else:
            phi_1, phi_2 = decay(z)
        if signal <= THETA:
            samples[s] = turning * times[s] + (x + tau * (v_0 + a * tau * phi_2))
        elif signal <= OMEGA:
            samples[s] = turning + (v_0 + a * tau * phi_1)
        else:
            samples[s] = a * (1.0 - z * phi_1)


@compiled_once
def fill_joined_column(system: System, run: Run, i: int, signal: int, samples: Floats) -> None:
    """Fill one signal up to accelerations of rotor i, which springs join to others, in a block of samples in flight."""
    y, row, at = run.y_try, run.row, signal_of(i)
    for s in range(samples.size):
        t = run.times[s]
        state_of(system, run.roster, i, t, run.y, y)
        row[at + THETA], row[at + OMEGA] = turn_of(system, i, t, y), spin_of(system, i, y)
        row[at + X], row[at + Y], row[at + VX], row[at + VY] = (
            y[x_of(i)], y[y_of(i)], y[vx_of(system, i)], y[vy_of(system, i)],
        )  # fmt: skip
        row[at + AX], row[at + AY] = 0.0, 0.0
        if run.roster.roles[i] == FLYING:
            row[at + AX], row[at + AY], _ = accelerations(system, run, i, t, y)
        samples[s] = row[at + signal]


@compiled_once
def fill_power_column(system: System, run: Run, i: int, which: int, samples: Floats) -> None:
    """Fill the drive torque, load torque or lost power of rotor i in a block of samples in flight."""
    y = run.y_try
    for s in range(samples.size):
        t = run.times[s]
        copy_rotor(system, i, run.y, y)
        alpha = 0.0
        if run.roster.roles[i] == FLYING:
            fly_on(system, run.roster, i, t, y)
            _, _, alpha = accelerations(system, run, i, t, y)
        if system.rotors[i].ripple_count > 0:
            alpha = follow_ripple(system, i, t, y)
        torque = applied_torque(system, i, y)
        if system.rotors[i].group >= 0:
            torque += joined_torque(system, run, i, t)
        found = shaft_power(system, i, t, y, run.branch, torque, 0.0, 0.0, alpha)
        samples[s] = found[0] if which == 0 else found[1] if which == 1 else found[2]


@compiled_once
def joined_torque(system: System, run: Run, i: int, t: float) -> float:
    """Return the torque [N m] at t [s] of those springs on rotor i that join it to others in flight."""
    y, loads = run.y_try, run.loads_try
    for j in range(system.rotors.size):
        if system.rotors[j].group == system.rotors[i].group:
            state_of(system, run.roster, j, t, run.y, y)
    loads.rotors[i, 2] = 0.0
    table.act(system, run.roster.joining, t, y, run.branch, loads, run.dy_try)
    return float(loads.rotors[i, 2])


@compiled_inline
def tally_step(system: System, run: Run, h: float) -> None:
    """Add one accepted step to the contact statistics."""
    for c in range(1, run.roster.acting[0] + 1):
        element = system.elements[run.roster.acting[c]]
        for k in range(element.contact, element.contact + element.contacts):
            tally_contact(system, run, k, h)


@compiled_inline
def peak_between(before: float, now: float, after: float, last: float, h: float) -> float:
    """Return the top of the parabola through three values, ``last`` and ``h`` apart, where the middle one is the highest.

    >>> peak_between(0.0, 3.0, 3.0, 1.0, 1.0), peak_between(3.0, 2.0, 1.0, 1.0, 1.0)
    (3.375, 2.0)
    """
    if now < before or now < after or before + after == 2.0 * now:
        return now
    rise, fall = (now - before) / last, (now - after) / h
    slope = (rise * h - fall * last) / (last + h)
    return now + 0.25 * slope * slope * (last + h) / (rise + fall)


@compiled_inline
def tally_contact(system: System, run: Run, k: int, h: float) -> None:
    """Add h [s] to contact k's time if it touches, and note its largest force and depth; or to that in which it should."""
    tally = run.tallies[k]
    if run.branch.modes[k] == OPEN:
        if run.loads.contacts[k, PENETRATION] > 0.0 and is_overruled(system, k, run.branch):
            tally[WEDGED] += h
        tally[LAST_STEP] = 0.0
        return
    tally[TIME] += h
    force, depth = run.loads.contacts[k, FORCE], run.loads.contacts[k, PENETRATION]
    highest, deepest, last = force, depth, tally[LAST_STEP]
    if last > 0.0:
        highest = max(highest, peak_between(tally[LAST_FORCE], tally[NOW_FORCE], force, last, h))
        deepest = max(deepest, peak_between(tally[LAST_DEPTH], tally[NOW_DEPTH], depth, last, h))
        tally[LAST_FORCE], tally[LAST_DEPTH] = tally[NOW_FORCE], tally[NOW_DEPTH]
    else:
        tally[LAST_FORCE] = run.loads_0.contacts[k, FORCE]
        tally[LAST_DEPTH] = run.loads_0.contacts[k, PENETRATION]
    tally[FORCE_MAX] = max(tally[FORCE_MAX], highest)
    tally[DEPTH_MAX] = max(tally[DEPTH_MAX], deepest)
    tally[LAST_STEP], tally[NOW_FORCE], tally[NOW_DEPTH] = h, force, depth


@compiled_inline
def tally_change(run: Run, t: float, k: int, mode_before: int, rate: float) -> None:
    """Log an onset or release of contact k at time t [s], at a rate of penetration [m/s], and count it."""
    now = run.branch.modes[k]
    if (mode_before == OPEN) == (now == OPEN):
        return
    if now == LOADED:
        tally = run.tallies[k]
        tally[ONSETS] += 1.0
        tally[SPEED_SUM] += rate
        tally[SPEED_SQUARES] += rate * rate
        tally[SPEED_MAX] = max(tally[SPEED_MAX], rate)
    row = run.log[run.counts[LOGGED]]
    row[0], row[1], row[2], row[3] = t, float(k), 1.0 if now == LOADED else 0.0, rate
    run.counts[LOGGED] += 1
