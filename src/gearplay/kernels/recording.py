"""Samples of a run: rows of what is wanted, from the interpolant of a step; while all fly `flown` writes them."""

from gearplay.kernels.compiled import compiled_inline
from gearplay.kernels.compiled_once import compiled_once
from gearplay.kernels.elements import table
from gearplay.kernels.flown import accelerations, record_flights
from gearplay.kernels.layout import (
    ACTING,
    ACTIVE,
    AX,
    AY,
    DRIVE_TORQUE,
    FLYING,
    LOAD_TORQUE,
    OMEGA,
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
from gearplay.kernels.ripple import follow_ripple
from gearplay.kernels.roster import fly_listed
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
def observe_elements(system: System, run: Run, t: float) -> None:
    """Fill ``row`` for the wanted elements from y_try."""
    for c in range(1, run.wanted_elements[0] + 1):
        e = run.wanted_elements[c]
        acting = run.roster.doings[e] == ACTING
        table.observe(system, e, t, run.y_try, run.branch, run.loads_try, acting, run.row)
