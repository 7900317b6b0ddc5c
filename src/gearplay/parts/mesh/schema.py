"""Meshes: two gears in contact, with the stiffness, damping and errors of their teeth."""

import math
from collections.abc import Iterator
from typing import Annotated, Literal

import numpy as np
from pydantic import Field, Tag, model_validator

from gearplay.parts.rotor.gear import GearName, split_name
from gearplay.schema.fields import ByKind, Listed, Measure, Order, Part, Problem, is_absent, refuse
from gearplay.vocabulary import quantities as q

Phase = Annotated[float, Measure(q.ANGLE, "phase against the mesh phase psi")]
Mean = Annotated[float, Measure(q.STIFFNESS, "mean stiffness along the line of action", gt=0.0)]
Amplitude = Annotated[float, Measure(q.STIFFNESS, "amplitude (half peak to peak)")]
TablePhase = Annotated[float, Measure(q.ANGLE, "mesh phase", ge=0.0, lt=2.0 * math.pi)]
TableStiffness = Annotated[float, Measure(q.STIFFNESS, "stiffness at this phase", gt=0.0)]


class HarmonicStiffness(Part):
    """``K = mean + amplitude cos(psi + phase)``, equation (16) of Han et al. 2021."""

    kind: Literal["harmonic"] = "harmonic"
    mean: Mean
    amplitude: Annotated[float, Measure(q.STIFFNESS, "amplitude (half peak to peak)", ge=0.0)] = 0.0
    phase: Phase = 0.0

    @model_validator(mode="after")
    def _check(self) -> "HarmonicStiffness":
        if self.amplitude >= self.mean:
            rule = f"must be less than the mean, {self.mean:g} N/m, so that the stiffness stays positive"
            refuse([Problem(("amplitude",), rule, "Lower the amplitude or raise the mean")])
        return self


class SquareStiffness(Part):
    """One pair of teeth in contact, then two: `single` and `double`, by the contact ratio."""

    kind: Literal["square"] = "square"
    single: Annotated[float, Measure(q.STIFFNESS, "stiffness with one pair in contact", gt=0.0)]
    double: Annotated[float, Measure(q.STIFFNESS, "stiffness with two pairs in contact", gt=0.0)]
    contact_ratio: (
        Annotated[float, Measure(None, "contact ratio; from the geometry if not given", ge=1.0, lt=2.0)]
        | None
    ) = None
    phase: Phase = 0.0

    @model_validator(mode="after")
    def _check(self) -> "SquareStiffness":
        if self.double < self.single:
            rule = f"must be at least the stiffness of a single pair, {self.single:g} N/m"
            refuse([Problem(("double",), rule, "Exchange the two or correct one")])
        return self


class StiffnessTerm(Part):
    """One term ``amplitude cos(order psi + phase)``."""

    order: Order
    amplitude: Amplitude
    phase: Phase = 0.0


class FourierStiffness(Part):
    """``K = mean + sum of terms``."""

    kind: Literal["fourier"] = "fourier"
    mean: Mean
    terms: Annotated[tuple[StiffnessTerm, ...], Listed(0, 64, "terms over the mean")]

    @model_validator(mode="after")
    def _check(self) -> "FourierStiffness":
        if sum(abs(term.amplitude) for term in self.terms) >= self.mean:  # else it cannot reach 0
            lowest, phase = self._lowest()
            if lowest <= 0.0:
                where = f"at a mesh phase of {math.degrees(phase):.4g} deg it is {lowest:.4g} N/m"
                rule = f"must keep the stiffness positive: {where}"
                refuse([Problem(("terms",), rule, "Lower the amplitudes or raise the mean")])
        return self

    def _lowest(self) -> tuple[float, float]:
        """Return the minimum of the curve [N/m] and its mesh phase [rad]: 64 samples a wave, then Newton's method."""
        order, amplitude, phase = np.array([(t.order, t.amplitude, t.phase) for t in self.terms]).T
        psi = 2.0 * np.pi * np.arange(64 * order.max()) / (64 * order.max())
        at = float(psi[np.argmin(amplitude @ np.cos(np.outer(order, psi) + phase[:, None]))])
        for _ in range(4):
            angle = order * at + phase
            curvature = -float(order**2 * amplitude @ np.cos(angle))
            if curvature <= 0.0:
                break
            at += float(order * amplitude @ np.sin(angle)) / curvature
        return self.mean + float(amplitude @ np.cos(order * at + phase)), at % (2.0 * math.pi)


CLOSEST = 1e-9
"""Least distance [rad] of two points of a stiffness table: closer ones make a jump that rounding of psi could overshoot."""


class TableStiffnessCurve(Part):
    """Stiffness at given mesh phases, a periodic curve that stays between neighbouring points (shape-preserving cubic)."""

    kind: Literal["table"] = "table"
    phase: Annotated[tuple[TablePhase, ...], Listed(4, 4096, "mesh phases, rising")]
    stiffness: Annotated[tuple[TableStiffness, ...], Listed(4, 4096, "stiffness at each phase")]

    @model_validator(mode="after")
    def _check(self) -> "TableStiffnessCurve":
        problems = []
        ends = (*self.phase[1:], self.phase[0] + 2.0 * math.pi)
        if any(b - a < CLOSEST for a, b in zip(self.phase, ends, strict=True)):
            rule = (
                f"must rise strictly from item to item, by {CLOSEST:g} rad or more, also around to the first"
            )
            problems.append(Problem(("phase",), rule, "Sort it, remove repeats"))
        if len(self.phase) != len(self.stiffness):
            rule = f"must have as many items as phase, {len(self.phase)}"
            problems.append(Problem(("stiffness",), rule, "Add or remove items"))
        refuse(problems)
        return self


class Iso6336Stiffness(Part):
    """Stiffness from the facewidth, by ISO 6336-1 method B."""

    kind: Literal["iso6336"] = "iso6336"
    facewidth: Annotated[float, Measure(q.LENGTH, "common facewidth", gt=0.0, le=100.0)]
    modulus: Annotated[float, Measure(q.PRESSURE, "Young's modulus of both gears", gt=0.0)] = 206e9
    amplitude_ratio: Annotated[float, Measure(q.RATIO, "amplitude over mean", ge=0.0, lt=1.0)] = 0.0
    phase: Phase = 0.0


Stiffness = Annotated[
    Annotated[HarmonicStiffness, Tag("kind:harmonic")]
    | Annotated[SquareStiffness, Tag("kind:square")]
    | Annotated[FourierStiffness, Tag("kind:fourier")]
    | Annotated[TableStiffnessCurve, Tag("kind:table")]
    | Annotated[Iso6336Stiffness, Tag("kind:iso6336")],
    ByKind("harmonic", "square", "fourier", "table", "iso6336"),
]


class Damping(Part):
    """Damping of the teeth: `maximum`, or a damping `ratio`, that rises with penetration or is constant.

    `law = "ramp"` has all of it from the penetration `depth` on, `law = "constant"` from the first touch on. Without `depth` it
    is half the deflection under the load of the case, at least 0.01 um, or 1 um where there is no load.
    """

    maximum: Annotated[float, Measure(q.DAMPING, "damping from the depth on", ge=0.0)] = 0.0
    ratio: Annotated[float, Measure(q.RATIO, "damping ratio, instead of maximum", ge=0.0, le=2.0)] | None = (
        None
    )
    law: Annotated[
        Literal["ramp", "constant"],
        Field(
            description="ramp: rises with penetration; constant: K p + C dp/dt, cut at zero",
            exclude_if=lambda law: law == "ramp",
        ),
    ] = "ramp"
    depth: (
        Annotated[
            float,
            Measure(
                q.LENGTH,
                "penetration of full damping; half the deflection under load if not given",
                gt=0.0,
                le=0.1,
            ),
        ]
        | None
    ) = Field(default=None, exclude_if=lambda depth: depth is None)
    ramp: Annotated[
        Literal["smooth", "literal"],
        Field(description="smooth: cubic ramp; literal: as Han et al. 2021 print it"),
    ] = "smooth"

    @model_validator(mode="after")
    def _check(self) -> "Damping":
        problems = []
        if self.ratio is not None and self.maximum > 0.0:
            problems.append(Problem(("ratio",), "must not be given beside maximum", "Remove one of the two"))
        if self.law == "constant" and self.depth is not None:
            problems.append(
                Problem(("depth",), 'must not be given with law = "constant"', "Remove one of the two")
            )
        if self.law == "constant" and self.ramp != "smooth":
            problems.append(
                Problem(("ramp",), 'must not be given with law = "constant"', "Remove one of the two")
            )
        refuse(problems)
        return self


class ErrorTerm(Part):
    """One term ``amplitude sin(order psi + phase)`` of the static transmission error."""

    order: Order
    amplitude: Annotated[float, Measure(q.LENGTH, "amplitude (half peak to peak) along the line of action")]
    phase: Phase = 0.0


Module = Annotated[float, Measure(q.LENGTH, "module", gt=0.0, le=10.0)]
PressureAngle = Annotated[
    float,
    Measure(q.ANGLE, "pressure angle at the reference circle", ge=math.radians(5.0), le=math.radians(45.0)),
]
FRICTION_SPEED = 1e-3
"""Sliding speed [m/s] within which friction is smoothed by default."""


class Mesh(Part):
    """Two gears in mesh."""

    driver: Annotated[
        GearName, Field(description="gear whose teeth count the mesh phase: rotor or rotor.gear")
    ]
    driven: Annotated[GearName, Field(description="the other gear")]
    module: Module
    pressure_angle: PressureAngle = math.radians(20.0)
    backlash: Annotated[
        float, Measure(q.LENGTH, "total backlash, normal, at the nominal centre distance", ge=0.0, le=10.0)
    ]
    stiffness: Stiffness
    damping: Damping = Damping()
    transmission_error: Annotated[
        tuple[ErrorTerm, ...], Listed(0, 64, "terms of the static transmission error")
    ] = ()
    friction_coefficient: Annotated[
        float,
        Measure(None, "coefficient of friction of the teeth", ge=0.0, le=1.0),
        Field(exclude_if=is_absent),
    ] = 0.0
    friction_phase: Annotated[
        float,
        Measure(q.ANGLE, "a pair of teeth passes the pitch point where psi and it make a whole turn"),
        Field(exclude_if=is_absent),
    ] = 0.0
    friction_speed: Annotated[
        float,
        Measure(q.SPEED, "sliding speed of the flanks from which on friction is full", gt=0.0),
        Field(exclude_if=lambda speed: speed == FRICTION_SPEED),
    ] = FRICTION_SPEED
    angle: (
        Annotated[
            float,
            Measure(
                q.ANGLE,
                "direction of the driven centre from the driver's, counter-clockwise from +x; as laid out if not given",
            ),
        ]
        | None
    ) = Field(default=None, exclude_if=lambda angle: angle is None)
    phase: Annotated[
        float,
        Measure(q.ANGLE, "mesh phase psi at the start, beside that of the place of the gears"),
        Field(exclude_if=is_absent),
    ] = 0.0

    @model_validator(mode="after")
    def _check(self) -> "Mesh":
        refuse(self._problems())
        return self

    def _problems(self) -> Iterator[Problem]:
        if self.rotors[0] == self.rotors[1]:
            what = (
                "differ from the driver"
                if self.driver == self.driven
                else "be on another rotor than the driver"
            )
            yield Problem(("driven",), f"must {what}", "Name the other gear")
        pitch = math.pi * self.module * math.cos(self.pressure_angle)
        if self.backlash >= pitch:
            rule = f"must be less than the base pitch, {pitch:.4g} m"
            yield Problem(("backlash",), rule, "Check the number and its unit")

    @property
    def label(self) -> str:
        """Name of the mesh in results: ``driver-driven``."""
        return f"{self.driver}-{self.driven}"

    @property
    def rotors(self) -> tuple[str, str]:
        """Rotors of driver and driven gear."""
        return split_name(self.driver, ())[0], split_name(self.driven, ())[0]


class PlanetMesh(Mesh):
    """A mesh within a planetary set, whose gears are called as their rotors: ``set.member``."""

    @property
    def rotors(self) -> tuple[str, str]:
        """Rotors of driver and driven gear."""
        return self.driver, self.driven
