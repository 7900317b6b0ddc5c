"""Meshes: two gears in contact, with the stiffness, damping and errors of their teeth."""

import math
from collections.abc import Iterator
from typing import Annotated, Any, Literal

from pydantic import Field, model_validator

from gearplay.parts.mesh.backlash import Backlash, CenterDistance
from gearplay.parts.mesh.stiffness import Phase, Stiffness
from gearplay.parts.mesh.wear import FlankWear
from gearplay.parts.rotor.allowance import DistanceAllowance
from gearplay.parts.rotor.gear import GearName, split_name
from gearplay.schema.fields import Listed, Measure, Order, Part, Problem, is_absent, refuse
from gearplay.vocabulary import quantities as q


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

    @model_validator(mode="before")
    @classmethod
    def _of_kind(cls, given: Any) -> Any:
        """Take ``{ kind = "constant", value = C }`` for ``{ law = "constant", maximum = C }``."""
        if not isinstance(given, dict) or "kind" not in given:
            return given
        rest = {name: value for name, value in given.items() if name not in ("kind", "value")}
        if given["kind"] != "constant":
            refuse([Problem(("kind",), 'must be "constant"', "Or give law, maximum or ratio, depth")])
        clashing = rest.keys() & {"law", "maximum", "ratio"}
        if clashing or "value" not in given:
            rule = (
                f"must not be given together with kind: {min(clashing)}"
                if clashing
                else "is required with kind"
            )
            refuse(
                [
                    Problem(
                        (min(clashing) if clashing else "value",),
                        rule,
                        'Write { kind = "constant", value = "500 N s/m" }',
                    )
                ]
            )
        return {**rest, "law": "constant", "maximum": given["value"]}

    @model_validator(mode="after")
    def _check(self) -> "Damping":
        problems = []
        if self.ratio is not None and self.maximum > 0.0:
            problems.append(
                Problem(("ratio",), "must not be given together with maximum", "Remove one of the two")
            )
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


Module = Annotated[float, Measure(q.LENGTH, "module, in the normal section", gt=0.0, le=10.0)]
PressureAngle = Annotated[
    float,
    Measure(q.ANGLE, "pressure angle at the reference circle", ge=math.radians(5.0), le=math.radians(45.0)),
]
ToothContact = Annotated[
    Literal["mesh", "pairs"],
    Field(
        description="mesh: one stiffness for all pairs of teeth in contact; pairs: each pair of teeth on its own",
        exclude_if=lambda contact: contact == "mesh",
    ),
]
TipContact = Annotated[
    bool,
    Field(
        description="with pairs: whether corners of the tips touch before and after the path of contact",
        exclude_if=lambda touches: touches,
    ),
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
    center_distance: CenterDistance | None = Field(default=None, exclude_if=is_absent)
    center_distance_allowance: (
        Annotated[
            DistanceAllowance,
            Field(description="of the centre distance: a class of DIN 3964, as js7, or upper and lower"),
        ]
        | None
    ) = Field(default=None, exclude_if=is_absent)
    backlash: Backlash | None = None
    stiffness: Stiffness
    contact: ToothContact = "mesh"
    tip_contact: TipContact = True
    wear: FlankWear | None = Field(default=None, exclude_if=is_absent)
    damping: Damping = Damping.model_construct()
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
        if isinstance(self.backlash, float) and self.backlash >= pitch:
            rule = f"must be less than the base pitch, {pitch:.4g} m"
            yield Problem(("backlash",), rule, "Check the number and its unit")
        if self.center_distance_allowance is not None and self.center_distance is None:
            rule = "must not be given without center_distance, from which it counts"
            yield Problem(("center_distance_allowance",), rule, "Give the centre distance")

    @property
    def label(self) -> str:
        """Name of the mesh in results: ``driver-driven``."""
        return f"{self.driver}-{self.driven}"

    @property
    def rotors(self) -> tuple[str, str]:
        """Rotors of driver and driven gear."""
        return split_name(self.driver, ())[0], split_name(self.driven, ())[0]


class PlanetMesh(Mesh):
    """A mesh within a planetary set; its gears have the names of their rotors, ``set.member``."""

    @property
    def rotors(self) -> tuple[str, str]:
        """Rotors of driver and driven gear."""
        return self.driver, self.driven
