"""Sleeves: journals in bushes with radial clearance."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Any, Literal

from pydantic import Discriminator, Field, Tag, model_validator

from gearplay.model.fields import HertzStiffness, Measure, Offset, Part, Problem, RotorName, refuse
from gearplay.vocabulary import quantities as q

Law = Literal["lankarani-nikravesh", "hunt-crossley", "flores", "gonthier", "conformal"]


class Material(Part):
    """Linear elastic material."""

    modulus: Annotated[float, Measure(q.PRESSURE, "Young's modulus", gt=0.0)]
    poisson: Annotated[float, Measure(None, "Poisson's ratio", ge=0.0, lt=0.5)]


class MaterialPair(Part):
    """Materials of the two sides of a sleeve."""

    shaft: Material
    sleeve: Material


def _one_or_two(value: Any) -> str:
    if isinstance(value, dict):
        return "kind:pair" if "shaft" in value or "sleeve" in value else "kind:same"
    return "kind:pair" if isinstance(value, MaterialPair) else "kind:same"


class Sleeve(Part):
    """A journal in a bush; the rotor it supports is the table's name.

    The stiffness is given as `stiffness`, or follows from `shaft_radius`, `material` and `radial_clearance`
    by the Hertz formula (9) of Han et al. 2021 for parallel cylinders, whose exponent is 1.5.
    """

    radial_clearance: Annotated[
        float, Measure(q.LENGTH, "radius of the bush minus radius of the journal", ge=0.0, le=0.1)
    ]
    law: Annotated[Law, Field(description="contact law")] = "lankarani-nikravesh"
    exponent: Annotated[float, Measure(None, "exponent of the penetration", ge=1.0, le=3.0)] = 1.5
    stiffness: Annotated[float, HertzStiffness(q.HERTZ_STIFFNESS, "contact stiffness", gt=0.0)] | None = None
    shaft_radius: Annotated[float, Measure(q.LENGTH, "radius of the journal", gt=0.0, le=100.0)] | None = None
    material: (
        Annotated[
            Annotated[Material, Tag("kind:same")] | Annotated[MaterialPair, Tag("kind:pair")],
            Discriminator(_one_or_two),
        ]
        | None
    ) = None
    restitution: Annotated[float, Measure(None, "coefficient of restitution", gt=0.0, le=1.0)] = 0.9
    restitution_reading: Annotated[
        Literal["literal", "delivered"],
        Field(
            description="delivered solves the damping factor so that an impact really has this restitution"
        ),
    ] = "literal"
    minimum_impact_speed: Annotated[float, Measure(q.SPEED, "floor of the stored impact speed", gt=0.0)] = (
        1e-4
    )
    friction_coefficient: Annotated[float, Measure(None, "coefficient of friction", ge=0.0, le=2.0)] = 0.0
    friction_speed: Annotated[
        float, Measure(q.SPEED, "sliding speed within which friction is smoothed", gt=0.0)
    ] = 1e-3
    bed_exponent: Annotated[
        float, Measure(None, "exponent of the elastic bed (conformal)", ge=1.0, le=3.0)
    ] = 1.0
    bed_reference_penetration: Annotated[
        float, Measure(q.LENGTH, "penetration at which bed and point law agree (conformal)", gt=0.0, le=0.1)
    ] = 1e-6
    on: (
        Annotated[RotorName, Field(description="rotor that carries the bush; the ground if not given")] | None
    ) = None
    offset: Offset = (0.0, 0.0)

    @model_validator(mode="after")
    def _check(self) -> Sleeve:
        refuse(self._problems())
        return self

    def _problems(self) -> Iterator[Problem]:
        if self.stiffness is None and self.material is None:
            rule = "is required, or shaft_radius with material"
            yield Problem(("stiffness",), rule, "Give the stiffness, or the shaft radius and the material")
        if self.stiffness is not None and self.material is not None:
            rule = "must not be given beside a stiffness, which it would contradict"
            yield Problem(("material",), rule, "Remove one of the two")
        if self.material is not None:
            if self.shaft_radius is None:
                yield Problem(
                    ("shaft_radius",), "is required with a material", "Give the radius of the journal"
                )
            if self.radial_clearance == 0.0:
                rule = "must be greater than 0 m when the stiffness follows from a material"
                yield Problem(("radial_clearance",), rule, "Give a clearance, or the stiffness itself")
            if self.exponent != 1.5:
                rule = "must be 1.5 when the stiffness follows from a material"
                yield Problem(("exponent",), rule, "Remove it, or give the stiffness itself")
        elif self.shaft_radius is None:
            if self.law == "conformal":
                yield Problem(
                    ("shaft_radius",), "is required by the conformal law", "Give the radius of the journal"
                )
            if self.friction_coefficient > 0.0:
                rule = "is required with friction, for its torque on the rotor"
                yield Problem(("shaft_radius",), rule, "Give the radius of the journal")

    def sides(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Return (modulus [Pa], Poisson's ratio) of shaft and of sleeve; only where a material is given."""
        assert self.material is not None, "validated: asked for only without a stiffness"
        if isinstance(self.material, MaterialPair):
            shaft, sleeve = self.material.shaft, self.material.sleeve
        else:
            shaft = sleeve = self.material
        return (shaft.modulus, shaft.poisson), (sleeve.modulus, sleeve.poisson)
