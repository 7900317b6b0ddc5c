"""Drives that bring a rotor to an angle: position loop, cascade of loops."""

import math
from abc import abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Final, Literal, Self

from pydantic import Field, model_validator

from gearplay.parts.drive.over_time import OVER_TIME, SetPoint, nominal_problems
from gearplay.parts.protocol import Actuator
from gearplay.schema.fields import Measure, Problem, RotorName, is_absent, refuse
from gearplay.schema.finding import Finding
from gearplay.vocabulary import quantities as q

FEWEST_SAMPLES: Final = 10
"""Samples of a control that a run should hold at least."""

Angle = Annotated[float, Measure(q.ANGLE, "set-point of the angle")]
SensorAngle = Annotated[float, Measure(q.ANGLE, "set-point of the rotation of the sensor's rotor")]
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


@dataclass(frozen=True)
class Loop:
    """Gains of the law T = s (kp e + ki z - kd c omega), z' = e - share c omega, with the lead [s] of the set-point in e."""

    proportional_gain: float
    integral_gain: float
    derivative_gain: float
    share: float = 0.0
    lead: float = 0.0
    every: int = 1


class LoopDrive(Actuator):
    """Base of drives that bring a rotor to an angle."""

    positions: ClassVar[bool] = True
    if TYPE_CHECKING:
        angle: float
        torque_limit: float
        sensor: str | None
        sample_time: float
        delay: float
        resolution: float
        speed_resolution: float
        current_time: float
        over_time: Any

    @abstractmethod
    def measures_speed_of(self, name: str) -> str:
        """Return the rotor whose speed is measured, of a drive of the rotor ``name``."""

    @abstractmethod
    def loop(self, ratio: float) -> Loop:
        """Return the gains where the speed sensor turns ``ratio`` times per turn of the angle's sensor."""

    def nominal_speed(self) -> float:
        """Return 0 rad/s: it turns no further than to its angle."""
        return 0.0

    def push(self, name: str) -> tuple[str, float]:
        """Return the rotor of the sensor, and the torque towards the angle."""
        torque = min(abs(self.loop(1.0).proportional_gain * self.angle), self.torque_limit)
        return self.sensor or name, math.copysign(torque, self.angle)

    def time_invariant(self) -> Self:
        """Return the loop at rest in its place: exact, continuous and without integral."""
        names = ("angle", "integral_gain", "sample_time", "delay", "resolution", "speed_resolution")
        return self.model_copy(update={**dict.fromkeys(names, 0.0), "over_time": None})

    def findings(self, path: str, span: float) -> Iterator[Finding]:
        """Yield a finding for a run that holds few samples."""
        if self.sample_time > 0.0 and (samples := span / self.sample_time) < FEWEST_SAMPLES:
            text = f"the whole run holds {samples:.3g} samples of the control: the torque is held in between"
            yield Finding("warning", f"{path}.sample_time", f"{text}.")

    def _sample_problems(self) -> Iterator[Problem]:
        """Yield what needs a sampled control, and a delay that is too long."""
        if self.sample_time == 0.0:
            for name in ("delay", "resolution", "speed_resolution"):
                if getattr(self, name) > 0.0:
                    cure = "Give a sample_time, or remove it"
                    yield Problem((name,), "must be 0 for a continuous control", cure)
        elif self.delay > self.sample_time:
            rule = f"must be at most sample_time, {self.sample_time:g} s"
            yield Problem(("delay",), rule, "Shorten it")


class PositionDrive(LoopDrive):
    """Position loop with a torque limit: ``T = kp (angle - theta) + ki integral - kd omega``, of the rotor itself or of sensors.

    Where the sensor's rotor turns against this one the torque has the other sign. With a ``sample_time`` the torque is computed
    at t = 0 and then once in that time, and held; then encoders may have a resolution and the torque a delay.
    """

    kind: Literal["position"] = "position"
    angle: SensorAngle
    proportional_gain: Annotated[
        float, Measure(q.ROTATIONAL_STIFFNESS, "gain on the error of the angle", gt=0.0)
    ]
    derivative_gain: Annotated[float, Measure(q.ROTATIONAL_DRAG, "gain on the sensor's speed", ge=0.0)] = 0.0
    integral_gain: Annotated[float, Measure(q.INTEGRAL_GAIN, "gain on the integral of the error", ge=0.0)] = (
        0.0
    )
    torque_limit: TorqueLimit
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
        refuse([*self._sample_problems(), *nominal_problems(self, "angle")])
        return self

    def loop(self, ratio: float) -> Loop:
        """Return the gains, the same for any ratio."""
        return Loop(self.proportional_gain, self.integral_gain, self.derivative_gain)

    def measures_speed_of(self, name: str) -> str:
        """Return the rotor whose speed is measured, by default that of the angle's sensor."""
        return self.speed_sensor or self.sensor or name


class CascadeDrive(LoopDrive):
    """Cascade of position, speed and current loops with a torque limit.

    The position loop wants the speed ``v = ratio (position_gain (angle - theta) + feedforward angle')`` of the speed sensor's
    rotor, by default this one, the speed loop the torque ``speed_gain (v - omega) + integral_gain integral of (v - omega)``; the
    current loop follows with ``current_time``. With a ``sample_time`` the speed loop is sampled, the position loop each
    ``position_every``-th time.
    """

    kind: Literal["cascade"] = "cascade"
    angle: SensorAngle
    position_gain: Annotated[
        float, Measure(q.ANGULAR_SPEED, "speed wanted per error of the angle [1/s]", gt=0.0)
    ]
    speed_gain: Annotated[float, Measure(q.ROTATIONAL_DRAG, "gain on the error of the speed", gt=0.0)]
    integral_gain: Annotated[
        float, Measure(q.ROTATIONAL_STIFFNESS, "gain on the integral of the speed's error", ge=0.0)
    ] = 0.0
    feedforward: Annotated[
        float, Measure(q.RATIO, "share of the set-point's speed that is wanted at once", ge=0.0, le=1.0)
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
        problems = list(self._sample_problems())
        if self.position_every > 1 and self.sample_time == 0.0:
            rule = "must be 1 for a continuous control"
            problems.append(Problem(("position_every",), rule, "Give a sample_time"))
        refuse([*problems, *nominal_problems(self, "angle")])
        return self

    def loop(self, ratio: float) -> Loop:
        """Return the gains; it wants the speed ratio (position_gain e + feedforward angle') of the speed sensor's rotor."""
        speed_per_angle = abs(ratio) * self.position_gain
        return Loop(
            proportional_gain=self.speed_gain * speed_per_angle,
            integral_gain=self.integral_gain * speed_per_angle,
            derivative_gain=self.speed_gain,
            share=1.0 / speed_per_angle,
            lead=self.feedforward / self.position_gain,
            every=self.position_every,
        )

    def measures_speed_of(self, name: str) -> str:
        """Return the rotor whose speed is measured, by default the driven one."""
        return self.speed_sensor or name

    def time_invariant(self) -> Self:
        """Return the cascade at rest in its place, its loops at one rate."""
        return super().time_invariant().model_copy(update={"position_every": 1})
