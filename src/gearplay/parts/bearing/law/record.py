"""Packed record of a rolling bearing, its signals, and the kinematics of one of its elements (docs/theory, section 3)."""

import math
from typing import Any

import numpy as np

from gearplay.kernels.arrays import Floats
from gearplay.kernels.carrier_motion import seat_motion
from gearplay.kernels.compiled import compiled_inline
from gearplay.kernels.layout import PLACES, Signal, System, spin_of, turn_of
from gearplay.parts.bearing.law.surface import dents, is_uneven, ripples, row_of_element

KIND = 8
PER_CONTACT = 2  # switches: touch, pull
RECORD = np.dtype(
    [
        *PLACES,
        ("half_clearance", "f8"),  # m, half the radial internal clearance; negative: preload
        ("stiffness", "f8"),  # K of one element between both rings [N/m^n]
        ("exponent", "f8"),  # n
        ("dissipation", "f8"),  # chi of F = K d^n (1 + chi d') [s/m]
        ("share_a", "f8"),  # of the rotor's rotation in the cage's
        ("share_b", "f8"),  # of the carrier's rotation
        ("cage_phase", "f8"),  # rad, of element 0 at rotation 0 of both
        ("pitch_cosine", "f8"),  # of the angle between neighbours; both 0 for uneven places (`surface`)
        ("pitch_sine", "f8"),
        ("slope_a", "f8"),  # m, bounds of the waviness of the rotor's ring: sum of order A
        ("bend_a", "f8"),  # m, sum of order^2 A
        ("slope_b", "f8"),  # of the carrier's ring
        ("bend_b", "f8"),
        ("highest_a", "f8"),  # highest order
        ("highest_b", "f8"),
        ("damping", "f8"),  # N s/m, of the centre's motion against a carried seat
        ("offset_x", "f8"),  # m, seat on its carrier at zero rotation
        ("offset_y", "f8"),
        ("misplaced_x", "f8"),  # m, of the offset: beside the rotor's nominal centre
        ("misplaced_y", "f8"),
        ("waves_a", "i8"),  # first row of terms of the waviness of the rotor's ring
        ("count_a", "i8"),
        ("waves_b", "i8"),
        ("count_b", "i8"),
        ("dents", "i8"),  # first row of terms of the dents, two rows each (`surface`)
        ("dent_count", "i8"),
        ("dent_slope", "f8"),  # m, bounds of the dents by the relative rotation of the rings: sum of |d'|
        ("dent_bend", "f8"),  # m, sum of |d''|
        ("dent_travel", "f8"),  # rad, relative rotation in which an element passes the shortest dent
        ("cage_torque", "i8"),  # 1 where the rings give the power of the cage's motion
        ("rotor", "i8"),
        ("carrier", "i8"),  # -1 for the ground
    ],
    align=True,
)
SIGNALS = (
    Signal("bearing_force_x", "Fx", "N", "N", 1.0, "force of the bearing on the rotor along x"),
    Signal("bearing_force_y", "Fy", "N", "N", 1.0, "force of the bearing on the rotor along y"),
    Signal("bearing_torque", "T", "N m", "N m", 1.0, "torque of the bearing on the rotor"),
    Signal("bearing_element_load", "Q", "N", "N", 1.0, "largest load of an element of the bearing"),
    Signal("bearing_power_loss", "P", "W", "W", 1.0, "power lost in the bearing"),
    Signal("bearing_cage_power", "P", "W", "W", 1.0, "power that the imposed motion of the cage puts in"),
)

# Slots of the scratch: the rotor's displacement [m] and velocity [m/s] in the seat, angle [rad] and speed [rad/s] of the cage,
# those of rotor and carrier, the seat's arm on the carrier [m]; then, of one element, its direction (c, s), displacement along
# and across it [m], penetration [m], its derivatives by the rotations of cage, rotor and carrier [m] and by time [m/s],
# second derivatives of the waviness of the two rings by the angle [m].
E_X, E_Y, V_X, V_Y, CAGE, CAGE_SPIN, TURN_A, TURN_B, SPIN_A, SPIN_B, ARM_X, ARM_Y = range(12)
C, S, ALONG, ACROSS, DELTA, BY_A, BY_B, DELTA_RATE, BEND, DENT, DENT_SLOPE, DENTED = range(12, 24)
# Sums over the elements: force [N] and torque [N m] on rotor and carrier, power lost and put in by the cage [W].
F_X, F_Y, TORQUE_A, TORQUE_B, LOST, PUT_IN = range(24, 30)


@compiled_inline
def place_seat(system: System, n: int, t: float, y: Floats, out: Floats) -> None:
    """Fill ``out`` with the motion of rotor and cage of bearing n relative to its seat at (t, y).

    The cage turns by g_a theta_rotor + g_b theta_carrier, g_a = (1 - g)/2 and g_b = (1 + g)/2 where the rotor has the inner
    ring, g = D cos(alpha)/d_m: pure rolling.
    """
    bearing = system.records[KIND][n]
    i, b = bearing.rotor, bearing.carrier
    e_x, e_y, v_x, v_y, arm_x, arm_y, turn_b, spin_b = seat_motion(system, bearing, i, b, t, y, out)
    turn_a, spin_a = turn_of(system, i, t, y), spin_of(system, i, y)
    out[E_X], out[E_Y], out[V_X], out[V_Y] = e_x, e_y, v_x, v_y
    out[CAGE] = bearing.cage_phase + bearing.share_a * turn_a + bearing.share_b * turn_b
    out[CAGE_SPIN] = bearing.share_a * spin_a + bearing.share_b * spin_b
    out[TURN_A], out[TURN_B], out[SPIN_A], out[SPIN_B] = turn_a, turn_b, spin_a, spin_b
    out[ARM_X], out[ARM_Y] = arm_x, arm_y
    out[C], out[S] = math.cos(out[CAGE]), math.sin(out[CAGE])


@compiled_inline
def next_element(bearing: Any, terms: Any, k: int, out: Floats) -> None:
    """Turn the direction (c, s) in ``out``, of the element before or for element 0 of the cage, to element k."""
    cosine, sine = bearing.pitch_cosine, bearing.pitch_sine
    if is_uneven(bearing):
        row = row_of_element(bearing, k)
        cosine, sine = terms[row, 1], terms[row, 2]
    elif k == 0:
        return
    c, s = out[C], out[S]
    out[C] = c * cosine - s * sine
    out[S] = s * cosine + c * sine


@compiled_inline
def place_element(system: System, n: int, k: int, inside: int, out: Floats) -> None:
    """Fill ``out`` with the kinematics of element k of bearing n, whose direction is there.

    delta = e.u - c + w; w of waviness and dents is a function of the relative rotation of the rings. ``inside`` has the dents
    that are passed (`dents`).
    """
    bearing = system.records[KIND][n]
    c, s = out[C], out[S]
    along, across = out[E_X] * c + out[E_Y] * s, -out[E_X] * s + out[E_Y] * c
    height, slope = 0.0, 0.0
    out[BEND], out[DENT], out[DENT_SLOPE], out[DENTED] = 0.0, 0.0, 0.0, 0.0
    if bearing.count_a + bearing.count_b > 0:
        height, slope, out[BEND] = ripples(bearing, system.terms, k, out[CAGE], out[TURN_A], out[TURN_B])
    if bearing.dent_count > 0:
        dent, by_turn, bend, out[DENTED] = dents(bearing, system.terms, k, out[TURN_A] - out[TURN_B], inside)
        height, slope = height + dent, slope + by_turn
        out[DENT], out[DENT_SLOPE], out[BEND] = dent, by_turn, out[BEND] + bend
    out[ALONG], out[ACROSS] = along, across
    out[DELTA] = along - bearing.half_clearance + height
    out[BY_A], out[BY_B] = bearing.share_a * across + slope, bearing.share_b * across - slope
    moving = out[V_X] * c + out[V_Y] * s
    out[DELTA_RATE] = moving + out[BY_A] * out[SPIN_A] + out[BY_B] * out[SPIN_B]
