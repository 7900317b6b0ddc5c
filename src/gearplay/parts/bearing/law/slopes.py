"""Slopes of a rolling bearing: the exact derivative of its forces, and of the gaps of its elements."""

import math
from typing import Any

from gearplay.kernels.arrays import Floats, Rows
from gearplay.kernels.carrier_motion import add_pair, seat_motion_change
from gearplay.kernels.compiled import compiled_inline
from gearplay.kernels.compiled_once import compiled_once
from gearplay.kernels.layout import (
    LOADED,
    Branch,
    Loads,
    System,
    omega_of,
    theta_of,
)
from gearplay.parts.bearing.law.forces import dents_inside, press
from gearplay.parts.bearing.law.record import (
    ACROSS,
    ALONG,
    ARM_X,
    ARM_Y,
    BEND,
    BY_A,
    BY_B,
    CAGE,
    CAGE_SPIN,
    DELTA,
    DELTA_RATE,
    E_X,
    E_Y,
    F_X,
    F_Y,
    KIND,
    PER_CONTACT,
    SPIN_A,
    SPIN_B,
    TURN_A,
    TURN_B,
    V_X,
    V_Y,
    C,
    S,
    next_element,
    place_element,
)
from gearplay.parts.bearing.law.surface import BY_PLACE, ROWS, dents, element_angle, ripples
from gearplay.parts.sleeve.force import signed_power

# Columns of a bearing's row of slopes: of force (x, y) and torques (rotor, carrier) by displacement (x, y), velocity (x, y),
# rotations and speeds of rotor and carrier; then the kinematics and the force.
BY_E, BY_V, BY_TURN, BY_SPIN, INPUTS = 0, 2, 4, 6, 8
KINEMATICS = 4 * INPUTS
SLOPE_F_X, SLOPE_F_Y = KINEMATICS + 12, KINEMATICS + 13
SLOPES = KINEMATICS + 14


@compiled_inline
def _add_column(
    row: Floats, at: int, out: Floats, along_u: float, across_u: float, torque_a: float, torque_b: float,
    arm_a: float, arm_b: float,
) -> None:  # fmt: skip
    """Add to column ``at`` of the slopes an element's change of force along and across its direction, and of its torques.

    ``torque_a`` and ``torque_b`` are F times the changes of the arms of the torques, ``arm_a`` and ``arm_b`` these arms.
    """
    row[at] -= along_u * out[C] - across_u * out[S]
    row[INPUTS + at] -= along_u * out[S] + across_u * out[C]
    row[2 * INPUTS + at] -= along_u * arm_a + torque_a
    row[3 * INPUTS + at] -= along_u * arm_b + torque_b


@compiled_once
def linearise(system: System, n: int, t: float, y: Floats, branch: Branch, loads: Loads, row: Floats) -> int:
    """Fill bearing n's row of slopes at (t, y), the exact derivative of `apply_forces` on a fixed mode; return 0."""
    press(system, n, t, y, branch, loads)
    out = loads.out
    bearing = system.records[KIND][n]
    for c in range(KINEMATICS):
        row[c] = 0.0
    for c in range(12):
        row[KINEMATICS + c] = out[c]
    row[SLOPE_F_X], row[SLOPE_F_Y] = out[F_X], out[F_Y]
    out[C], out[S] = math.cos(out[CAGE]), math.sin(out[CAGE])
    share_a, share_b, whole = bearing.share_a, bearing.share_b, bearing.cage_torque
    inside = dents_inside(bearing, branch)
    for at in range(bearing.contacts):
        next_element(bearing, system.terms, at, out)
        if branch.modes[bearing.contact + at] != LOADED:
            continue
        place_element(system, n, at, inside, out)
        delta, margin = out[DELTA], 1.0 + bearing.dissipation * out[DELTA_RATE]
        elastic = bearing.stiffness * signed_power(delta, bearing.exponent)
        stiff = math.sqrt(abs(delta)) if bearing.exponent == 1.5 else abs(delta) ** (bearing.exponent - 1.0)
        by_delta = bearing.stiffness * bearing.exponent * stiff * margin
        by_rate, force = elastic * bearing.dissipation, elastic * margin
        u_x, u_y, t_x, t_y = out[C], out[S], -out[S], out[C]
        sliding = out[V_X] * t_x + out[V_Y] * t_y
        spin, arm_a, arm_b = out[CAGE_SPIN], out[BY_A], out[BY_B]
        if whole == 0:
            arm_a, arm_b = 0.0, out[ACROSS]
        # By displacement: the penetration by u, its derivative by the cage's angle by t.
        for axis in range(2):
            u, v = (u_x, t_x) if axis == 0 else (u_y, t_y)
            change = by_delta * u + by_rate * v * spin
            a, b = (share_a * v, share_b * v) if whole == 1 else (0.0, v)
            _add_column(row, BY_E + axis, out, change, 0.0, force * a, force * b, arm_a, arm_b)
            _add_column(row, BY_V + axis, out, by_rate * u, 0.0, 0.0, 0.0, arm_a, arm_b)
        # By the rotation of a ring: of the cage by its share, of the surface by the relative rotation.
        for ring in range(2):
            share, sign = (share_a, 1.0) if ring == 0 else (share_b, -1.0)
            arm = out[BY_A] if ring == 0 else out[BY_B]
            by_cage, bend = -out[ALONG] * share, sign * out[BEND]
            rate = sliding * share + by_cage * spin + bend * (out[SPIN_A] - out[SPIN_B])
            change = by_delta * arm + by_rate * rate
            a, b = (share_a * by_cage + bend, share_b * by_cage - bend) if whole == 1 else (0.0, by_cage)
            _add_column(row, BY_TURN + ring, out, change, force * share, force * a, force * b, arm_a, arm_b)
            _add_column(row, BY_SPIN + ring, out, by_rate * arm, 0.0, 0.0, 0.0, arm_a, arm_b)
    if bearing.damping > 0.0:
        row[BY_V] -= bearing.damping
        row[INPUTS + BY_V + 1] -= bearing.damping
    return 0


@compiled_inline
def _motion_change(
    bearing: Any, system: System, row: Floats, z: Floats
) -> tuple[float, float, float, float, float, float, float, float]:
    """Return the derivative along z of the motion relative to the seat, in the order of the inputs of a slope."""
    i, b = bearing.rotor, bearing.carrier
    arm_x, arm_y, spin_b = row[KINEMATICS + ARM_X], row[KINEMATICS + ARM_Y], row[KINEMATICS + SPIN_B]
    e_x, e_y, v_x, v_y = seat_motion_change(system, i, b, z, arm_x, arm_y, spin_b)
    turn, spin = (z[theta_of(b)], z[omega_of(system, b)]) if b >= 0 else (0.0, 0.0)
    return e_x, e_y, v_x, v_y, z[theta_of(i)], turn, z[omega_of(system, i)], spin


@compiled_once
def crossing(system: System, n: int, s: int, row: Floats, z: Floats) -> tuple[float, float, float]:
    """Return the derivatives along z of the penetration of switch s of bearing n [m] and of its rate [m/s], and the rate.

    Of the switch of a dent: of the angle between the element and the dent's middle [rad] and of its rate [rad/s].
    """
    bearing, at = system.records[KIND][n], s // PER_CONTACT
    e_x, e_y, v_x, v_y, turn_a, turn_b, spin_a, spin_b = _motion_change(bearing, system, row, z)
    rolling = row[KINEMATICS + SPIN_A] - row[KINEMATICS + SPIN_B]
    if at >= bearing.contacts:
        rate = system.terms[bearing.dents + ROWS * (s - PER_CONTACT * bearing.contacts), 0]
        return rate * (turn_a - turn_b), rate * (spin_a - spin_b), rate * rolling
    cage, relative = row[KINEMATICS + CAGE], row[KINEMATICS + TURN_A] - row[KINEMATICS + TURN_B]
    angle = cage + element_angle(bearing, system.terms, at)
    u_x, u_y, t_x, t_y = math.cos(angle), math.sin(angle), -math.sin(angle), math.cos(angle)
    _, slope, bend = ripples(
        bearing, system.terms, at, cage, row[KINEMATICS + TURN_A], row[KINEMATICS + TURN_B]
    )
    _, dent_slope, dent_bend, _ = dents(bearing, system.terms, at, relative, BY_PLACE)
    slope, bend = slope + dent_slope, bend + dent_bend
    s_x, s_y, r_x, r_y = (
        row[KINEMATICS + E_X],
        row[KINEMATICS + E_Y],
        row[KINEMATICS + V_X],
        row[KINEMATICS + V_Y],
    )
    across = s_x * t_x + s_y * t_y
    by_a, by_b = bearing.share_a * across + slope, bearing.share_b * across - slope
    rate = r_x * u_x + r_y * u_y + by_a * row[KINEMATICS + SPIN_A] + by_b * row[KINEMATICS + SPIN_B]
    turn = bearing.share_a * turn_a + bearing.share_b * turn_b
    grown = e_x * t_x + e_y * t_y - (s_x * u_x + s_y * u_y) * turn
    faster = v_x * u_x + v_y * u_y + (r_x * t_x + r_y * t_y) * turn + by_a * spin_a + by_b * spin_b
    faster += grown * row[KINEMATICS + CAGE_SPIN] + bend * (turn_a - turn_b) * rolling
    return e_x * u_x + e_y * u_y + by_a * turn_a + by_b * turn_b, faster, rate


@compiled_once
def add_change(
    system: System, n: int, row: Floats, z: Floats, branch: Branch, force: Rows, dz: Floats
) -> None:
    """Add the change of bearing n's forces by a change z of the state to ``force`` [rotor, (N, N, N m)]."""
    bearing = system.records[KIND][n]
    i, b = bearing.rotor, bearing.carrier
    change = _motion_change(bearing, system, row, z)
    f_x, f_y, torque_a, torque_b = 0.0, 0.0, 0.0, 0.0
    for c in range(INPUTS):
        f_x += row[c] * change[c]
        f_y += row[INPUTS + c] * change[c]
        torque_a += row[2 * INPUTS + c] * change[c]
        torque_b += row[3 * INPUTS + c] * change[c]
    arm_x, arm_y = row[KINEMATICS + ARM_X], row[KINEMATICS + ARM_Y]
    add_pair(force, i, b, f_x, f_y, torque_a, torque_b - arm_x * f_y + arm_y * f_x)
    if b >= 0:
        force[b, 2] += z[theta_of(b)] * (arm_y * row[SLOPE_F_Y] + arm_x * row[SLOPE_F_X])
