"""Drives of a rotor: prescribed speed, torque, servo, motor at a voltage, position loop, cascade."""

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING, Annotated, Any, Final, Literal

from pydantic import Field, Tag, model_validator

from gearplay.parts.drive.terms import Table, Terms, largest_torque
from gearplay.schema.fields import (
    ByKind,
    Later,
    Listed,
    Measure,
    Part,
    Problem,
    RotorName,
    is_absent,
    refuse,
)
from gearplay.vocabulary import quantities as q

if TYPE_CHECKING:
    from gearplay.parts.drive.set_points import SetPoint
else:

    class SetPoint:
        """Set-points of few cases: ``SetPoint[Speed]`` imports them, when the first is read."""

        def __class_getitem__(cls, value: Any) -> Any:
            def find() -> type[Part]:
                from gearplay.parts.drive import set_points

                return set_points.SetPoint[value]

            return Annotated[Any, Later(find)]


Speed = Annotated[float, Measure(q.ANGULAR_SPEED, "speed of rotation, counter-clockwise positive")]
Ramp = Annotated[
    float, Measure(q.TIME, "time of constant acceleration from start_speed; 0 starts at speed", ge=0.0)
]
StartSpeed = Annotated[float, Measure(q.ANGULAR_SPEED, "speed at which a ramp begins")]
Torque = Annotated[float, Measure(q.TORQUE, "torque, counter-clockwise positive")]
Angle = Annotated[float, Measure(q.ANGLE, "set-point of the angle")]
Voltage = Annotated[float, Measure(q.VOLTAGE, "voltage of the winding")]
TorqueLimit = Annotated[float, Measure(q.TORQUE, "largest torque, either sense", gt=0.0)]
Sensor = (
    Annotated[RotorName, Field(description="rotor whose angle is measured; this one if not given")] | None
)
SpeedSensor = Annotated[
    RotorName | None, Field(description="rotor whose speed is measured", exclude_if=is_absent)
]
SampleTime = Annotated[
    float, Measure(q.TIME, "time between samples of the control; 0 for a continuous one", ge=0.0)
]
Delay = Annotated[
    float,
    Measure(q.TIME, "from a sample to its torque, at most sample_time", ge=0.0),
    Field(exclude_if=is_absent),
]
Resolution = Annotated[
    float,
    Measure(q.ANGLE, "step of the encoder of the angle; 0 for an exact one", ge=0.0),
    Field(exclude_if=is_absent),
]
SpeedResolution = Annotated[
    float,
    Measure(
        q.ANGLE,
        "step of the encoder whose counts at two samples give the speed; 0 for an exact speed",
        ge=0.0,
    ),
    Field(exclude_if=is_absent),
]
Lag = Annotated[
    float,
    Measure(q.TIME, "time constant of the current loop; 0 for none", ge=0.0),
    Field(exclude_if=is_absent),
]
OVER_TIME: Final = "set-point over time, in place of the constant"


class RippleTerm(Part):
    """One term ``amplitude sin(order speed t + phase)`` of a drive's ripple, relative to its speed."""

    order: Annotated[
        int, Field(ge=1, le=64, description="order: periods per revolution at the nominal speed")
    ]
    amplitude: Annotated[
        float, Measure(q.RATIO, "amplitude (half peak to peak) over the speed", ge=0.0, le=0.5)
    ]
    phase: Annotated[float, Measure(q.ANGLE, "phase at t = 0")] = 0.0


class SpeedDrive(Part):
    """Prescribed rotation: ``theta = speed t`` after the ramp from ``start_speed``, or the integral of a speed that ripples or
    is given over time.
    """

    kind: Literal["speed"] = "speed"
    speed: Speed
    ramp: Ramp = 0.0
    start_speed: StartSpeed = 0.0
    ripple: Annotated[tuple[RippleTerm, ...], Listed(0, 8, "terms of the ripple of the speed")] = ()
    over_time: Annotated[SetPoint[Speed] | None, Field(description=OVER_TIME, exclude_if=is_absent)] = None

    @model_validator(mode="after")
    def _check(self) -> "SpeedDrive":
        problems = _over_time_problems(self)
        if self.over_time is not None and self.ripple:
            rule = "must not be given for a drive whose speed is given over time"
            problems.append(Problem(("ripple",), rule, "Remove one of the two"))
        total = sum(term.amplitude for term in self.ripple)
        if total >= 1.0:
            rule = f"must have amplitudes that add up to less than 1, or the shaft reverses; they make {total:.4g}"
            problems.append(Problem(("ripple",), rule, "Lower the amplitudes"))
        if self.ripple and self.ramp > 0.0:
            rule = "must be 0 for a drive with a ripple, which has its full speed from the start"
            problems.append(Problem(("ramp",), rule, "Remove the ramp or the ripple"))
        refuse([*problems, *_start_problems(self.start_speed, self.ramp)])
        return self

    @property
    def first_speed(self) -> float:
        """Speed at t = 0 [rad/s], without a ramp: by the phases of the ripple, or the set-point."""
        if self.over_time is not None:
            return self.over_time.at_start
        return self.speed * (1.0 + sum(term.amplitude * math.sin(term.phase) for term in self.ripple))


class TorqueDrive(Part):
    """Sum of a constant torque, harmonic terms and a table over time."""

    kind: Literal["torque"] = "torque"
    torque: Annotated[float, Measure(q.TORQUE, "driving torque, counter-clockwise positive")]
    terms: Terms = ()
    table: Table = None
    over_time: Annotated[
        SetPoint[Torque] | None,
        Field(description="torque over time besides the constant", exclude_if=is_absent),
    ] = None

    @property
    def largest_torque(self) -> float:
        """A bound of the magnitude of the torque [N m]."""
        varying = 0.0 if self.over_time is None else self.over_time.largest
        return varying + largest_torque(self.torque, self.terms, self.table)


class ServoDrive(Part):
    """Speed loop with a torque limit: ``T = kp (target - omega) + ki integral``."""

    kind: Literal["servo"] = "servo"
    speed: Speed
    proportional_gain: Annotated[float, Measure(q.ROTATIONAL_DRAG, "gain on the speed error", gt=0.0)]
    integral_gain: Annotated[float, Measure(q.ROTATIONAL_STIFFNESS, "gain on its integral", ge=0.0)]
    torque_limit: Annotated[float, Measure(q.TORQUE, "largest torque, either sense", gt=0.0)]
    ramp: Ramp = 0.0
    start_speed: StartSpeed = 0.0
    over_time: Annotated[SetPoint[Speed] | None, Field(description=OVER_TIME, exclude_if=is_absent)] = None

    @model_validator(mode="after")
    def _check(self) -> "ServoDrive":
        refuse([*_start_problems(self.start_speed, self.ramp), *_over_time_problems(self)])
        return self

    @property
    def first_speed(self) -> float:
        """Set-point of the speed at t = 0 [rad/s], without a ramp."""
        return self.speed if self.over_time is None else self.over_time.at_start


class MotorDrive(Part):
    """Motor at a voltage u: ``inductance i' + resistance i + torque_constant omega = u``, torque ``torque_constant i``.

    The current is a state, 0 at the start; the rotor starts with the no-load speed, unless ``initial.omega`` is given.
    """

    kind: Literal["motor"] = "motor"
    voltage: Annotated[
        float, Measure(q.VOLTAGE, "voltage of the winding; of a positive one the torque is too")
    ]
    resistance: Annotated[float, Measure(q.RESISTANCE, "resistance of the winding", gt=0.0)]
    inductance: Annotated[float, Measure(q.INDUCTANCE, "inductance of the winding", gt=0.0)]
    torque_constant: Annotated[
        float, Measure(q.TORQUE_CONSTANT, "torque per current, and voltage per angular speed", gt=0.0)
    ]
    over_time: Annotated[SetPoint[Voltage] | None, Field(description=OVER_TIME, exclude_if=is_absent)] = None

    @model_validator(mode="after")
    def _check(self) -> "MotorDrive":
        refuse(_nominal_problems(self, "voltage"))
        return self

    @property
    def speed(self) -> float:
        """No-load speed [rad/s]."""
        return self.voltage / self.torque_constant

    @property
    def first_speed(self) -> float:
        """No-load speed at the voltage at t = 0 [rad/s]."""
        return (self.voltage if self.over_time is None else self.over_time.at_start) / self.torque_constant

    @property
    def proportional_gain(self) -> float:
        """Torque per speed below that without load, once the current has settled [N m s]."""
        return self.torque_constant**2 / self.resistance

    @property
    def integral_gain(self) -> float:
        """Integral gain, 0: a motor has no integral term."""
        return 0.0


class PositionDrive(Part):
    """Position loop with a torque limit: ``T = kp (angle - theta) + ki integral - kd omega``, of the rotor itself or of sensors.

    Where the sensor's rotor turns against this one the torque has the other sign. With a ``sample_time`` the torque is computed
    at t = 0 and then once in that time, and held; then encoders may have a resolution and the torque a delay.
    """

    kind: Literal["position"] = "position"
    angle: Annotated[float, Measure(q.ANGLE, "set-point of the rotation of the sensor's rotor")]
    proportional_gain: Annotated[
        float, Measure(q.ROTATIONAL_STIFFNESS, "gain on the error of the angle", gt=0.0)
    ]
    derivative_gain: Annotated[float, Measure(q.ROTATIONAL_DRAG, "gain on the sensor's speed", ge=0.0)] = 0.0
    integral_gain: Annotated[float, Measure(q.INTEGRAL_GAIN, "gain on the integral of the error", ge=0.0)] = (
        0.0
    )
    torque_limit: Annotated[float, Measure(q.TORQUE, "largest torque, either sense", gt=0.0)]
    sensor: Sensor = None
    speed_sensor: SpeedSensor = None
    sample_time: SampleTime = 0.0
    delay: Delay = 0.0
    resolution: Resolution = 0.0
    speed_resolution: SpeedResolution = 0.0
    current_time: Lag = 0.0
    over_time: Annotated[SetPoint[Angle] | None, Field(description=OVER_TIME, exclude_if=is_absent)] = None

    @model_validator(mode="after")
    def _check(self) -> "PositionDrive":
        refuse([*_sample_problems(self), *_nominal_problems(self, "angle")])
        return self


class CascadeDrive(Part):
    """Cascade of position, speed and current loops with a torque limit.

    The position loop requests the speed ``v = ratio (position_gain (angle - theta) + feedforward angle')`` of the speed sensor's
    rotor, by default this one, the speed loop the torque ``speed_gain (v - omega) + integral_gain integral of (v - omega)``; the
    current loop follows with ``current_time``. With a ``sample_time`` the speed loop is sampled, the position loop each
    ``position_every``-th time.
    """

    kind: Literal["cascade"] = "cascade"
    angle: Annotated[float, Measure(q.ANGLE, "set-point of the rotation of the sensor's rotor")]
    position_gain: Annotated[
        float, Measure(q.ANGULAR_SPEED, "set-point of the speed per error of the angle [1/s]", gt=0.0)
    ]
    speed_gain: Annotated[float, Measure(q.ROTATIONAL_DRAG, "gain on the error of the speed", gt=0.0)]
    integral_gain: Annotated[
        float, Measure(q.ROTATIONAL_STIFFNESS, "gain on the integral of the speed's error", ge=0.0)
    ] = 0.0
    feedforward: Annotated[
        float, Measure(q.RATIO, "share of the set-point's rate that is fed forward", ge=0.0, le=1.0)
    ] = 0.0
    torque_limit: TorqueLimit
    current_time: Lag = 0.0
    sensor: Sensor = None
    speed_sensor: SpeedSensor = None
    sample_time: SampleTime = 0.0
    position_every: Annotated[
        int,
        Field(ge=1, le=1000, description="samples of the speed loop per sample of the position loop"),
    ] = 1
    delay: Delay = 0.0
    resolution: Resolution = 0.0
    speed_resolution: SpeedResolution = 0.0
    over_time: Annotated[SetPoint[Angle] | None, Field(description=OVER_TIME, exclude_if=is_absent)] = None

    @model_validator(mode="after")
    def _check(self) -> "CascadeDrive":
        problems = list(_sample_problems(self))
        if self.position_every > 1 and self.sample_time == 0.0:
            rule = "must be 1 for a continuous control"
            problems.append(Problem(("position_every",), rule, "Give a sample_time"))
        refuse([*problems, *_nominal_problems(self, "angle")])
        return self


def _sample_problems(drive: "PositionDrive | CascadeDrive") -> Iterator[Problem]:
    """Yield problems of fields that require a sampled control, and of a delay that is too long."""
    if drive.sample_time == 0.0:
        for name in ("delay", "resolution", "speed_resolution"):
            if getattr(drive, name) > 0.0:
                yield Problem(
                    (name,), "must be 0 for a continuous control", "Give a sample_time, or remove it"
                )
    elif drive.delay > drive.sample_time:
        rule = f"must be at most sample_time, {drive.sample_time:g} s"
        yield Problem(("delay",), rule, "Shorten it")


def _over_time_problems(drive: "SpeedDrive | ServoDrive") -> list[Problem]:
    """Set the constant of a drive whose speed is given over time; return a contradiction, and a ramp."""
    problems = _nominal_problems(drive, "speed")
    if drive.over_time is not None and drive.ramp > 0.0:
        rule = "must be 0 for a drive whose speed is given over time"
        problems.append(Problem(("ramp",), rule, "Write it into the set-point"))
    return problems


def _nominal_problems(
    drive: "SpeedDrive | ServoDrive | PositionDrive | CascadeDrive | MotorDrive", name: str
) -> list[Problem]:
    """Set the constant of a drive to the nominal value of its set-point over time; return a contradiction of both."""
    if drive.over_time is None:
        return []
    given, nominal = getattr(drive, name), drive.over_time.nominal
    if given not in (0.0, nominal):
        rule = "must be left out where over_time gives it"
        return [Problem((name,), rule, "Remove it, or over_time")]
    drive.__dict__[name] = nominal
    return []


def _start_problems(start_speed: float, ramp: float) -> list[Problem]:
    if start_speed == 0.0 or ramp > 0.0:
        return []
    rule = "must be 0 for a drive without a ramp, which starts at its speed"
    return [Problem(("start_speed",), rule, "Give the ramp's time, or remove it")]


Drive = Annotated[
    Annotated[SpeedDrive, Tag("kind:speed")]
    | Annotated[TorqueDrive, Tag("kind:torque")]
    | Annotated[ServoDrive, Tag("kind:servo")]
    | Annotated[PositionDrive, Tag("kind:position")]
    | Annotated[CascadeDrive, Tag("kind:cascade")]
    | Annotated[MotorDrive, Tag("kind:motor")],
    ByKind("speed", "torque", "servo", "position", "cascade", "motor"),
]
