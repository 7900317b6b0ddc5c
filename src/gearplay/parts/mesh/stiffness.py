"""Stiffness of the teeth in case files: terms, square wave, table, ISO 6336-1, teeth as drawn."""

import math
from typing import Annotated, Literal

import numpy as np
from pydantic import Field, Tag, model_validator

from gearplay.schema.fields import ByKind, Listed, Measure, Order, Part, Problem, refuse
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


class TeethStiffness(Part):
    """Stiffness over the actual path of contact, from the drawing of the teeth; both gears need a facewidth.

    `method = "iso6336"`: single stiffness of ISO 6336-1 method B with its factor of light loads and a parabola over the path
    whose mean is ISO's c_gamma. `method = "potential-energy"`: bending, shear and compression of the tooth that the rack cuts,
    its foundation, Hertzian contact; of spur gears.
    """

    kind: Literal["teeth"] = "teeth"
    method: Annotated[
        Literal["iso6336", "potential-energy"], Field(description="how a pair of teeth is computed")
    ]
    modulus: Annotated[float, Measure(q.PRESSURE, "Young's modulus of both gears", gt=0.0)] = 206e9
    poisson: Annotated[
        float, Measure(None, "Poisson's ratio of both gears, of potential-energy", ge=0.0, lt=0.5)
    ] = 0.3
    line_load: (
        Annotated[
            float,
            Measure(
                q.STIFFNESS,
                "nominal F_t/b, of iso6336, which is softer below 100 N/mm; by the load of the case if not given",
                gt=0.0,
            ),
        ]
        | None
    ) = None


Stiffness = Annotated[
    Annotated[HarmonicStiffness, Tag("kind:harmonic")]
    | Annotated[SquareStiffness, Tag("kind:square")]
    | Annotated[FourierStiffness, Tag("kind:fourier")]
    | Annotated[TableStiffnessCurve, Tag("kind:table")]
    | Annotated[Iso6336Stiffness, Tag("kind:iso6336")]
    | Annotated[TeethStiffness, Tag("kind:teeth")],
    ByKind("harmonic", "square", "fourier", "table", "iso6336", "teeth"),
]
