"""Packing of position loops: PID control of an angle, and cascades of position, speed and current loops."""

import math
from dataclasses import dataclass
from typing import Any

from gearplay.parts.assembly import blank
from gearplay.parts.drive import positioner
from gearplay.parts.drive.schema import CascadeDrive, PositionDrive
from gearplay.parts.drive.set_point_packing import add_set_point
from gearplay.parts.protocol import Packing
from gearplay.vocabulary.errors import InputError


@dataclass(frozen=True)
class Loop:
    """Gains of the law T = s (kp e + ki z - kd c omega), z' = e - share c omega, with the lead [s] of the set-point in e."""

    proportional_gain: float
    integral_gain: float
    derivative_gain: float
    share: float = 0.0
    lead: float = 0.0
    every: int = 1


def loop_of(drive: PositionDrive | CascadeDrive, ratio: float) -> Loop:
    """Return the gains of a drive whose speed sensor turns ``ratio`` times per turn of the angle's sensor.

    A cascade wants the speed ratio (position_gain e + feedforward angle') of the speed sensor's rotor.
    """
    if drive.kind == "position":
        return Loop(drive.proportional_gain, drive.integral_gain, drive.derivative_gain)
    speed_per_angle = abs(ratio) * drive.position_gain
    return Loop(
        proportional_gain=drive.speed_gain * speed_per_angle,
        integral_gain=drive.integral_gain * speed_per_angle,
        derivative_gain=drive.speed_gain,
        share=1.0 / speed_per_angle,
        lead=drive.feedforward / drive.position_gain,
        every=drive.position_every,
    )


def pack_position_loops(packing: Packing) -> None:
    """Add an element for every rotor whose drive brings an angle to its set-point."""
    for name, given in packing.bodies.items():
        drive = given.drive
        if not isinstance(drive, (PositionDrive, CascadeDrive)):
            continue
        sensor, speed_sensor = drive.sensor or name, speed_sensor_of(drive, name)
        turns = _turns(packing, name, "sensor", sensor), _turns(packing, name, "speed_sensor", speed_sensor)
        loop, record = loop_of(drive, turns[1] / turns[0]), blank(positioner.RECORD)
        record.rotor, record.sensor, record.speed_sensor = (
            packing.place(each) for each in (name, sensor, speed_sensor)
        )
        record.sense = math.copysign(1.0, turns[0])
        record.speed_sense = record.sense * math.copysign(1.0, turns[1])
        record.angle = drive.angle if drive.over_time is None else drive.over_time.constant
        wave = add_set_point(packing, record, drive.over_time, of_speed=True, lead=loop.lead)
        record.proportional_gain, record.integral_gain = loop.proportional_gain, loop.integral_gain
        record.derivative_gain, record.share, record.lead = loop.derivative_gain, loop.share, loop.lead
        record.limit, record.lag = drive.torque_limit, drive.current_time
        record.sample_time, record.delay, record.every = drive.sample_time, drive.delay, loop.every
        record.resolution, record.speed_resolution = drive.resolution, drive.speed_resolution
        states = _place_states(record)
        sampled = 2.0 * math.pi / drive.sample_time if drive.sample_time > 0.0 else 0.0
        lagging = 1.0 / drive.current_time if drive.current_time > 0.0 else 0.0
        joined = list(dict.fromkeys((record.rotor, record.sensor, record.speed_sensor)))
        packing.records[record.rotor].controller = len(packing.assembly.entries)
        packing.assembly.add(
            positioner,
            name,
            record,
            joined,
            always=True,
            switches=1,
            states=states,
            rate=max(sampled, lagging, wave),
        )


def speed_sensor_of(drive: PositionDrive | CascadeDrive, name: str) -> str:
    """Return the rotor whose speed is measured: of a position loop by default the angle's sensor, of a cascade the driven one."""
    return drive.speed_sensor or (name if drive.kind == "cascade" else drive.sensor or name)


def _place_states(record: Any) -> int:
    """Assign indices to the states of a loop after its integral; return their number."""
    states = 2 if record.sample_time > 0.0 else 1
    for field, present in (
        ("lagged", record.lag > 0.0),
        ("waiting", record.delay > 0.0),
        ("held_error", record.every > 1),
    ):
        setattr(record, field, states if present else -1)
        states += int(present)
    return states


def _turns(packing: Packing, name: str, field: str, sensor: str) -> float:
    """Return the turns of a sensor's rotor per turn of the driven one."""
    if sensor == name:
        return 1.0
    turns = packing.ratio(name, sensor)
    if turns == 0.0:
        rule = f"must be a rotor that turns with {name}"
        raise InputError.of(f"rotors.{name}.drive.{field}", sensor, rule, "Name one of the same train")
    return turns
