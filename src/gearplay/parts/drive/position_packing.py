"""Packing of position loops: PID control of an angle, and cascades of position, speed and current loops."""

import math
from typing import Any

from gearplay.parts.assembly import blank
from gearplay.parts.drive import positioner
from gearplay.parts.drive.loops import LoopDrive
from gearplay.parts.drive.set_point_packing import add_set_point
from gearplay.parts.protocol import Packing
from gearplay.vocabulary.errors import InputError


def pack_position_loops(packing: Packing) -> None:
    """Add an element for every rotor whose drive brings an angle to its set-point."""
    for name, given in packing.bodies.items():
        drive = given.drive
        if not isinstance(drive, LoopDrive):
            continue
        sensor, speed_sensor = drive.sensor or name, drive.measures_speed_of(name)
        turns = _turns(packing, name, "sensor", sensor), _turns(packing, name, "speed_sensor", speed_sensor)
        loop, record = drive.loop(turns[1] / turns[0]), blank(positioner.RECORD)
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
