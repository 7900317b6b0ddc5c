"""Packing: from a validated case with full names to records with kernel symbols."""

from collections.abc import Container, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gearplay.kernels import housing_motion, layout
from gearplay.kernels.layout import ROTOR, System
from gearplay.model.excitation_packing import pack_excitations, refuse_senseless
from gearplay.model.natural_sizes import natural_sizes
from gearplay.model.position_packing import pack_position_loops
from gearplay.model.set_point_packing import SetPoints
from gearplay.parts.assembly import Assembly, blank
from gearplay.parts.drive import servo
from gearplay.parts.housing import law as housing
from gearplay.parts.mesh.packing import add_pair_signals, pack_meshes
from gearplay.parts.mesh.tooth_deflections import damping_depths
from gearplay.parts.mesh.train import geometry, rolling
from gearplay.parts.mesh.train.massless import refuse_massless
from gearplay.parts.protocol import Packing
from gearplay.parts.registry import EXCITATION, KINDS, MESH, PAIR, POSITIONER
from gearplay.schema.fields import LARGEST
from gearplay.schema.records import edges, harmonic_rows
from gearplay.vocabulary import quantities as q
from gearplay.vocabulary.errors import InputError

if TYPE_CHECKING:
    from gearplay.model.case import Case

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Packed:
    """A case in the layout of the kernels, with the solver's data that are not part of the equations."""

    system: System
    labels: Mapping[str, tuple[str, ...]]  # of rotors and elements, by dimension of a result
    contact_labels: tuple[str, ...]  # sleeves by name, flanks as ``mesh:drive``, ``mesh:back``
    angular: NDArray[np.bool_]  # per contact: whether it is one of angles and torques
    natural: Floats  # natural size per state: m, rad, m/s, rad/s
    restart_step: float  # s, first step after a switch
    stops: Floats  # s, times where the right-hand side jumps
    half_backlashes: Mapping[str, tuple[str, float]]
    """By a signal in half backlashes, ``mesh.x``: the penetration of the drive flank, and half the backlash [m]."""

    @property
    def rotor_names(self) -> tuple[str, ...]:
        """Names of the rotors."""
        return self.labels["rotor"]

    @property
    def state_size(self) -> int:
        """Number of states."""
        return int(self.natural.size)


NO_LIMIT = LARGEST[q.TORQUE.name]
"""Torque limit [N m] of a motor, which its voltage limits."""


def _pack_rotors(case: "Case", speeds: Floats, senses: Floats) -> list[Any]:
    rotors = [blank(ROTOR) for _ in case.rotors]
    for i, (name, given) in enumerate(case.rotors.items()):
        r, drive = rotors[i], given.drive
        prescribed = drive is not None and drive.kind == "speed"
        held = geometry.is_held(case, name)
        if held and (given.initial.vx != 0.0 or given.initial.vy != 0.0):
            _refuse_moving(name, given.initial)
        r.mass, r.inertia = given.mass, given.inertia
        r.inv_mass = 0.0 if held else 1.0 / (given.mass or 1.0)
        r.inv_inertia = 0.0 if prescribed else 1.0 / (given.inertia or 1.0)
        r.nominal_speed = speeds[i]
        if given.load.torque > 0.0 and senses[i] == 0.0:
            refuse_senseless(name, "torque", f"{given.load.torque:g} N m")
        r.torque = -senses[i] * given.load.torque
        if given.unbalance is not None:
            r.unbalance, r.unbalance_phase = given.unbalance.amount, given.unbalance.phase
        r.drag, r.friction, r.friction_speed = given.load.drag, given.load.friction, given.load.friction_speed
        # Of a carried rotor it acts relative to the pin: in its sleeve, or its support.
        r.radial_damping = given.radial_damping if geometry.carrier_of(case, name) is None else 0.0
        r.drive, r.controller, r.excitation, r.group, r.wave = layout.DRIVE_NONE, -1, -1, -1, -1
        if drive is None or drive.kind == "position" or drive.kind == "cascade":
            continue
        if drive.kind == "torque":
            r.torque += drive.torque
            r.drive_torque = drive.torque
            continue
        r.drive = layout.DRIVE_SPEED if prescribed else layout.DRIVE_SERVO
        if drive.kind == "motor":
            continue
        r.ramp_time, r.ramp_start = drive.ramp, drive.start_speed
        r.ramp_acceleration = (drive.speed - drive.start_speed) / drive.ramp if drive.ramp > 0.0 else 0.0
    return rotors


def _refuse_moving(name: str, start: Any) -> None:
    """Refuse a velocity of a centre that is held."""
    axis = "vx" if start.vx != 0.0 else "vy"
    rule = "must be 0: its centre is held"
    cure = "Remove it, or give the rotor a sleeve, a support, or floating = true"
    raise InputError.of(f"rotors.{name}.initial.{axis}", getattr(start, axis), rule, cure)


def _pack_servos(case: "Case", assembly: Assembly, rotors: Any, set_points: SetPoints) -> None:
    for i, (name, given) in enumerate(case.rotors.items()):
        drive = given.drive
        if drive is None or (drive.kind != "servo" and drive.kind != "motor"):
            continue
        s = blank(servo.RECORD)
        if drive.kind == "motor":
            s.rotor, s.gain, s.limit = i, drive.proportional_gain, NO_LIMIT
            s.lag = drive.inductance / drive.resistance
            s.speed = (
                drive.speed if drive.over_time is None else drive.over_time.constant / drive.torque_constant
            )
            wave = set_points.add(s, drive.over_time, scale=1.0 / drive.torque_constant)
            rotors[i].controller = len(assembly.entries)
            rate = max(wave, 1.0 / s.lag)
            assembly.add(servo, name, s, [i], always=True, switches=1, states=2, rate=rate)
            continue
        s.rotor, s.speed = i, drive.speed if drive.over_time is None else drive.over_time.constant
        rate = set_points.add(s, drive.over_time)
        s.gain, s.integral_gain, s.limit = drive.proportional_gain, drive.integral_gain, drive.torque_limit
        rotors[i].controller = len(assembly.entries)
        assembly.add(servo, name, s, [i], always=True, switches=1, states=1, rate=rate)


def _pack_holders(case: "Case", packing: Packing, kinds: Container[int]) -> None:
    """Add parts that hold rotors; of a carried rotor the first takes the damping of the centre's motion."""
    for _, name, part in case.every_holder():
        if part.kind in kinds:
            first = part.on is not None and part is case.holders(name)[0]
            part.pack(packing, name, case.rotors[name].radial_damping if first else 0.0)


def _pack_ripples(case: "Case", rotors: Any, start: int) -> Floats:
    """Note every drive's ripple in its rotor's record; return its rows of terms, which begin at row ``start``."""
    rows: list[list[float]] = []
    for r, given in zip(rotors, case.rotors.values(), strict=True):
        drive = given.drive
        if drive is None or drive.kind != "speed" or not drive.ripple:
            continue
        r.varying, r.ripple_start, r.ripple_count = 1, start + len(rows), len(drive.ripple)
        rows += harmonic_rows([(float(term.order), term.amplitude, term.phase) for term in drive.ripple])
        r.ripple_curvature = sum(term.order * term.amplitude for term in drive.ripple) * drive.speed**2
        r.ripple_rate = max(term.order for term in drive.ripple) * abs(drive.speed)
    return np.array(rows).reshape(-1, 3)


def _pack_prescribed(case: "Case", rotors: Any, set_points: SetPoints) -> None:
    """Note the prescribed speeds over time in their rotors' records."""
    for r, given in zip(rotors, case.rotors.values(), strict=True):
        drive = given.drive
        if drive is not None and drive.kind == "speed" and drive.over_time is not None:
            r.varying = 1
            r.ripple_curvature = drive.over_time.steepest()
            r.ripple_rate = set_points.add_motion(r, drive.over_time, drive.speed)


def pack(
    case: "Case",
    *,
    span: float | None = None,
    member: int = 0,
    turning: "Case | None" = None,
    moves: bool = True,
) -> Packed:
    """Translate a case for the kernels: for one member's run of ``span`` [s], transient included, else of the case's own.

    Both matter only where the housing has a random record. ``turning`` is the case whose motion determines which flanks drive and
    how deep teeth are pressed, the case itself if not given. ``moves`` is whether the motion over time is computed; where it is
    not, free coordinates may be without mass: their inverse mass is 1, so that their rates are the forces on them.

    Raises `InputError` where drives contradict each other, given centres cannot mesh or a moving coordinate has no mass.
    """
    case = case.operating
    if moves:
        refuse_massless(case)
    centres = geometry.centres(case)
    speeds = rolling.nominal_speeds(case)
    turning = case if turning is None else turning.operating
    moving = rolling.moving_speeds(turning, speeds if turning is case else rolling.nominal_speeds(turning))
    senses = np.sign(moving)
    rotors = _pack_rotors(case, speeds, senses)
    assembly = Assembly(len(rotors))
    set_points = SetPoints()
    _pack_servos(case, assembly, rotors, set_points)
    _pack_prescribed(case, rotors, set_points)
    printed = case.formulation == "as_published"
    packing = Packing(assembly, case.rotors, rotors, centres, printed, faults=case.faults)
    _pack_holders(case, packing, range(MESH))
    terms, spline, involutes = pack_meshes(
        case, assembly, rotors, centres, moving, damping_depths(turning), (case.run.seed, member)
    )
    packing.terms += np.concatenate([terms, _pack_ripples(case, rotors, len(terms))]).tolist()
    for _, name, joint in case.named_joints():
        joint.pack(packing, name)
    _pack_holders(case, packing, range(MESH, EXCITATION))
    base, record = np.zeros(housing_motion.SLOTS), np.zeros((0, 4))
    if case.base is not None:
        from gearplay.parts.housing.schema import Member

        whole = case.run.transient + case.run.duration if span is None else span
        base, record = case.base.pack(whole, Member(case.run.seed, member))
    rows, record, stops = pack_excitations(
        case, assembly, rotors, senses, len(packing.terms), record, set_points
    )
    packing.terms += rows.tolist()
    if case.base is not None:  # an element that shows it
        assembly.add(housing, "base", blank(housing.RECORD), [0])
    pack_position_loops(case, assembly, rotors, set_points)
    _pack_holders(case, packing, range(POSITIONER, PAIR))
    add_pair_signals(assembly)
    record = set_points.place(packing.terms, record)
    gravity = np.array(case.gravity, dtype=np.float64)
    system = assembly.system(
        rotors,
        [kind.file.RECORD for kind in KINDS],
        terms=np.array(packing.terms, dtype=np.float64).reshape(-1, 3),
        involutes=involutes,
        spline=spline,
        gravity=gravity,
        base=base,
        record=record,
    )
    stops |= set_points.stops | {float(r.ramp_time) for r in rotors}
    if case.base is not None:
        stops |= edges(float(base[housing_motion.START]), float(base[housing_motion.END]))
    return Packed(
        system=system,
        labels={"rotor": tuple(case.rotors)}
        | {KINDS[kind].name: tuple(found) for kind, found in assembly.labels.items()},
        contact_labels=tuple(assembly.contact_labels),
        angular=np.array(assembly.angular, dtype=bool),
        natural=natural_sizes(system, assembly.states),
        restart_step=0.1
        / max(1.0, *(r.ripple_rate for r in rotors), base[housing_motion.RATE], assembly.fastest),
        stops=np.array(sorted(stops - {0.0}), dtype=np.float64),
        half_backlashes=_half_backlashes(case),
    )


def _half_backlashes(case: "Case") -> dict[str, tuple[str, float]]:
    found = {
        f"{mesh.label}.x": (f"{mesh.label}.drive_penetration", 0.5 * backlash)
        for j, mesh in enumerate(case.meshes)
        if (backlash := geometry.working_backlash(case, j)) > 0.0
    }
    alone = next(iter(found.values()), None)
    return found | ({"x": alone} if case.torsional_pair is not None and alone is not None else {})
