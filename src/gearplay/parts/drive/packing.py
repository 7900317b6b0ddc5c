"""Packing of drives: servos and motors, prescribed speeds over time and their ripples."""

from typing import Any, Final

from gearplay.kernels.layout import DRIVE_SERVO, DRIVE_SPEED
from gearplay.parts.assembly import blank
from gearplay.parts.drive import servo
from gearplay.parts.drive.schema import MotorDrive, ServoDrive, SpeedDrive
from gearplay.parts.drive.set_point_packing import add_motion, add_set_point
from gearplay.parts.protocol import Actuator, Packing
from gearplay.schema.fields import LARGEST
from gearplay.schema.records import harmonic_rows
from gearplay.vocabulary import quantities as q

NO_LIMIT: Final = LARGEST[q.TORQUE.name]
"""Torque limit [N m] of a motor, which its voltage limits."""


def pack_servos(packing: Packing) -> None:
    """Add an element for every servo and motor, and note constant torques, ramps and prescribed speeds over time."""
    for r, given in zip(packing.records, packing.bodies.values(), strict=True):
        if given.drive is not None:
            _note(r, given.drive)
    for i, (name, given) in enumerate(packing.bodies.items()):
        drive = given.drive
        if not isinstance(drive, (MotorDrive, ServoDrive)):
            continue
        s = blank(servo.RECORD)
        s.rotor = i
        if isinstance(drive, MotorDrive):
            s.gain, s.limit = drive.proportional_gain, NO_LIMIT
            s.lag = drive.inductance / drive.resistance
            s.speed = (
                drive.speed if drive.over_time is None else drive.over_time.constant / drive.torque_constant
            )
            wave = add_set_point(packing, s, drive.over_time, scale=1.0 / drive.torque_constant)
            _add(packing, name, s, states=2, rate=max(wave, 1.0 / s.lag))
        else:
            s.speed = drive.speed if drive.over_time is None else drive.over_time.constant
            rate = add_set_point(packing, s, drive.over_time)
            s.gain, s.integral_gain, s.limit = (
                drive.proportional_gain,
                drive.integral_gain,
                drive.torque_limit,
            )
            _add(packing, name, s, states=1, rate=rate)
    for r, given in zip(packing.records, packing.bodies.values(), strict=True):
        drive = given.drive
        if isinstance(drive, SpeedDrive) and drive.over_time is not None:
            r.varying = 1
            r.ripple_curvature = drive.over_time.steepest()
            r.ripple_rate = add_motion(packing, r, drive.over_time, drive.speed)


def _note(r: Any, drive: Actuator) -> None:
    """Note a drive's constant torque, or its speed with a ramp, in the record of its rotor."""
    if drive.nominal_speed() is None:
        r.drive_torque = drive.constant_torque()
        r.torque += r.drive_torque
    elif not drive.positions:
        r.drive = DRIVE_SPEED if drive.prescribes else DRIVE_SERVO
        change, time = drive.run_up()
        if time > 0.0:
            r.ramp_time, r.ramp_start, r.ramp_acceleration = time, drive.starting_speed(), change / time


def _add(packing: Packing, name: str, record: Any, *, states: int, rate: float) -> None:
    packing.records[record.rotor].controller = len(packing.assembly.entries)
    packing.assembly.add(
        servo, name, record, [record.rotor], always=True, switches=1, states=states, rate=rate
    )


def pack_ripples(packing: Packing) -> None:
    """Note every drive's ripple in its rotor's record."""
    for r, given in zip(packing.records, packing.bodies.values(), strict=True):
        drive = given.drive
        if not isinstance(drive, SpeedDrive) or not drive.ripple:
            continue
        r.varying = 1
        rows = harmonic_rows([(float(term.order), term.amplitude, term.phase) for term in drive.ripple])
        r.ripple_start, r.ripple_count = packing.add_terms(rows)
        r.ripple_curvature = sum(term.order * term.amplitude for term in drive.ripple) * drive.speed**2
        r.ripple_rate = max(term.order for term in drive.ripple) * abs(drive.speed)
