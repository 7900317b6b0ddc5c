"""A support: springs and dampers on a rotor's centre and rotation, from the ground or a carrier (docs/theory, section 4).

No contact: it always acts, without stress where the rotor is at its nominal centre and at rotation 0. On a carrier its axes turn
with it, rates are those seen from there, and the reaction acts at the journal's centre, so that angular momentum is kept. Its
cubic spring has the potential k3 r^4 / 4 of the displacement r, alike in all directions.
"""

import math
from typing import Any

import numpy as np

from gearplay.kernels.arrays import Floats, Rows
from gearplay.kernels.carrier_motion import add_pair, carried
from gearplay.kernels.compiled import compiled_inline
from gearplay.kernels.compiled_once import compiled_once
from gearplay.kernels.layout import (
    PLACES,
    Branch,
    Loads,
    Signal,
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
from gearplay.parts.mount import Mount

KIND = 4
RECORD = np.dtype(
    [
        *PLACES,
        ("stiffness_x", "f8"),  # N/m
        ("stiffness_y", "f8"),
        ("stiffness_xy", "f8"),  # of the force along x by a displacement along y
        ("stiffness_yx", "f8"),
        ("cubic_stiffness", "f8"),  # N/m^3, isotropic
        ("damping_x", "f8"),  # N s/m
        ("damping_y", "f8"),
        ("damping_xy", "f8"),
        ("damping_yx", "f8"),
        ("torsional_stiffness", "f8"),  # N m/rad
        ("torsional_damping", "f8"),  # N m s/rad
        ("offset_x", "f8"),  # m, nominal centre from that of the carrier, at zero rotation
        ("offset_y", "f8"),
        (
            "misplaced_x",
            "f8",
        ),  # m, of the unstressed place beside the nominal centre, along the support's own axes
        ("misplaced_y", "f8"),
        ("journal", "i8"),  # rotor
        ("carrier", "i8"),  # rotor that carries it, -1 for the ground
    ],
    align=True,
)
SIGNALS = (
    Signal("support_force_x", "Fx", "N", "N", 1.0, "force of the support on the rotor along x", True),
    Signal("support_force_y", "Fy", "N", "N", 1.0, "force of the support on the rotor along y", True),
    Signal("support_torque", "T", "N m", "N m", 1.0, "torque of the support on the rotor", True),
    Signal("support_power_loss", "P", "W", "W", 1.0, "power lost in the support", True),
    Signal("support_deflection", "r", "m", "um", 1e6, "deflection of the support", True),
)
MEMORY: tuple[float, ...] = ()
MODES = 0
PER_CONTACT = 0

# Slots of the scratch and columns of a row of slopes: direction of the carrier's x axis, from its centre to the rotor's [m], its
# speed [rad/s], the velocity [m/s] seen from it, the force [N]; the torque [N m]; the displacement along the support's axes [m].
COSINE, SINE, ARM_X, ARM_Y, SPIN, V_X, V_Y, F_X, F_Y, TORQUE, ALONG, ACROSS = range(12)
SLOPES = 12


def recurrence_rates(system: System, speeds: Floats, frames: Floats) -> list[float]:
    """Return the angular frequencies [rad/s] with which uneven or off-centre supports turn in the frames of their rotors."""
    rates = []
    for each in system.records[KIND]:
        if each.carrier >= 0 and (not is_isotropic(each) or math.hypot(each.offset_x, each.offset_y) > 0.0):
            rates.append(abs(speeds[each.carrier] - frames[each.journal]))
    return rates


def is_isotropic(support: Any) -> bool:
    """Return whether a support is isotropic: k I + k' J, its damping too."""
    return bool(
        support["stiffness_x"] == support["stiffness_y"]
        and support["damping_x"] == support["damping_y"]
        and support["stiffness_xy"] == -support["stiffness_yx"]
        and support["damping_xy"] == -support["damping_yx"]
    )


def mounts(records: Any) -> list[Mount]:
    """Return the mounting of the rotors."""
    return [
        Mount(
            int(each["journal"]),
            int(each["carrier"]),
            (float(each["offset_x"]), float(each["offset_y"])),
            (float(each["misplaced_x"]), float(each["misplaced_y"])),
            isotropic=is_isotropic(each),
        )
        for each in records
    ]


@compiled_inline
def _force(support: Any, x: float, y: float, v_x: float, v_y: float) -> tuple[float, float]:
    """Return the linear force [N] along the support's own axes at a displacement [m] and a rate [m/s] along them."""
    f = -support.stiffness_x * x - support.damping_x * v_x
    g = -support.stiffness_y * y - support.damping_y * v_y
    f -= support.stiffness_xy * y + support.damping_xy * v_y
    g -= support.stiffness_yx * x + support.damping_yx * v_x
    return f, g


@compiled_inline
def load_support(system: System, n: int, t: float, y: Floats, out: Floats) -> None:
    """Fill ``out`` with the kinematics and the force of support n at (t, y)."""
    support = system.records[KIND][n]
    j, b = support.journal, support.carrier
    e_x, e_y, v_x, v_y = y[x_of(j)], y[y_of(j)], y[vx_of(system, j)], y[vy_of(system, j)]
    turn, spin = turn_of(system, j, t, y), spin_of(system, j, y)
    cosine, sine, arm_x, arm_y, base_spin = 1.0, 0.0, 0.0, 0.0, 0.0
    if b >= 0:
        base_turn = turn_of(system, b, t, y)
        base_spin = spin_of(system, b, y)
        shift_x, shift_y, cosine_1, sine = carried(base_turn, support.offset_x, support.offset_y, out)
        cosine = 1.0 + cosine_1
        away_x, away_y = e_x - y[x_of(b)], e_y - y[y_of(b)]
        e_x, e_y = away_x - shift_x, away_y - shift_y
        arm_x, arm_y = support.offset_x + away_x, support.offset_y + away_y
        v_x -= y[vx_of(system, b)] - base_spin * arm_y
        v_y -= y[vy_of(system, b)] + base_spin * arm_x
        turn -= base_turn
        spin -= base_spin
    # Along the support's own axes.
    along, across = (
        cosine * e_x + sine * e_y - support.misplaced_x,
        -sine * e_x + cosine * e_y - support.misplaced_y,
    )
    f, g = _force(support, along, across, cosine * v_x + sine * v_y, -sine * v_x + cosine * v_y)
    secant = support.cubic_stiffness * (along * along + across * across)
    f -= secant * along
    g -= secant * across
    out[ALONG], out[ACROSS] = along, across
    out[COSINE], out[SINE], out[ARM_X], out[ARM_Y] = cosine, sine, arm_x, arm_y
    out[SPIN], out[V_X], out[V_Y] = base_spin, v_x, v_y
    out[F_X], out[F_Y] = cosine * f - sine * g, sine * f + cosine * g
    out[TORQUE] = -support.torsional_stiffness * turn - support.torsional_damping * spin


@compiled_once
def apply_forces(
    system: System, n: int, t: float, y: Floats, branch: Branch, loads: Loads, dy: Floats
) -> int:
    """Add support n's force and torque to the sums on its rotors; return 0."""
    out, force = loads.out, loads.rotors
    support = system.records[KIND][n]
    load_support(system, n, t, y, out)
    j, b = support.journal, support.carrier
    reaction = -(out[TORQUE] + out[ARM_X] * out[F_Y] - out[ARM_Y] * out[F_X])
    add_pair(force, j, b, out[F_X], out[F_Y], out[TORQUE], reaction)
    return 0


@compiled_once
def linearise(system: System, n: int, t: float, y: Floats, branch: Branch, loads: Loads, row: Floats) -> int:
    """Fill support n's row of slopes at (t, y): its kinematics and its force; return 0."""
    load_support(system, n, t, y, loads.out)
    for k in range(SLOPES):
        row[k] = loads.out[k]
    return 0


@compiled_once
def add_change(
    system: System, n: int, row: Floats, z: Floats, branch: Branch, force: Rows, dz: Floats
) -> None:
    """Add the change of support n's force and torque by a change z of the state to ``force`` [rotor, (N, N, N m)]."""
    support = system.records[KIND][n]
    j, b = support.journal, support.carrier
    away_x, away_y, v_x, v_y = z[x_of(j)], z[y_of(j)], z[vx_of(system, j)], z[vy_of(system, j)]
    turn, spin = z[theta_of(j)], z[omega_of(system, j)]
    e_x, e_y, base_turn = away_x, away_y, 0.0
    arm_x, arm_y = row[ARM_X], row[ARM_Y]
    if b >= 0:
        base_turn, base_spin = z[theta_of(b)], z[omega_of(system, b)]
        away_x -= z[x_of(b)]
        away_y -= z[y_of(b)]
        # Seen from the carrier: its axes turn away below the arm and the velocity.
        e_x, e_y = away_x + base_turn * arm_y, away_y - base_turn * arm_x
        v_x += -z[vx_of(system, b)] + base_spin * arm_y + row[SPIN] * away_y + base_turn * row[V_Y]
        v_y += -z[vy_of(system, b)] - base_spin * arm_x - row[SPIN] * away_x - base_turn * row[V_X]
        turn -= base_turn
        spin -= base_spin
    cosine, sine = row[COSINE], row[SINE]
    x, y = cosine * e_x + sine * e_y, -sine * e_x + cosine * e_y
    f, g = _force(support, x, y, cosine * v_x + sine * v_y, -sine * v_x + cosine * v_y)
    along, across, cubic = row[ALONG], row[ACROSS], support.cubic_stiffness
    secant, radial = cubic * (along * along + across * across), 2.0 * cubic * (along * x + across * y)
    f -= secant * x + radial * along
    g -= secant * y + radial * across
    f_x = cosine * f - sine * g - base_turn * row[F_Y]
    f_y = sine * f + cosine * g + base_turn * row[F_X]
    torque = -support.torsional_stiffness * turn - support.torsional_damping * spin
    reaction = -(torque + arm_x * f_y - arm_y * f_x + away_x * row[F_Y] - away_y * row[F_X])
    add_pair(force, j, b, f_x, f_y, torque, reaction)


@compiled_once
def observe(
    system: System, n: int, t: float, y: Floats, branch: Branch, loads: Loads, acting: bool, row: Floats
) -> None:
    """Fill support n's signals of a full ``row`` at (t, y)."""
    support, out = system.records[KIND][n], loads.out
    at = support.signal
    load_support(system, n, t, y, out)
    row[at], row[at + 1], row[at + 2] = out[F_X], out[F_Y], out[TORQUE]
    along, across = (
        out[COSINE] * out[V_X] + out[SINE] * out[V_Y],
        -out[SINE] * out[V_X] + out[COSINE] * out[V_Y],
    )
    spin = spin_of(system, support.journal, y)
    if support.carrier >= 0:
        spin -= spin_of(system, support.carrier, y)
    row[at + 3] = support.damping_x * along * along + support.damping_y * across * across
    row[at + 3] += (support.damping_xy + support.damping_yx) * along * across
    # Of the stiffness the antisymmetric part stores nothing: what it takes is lost, or put in.
    whirl = 0.5 * (support.stiffness_xy - support.stiffness_yx)
    if whirl != 0.0:
        row[at + 3] += whirl * (out[ACROSS] * along - out[ALONG] * across)
    row[at + 3] += support.torsional_damping * spin * spin
    row[at + 4] = math.sqrt(out[ALONG] * out[ALONG] + out[ACROSS] * out[ACROSS])
