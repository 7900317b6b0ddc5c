"""Samples of a run: rows of requested signals, from the interpolant of a step; `free_samples` fills them in free motion."""

from gearplay.integrate import dispatch
from gearplay.integrate.active_set import propagate_listed
from gearplay.integrate.free_samples import accelerations, record_free_motion
from gearplay.integrate.right_hand_side import rates_of
from gearplay.integrate.run import (
    FORCES,
    LAST_SAMPLE,
    NEXT_SAMPLE,
    ROWS,
    SAMPLE_INTERVAL,
    SAMPLE_START,
    Run,
    T,
)
from gearplay.integrate.shaft_power import applied_torque, shaft_power
from gearplay.integrate.trial_step import interpolate
from gearplay.kernels.compiled import compiled_inline
from gearplay.kernels.compiled_once import compiled_once
from gearplay.kernels.layout import (
    ACTING,
    ACTIVE,
    AX,
    AY,
    DRIVE_TORQUE,
    FREE,
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
from gearplay.kernels.prescribed import follow_drive


@compiled_inline
def sample_is_due(run: Run, t_new: float) -> bool:
    """Return whether a sample time lies at or before t_new [s]."""
    clock, counts = run.clock, run.counts
    if counts[NEXT_SAMPLE] > counts[LAST_SAMPLE]:
        return False
    return bool(clock[SAMPLE_START] + counts[NEXT_SAMPLE] * clock[SAMPLE_INTERVAL] <= t_new)


@compiled_once
def record_samples(system: System, run: Run, h: float, t_new: float) -> None:
    """Write the samples of all times up to t_new: from the step's interpolant, or from the closed form."""
    clock, counts, active_set = run.clock, run.counts, run.active_set
    while sample_is_due(run, t_new):
        t = clock[SAMPLE_START] + counts[NEXT_SAMPLE] * clock[SAMPLE_INTERVAL]
        if active_set.active[0] == 0:
            record_free_motion(system, run, t_new)
            continue
        propagate_listed(system, active_set, run.wanted_rotors, t, run.y_try)
        x = min(max((t - clock[T]) / h, 0.0), 1.0)
        interpolate(run, h, x)
        if counts[FORCES] == 2:
            for i in range(system.rotors.size):
                if active_set.body_states[i] != ACTIVE:  # elements add to them all the same
                    run.loads_try.rotors[i, 2] = applied_torque(system, i, run.y_try)
            dispatch.apply_forces(
                system, active_set.joining, t, run.y_try, run.branch, run.loads_try, run.dy_try
            )
        if counts[FORCES] >= 1:
            rates_of(system, active_set, t, run.y_try, run.branch, run.dy_try, run.loads_try)
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
    if system.rotors[i].varying == 1:
        follow_drive(system, i, t, y)  # the interpolant of a step is not exact
    vx, vy, omega = vx_of(system, i), vy_of(system, i), omega_of(system, i)
    row[at + X], row[at + Y], row[at + THETA] = y[x_of(i)], y[y_of(i)], turn_of(system, i, t, y)
    row[at + VX], row[at + VY], row[at + OMEGA] = y[vx], y[vy], spin_of(system, i, y)
    a_x, a_y, alpha = 0.0, 0.0, 0.0
    if run.active_set.body_states[i] == ACTIVE:
        a_x, a_y, alpha = run.dy_try[vx], run.dy_try[vy], run.dy_try[omega]
    elif run.active_set.body_states[i] == FREE:
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
        acting = run.active_set.element_states[e] == ACTING
        dispatch.observe(system, e, t, run.y_try, run.branch, run.loads_try, acting, run.row)
