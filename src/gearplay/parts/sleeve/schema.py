"""Sleeves: journals in bushes with radial clearance."""

import math
from collections.abc import Iterator
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Discriminator, Field, Tag, model_validator

from gearplay.parts.assembly import Contact, blank
from gearplay.parts.protocol import Holder, Packing
from gearplay.parts.sleeve import conformal, contact_laws, law, line
from gearplay.parts.sleeve.wear import BushWear
from gearplay.schema.fields import (
    HertzStiffness,
    Measure,
    Offset,
    Part,
    Problem,
    RotorName,
    is_absent,
    refuse,
)
from gearplay.schema.finding import Finding, micrometres
from gearplay.vocabulary import quantities as q
from gearplay.vocabulary.errors import NO_VALUE, InputError

MOST_CLEARANCE = 0.1
"""Largest radial clearance [m]."""
TYPICAL_DEPTH = 1e-6
"""Penetration [m] at which a contact's angular frequency is estimated."""

Law = Literal["lankarani-nikravesh", "hunt-crossley", "flores", "gonthier", "conformal", "johnson", "liu"]
LINES = {"johnson": line.LINE_JOHNSON, "liu": line.LINE_LIU}


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


class Sleeve(Holder):
    """A journal in a bush; the rotor it supports is the table's name.

    The stiffness is given as `stiffness`, or follows from `shaft_radius`, `material` and `radial_clearance`
    by the Hertz formula (9) of Han et al. 2021 for parallel cylinders, whose exponent is 1.5.
    """

    kind: ClassVar[int] = law.KIND
    noun: ClassVar[str] = "bush"
    has_clearance: ClassVar[bool] = True

    radial_clearance: Annotated[
        float, Measure(q.LENGTH, "radius of the bush minus radius of the journal", ge=0.0, le=MOST_CLEARANCE)
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
    length: Annotated[
        Annotated[
            float, Measure(q.LENGTH, "length of the bush, of a line contact (johnson, liu)", gt=0.0, le=100.0)
        ]
        | None,
        Field(exclude_if=is_absent),
    ] = None
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
    rotor_side: Annotated[
        Literal["journal", "bush"],
        Field(
            description="side that the rotor is, the bush for a planet on its pin: for friction, and clearance at temperature"
        ),
    ] = "journal"
    offset: Offset = (0.0, 0.0)
    wear: BushWear | None = Field(default=None, exclude_if=is_absent)

    @model_validator(mode="after")
    def _check(self) -> "Sleeve":
        refuse(self._problems())
        return self

    def _line_problems(self) -> Iterator[Problem]:
        if self.length is None:
            yield Problem(("length",), f"is required by the law {self.law}", "Give the length of the bush")
        if self.material is None:
            yield Problem(
                ("material",), f"is required by the law {self.law}", "Give modulus and Poisson's ratio"
            )
        if self.stiffness is not None:
            rule = (
                f"must not be given with the law {self.law}, whose stiffness follows from length and material"
            )
            yield Problem(("stiffness",), rule, "Remove it")
        if self.radial_clearance == 0.0:
            rule = f"must be greater than 0 m with the law {self.law}"
            yield Problem(("radial_clearance",), rule, "Give a clearance, or choose another law")
        if self.friction_coefficient > 0.0 and self.shaft_radius is None:
            rule = "is required with friction, for its torque on the rotor"
            yield Problem(("shaft_radius",), rule, "Give the radius of the journal")

    def _problems(self) -> Iterator[Problem]:
        if self.law in LINES:
            yield from self._line_problems()
            return
        if self.length is not None:
            rule = f"must not be given with the law {self.law}, a contact at a point"
            yield Problem(("length",), rule, 'Remove it, or choose law = "johnson" or "liu"')
        if self.stiffness is None and self.material is None:
            rule = "is required, or shaft_radius with material"
            yield Problem(("stiffness",), rule, "Give the stiffness, or the shaft radius and the material")
        if self.stiffness is not None and self.material is not None:
            rule = "must not be given together with a stiffness, which it would contradict"
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

    def clearance(self) -> float | None:
        """Return the radial clearance [m]."""
        return self.radial_clearance

    def contact_stiffness(self) -> float:
        """Return the contact stiffness [N/m^exponent], as given or from radius and materials by (9)."""
        if self.stiffness is not None:
            return self.stiffness
        assert self.shaft_radius is not None, "validated: a sleeve without stiffness has its geometry"
        return contact_laws.hertz_stiffness(self.shaft_radius, self.radial_clearance, *self.sides())

    def pack(self, packing: Packing, name: str, damping: float) -> None:
        """Add its element: one contact, which without clearance touches from the start."""
        s = blank(law.RECORD)
        s.clearance, s.exponent = self.radial_clearance, self.exponent
        s.shaft_radius = self.shaft_radius or 0.0
        s.line = LINES.get(self.law, line.LINE_NONE)
        if s.line == line.LINE_NONE:
            s.stiffness = self.contact_stiffness()
        else:
            s.line_length, s.line_modulus = self.length or 0.0, line.contact_modulus(self.sides())
        s.dissipation = (
            contact_laws.solved_dissipation(self.restitution)
            if self.restitution_reading == "delivered"
            else contact_laws.literal_dissipation(self.law, self.restitution)
        )
        s.friction, s.friction_speed = self.friction_coefficient, self.friction_speed
        s.is_bush = int(self.rotor_side == "bush")
        s.journal, s.bush = packing.place(name), packing.place(self.on)
        s.misplaced_x, s.misplaced_y = self.offset
        s.offset_x, s.offset_y = (a + b for a, b in zip(packing.arm(name, self.on), self.offset, strict=True))
        s.damping = damping
        s.bed = conformal.BED_NONE
        if self.law == "conformal" and packing.as_published:
            s.bed, s.bed_exponent = conformal.BED_AS_PRINTED, self.exponent
        elif self.law == "conformal":
            s.bed, s.bed_exponent = conformal.BED_MATCHED, self.bed_exponent
            s.bed_stiffness = contact_laws.bed_stiffness(
                s.stiffness, s.exponent, s.clearance, s.shaft_radius, s.bed_exponent, self.bed_reference_penetration
            )  # fmt: skip
        contact = Contact(floor=self.minimum_impact_speed, closed=self.radial_clearance == 0.0)
        stiffness = s.stiffness * s.exponent * TYPICAL_DEPTH ** (s.exponent - 1.0)
        if s.line != line.LINE_NONE:
            stiffness = line.line_slope(s, TYPICAL_DEPTH)
        packing.assembly.add(
            law,
            name,
            s,
            [s.journal, s.bush],
            [contact],
            always=damping > 0.0,
            rate=math.sqrt(stiffness * max(packing.records[s.journal].inv_mass, 1e-3)),
            hides=bool(s.dissipation > 0.0) and s.bed != conformal.BED_AS_PRINTED,
        )

    def at_temperature(self, path: str, journal: float, bush: float) -> "Sleeve":
        """Return the sleeve with its radius and clearance, (R + c) f_bush - R f_journal.

        The factors are those of the rotor and of its seat, in turn where the rotor is the bush.

        Raises `InputError` where the radius is not given, or the journal no longer fits its bush.
        """
        if bush == 1.0 and journal == 1.0:
            return self
        if self.shaft_radius is None:
            rule = "is required at a temperature other than the reference temperature, where it changes the clearance"
            raise InputError.of(f"{path}.shaft_radius", NO_VALUE, rule, "Give the radius of the journal")
        if self.rotor_side == "bush":
            journal, bush = bush, journal
        clearance = (self.shaft_radius + self.radial_clearance) * bush - self.shaft_radius * journal
        if clearance < 0.0:
            rule = f"is {1e6 * clearance:.4g} um at temperature: the journal no longer fits its bush"
            cure = "Raise it, or choose materials that expand alike"
            raise InputError.of(
                f"{path}.radial_clearance", f"{1e6 * self.radial_clearance:.4g} um", rule, cure
            )
        grown = {"radial_clearance": clearance, "shaft_radius": self.shaft_radius * journal}
        return self.model_copy(update=grown)

    def thermal_change(self, hot: "Sleeve") -> tuple[str, str]:
        """Return its clearance at temperature as a text."""
        warm, cold = hot.radial_clearance, self.radial_clearance
        text = f"at temperature it is {1e6 * warm:.1f} um, {micrometres(warm - cold)}"
        return "radial_clearance", text

    def findings(self, path: str, *, held: bool, alone: bool) -> Iterator[Finding]:
        """Yield a finding on the end of Johnson's law."""
        if self.law != "johnson" or self.length is None:
            return
        depth = 4.0 * line.DEEPEST * self.radial_clearance
        force = math.pi * line.contact_modulus(self.sides()) * depth * self.length
        text = f"Johnson's law is one-valued up to {1e6 * depth:.4g} um and {force:.4g} N: a run that presses deeper ends there"
        yield Finding("note", f"{path}.law", f"{text}.")

    def time_invariant(self) -> "Sleeve":
        """Return the sleeve without friction and with a restitution of 1."""
        still = {"restitution": 1.0, "restitution_reading": "literal", "friction_coefficient": 0.0}
        return self.model_copy(update=still)
