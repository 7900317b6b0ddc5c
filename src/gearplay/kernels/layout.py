"""How a system is packed for the kernels: records of plain floats and integers, no Python objects.

One `System` holds arrays of rotors, sleeves and meshes, so that a gear pair is nothing special. Records
rather than bare columns keep the kernels readable (``mesh.c0``) at the cost of nothing.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gearplay.kernels.compiled import compiled_inline

# Kinds, as integers because kernels know no strings.
DRIVE_NONE, DRIVE_SPEED, DRIVE_SERVO = 0, 1, 2
BED_NONE, BED_MATCHED, BED_AS_PRINTED = 0, 1, 2
MESH_COUPLED, MESH_UNCOUPLED, MESH_PRINTED_COUPLED, MESH_PRINTED_UNCOUPLED = 0, 1, 2, 3
STIFFNESS_FOURIER, STIFFNESS_SQUARE, STIFFNESS_SPLINE = 0, 1, 2
RAMP_SMOOTH, RAMP_AS_PRINTED = 0, 1

# What a contact is doing (see `switches`).
OPEN, LOADED, SEPARATING = 0, 1, 2

# How a rotor moves (see `roster`): in closed form since it was last touched, integrated, or always at its nominal state.
FLYING, ACTIVE, KNOWN = 0, 1, 2
# What a sleeve or mesh is to the stepper: open between rotors that fly, open beside an active rotor, in contact.
DORMANT, WATCHED, TOUCHING = 0, 1, 2

ROTOR = np.dtype(
    [
        ("inv_mass", "f8"),  # 1/kg, 0 where the centre is held
        ("inv_inertia", "f8"),  # 1/(kg m^2), 0 where the rotation is prescribed
        ("mass", "f8"),  # kg
        ("inertia", "f8"),  # kg m^2
        ("nominal_speed", "f8"),  # rad/s
        ("torque", "f8"),  # N m, constant: drive minus load
        ("drag", "f8"),  # N m s
        ("friction", "f8"),  # N m, dry
        ("friction_speed", "f8"),  # rad/s, half-width of the regularisation
        ("radial_damping", "f8"),  # N s/m
        ("eccentricity", "f8"),  # m, of the toothing
        ("eccentricity_phase", "f8"),  # rad
        ("drive_speed", "f8"),  # rad/s, target of a servo
        ("ramp_time", "f8"),  # s
        ("ramp_start", "f8"),  # rad/s, speed at t = 0
        ("ramp_acceleration", "f8"),  # rad/s^2 during the ramp
        ("servo_gain", "f8"),  # N m s
        ("servo_integral_gain", "f8"),  # N m
        ("servo_limit", "f8"),  # N m
        ("ripple_bend", "f8"),  # rad/s^2, largest angular acceleration of the drive's ripple, 0 without
        ("ripple_rate", "f8"),  # rad/s, its highest angular frequency, 0 without
        ("servo_slot", "i8"),  # index of the integral state in y, -1 without servo
        ("ripple_start", "i8"),  # rows in System.terms
        ("ripple_count", "i8"),
        ("drive", "i8"),
    ],
    align=True,
)

SLEEVE = np.dtype(
    [
        ("clearance", "f8"),  # m, radius difference
        ("stiffness", "f8"),  # N/m^n
        ("exponent", "f8"),  # n
        ("dissipation", "f8"),  # a of F = K delta^n (1 + a ddelta/v_in)
        ("minimum_speed", "f8"),  # m/s, floor of the latched impact speed
        ("friction", "f8"),  # Coulomb coefficient
        ("friction_speed", "f8"),  # m/s
        ("shaft_radius", "f8"),  # m
        ("bed_stiffness", "f8"),  # N/m^k/rad
        ("bed_exponent", "f8"),  # k
        ("offset_x", "f8"),  # m, bush on its carrier at zero rotation
        ("offset_y", "f8"),
        ("journal", "i8"),  # rotor
        ("bush", "i8"),  # rotor, -1 for the ground
        ("bed", "i8"),
    ],
    align=True,
)

MESH = np.dtype(
    [
        ("rho_a", "f8"),  # m, signed base (or pitch) radii, docs/conventions
        ("rho_b", "f8"),
        ("c0", "f8"),  # m, sum or difference of the base radii
        ("A0", "f8"),  # m, distance of the nominal centres as placed
        ("opening0", "f8"),  # m, s c0 (inv alpha - inv alpha0) as placed: 0 at the nominal distance
        ("u0_x", "f8"),  # nominal direction from a to b
        ("u0_y", "f8"),
        (
            "turned",
            "f8",
        ),  # rad, how far the reference of phi has followed an orbiting gear (`mesh.follow_orbit`)
        ("turned_cos", "f8"),
        ("turned_sin", "f8"),
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
        ("k_m", "f8"),  # N/m
        ("k_single", "f8"),  # N/m, square wave
        ("duty", "f8"),  # share of the mesh period with k_m in a square wave
        ("phase", "f8"),  # rad, of the square wave or spline
        ("C_m", "f8"),  # N s/m
        ("depth", "f8"),  # m
        ("inv_depth", "f8"),  # 1/m
        ("highest_order", "f8"),  # of stiffness and transmission error
        ("error_slope", "f8"),  # m, largest |de/dpsi| and |d2e/dpsi2| of the transmission error
        ("error_bend", "f8"),
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
    ],
    align=True,
)


class System(NamedTuple):
    """A packed mechanism; `gearplay.model.pack` makes it, kernels read it."""

    rotors: NDArray[Any]  # ROTOR records
    sleeves: NDArray[Any]  # SLEEVE records
    meshes: NDArray[Any]  # MESH records
    terms: NDArray[
        np.float64
    ]  # rows of (order, a cos(phase), a sin(phase)), orders rising within a mesh or drive
    involutes: NDArray[np.float64]  # involute series of each mesh, shape [mesh, coefficient]
    spline: NDArray[np.float64]  # rows of (start [rad], c0, c1, c2, c3): periodic cubic pieces
    gravity: NDArray[np.float64]  # m/s^2, shape [2]
    known_angles: NDArray[np.float64]  # scratch of a run, shape [mesh, 9]: see `mesh.nearby_angle`


@compiled_inline
def contact_count(system: System) -> int:
    """Return the number of contacts: one a sleeve, two a mesh."""
    return int(system.sleeves.size + 2 * system.meshes.size)


@compiled_inline
def mode_count(system: System) -> int:
    """Return the length of ``modes``."""
    return int(system.sleeves.size + 5 * system.meshes.size + 2 * system.rotors.size)


@compiled_inline
def switch_count(system: System) -> int:
    """Return the number of switch functions."""
    return int(2 * system.sleeves.size + 7 * system.meshes.size + system.rotors.size)


# Columns of the contact table that the right-hand side fills, one row per contact: sleeves first, then two
# flanks per mesh (drive, back).
PENETRATION, RATE, MARGIN, FORCE, FORCE_X, FORCE_Y = 0, 1, 2, 3, 4, 5
CONTACT_COLUMNS = 6
OUT_SIZE = 27  # scratch that `mesh_geometry` and `sleeve_geometry` fill

# Columns of a sampled row, per rotor, sleeve and mesh.
ROTOR_SIGNALS = ("x", "y", "theta", "vx", "vy", "omega", "ax", "ay")
SLEEVE_SIGNALS = ("sleeve_penetration", "sleeve_force_x", "sleeve_force_y")
MESH_SIGNALS = (
    "drive_penetration",
    "back_penetration",
    "drive_force",
    "back_force",
    "backlash",
    "working_pressure_angle",
    "center_distance",
    "transmission_error_dynamic",
    "contact_state",
)
