"""Fields of a mesh's packed record for pairs of teeth, and numbers of its contacts.

The contacts of a mesh with pairs are its two flanks, then ``pairs`` slots of the drive flank and as many of the back flank. Teeth
take the slots in turn: pair j has slot j modulo ``pairs``, and changes it far from contact. A flank touches while one of its
pairs does. With an ``envelope`` the flanks are the only contacts (`pairs.envelope`).
"""

from typing import Final

FLANKS: Final = 2
SPARE: Final = 2
"""Slots beyond the largest number of pairs between the ends of the path."""
SEGMENT, PAIR, LEAD, SENSE = 2, 3, 4, 6
"""Modes of a mesh behind those of the damping ramps: half-waves passed by a square wave; pair of teeth whose sliding friction
opposes; slot of each flank's lead; for each contact the sense of its sliding, 0 while it is slower than ``friction_speed``."""
TABLE_COLUMNS: Final = 5

GEAR_FIELDS: Final = (
    ("base", "f8"),  # m, base radius
    ("tip", "f8"),  # m, tip radius
    ("tip_length", "f8"),  # m, from the base tangent point to the tip circle
    ("tip_involute", "f8"),  # rad, inv(alpha) at the tip circle
    ("teeth", "f8"),
    ("relief", "f8"),  # m, tip relief
    ("relief_length", "f8"),  # m, along the flank's path
    ("relief_power", "f8"),  # 1 linear, 2 parabolic
    ("low", "f8"),  # m, lowest and highest place of contact on its path, in the direction of its tip
    ("high", "f8"),
    ("toothing", "i8"),  # first row of its teeth in System.terms, -1 for none
    ("rows", "i8"),  # rows of each flank of a tooth there: deviations, or those and faults
    ("number", "i8"),  # of its tooth that is at, or next to, the line of centres where nothing has turned
)
"""Of each gear of the pair, the first external, with the endings ``_1`` and ``_2``."""

PAIR_FIELDS: Final = (
    ("pairs", "i8"),  # slots of each flank, 0 for one stiffness of a mesh without deviations
    ("envelope", "i8"),  # 1 where one stiffness acts on the deepest pair of each flank
    ("ring_drives", "i8"),
    ("corners", "i8"),  # 1 where tips touch beyond the path
    ("varies", "i8"),  # 1 where relief or profile deviations vary along oblique lines of contact
    ("oblique", "f8"),  # m, half the way by which the contact shifts along the path over the facewidth
    ("path_start", "f8"),  # m, ends of the installed path of contact
    ("path_end", "f8"),
    ("density", "f8"),  # N/m per m of that way, largest stiffness of a pair
    ("kappa", "f8"),  # of its parabola over the path
    ("fades", "i8"),  # 1 where damping follows the stiffness of the pair, as along oblique lines of contact
    ("base_pitch", "f8"),  # m
    ("pair_phase", "f8"),  # rad, phase of the teeth in their places less the mesh phase
    (
        "half_angle",
        "f8",
    ),  # rad, of the driver's tooth, or space of a ring, at the base circle; backlash included
    ("middle", "f8"),  # m, middle of the path of contact at the installed centres
    (
        "shift",
        "f8",
    ),  # m, from the place on the first gear's path to that on the driver's at the installed centres
    ("start", "f8"),  # m, hard ends of the path, at which contact is lost without a corner
    ("end", "f8"),
    ("stiffest", "f8"),  # N/m
    ("deviation_slope", "f8"),  # largest slope [1] and curvature [1/m] of the deviations over a flank's path
    ("deviation_curvature", "f8"),
    *((f"{name}_{gear}", form) for gear in (1, 2) for name, form in GEAR_FIELDS),
)
