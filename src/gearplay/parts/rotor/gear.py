"""Gears of rotors as their drawings define them, and their names in meshes."""

import math
from collections.abc import Container, Iterator
from typing import Annotated, Any

from pydantic import Field, model_validator

from gearplay.parts.rotor.allowance import ThicknessAllowance
from gearplay.parts.rotor.deviations import Quality, TipRelief, ToothDeviations
from gearplay.schema.fields import NAME, Measure, Part, Problem, is_absent, refuse
from gearplay.toothing.allowances import thickness_allowances
from gearplay.toothing.gear import ADDENDUM, DEDENDUM, TIP_RADIUS, DrawnGear
from gearplay.vocabulary import quantities as q

GearName = Annotated[
    str,
    Field(
        pattern=rf"^{NAME}(\.{NAME})?$",
        description="rotor, or rotor.gear: names of a letter, then at most 31 letters, digits or _",
    ),
]
Teeth = Annotated[int, Field(ge=6, le=10_000, description="number of teeth; required in a mesh")]
Internal = Annotated[bool, Field(description="true for a ring gear")]


class Runout(Part):
    """Eccentricity of the toothing (half the indicator reading) and where it points at ``theta = 0``."""

    amplitude: Annotated[
        float, Measure(q.LENGTH, "eccentricity (half the indicator reading)", ge=0.0, le=0.1)
    ] = 0.0
    phase: Annotated[float, Measure(q.ANGLE, "direction of the eccentricity at theta = 0")] = 0.0


class Toothing(Part):
    """Teeth as a drawing defines them; without any of these fields full-depth spur teeth without shift."""

    profile_shift: Annotated[
        float,
        Measure(
            None,
            "profile shift x in modules; positive moves material away from the gear's own axis, of a ring too",
            ge=-3.0,
            le=3.0,
        ),
        Field(exclude_if=is_absent),
    ] = 0.0
    helix_angle: Annotated[
        float,
        Measure(
            q.ANGLE,
            "helix angle at the reference cylinder, of either hand; module and pressure_angle of the mesh are then normal ones",
            ge=-math.radians(45.0),
            le=math.radians(45.0),
        ),
        Field(exclude_if=is_absent),
    ] = 0.0
    tip_diameter: (
        Annotated[float, Measure(q.LENGTH, "diameter of the tip circle, instead of addendum", gt=0.0)] | None
    ) = Field(default=None, exclude_if=is_absent)
    addendum: Annotated[
        float,
        Measure(None, "addendum in modules, from the reference circle moved by the shift", gt=0.0, le=3.0),
        Field(exclude_if=lambda given: given == ADDENDUM),
    ] = ADDENDUM
    dedendum: Annotated[
        float,
        Measure(None, "dedendum of the rack in modules", gt=0.0, le=3.0),
        Field(exclude_if=lambda given: given == DEDENDUM),
    ] = DEDENDUM
    tip_radius: Annotated[
        float,
        Measure(None, "radius of the rack's tips in modules, at most that of a full round", ge=0.0, le=2.0),
        Field(exclude_if=lambda given: given == TIP_RADIUS),
    ] = TIP_RADIUS
    facewidth: Annotated[float, Measure(q.LENGTH, "facewidth", gt=0.0, le=100.0)] | None = Field(
        default=None, exclude_if=is_absent
    )
    bore: (
        Annotated[
            float,
            Measure(q.LENGTH, "diameter of the bore, for the stiffness of the body under the teeth", gt=0.0),
        ]
        | None
    ) = Field(default=None, exclude_if=is_absent)
    allowance: (
        Annotated[
            ThicknessAllowance,
            Field(
                description="of the normal tooth thickness: a class of DIN 3967, as c25, or upper and lower"
            ),
        ]
        | None
    ) = Field(default=None, exclude_if=is_absent)
    thickness: (
        Annotated[
            float,
            Measure(q.LENGTH, "normal tooth thickness at the reference circle, instead of allowance", gt=0.0),
        ]
        | None
    ) = Field(default=None, exclude_if=is_absent)

    tip_relief: TipRelief | None = Field(default=None, exclude_if=is_absent)
    quality: Quality | None = Field(default=None, exclude_if=is_absent)
    deviations: ToothDeviations | None = Field(default=None, exclude_if=is_absent)

    @model_validator(mode="after")
    def _check_toothing(self) -> "Toothing":
        refuse(self._toothing_problems())
        return self

    def _toothing_problems(self) -> Iterator[Problem]:
        if self.tip_diameter is not None and self.addendum != ADDENDUM:
            yield Problem(
                ("addendum",), "must not be given together with tip_diameter", "Remove one of the two"
            )
        if self.thickness is not None and self.allowance is not None:
            yield Problem(
                ("allowance",), "must not be given together with thickness", "Remove one of the two"
            )
        if self.quality is not None and self.deviations is not None:
            yield Problem(("quality",), "must not be given together with deviations", "Remove one of the two")

    @property
    def drawn(self) -> list[str]:
        """Fields of the drawing that differ from their defaults."""
        return [name for name, info in Toothing.model_fields.items() if getattr(self, name) != info.default]

    @property
    def deviates(self) -> bool:
        """Whether its teeth deviate from involutes in their places: relieved, drawn within a class or measured."""
        relieved = self.tip_relief is not None and self.tip_relief.amount > 0.0
        return (
            relieved or self.quality is not None or (self.deviations is not None and self.deviations.deviate)
        )

    def toothing(self) -> dict[str, Any]:
        """Return the fields of the drawing by name."""
        return {name: getattr(self, name) for name in Toothing.model_fields}

    def thickness_change(
        self, module: float, pressure_angle: float, teeth: int, sign: float
    ) -> tuple[float, float]:
        """Return upper and lower change of the normal tooth thickness [m] from that of the shift; ``sign`` -1 of a ring.

        NaN for a class that the table of DIN 3967 does not have.
        """
        if self.thickness is not None:
            shift = 2.0 * self.profile_shift * math.tan(pressure_angle)
            change = self.thickness - (0.5 * math.pi + sign * shift) * module
            return change, change
        if isinstance(self.allowance, str):
            diameter = module * teeth / math.cos(self.helix_angle)
            return thickness_allowances(self.allowance, diameter) or (math.nan, math.nan)
        return (self.allowance.upper, self.allowance.lower) if self.allowance is not None else (0.0, 0.0)

    def drawing(
        self, module: float, pressure_angle: float, teeth: int, *, internal: bool, place: float = 0.5
    ) -> DrawnGear:
        """Return the gear with the module [m] and the pressure angle [rad] of its mesh.

        ``place`` of its tooth thickness between the lower (0) and the upper (1) limit.
        """
        upper, lower = self.thickness_change(module, pressure_angle, teeth, -1.0 if internal else 1.0)
        return DrawnGear(
            teeth=teeth,
            module=module,
            pressure_angle=pressure_angle,
            helix_angle=abs(self.helix_angle),
            internal=internal,
            profile_shift=self.profile_shift,
            addendum=self.addendum,
            dedendum=self.dedendum,
            tip_radius=self.tip_radius,
            tip_diameter=self.tip_diameter,
            thickness_change=upper if upper == lower else lower + place * (upper - lower),
            facewidth=self.facewidth,
            bore=self.bore,
        )


class Gear(Toothing):
    """One of several gears that a rotor carries."""

    teeth: Teeth
    internal: Internal = False
    runout: Runout = Runout.model_construct()


def split_name(name: str, rotors: Container[str]) -> tuple[str, str]:
    """Return rotor and gear from the name of a gear in a mesh, "" for the only gear of a rotor.

    >>> split_name("layshaft.wheel", ["layshaft"]), split_name("stage.sun", ["stage.sun"])
    (('layshaft', 'wheel'), ('stage.sun', ''))
    """
    if name in rotors:
        return name, ""
    rotor, _, gear = name.partition(".")
    return rotor, gear


def grown(gear: Any, factor: float) -> dict[str, object]:
    """Return the runout and the lengths of the drawing of a gear, or of a rotor, times a factor."""
    lengths = {
        field: factor * value
        for field in ("tip_diameter", "bore", "facewidth", "thickness")
        if (value := getattr(gear, field)) is not None
    }
    return {
        "runout": gear.runout.model_copy(update={"amplitude": factor * gear.runout.amplitude}),
        **lengths,
    }
