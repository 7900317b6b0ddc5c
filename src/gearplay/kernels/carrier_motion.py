"""Motion of rotors relative to a rotating carrier, and forces between rotor and carrier."""

import math
from typing import Any

from gearplay.kernels.arrays import Floats, Rows
from gearplay.kernels.compiled import compiled_inline
from gearplay.kernels.layout import (
    LAST_COSINE_1,
    LAST_SINE,
    LAST_TURN,
    System,
    omega_of,
    spin_of,
    theta_of,
    turn_of,
    vx_of,
    vy_of,
    x_of,
    y_of,
)


@compiled_inline
def rotation(turn: float, out: Floats) -> tuple[float, float]:
    """Return cos - 1 and sin of an angle [rad]; the last one is kept in the scratch ``out``, as all planets of a set need it.

    By the half angle: displacements must not cancel against 1.

    >>> import numpy as np
    >>> from gearplay.kernels.layout import OUT_SIZE
    >>> float(rotation(math.pi, np.zeros(OUT_SIZE))[0])
    -2.0
    """
    if out[LAST_TURN] != turn:
        cosine, sine = math.cos(0.5 * turn), math.sin(0.5 * turn)
        out[LAST_TURN], out[LAST_COSINE_1], out[LAST_SINE] = turn, -2.0 * sine * sine, 2.0 * sine * cosine
    return out[LAST_COSINE_1], out[LAST_SINE]


@compiled_inline
def carried(turn: float, x: float, y: float, out: Floats) -> tuple[float, float, float, float]:
    """Return the displacement [m] of a point (x, y) of a carrier that turns by an angle [rad], and `rotation` of the angle.

    >>> import numpy as np
    >>> from gearplay.kernels.layout import OUT_SIZE
    >>> float(carried(math.pi, 0.1, 0.0, np.zeros(OUT_SIZE))[0])
    -0.2
    """
    cosine_1, sine = rotation(turn, out)
    return cosine_1 * x - sine * y, sine * x + cosine_1 * y, cosine_1, sine


@compiled_inline
def seat_motion(
    system: System, part: Any, i: int, b: int, t: float, y: Floats, out: Floats
) -> tuple[float, float, float, float, float, float, float, float]:
    """Return the motion of rotor i relative to its seat in carrier b, -1 for the ground, along fixed axes.

    Displacement (x, y) [m] and velocity (x, y) [m/s]; arm (x, y) [m] of the seat on the carrier, the carrier's rotation [rad]
    and speed [rad/s], zero on the ground. ``part`` has the seat's ``offset_x``, ``offset_y`` from the carrier's centre and
    ``misplaced_x``, ``misplaced_y`` from the rotor's nominal centre [m].
    """
    e_x, e_y = y[x_of(i)] - part.misplaced_x, y[y_of(i)] - part.misplaced_y
    v_x, v_y = y[vx_of(system, i)], y[vy_of(system, i)]
    arm_x, arm_y, turn, spin = 0.0, 0.0, 0.0, 0.0
    if b >= 0:
        turn, spin = turn_of(system, b, t, y), spin_of(system, b, y)
        shift_x, shift_y, _, _ = carried(turn, part.offset_x, part.offset_y, out)
        arm_x, arm_y = part.offset_x + shift_x, part.offset_y + shift_y
        e_x -= y[x_of(b)] + shift_x
        e_y -= y[y_of(b)] + shift_y
        v_x -= y[vx_of(system, b)] - spin * arm_y
        v_y -= y[vy_of(system, b)] + spin * arm_x
    return e_x, e_y, v_x, v_y, arm_x, arm_y, turn, spin


@compiled_inline
def seat_motion_change(
    system: System, i: int, b: int, z: Floats, arm_x: float, arm_y: float, spin_b: float
) -> tuple[float, float, float, float]:
    """Return the change by z of the displacement [m] and velocity [m/s] of `seat_motion`, given the seat's arm and speed."""
    e_x, e_y, v_x, v_y = z[x_of(i)], z[y_of(i)], z[vx_of(system, i)], z[vy_of(system, i)]
    if b >= 0:
        turn, spin = z[theta_of(b)], z[omega_of(system, b)]
        e_x -= z[x_of(b)] - arm_y * turn
        e_y -= z[y_of(b)] + arm_x * turn
        v_x -= z[vx_of(system, b)] - arm_y * spin - spin_b * arm_x * turn
        v_y -= z[vy_of(system, b)] + arm_x * spin - spin_b * arm_y * turn
    return e_x, e_y, v_x, v_y


@compiled_inline
def add_pair(force: Rows, i: int, b: int, f_x: float, f_y: float, torque: float, reaction: float) -> None:
    """Add a force [N] and a torque [N m] to the sums on rotor i; the opposite force and a ``reaction`` torque to those on b.

    Nothing is added to the ground, b = -1.
    """
    force[i, 0] += f_x
    force[i, 1] += f_y
    force[i, 2] += torque
    if b >= 0:
        force[b, 0] -= f_x
        force[b, 1] -= f_y
        force[b, 2] += reaction
