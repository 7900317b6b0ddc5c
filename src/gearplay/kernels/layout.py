"""Packed form of a system for the kernels: records of plain floats and integers, no Python objects.

One `System` holds arrays of rotors and of elements, so that a gear pair is nothing special. Records rather than bare columns
keep the kernels readable (``mesh.c0``) at the cost of nothing. Every place in an array has a name here.
"""

from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gearplay.kernels.arrays import Floats, Ints, Rows
from gearplay.kernels.by_address import Group
from gearplay.kernels.compiled import compiled_inline

# Kinds, as integers: kernels have no strings.
DRIVE_NONE, DRIVE_SPEED, DRIVE_SERVO = 0, 1, 2

# What a contact is doing (see `switches`).
OPEN, LOADED, SEPARATING = 0, 1, 2
# Quantity of a switch: penetration of a contact, margin of its force, or one of the element's own.
TOUCH, PULL, OWN = 0, 1, 2

# State of a body (see `active_set`): closed form since its last contact, integrated, or always at its nominal state.
FREE, ACTIVE, KNOWN = 0, 1, 2
# State of an element: open between free rotors, open beside an active rotor, acting.
DORMANT, WATCHED, ACTING = 0, 1, 2

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
        ("radial_damping", "f8"),  # N s/m, against the ground
        ("ramp_time", "f8"),  # s
        ("ramp_start", "f8"),  # rad/s, speed at t = 0
        ("ramp_acceleration", "f8"),  # rad/s^2 during the ramp
        ("varying", "i8"),  # 1 where its drive prescribes a speed that varies, by a ripple or over time
        ("ripple_curvature", "f8"),  # rad/s^2, largest angular acceleration of that variation, 0 without
        ("ripple_rate", "f8"),  # rad/s, its highest angular frequency, 0 without
        ("ripple_start", "i8"),  # rows in System.terms
        ("ripple_count", "i8"),
        ("set_point", "i8"),  # first piece of its rotation over time in System.record, less the nominal one
        ("set_points", "i8"),  # number of pieces
        ("wave", "i8"),  # row of the sine of its speed in System.terms, -1 for none
        ("drive_torque", "f8"),  # N m, the constant part of ``torque`` that a torque drive gives
        ("unbalance", "f8"),  # kg m, mass times eccentricity
        ("unbalance_phase", "f8"),  # rad, where it points at rotation 0
        ("drive", "i8"),
        ("controller", "i8"),  # element that controls it, -1 for none
        ("excitation", "i8"),  # element of its terms of torque, -1 for none
        ("group", "i8"),  # of rotors joined by springs and propagated together, -1 for none
        (
            "modal_rate",
            "f8",
        ),  # rad/s, highest angular frequency at which it oscillates in free motion, or 0
    ],
    align=True,
)

# Where the entries of an element lie, at the head of the record of every kind.
PLACES = [
    ("element", "i8"),  # its number among all elements
    ("contact", "i8"),  # first row of the contact tables
    ("contacts", "i8"),
    ("impact_slot", "i8"),  # first of its stored impact speeds
    ("mode", "i8"),  # first of its own modes
    ("switch", "i8"),  # first switch; for each contact touch, pull and its own, then those of the whole
    ("switches", "i8"),
    ("state", "i8"),  # first of its own states in y
    ("states", "i8"),
    ("signal", "i8"),  # first column of a full row
]

# What every element has, whatever its kind (`elements.table`), and whom it joins.
ELEMENT = np.dtype(
    [
        ("kind", "i8"),
        ("index", "i8"),  # row among the records of its kind
        ("a", "i8"),  # rotors that it joins, -1 for none
        ("b", "i8"),
        ("c", "i8"),
        ("always", "i8"),  # 1 where it acts whatever its contacts do
        (
            "joins",
            "i8",
        ),  # 1 where, but for its contacts, it is a spring between jointly propagated rotors (`joined`)
        ("more_modes", "i8"),  # modes of its own, and columns of its slopes, beyond those of its kind
        ("more_slopes", "i8"),
        (
            "deferred",
            "i8",
        ),  # 1 where forces leave its open contacts out, which are evaluated at the end of a step
        *PLACES,
    ],
    align=True,
)

CONTACT = np.dtype(
    [
        ("element", "i8"),
        ("impact_slot", "i8"),  # slot of its stored impact speed, -1 for none
        ("partner", "i8"),  # contact that cannot be loaded with it, -1 for none
        ("yields", "i8"),  # 1 where the partner goes first
        ("closed", "i8"),  # 1 where it touches from the start, whatever its penetration
        ("floor", "f8"),  # m/s, least impact speed that is stored
        ("natural", "f8"),  # m or rad, natural size of its penetration
    ],
    align=True,
)

SWITCH = np.dtype(
    [
        ("element", "i8"),
        ("contact", "i8"),  # -1 for one of the whole element
        ("role", "i8"),  # TOUCH, PULL or OWN
        ("local", "i8"),  # place among the switches of its element
        (
            "hides",
            "i8",
        ),  # 1 where it may turn positive and back within a step (see `elements.table.may_return`)
    ],
    align=True,
)


# Along one axis: coordinates that springs join. They are listed in `Joined.coordinates` from ``first`` on, the ``count`` that
# move and the ``fixed`` that do not; ``right``, ``left`` and ``pull`` are where its matrices begin in `Joined.numbers`.
CHAIN = np.dtype(
    [
        ("first", "i8"),
        ("count", "i8"),
        ("fixed", "i8"),
        ("right", "i8"),  # [count, 2 count], shapes of its vibrations
        ("left", "i8"),  # [2 count, 2 count], vibrations in velocities and accelerations
        (
            "pull",
            "i8",
        ),  # [count, 2 (count + fixed) + 1], accelerations by positions, velocities, and constant
        ("vibration", "i8"),  # its first
        ("vibrations", "i8"),
        ("modal_rates", "i8"),  # first of its entries in `ActiveSet.modal_rates`
        ("damping", "f8"),  # 1/s, trace of its damping beyond that of each rotor alone
    ],
    align=True,
)

# What a chain's vibration is: a drift of the whole, slowed down or not, a decay, an oscillation.
DRIFT, DECAY, SWING = 0, 1, 2
VIBRATION = np.dtype(
    [
        ("kind", "i8"),
        ("column", "i8"),  # first of its columns of shapes
        ("decay", "f8"),  # 1/s, at least 0
        ("frequency", "f8"),  # rad/s, 0 unless oscillating
    ],
    align=True,
)


@dataclass(frozen=True, eq=False)
class Joined(Group):
    """Rotors joined by springs and propagated together, chain by chain (see `joined`); made by `gearplay.parts.joining`."""

    chains: Annotated[NDArray[Any], CHAIN]
    vibrations: Annotated[NDArray[Any], VIBRATION]
    coordinates: Ints  # places of positions in the state
    numbers: Floats
    places: Ints  # [2 * position]: its chain, -1 for none, and its number there


@dataclass(frozen=True, eq=False)
class System(Group):
    """A packed mechanism; `gearplay.model.pack` makes it, kernels only read it: runs on many threads share it."""

    rotors: Annotated[NDArray[Any], ROTOR]
    elements: Annotated[NDArray[Any], ELEMENT]  # kind after kind
    contacts: Annotated[NDArray[Any], CONTACT]
    switches: Annotated[NDArray[Any], SWITCH]
    records: tuple[NDArray[Any], ...]  # of each kind of element, declared by `gearplay.parts.registry`
    joined: Joined
    terms: Rows  # rows of (order, a cos(phase), a sin(phase)), orders rising within a mesh or drive
    involutes: Rows  # involute series of each mesh, shape [mesh, coefficient]
    spline: Rows  # rows of (start [rad], c0, c1, c2, c3): periodic cubic pieces
    gravity: Floats  # m/s^2, shape [2]
    base: Floats  # acceleration of the housing, slots in `base_motion`
    record: Rows  # [piece, 4], its record [m/s^2], then those of torques [N m]: c0 + c1 u + c2 u^2 + c3 u^3, u from 0 to 1


class Signal(NamedTuple):
    """A signal that an element shows: name and symbol, SI unit, unit for people and its factor, words for an axis; whether it
    follows from the state alone, without forces.
    """

    name: str
    symbol: str
    unit: str
    display_unit: str
    display_factor: float
    long_name: str
    of_state: bool = False


@dataclass(frozen=True, eq=False)
class Branch(Group):
    """The smooth branch of a run and the memory of its elements; made by `branch.make_branch`."""

    modes: Ints  # of every contact, of the elements' own, then 1 for each rotor that ramps
    impact_speeds: Floats  # [m/s], impact speeds
    memory: Rows  # [element, MEMORY], what elements carry along: angles known, turns followed
    acceleration_bounds: Floats  # [3 * rotor], bounds of the accelerations of joined coordinates


@dataclass(frozen=True, eq=False)
class Loads(Group):
    """Loads at one state: the contact table, the sums on each rotor (N, N, N m), and an element's scratch."""

    contacts: Rows  # [contact, CONTACT_COLUMNS]
    rotors: Rows  # [rotor, 3]
    out: Floats  # [OUT_SIZE]


# Columns of the contact table that the right-hand side fills, one row per contact.
PENETRATION, RATE, MARGIN, FORCE, FORCE_X, FORCE_Y = range(6)
CONTACT_COLUMNS = 6
LAST_TURN, LAST_COSINE_1, LAST_SINE = (
    29,
    30,
    31,
)  # behind the longest scratch, that of `mesh_geometry`: `rotation`
OUT_SIZE = 44
MEMORY = 12  # of the longest memory: `elements.mesh`

# Columns of a sampled row, per rotor.
(X, Y, THETA, VX, VY, OMEGA, AX, AY, DRIVE_TORQUE, LOAD_TORQUE, ROTOR_LOSS) = range(11)
PER_ROTOR = 11


@compiled_inline
def x_of(i: int) -> int:
    """Return the place of rotor i's x in the state; y and theta follow."""
    return 3 * i


@compiled_inline
def y_of(i: int) -> int:
    """Return the place of rotor i's y."""
    return 3 * i + 1


@compiled_inline
def theta_of(i: int) -> int:
    """Return the place of rotor i's rotation, relative to its nominal one."""
    return 3 * i + 2


@compiled_inline
def vx_of(system: System, i: int) -> int:
    """Return the place of rotor i's velocity along x; those along y and of rotation follow."""
    return int(3 * (system.rotors.size + i))


@compiled_inline
def vy_of(system: System, i: int) -> int:
    """Return the place of rotor i's velocity along y."""
    return int(3 * (system.rotors.size + i) + 1)


@compiled_inline
def omega_of(system: System, i: int) -> int:
    """Return the place of rotor i's angular speed, relative to its nominal one."""
    return int(3 * (system.rotors.size + i) + 2)


@compiled_inline
def spin_of(system: System, i: int, y: Floats) -> float:
    """Return rotor i's absolute angular speed [rad/s] at state y."""
    return system.rotors[i].nominal_speed + y[3 * (system.rotors.size + i) + 2]


@compiled_inline
def turn_of(system: System, i: int, t: float, y: Floats) -> float:
    """Return rotor i's absolute rotation [rad] at t [s] and state y."""
    return system.rotors[i].nominal_speed * t + y[3 * i + 2]


@compiled_inline
def signal_of(i: int) -> int:
    """Return the first of rotor i's columns in a full row."""
    return PER_ROTOR * i


@compiled_inline
def ramp_of(system: System, modes: Ints, i: int) -> int:
    """Return the place of rotor i's mode of ramping, 1 while its drive has not reached its speed."""
    return modes.size - system.rotors.size + i


@compiled_inline
def impact_speed_at(z: Floats, impact_speeds: Floats, slot: int) -> int:
    """Return the place of a stored impact speed in a change ``z`` of the state, behind the states."""
    return z.size - impact_speeds.size + slot


@compiled_inline
def members(system: System, e: int) -> tuple[int, int, int]:
    """Return the rotors of element e, -1 for none."""
    element = system.elements[e]
    return element.a, element.b, element.c


@compiled_inline
def is_acting(system: System, e: int, modes: Ints) -> bool:
    """Return whether element e acts of itself: always, or because one of its contacts is closed."""
    element = system.elements[e]
    acting = element.always == 1 and element.joins == 0
    for k in range(element.contact, element.contact + element.contacts):
        acting = acting or modes[k] != OPEN
    return bool(acting)
