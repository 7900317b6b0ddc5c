"""Samples of a run: rows of what is wanted, from steps and from flights."""

from gearplay.kernels.arrays import Floats
from gearplay.kernels.base_motion import COSINE, KIND, NONE, SINE, base_acceleration
from gearplay.kernels.compiled import compiled_inline
from gearplay.kernels.compiled_once import compiled_once
from gearplay.kernels.decay import SHORT, decay, short_decay
from gearplay.kernels.elements import table
from gearplay.kernels.flight import flight_rates, shaken_rates
from gearplay.kernels.joined import joined_accelerations
from gearplay.kernels.layout import (
    ACTING,
    ACTIVE,
    AX,
    AY,
    DRIVE_TORQUE,
    FLYING,
    LOAD_TORQUE,
    OMEGA,
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
    FORCES,
    LAST_SAMPLE,
    NEXT_SAMPLE,
    ROWS,
    SAMPLE_INTERVAL,
    SAMPLE_START,
    Run,
    T,
)
from gearplay.kernels.runge_kutta import interpolate
from gearplay.kernels.shaft_power import applied_torque, shaft_power
from gearplay.kernels.shaken import behind


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
    out[0], out[1], out[2] = shaken_rates(
        system, i, t, y[vx_of(system, i)], y[vy_of(system, i)], y[omega_of(system, i)]
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
    if roster.roles[i] == FLYING and axis != THETA and r.inv_mass > 0.0 and system.base[KIND] != NONE:
        add_shaking(system, axis, signal, gamma, since, times, samples)


@compiled_once
def add_shaking(
    system: System, axis: int, signal: int, gamma: float, since: float, times: Floats, samples: Floats
) -> None:
    """Add what the housing's motion makes of one signal of a free body, damped with gamma [1/s], that flies since then."""
    along = system.base[COSINE] if axis == X else system.base[SINE]
    for s in range(samples.size):
        way, speed = behind(system, gamma, since, times[s] - since)
        if signal <= THETA:
            samples[s] += along * way
        elif signal <= OMEGA:
            samples[s] += along * speed
        else:
            samples[s] -= along * (base_acceleration(system, times[s]) + gamma * speed)


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
