"""Packed record, signals, modes and switches of a mesh."""

import math
from typing import Any

import numpy as np

from gearplay.kernels.arrays import Floats
from gearplay.kernels.layout import PLACES, Signal, System
from gearplay.parts.mesh.geometry import (
    FRESH,
    MESH,
)
from gearplay.parts.mesh.pairs.record import PAIR_FIELDS, SENSE

KIND = MESH
RECORD = np.dtype(
    [
        *PLACES,
        ("rho_a", "f8"),  # m, signed base (or pitch) radii, docs/conventions
        ("rho_b", "f8"),
        ("c0", "f8"),  # m, sum or difference of the base radii
        ("A0", "f8"),  # m, distance of the nominal centres as placed
        ("opening0", "f8"),  # m, s c0 (inv alpha - inv alpha0) as placed: 0 at the nominal distance
        ("u0_x", "f8"),  # nominal direction from a to b
        ("u0_y", "f8"),
        ("sin_alpha0", "f8"),  # of the working pressure angle as placed
        ("cos_alpha0", "f8"),
        ("A_nominal_squared", "f8"),  # m^2
        ("inv_A_nominal_squared", "f8"),  # 1/m^2
        ("u_series", "f8"),  # largest |(A/A0)^2 - 1| of the involute series
        ("inv_alpha0", "f8"),  # of the reference pressure angle
        ("sigma", "f8"),  # +1/-1, sense of the drive flank
        ("s", "f8"),  # +1 internal, -1 external
        ("backlash", "f8"),  # m, total, normal, at the nominal centre distance
        ("A_min", "f8"),  # m, smallest and largest centre distance that meshes
        ("A_max", "f8"),
        ("z_driver", "f8"),
        ("psi_0", "f8"),  # rad, mesh phase where nothing has turned yet
        ("runout_a", "f8"),  # m, eccentricity of the toothing, and where it points at theta = 0 [rad]
        ("runout_phase_a", "f8"),
        ("runout_b", "f8"),
        ("runout_phase_b", "f8"),
        ("k_m", "f8"),  # N/m
        ("k_single", "f8"),  # N/m, square wave
        ("duty", "f8"),  # share of the mesh period with k_m in a square wave
        ("phase", "f8"),  # rad, of the square wave or spline
        ("C_m", "f8"),  # N s/m
        ("depth", "f8"),  # m
        ("inv_depth", "f8"),  # 1/m
        ("highest_order", "f8"),  # of stiffness and transmission error
        ("error_slope", "f8"),  # m, largest |de/dpsi| and |d2e/dpsi2| of the transmission error
        ("error_curvature", "f8"),
        ("friction", "f8"),  # Coulomb coefficient of the teeth
        ("friction_speed", "f8"),  # m/s, sliding speed from which on friction is full
        ("pitch_phase", "f8"),  # rad, a pair passes the pitch point where psi and it make 0
        ("way", "f8"),  # m/rad, of the contact along the drive flanks' line of action
        ("a", "i8"),  # rotor at the foot of the vector of centres
        ("b", "i8"),  # rotor at its tip
        ("driver", "i8"),
        ("frame", "i8"),  # carrier rotor that turns the nominal direction, -1 for none
        ("kind", "i8"),
        ("stiffness_kind", "i8"),
        ("ramp", "i8"),
        ("stiffness_start", "i8"),  # rows in System.terms or System.spline
        ("stiffness_count", "i8"),
        ("error_start", "i8"),
        ("error_count", "i8"),
        *PAIR_FIELDS,
    ],
    align=True,
)
_DEGREES = 180.0 / math.pi
SIGNALS = (
    Signal("drive_penetration", "p_d", "m", "um", 1e6, "penetration of the drive flanks", True),
    Signal("back_penetration", "p_b", "m", "um", 1e6, "penetration of the back flanks", True),
    Signal("drive_force", "F_d", "N", "N", 1.0, "force of the drive flanks along the line of action"),
    Signal("back_force", "F_b", "N", "N", 1.0, "force of the back flanks along the line of action"),
    Signal("backlash", "b_t", "m", "um", 1e6, "total backlash along the line of action", True),
    Signal("working_pressure_angle", "alpha_w", "rad", "deg", _DEGREES, "working pressure angle"),
    Signal("center_distance", "A", "m", "mm", 1e3, "centre distance", True),
    Signal(
        "transmission_error_dynamic",
        "DTE",
        "m",
        "um",
        1e6,
        "dynamic transmission error along the line of action",
        True,
    ),
    Signal("contact_state", "state", "1", "1", 1.0, "contact state of the mesh"),
    Signal(
        "mesh_power_loss", "P", "W", "W", 1.0, "power lost in the mesh: damping and friction of the teeth"
    ),
    Signal(
        "mesh_power_input",
        "P_e",
        "W",
        "W",
        1.0,
        "power that errors and varying stiffness of the teeth put in",
    ),
)
SHOWN = len(SIGNALS)
MEMORY = FRESH
PER_CONTACT = 3  # switches: touch, pull, end of the damping ramp

DRIVE, BACK = 0, 1
# Modes of its own: 1 for each flank beyond the damping ramp, those of `pairs.record`; of pairs of teeth a sense for each contact.
MODES = SENSE + 2
# Switches: of each flank touch, pull and the ramp's end; then the edge of the square wave, if any; then, with friction, the
# hand-over to the next pair, with an envelope instead for each flank that to the next lead; then for each contact, with friction,
# the edge of the band in which its sliding is slower than ``friction_speed``. Pairs of teeth have those of contacts alone.
EDGE = 2 * PER_CONTACT


def recurrence_rates(system: System, speeds: Floats, frames: Floats) -> list[float]:
    """Return the angular frequencies [rad/s] of mesh phases and runouts (`gearplay.parts.registry.recurrence_rates`)."""
    rates: list[float] = []
    for each in system.records[KIND]:
        frame = speeds[each.frame] if each.frame >= 0 else 0.0
        rates.append(abs(each.z_driver * (speeds[each.driver] - frame)))
        ends = ((each.a, each.runout_a), (each.b, each.runout_b))
        rates += [abs(speeds[i] - frames[i]) for i, runout in ends if runout > 0.0]
    return rates


def joined_centres(records: Any) -> list[tuple[int, int]]:
    """Return the pairs of rotors that the force of the mesh couples by their centres."""
    return [(int(each["a"]), int(each["b"])) for each in records]
