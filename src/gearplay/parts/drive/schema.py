"""Drives of a rotor: prescribed speed, torque, servo, motor at a voltage, position loop, cascade."""

import math
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal

from pydantic import Field, Tag, model_validator

from gearplay.parts.drive.loops import CascadeDrive, PositionDrive
from gearplay.parts.drive.over_time import OVER_TIME, SetPoint, nominal_problems
from gearplay.parts.drive.terms import Table, Terms, largest_torque
from gearplay.parts.protocol import Actuator
from gearplay.schema.fields import ByKind, Listed, Measure, Part, Problem, is_absent, refuse
from gearplay.vocabulary import quantities as q

Speed = Annotated[float, Measure(q.ANGULAR_SPEED, "speed of rotation, counter-clockwise positive")]
Ramp = Annotated[
    float, Measure(q.TIME, "time of constant acceleration from start_speed; 0 starts at speed", ge=0.0)
]
StartSpeed = Annotated[float, Measure(q.ANGULAR_SPEED, "speed at which a ramp begins")]
Torque = Annotated[float, Measure(q.TORQUE, "torque, counter-clockwise positive")]
Voltage = Annotated[float, Measure(q.VOLTAGE, "voltage of the winding")]


class RippleTerm(Part):
    """One term ``amplitude sin(order speed t + phase)`` of a drive's ripple, relative to its speed."""

    order: Annotated[
        int, Field(ge=1, le=64, description="order: periods per revolution at the nominal speed")
    ]
    amplitude: Annotated[
        float, Measure(q.RATIO, "amplitude (half peak to peak) over the speed", ge=0.0, le=0.5)
    ]
    phase: Annotated[float, Measure(q.ANGLE, "phase at t = 0")] = 0.0


class _SpeedDrive(Actuator):
    """Base of drives at a speed, which may begin with a ramp or be given over time."""

    if TYPE_CHECKING:
        speed: float
        ramp: float
        start_speed: float
        over_time: Any

    def nominal_speed(self) -> float:
        """Return the speed [rad/s]."""
        return self.speed

    def starting_speed(self) -> float:
        """Return the speed at which a ramp or a set-point over time begins [rad/s], else the speed."""
        if self.over_time is not None:
            return float(self.over_time.at_start)
        return self.start_speed if self.ramp > 0.0 else self.speed

    def run_up(self) -> tuple[float, float]:
        """Return the change of the speed [rad/s] in its ramp, and the time [s] that it takes."""
        return self.speed - self.start_speed, self.ramp

    def holds_rotation(self) -> bool:
        """Return whether the speed is 0."""
        return self.speed == 0.0

    def excites(self) -> bool:
        """Return whether its speed changes: with a ramp, over time."""
        return self.ramp > 0.0 or self.over_time is not None

    def _over_time_problems(self) -> list[Problem]:
        """Set the constant of a drive whose speed is given over time; return a contradiction, and a ramp."""
        problems = nominal_problems(self, "speed")
        if self.over_time is not None and self.ramp > 0.0:
            rule = "must be 0 for a drive whose speed is given over time"
            problems.append(Problem(("ramp",), rule, "Write it into the set-point"))
        return problems

    def _start_problems(self) -> list[Problem]:
        if self.start_speed == 0.0 or self.ramp > 0.0:
            return []
        rule = "must be 0 for a drive without a ramp, which starts at its speed"
        return [Problem(("start_speed",), rule, "Give the ramp's time, or remove it")]


class SpeedDrive(_SpeedDrive):
    """Prescribed rotation: ``theta = speed t`` after the ramp from ``start_speed``, or the integral of a speed that ripples or
    is given over time.
    """

    prescribes: ClassVar[bool] = True
    kind: Literal["speed"] = "speed"
    speed: Speed
    ramp: Ramp = 0.0
    start_speed: StartSpeed = 0.0
    ripple: Annotated[tuple[RippleTerm, ...], Listed(0, 8, "terms of the ripple of the speed")] = ()
    over_time: Annotated[SetPoint[Speed] | None, Field(description=OVER_TIME, exclude_if=is_absent)] = None

    @model_validator(mode="after")
    def _check(self) -> "SpeedDrive":
        problems = self._over_time_problems()
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
        refuse([*problems, *self._start_problems()])
        return self

    @property
    def first_speed(self) -> float:
        """Speed at t = 0 [rad/s], without a ramp: by the phases of the ripple, or the set-point."""
        if self.over_time is not None:
            return self.over_time.at_start
        return self.speed * (1.0 + sum(term.amplitude * math.sin(term.phase) for term in self.ripple))

    def excites(self) -> bool:
        """Return whether its speed changes: with a ramp, over time, with a ripple."""
        return super().excites() or any(term.amplitude for term in self.ripple)

    def time_invariant(self) -> "SpeedDrive":
        """Return a drive that holds the rotation."""
        return SpeedDrive(speed=0.0)


class TorqueDrive(Actuator):
    """Sum of a constant torque, harmonic terms and a table over time."""

    kind: Literal["torque"] = "torque"
    torque: Annotated[float, Measure(q.TORQUE, "driving torque, counter-clockwise positive")]
    terms: Terms = ()
    table: Table = None
    over_time: Annotated[
        SetPoint[Torque] | None,
        Field(description="torque over time besides the constant", exclude_if=is_absent),
    ] = None

    def constant_torque(self) -> float:
        """Return the constant of the sum."""
        return self.torque

    def push(self, name: str) -> tuple[str, float]:
        """Return its rotor and the constant torque, or the nominal one over time."""
        return name, self.torque or (0.0 if self.over_time is None else self.over_time.nominal)

    def excites(self) -> bool:
        """Return whether there is any torque."""
        return self.largest_torque() != 0.0

    def largest_torque(self) -> float:
        """Return a bound of the sum."""
        varying = 0.0 if self.over_time is None else self.over_time.largest
        return varying + largest_torque(self.torque, self.terms, self.table)


class ServoDrive(_SpeedDrive):
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
        refuse([*self._start_problems(), *self._over_time_problems()])
        return self

    def speed_gains(self) -> tuple[float, float]:
        """Return the gains on the error of the speed and on its integral."""
        return self.proportional_gain, self.integral_gain


class MotorDrive(Actuator):
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
        refuse(nominal_problems(self, "voltage"))
        return self

    @property
    def speed(self) -> float:
        """No-load speed [rad/s]."""
        return self.voltage / self.torque_constant

    @property
    def proportional_gain(self) -> float:
        """Torque per speed below that without load, once the current has settled [N m s]."""
        return self.torque_constant**2 / self.resistance

    def nominal_speed(self) -> float:
        """Return the speed without load."""
        return self.speed

    def starting_speed(self) -> float:
        """Return the speed without load at the voltage of t = 0."""
        return (self.voltage if self.over_time is None else self.over_time.at_start) / self.torque_constant

    def excites(self) -> bool:
        """Return whether there is any voltage."""
        return self.voltage != 0.0 or self.over_time is not None

    def speed_gains(self) -> tuple[float, float]:
        """Return torque per speed, and 0: a motor is no spring."""
        return self.proportional_gain, 0.0


Drive = Annotated[
    Annotated[SpeedDrive, Tag("kind:speed")]
    | Annotated[TorqueDrive, Tag("kind:torque")]
    | Annotated[ServoDrive, Tag("kind:servo")]
    | Annotated[PositionDrive, Tag("kind:position")]
    | Annotated[CascadeDrive, Tag("kind:cascade")]
    | Annotated[MotorDrive, Tag("kind:motor")],
    ByKind("speed", "torque", "servo", "position", "cascade", "motor"),
]
