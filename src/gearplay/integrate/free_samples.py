"""Samples in free motion of all bodies, in blocks of times and signal by signal, so that the loops vectorise.

First the states of the rotors that requested signals depend on, then signals that follow from one rotor's states, then powers
and the signals of elements, row by row.
"""

from gearplay.integrate import dispatch
from gearplay.integrate.active_set import state_of
from gearplay.integrate.run import LAST_SAMPLE, NEXT_SAMPLE, ROWS, SAMPLE_INTERVAL, SAMPLE_START, Run
from gearplay.integrate.shaft_power import applied_torque, braking, is_plain, lost_power, shaft_power
from gearplay.kernels.arrays import Floats
from gearplay.kernels.compiled import compiled_inline
from gearplay.kernels.compiled_once import compiled_once
from gearplay.kernels.decay import SHORT, decay, short_decay
from gearplay.kernels.free_motion import free_rates, shaken_rates
from gearplay.kernels.housing_motion import COSINE, KIND, NONE, SINE
from gearplay.kernels.housing_response import behind
from gearplay.kernels.joined import joined_accelerations
from gearplay.kernels.layout import (
    ACTING,
    AX,
    AY,
    DRIVE_TORQUE,
    FREE,
    LOAD_TORQUE,
    OMEGA,
    PER_ROTOR,
    ROTOR_LOSS,
    THETA,
    VX,
    VY,
    System,
    X,
    omega_of,
    signal_of,
    vx_of,
    vy_of,
    x_of,
)
from gearplay.kernels.prescribed import variation
from gearplay.kernels.sample_block import STATES_OF_ROTOR, place_rotor
from gearplay.parts.registry import SIGNAL_COUNTS


@compiled_inline
def record_free_motion(system: System, run: Run, t_new: float) -> None:
    """Write one block of samples up to t_new, every rotor free or prescribed."""
    counts = run.counts
    count = note_times(run, t_new)
    first, columns = counts[ROWS], run.columns
    for c in range(1, run.wanted_rotors[0] + 1):
        fill_states(system, run, run.wanted_rotors[c], count)
    left = 0
    for c in range(columns.size):
        i, signal = columns[c] // PER_ROTOR, columns[c] % PER_ROTOR
        if i >= system.rotors.size:
            continue
        samples = run.rows[c, first : first + count]
        if signal <= AY:
            fill_signal(system, run, i, signal, samples)
        elif is_plain(system, i):
            fill_power(system, run, i, signal, samples)
        else:
            left += 1
    if left > 0:
        fill_powers(system, run, first, count)
    for c in range(1, run.wanted_elements[0] + 1):
        fill_element(system, run, run.wanted_elements[c], first, count)
    counts[ROWS] += count
    counts[NEXT_SAMPLE] += count


@compiled_inline
def note_times(run: Run, t_new: float) -> int:
    """Fill ``times`` with those of the next samples [s] and return how many of them are due by t_new."""
    clock, counts, times = run.clock, run.counts, run.times
    left = min(times.size, counts[LAST_SAMPLE] + 1 - counts[NEXT_SAMPLE])
    for s in range(left):
        times[s] = clock[SAMPLE_START] + (counts[NEXT_SAMPLE] + s) * clock[SAMPLE_INTERVAL]
    while left > 0 and times[left - 1] > t_new:
        left -= 1
    return int(left)


@compiled_inline
def fill_states(system: System, run: Run, i: int, count: int) -> None:
    """Fill those of rotor i's states in a block that are needed, relative to its nominal turning."""
    at, r = STATES_OF_ROTOR * i, system.rotors[i]
    if r.group >= 0:
        fill_joined_states(system, run, i, count)
        return
    for k in range(STATES_OF_ROTOR):
        if run.needed[at + k] == 1:
            fill_free_state(system, run, i, k, run.free_states[at + k, 0:count])


@compiled_once
def fill_joined_states(system: System, run: Run, i: int, count: int) -> None:
    """Fill the states of a rotor in a block that springs join to others."""
    at, y, times, free_states = STATES_OF_ROTOR * i, run.y_try, run.times, run.free_states
    for s in range(count):
        state_of(system, run.active_set, i, times[s], run.y, y)
        for axis in range(VX):
            free_states[at + axis, s] = y[x_of(i) + axis]
            free_states[at + VX + axis, s] = y[vx_of(system, i) + axis]


@compiled_inline
def fill_free_state(system: System, run: Run, i: int, k: int, samples: Floats) -> None:
    """Fill the k-th of rotor i's six states in a block; no spring holds it (formulas: `free_motion`)."""
    r, active_set, times = system.rotors[i], run.active_set, run.times
    axis = k % VX
    if axis == THETA and r.varying == 1:
        for s in range(samples.size):
            theta, omega, _ = variation(system, i, times[s])
            samples[s] = theta if k == THETA else omega
        return
    if active_set.body_states[i] != FREE:
        value = run.y[x_of(i) + axis] if k < VX else run.y[vx_of(system, i) + axis]
        for s in range(samples.size):
            samples[s] = value
        return
    since, source = active_set.since[i], active_set.origin
    v_x, v_y, omega = source[vx_of(system, i)], source[vy_of(system, i)], source[omega_of(system, i)]
    a_x, a_y, alpha = free_rates(system, i, v_x, v_y, omega)
    gamma = r.drag * r.inv_inertia if axis == THETA else r.radial_damping * r.inv_mass
    a = alpha if axis == THETA else a_x if axis == X else a_y
    x, v = source[x_of(i) + axis], source[vx_of(system, i) + axis]
    short = samples.size > 0 and gamma * (times[samples.size - 1] - since) < SHORT
    for s in range(samples.size):
        tau = times[s] - since
        z = gamma * tau
        if short:
            phi_2 = short_decay(z)
            phi_1 = 1.0 - z * phi_2
        else:
            phi_1, phi_2 = decay(z)
        samples[s] = x + tau * (v + a * tau * phi_2) if k < VX else v + a * tau * phi_1
    if axis != THETA and r.inv_mass > 0.0 and system.base[KIND] != NONE:
        add_shaking(system, axis, k < VX, gamma, since, times, samples)


@compiled_once
def add_shaking(
    system: System, axis: int, of_place: bool, gamma: float, since: float, times: Floats, samples: Floats
) -> None:
    """Add the housing's part in place or velocity of a free body, damped with gamma [1/s], that is free since then."""
    along = system.base[COSINE] if axis == X else system.base[SINE]
    for s in range(samples.size):
        way, speed = behind(system, gamma, since, times[s] - since)
        samples[s] += along * (way if of_place else speed)


@compiled_inline
def fill_signal(system: System, run: Run, i: int, signal: int, samples: Floats) -> None:
    """Fill a signal of rotor i up to its accelerations in a block, from its states there."""
    if signal >= AX:
        fill_acceleration(system, run, i, signal - AX, samples)
        return
    state = run.free_states[STATES_OF_ROTOR * i + signal]
    nominal, times = system.rotors[i].nominal_speed, run.times
    if signal == THETA:
        for s in range(samples.size):
            samples[s] = nominal * times[s] + state[s]
    elif signal == OMEGA:
        for s in range(samples.size):
            samples[s] = nominal + state[s]
    else:
        for s in range(samples.size):
            samples[s] = state[s]


@compiled_inline
def fill_acceleration(system: System, run: Run, i: int, axis: int, samples: Floats) -> None:
    """Fill rotor i's acceleration along an axis in a block, from its states in the block."""
    r = system.rotors[i]
    if run.active_set.body_states[i] != FREE:
        for s in range(samples.size):
            samples[s] = 0.0
    elif r.group < 0 and system.base[KIND] == NONE:
        held = r.mass * r.inv_mass * system.gravity[axis]
        damping, speed = r.radial_damping * r.inv_mass, run.free_states[STATES_OF_ROTOR * i + VX + axis]
        for s in range(samples.size):
            samples[s] = held - damping * speed[s]
    else:
        times, free_states, y = run.times, run.free_states, run.y_try
        for s in range(samples.size):
            place_rotor(system, i, free_states, s, y)
            samples[s] = accelerations(system, run, i, times[s], y)[axis]


@compiled_once
def fill_power(system: System, run: Run, i: int, signal: int, samples: Floats) -> None:
    """Fill a torque or the lost power of rotor i, a plain one, in a block (formulas: `shaft_power`)."""
    r, at = system.rotors[i], STATES_OF_ROTOR * i
    times, v_x, v_y, turning = (
        run.times,
        run.free_states[at + VX],
        run.free_states[at + VY],
        run.free_states[at + OMEGA],
    )
    nominal, varies, inertia, given = r.nominal_speed, r.varying == 1, r.inertia, r.torque
    drag, friction, friction_speed, damping = r.drag, r.friction, r.friction_speed, r.radial_damping
    if signal == ROTOR_LOSS:
        for s in range(samples.size):
            spin = nominal + turning[s]
            samples[s] = lost_power(
                braking(drag, friction, friction_speed, spin), spin, damping, v_x[s], v_y[s]
            )
    elif signal == DRIVE_TORQUE and r.inv_inertia == 0.0:
        for s in range(samples.size):
            alpha = 0.0
            if varies:
                _, _, alpha = variation(system, i, times[s])
            torque = given - braking(drag, friction, friction_speed, nominal + turning[s])
            samples[s] = inertia * alpha - torque
    else:
        torque = r.drive_torque if signal == DRIVE_TORQUE else given - r.drive_torque
        for s in range(samples.size):
            samples[s] = torque


@compiled_inline
def accelerations(system: System, run: Run, i: int, t: float, y: Floats) -> tuple[float, float, float]:
    """Return the accelerations [m/s^2, rad/s^2] of the free rotor i at (t, y)."""
    r, active_set, out = system.rotors[i], run.active_set, run.loads_try.out
    out[0], out[1], out[2] = shaken_rates(
        system, i, t, y[vx_of(system, i)], y[vy_of(system, i)], y[omega_of(system, i)]
    )
    if r.group >= 0:
        joined_accelerations(system, i, t - active_set.since[i], active_set.modal_rates, out)
    if r.varying == 1:
        _, _, out[2] = variation(system, i, t)
    return out[0], out[1], out[2]


@compiled_once
def fill_powers(system: System, run: Run, first: int, count: int) -> None:
    """Fill torques and lost powers of rotors that are not plain in a block, row by row from the states there."""
    rotors, columns, powers = run.wanted_rotors, run.columns, PER_ROTOR * system.rotors.size
    for s in range(count):
        for c in range(1, rotors[0] + 1):
            place_rotor(system, rotors[c], run.free_states, s, run.y_try)
        for c in range(1, rotors[0] + 1):
            if not is_plain(system, rotors[c]):
                observe_power(system, run, rotors[c], run.times[s])
        for c in range(columns.size):
            column = columns[c]
            if column < powers and column % PER_ROTOR > AY and not is_plain(system, column // PER_ROTOR):
                run.rows[c, first + s] = run.row[column]


@compiled_once
def fill_element(system: System, run: Run, e: int, first: int, count: int) -> None:
    """Fill the signals of element e in a block of samples."""
    columns, shown, rows = run.columns, run.shown, run.rows
    acting = run.active_set.element_states[e] == ACTING
    dispatch.show(
        system, e, run.times, count, run.free_states, run.y_try, run.branch, run.loads_try, acting,
        run.scratch_memory, run.row, shown
    )  # fmt: skip
    at = system.elements[e].signal
    for c in range(columns.size):
        k = columns[c] - at
        if 0 <= k < SIGNAL_COUNTS[system.elements[e].kind]:
            for s in range(count):
                rows[c, first + s] = shown[k, s]


@compiled_inline
def observe_power(system: System, run: Run, i: int, t: float) -> None:
    """Fill rotor i's torques of drive and load and its lost power in ``row`` from y_try, in free motion."""
    y, row, at, alpha = run.y_try, run.row, signal_of(i), 0.0
    if system.rotors[i].varying == 1:  # else one whose drive is to be found does not accelerate
        _, _, alpha = variation(system, i, t)
    torque = applied_torque(system, i, y)
    if system.rotors[i].group >= 0:
        torque += joined_torque(system, run, i, t)
    row[at + DRIVE_TORQUE], row[at + LOAD_TORQUE], row[at + ROTOR_LOSS] = shaft_power(
        system, i, t, y, run.branch, torque, 0.0, 0.0, alpha
    )


@compiled_once
def joined_torque(system: System, run: Run, i: int, t: float) -> float:
    """Return the torque [N m] at t [s] of those springs on rotor i that join it to other free rotors, all of them in y_try."""
    loads = run.loads_try
    loads.rotors[i, 2] = 0.0
    dispatch.apply_forces(system, run.active_set.joining, t, run.y_try, run.branch, loads, run.dy_try)
    return float(loads.rotors[i, 2])
