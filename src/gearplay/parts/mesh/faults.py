"""Faults of gears: cracks, chips, spalls, missing teeth, pitch errors, wear, eccentricity."""

from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from typing import Annotated, Any, ClassVar, Final, Literal

from pydantic import Field, model_validator

from gearplay.parts.mesh.schema import Mesh
from gearplay.parts.part_fault import PartFault
from gearplay.parts.rotor.gear import GearName, split_name
from gearplay.schema.fields import Listed, Measure, Problem, is_absent, refuse
from gearplay.schema.finding import Finding
from gearplay.vocabulary import quantities as q

Tooth = Annotated[
    int,
    Field(
        ge=0,
        le=9_999,
        description="number of the tooth, from 0 at the first mesh of the gear, counter-clockwise",
    ),
]
Flank = Annotated[
    Literal["left", "right", "both"],
    Field(description="left is the counter-clockwise flank of an external tooth, of a ring the other one"),
]
DEEPEST: Final = 0.01
"""Largest depth [m] of material that is missing."""
Depth = Annotated[float, Measure(q.LENGTH, "material missing, normal to the flank", gt=0.0, le=DEEPEST)]
Worn = Annotated[float, Measure(q.LENGTH, "material missing, normal to the flank", ge=0.0, le=DEEPEST)]
SINGLE_TEETH: Final = 'faults of single teeth need meshes with contact = "pairs"'
CLOSEST = 1e-3
"""Least distance of two points of a worn profile, in heights."""
Height = Annotated[
    float,
    Measure(None, "place on the flank's path of contact, 0 at its root end, 1 at the tip", ge=0.0, le=1.0),
]


class GearFault(PartFault):
    """Base of faults of a gear."""

    table: ClassVar[str] = "rotors"
    of_teeth: ClassVar[bool] = True  # else of the whole gear
    needs_pairs: ClassVar[bool] = False  # as it takes stiffness from the pairs of a tooth

    @classmethod
    def fits_contact(cls, mesh: Mesh) -> bool:
        """Return whether the contact of a mesh can follow it."""
        return not cls.needs_pairs or mesh.contact == "pairs"

    along_facewidth: ClassVar[bool] = False  # constant along oblique lines of contact too

    at: Annotated[GearName, Field(description="gear, as meshes call it: rotor or rotor.gear")]

    def part(self, parts: Mapping[str, Any]) -> Any:
        """Return the gear; None where there is none of that name."""
        rotor, gear = split_name(self.at, parts)
        found = parts.get(rotor)
        if found is None or not gear:
            return found
        return getattr(found, "gears", {}).get(gear)

    def misfits(self, part: Any, others: Sequence[PartFault]) -> Iterator[Problem]:
        """Yield faults against the gear: a tooth that it does not have."""
        if part.teeth is None:
            yield Problem(("at",), "must be a gear", "Name a rotor with teeth, or one of its gears")
        elif getattr(self, "tooth", 0) >= part.teeth:
            rule = f"must be less than {part.teeth}, the number of teeth, counted from 0"
            yield Problem(("tooth",), rule, "Choose one of them")

    def findings(self, path: str, part: Any, speed: float) -> Iterator[Finding]:
        """Yield nothing: `check` prints the frequencies of meshes and shafts."""
        return iter(())


class CrackFault(GearFault):
    """A crack at the root of a tooth of an external gear; it takes stiffness from the pairs of that tooth."""

    needs_pairs: ClassVar[bool] = True

    kind: Literal["crack"] = "crack"
    tooth: Tooth = 0
    depth: Annotated[float, Measure(q.LENGTH, "length of the crack from the fillet inwards", gt=0.0, le=0.1)]
    angle: Annotated[
        float,
        Measure(
            q.ANGLE, "angle of the crack from the middle line of the tooth", ge=0.0, le=1.5707963267948966
        ),
    ] = 0.7853981633974483
    flank: Flank = "both"

    def misfits(self, part: Any, others: Sequence[PartFault]) -> Iterator[Problem]:
        """Yield faults against the gear, also a ring gear, whose root fillet is not modelled."""
        yield from super().misfits(part, others)
        if part.internal:
            yield Problem(("at",), "must be an external gear", "Name one, or take another kind of fault")


class ChipFault(GearFault):
    """A chipped tip: the share of the facewidth that is lost above a height carries no load."""

    needs_pairs: ClassVar[bool] = True

    kind: Literal["chip"] = "chip"
    tooth: Tooth = 0
    share: Annotated[float, Measure(q.RATIO, "share of the facewidth that is lost", gt=0.0, le=1.0)]
    height: Height = 0.5


class SpallFault(GearFault):
    """A spall: material missing over a stretch of one flank."""

    kind: Literal["spall"] = "spall"
    tooth: Tooth = 0
    depth: Depth
    start: Height = 0.4
    end: Height = 0.6
    flank: Flank = "left"

    def misfits(self, part: Any, others: Sequence[PartFault]) -> Iterator[Problem]:
        """Yield faults against the gear, also an end before the start."""
        yield from super().misfits(part, others)
        if self.end <= self.start:
            yield Problem(("end",), f"must be above start, {self.start:g}", "Give the higher one as end")


class MissingToothFault(GearFault):
    """A broken tooth: its pairs carry no load."""

    needs_pairs: ClassVar[bool] = True
    along_facewidth: ClassVar[bool] = True

    kind: Literal["missing-tooth"] = "missing-tooth"
    tooth: Tooth = 0


class PitchFault(GearFault):
    """A tooth displaced along the pitch circle."""

    along_facewidth: ClassVar[bool] = True

    kind: Literal["pitch"] = "pitch"
    tooth: Tooth = 0
    offset: Annotated[
        float,
        Measure(q.LENGTH, "displacement along the reference circle, counter-clockwise", ge=-0.01, le=0.01),
    ]
    flank: Flank = "both"


class WearFault(GearFault):
    """Worn flanks of all teeth, alike: by ``depth`` (2 x - 1)^2, most at root and tip, or by points of a ``profile``."""

    kind: Literal["wear"] = "wear"
    depth: Depth | None = None
    profile: Annotated[
        tuple[Annotated[tuple[Height, Worn], Listed(2, 2, "height and depth")], ...],
        Listed(0, 256, "instead of depth: material missing over height, normal to the flank"),
        Field(exclude_if=is_absent),
    ] = ()
    flank: Flank = "left"

    @property
    def depth_alone(self) -> bool:
        """Whether it is the parabola of a depth, which oblique lines of contact can have."""
        return not self.profile

    @model_validator(mode="after")
    def _check(self) -> "WearFault":
        refuse(self._problems())
        return self

    def _problems(self) -> Iterator[Problem]:
        if self.profile and self.depth is not None:
            yield Problem(("profile",), "must not be given together with depth", "Remove one of the two")
        elif not self.profile and self.depth is None:
            yield Problem(("depth",), "is required, or a profile", "Give one of the two")
        elif len(self.profile) == 1:
            yield Problem(("profile",), "must have at least two points", "Add one, or give depth")
        for k, ((x, _), (x_1, _)) in enumerate(pairwise(self.profile), start=1):
            if x_1 - x < CLOSEST:
                rule = f"must be at least {CLOSEST:g} higher than the point before"
                yield Problem(("profile", k), rule, "Order the points by height")


class EccentricityFault(GearFault):
    """An eccentric toothing; adds to the runout of the gear, in meshes of any contact."""

    kind: Literal["eccentricity"] = "eccentricity"
    of_teeth: ClassVar[bool] = False
    amount: Annotated[float, Measure(q.LENGTH, "eccentricity, half the indicator reading", gt=0.0, le=0.01)]
    phase: Annotated[float, Measure(q.ANGLE, "direction of the eccentricity at rotation 0")] = 0.0
