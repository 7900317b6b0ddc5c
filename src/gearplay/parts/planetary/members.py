"""Parts of a planetary set: members, planets, position errors."""

import math
from collections.abc import Callable
from typing import Annotated, Any

from pydantic import Field, ValidationError, model_validator

from gearplay.parts.drive.schema import Drive, SpeedDrive
from gearplay.parts.environment import Material, Temperature
from gearplay.parts.planetary.names import MOST_PLANETS
from gearplay.parts.rotor.gear import Runout, Teeth, Toothing
from gearplay.parts.rotor.schema import Inertia, Initial, Load, Mass, Rotor, Weight
from gearplay.parts.rotor.unbalance import Unbalance
from gearplay.parts.sleeve.schema import MOST_CLEARANCE, Sleeve
from gearplay.parts.support.schema import Support
from gearplay.schema.fields import Listed, Measure, Part, Problem, refuse
from gearplay.vocabulary import quantities as q

PlanetNumber = Annotated[int, Field(ge=1, le=MOST_PLANETS, description="number of the planet, from 1")]


def problems_of(make: Callable[[], object]) -> list[Problem]:
    """Return the problems of a part that is made of fields of the same names."""
    try:
        make()
    except ValidationError as error:
        return [problem for detail in error.errors() for problem in detail.get("ctx", {}).get("problems", ())]
    return []


class Member(Part):
    """Fields of a sun, a ring or a carrier in common with any rotor, and its bearing."""

    mass: Mass
    inertia: Inertia
    drive: Drive | None = None
    load: Load = Load.model_construct()
    initial: Initial = Initial.model_construct()
    radial_damping: Annotated[float, Measure(q.DAMPING, "viscous damping of the centre's motion", ge=0.0)] = (
        0.0
    )
    floating: Annotated[bool, Field(description="true leaves its centre free in the plane")] = False
    fixed: Annotated[bool, Field(description="true keeps it from turning")] = False
    unbalance: Unbalance | None = None
    material: Annotated[Material | None, Field(description="what it is made of")] = None
    temperature: Temperature | None = None
    support: Annotated[Support | None, Field(description="elastic support of its centre and rotation")] = None
    sleeve: Annotated[Sleeve | None, Field(description="sleeve that holds it, with clearance")] = None

    @model_validator(mode="after")
    def _check(self) -> "Member":
        problems = []
        if self.fixed and self.drive is not None:
            rule = "must not be given for a member that is fixed"
            problems.append(Problem(("drive",), rule, "Remove one of the two"))
        for name in ("support", "sleeve"):
            part = getattr(self, name)
            if part is not None and part.on is not None:
                rule = "must not be given: members are held by the ground"
                problems.append(Problem((name, "on"), rule, "Remove it"))
        refuse(problems)
        refuse(problems_of(lambda: self.rotor((0.0, 0.0))))
        return self

    @property
    def stands(self) -> bool:
        """Whether the member is kept from turning: fixed, driven at speed 0, or held by a torsional spring."""
        driven_at_0 = isinstance(self.drive, SpeedDrive) and self.drive.speed == 0.0
        return (
            self.fixed or driven_at_0 or (self.support is not None and self.support.torsional_stiffness > 0.0)
        )

    def rotor(self, at: tuple[float, float], **more: Any) -> Rotor:
        """Return the member as a rotor with its centre ``at`` [m]."""
        drive = SpeedDrive(speed=0.0) if self.fixed else self.drive
        shared = {name: getattr(self, name) for name in Member.model_fields if name in Rotor.model_fields}
        return Rotor.model_validate(shared | {"drive": drive, "position": at} | more)


class Toothed(Member, Toothing):
    """Gear that is the sun or the ring of a set."""

    teeth: Teeth
    runout: Runout = Runout.model_construct()


class Planets(Toothing):
    """The planets, all with the same fields."""

    count: Annotated[int, Field(ge=1, le=MOST_PLANETS, description="number of planets")]
    teeth: Teeth
    mass: Annotated[float, Weight(q.MASS, "mass of one planet; 0 in linear analysis only", ge=0.0)]
    inertia: Annotated[
        float,
        Weight(
            q.INERTIA, "polar moment of inertia of one about its centre; 0 in linear analysis only", ge=0.0
        ),
    ]
    angles: (
        Annotated[
            tuple[Annotated[float, Measure(q.ANGLE, "direction of a planet from the centre")], ...],
            Listed(1, 24, "direction of each planet, counter-clockwise from +x; equally spaced if not given"),
        ]
        | None
    ) = None
    runout: Runout = Runout.model_construct()
    radial_damping: Annotated[
        float, Measure(q.DAMPING, "viscous damping of a planet's motion beside its pin", ge=0.0)
    ] = 0.0
    load: Load = Load.model_construct()
    material: Annotated[Material | None, Field(description="what they are made of")] = None
    temperature: Temperature | None = None

    @property
    def directions(self) -> tuple[float, ...]:
        """Direction of every planet [rad]."""
        if self.angles is not None:
            return self.angles
        return tuple(2.0 * math.pi * k / self.count for k in range(self.count))


class PinError(Part):
    """Position error of a pin on the carrier, and the clearance that it has beyond the others."""

    planet: PlanetNumber
    tangential: Annotated[
        float, Measure(q.LENGTH, "ahead of its place, counter-clockwise", ge=-0.01, le=0.01)
    ] = 0.0
    radial: Annotated[float, Measure(q.LENGTH, "outside its place", ge=-0.01, le=0.01)] = 0.0
    clearance: Annotated[
        float,
        Measure(
            q.LENGTH,
            "radial clearance beyond that of the set's pins, of a worn one",
            ge=0.0,
            le=MOST_CLEARANCE,
        ),
        Field(exclude_if=lambda value: not value),
    ] = 0.0


class Eccentricity(Part):
    """Runout of one planet's teeth, instead of that of all."""

    planet: PlanetNumber
    amplitude: Annotated[
        float, Measure(q.LENGTH, "eccentricity (half the indicator reading)", ge=0.0, le=0.1)
    ]
    phase: Annotated[float, Measure(q.ANGLE, "direction of the eccentricity at theta = 0")] = 0.0
