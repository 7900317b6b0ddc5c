"""Tip relief and deviations of the teeth of a gear in case files."""

from typing import Annotated, Literal

from pydantic import Field

from gearplay.schema.fields import Listed, Measure, Part
from gearplay.vocabulary import quantities as q

Quality = Annotated[
    int,
    Field(
        ge=1,
        le=11,
        description="class of ISO 1328-1, for deviations drawn with run.seed",
    ),
]
Position = Annotated[
    float,
    Measure(
        q.LENGTH,
        "cumulative deviation of a tooth along the reference circle, counter-clockwise",
        ge=-0.01,
        le=0.01,
    ),
]
Missing = Annotated[float, Measure(q.LENGTH, "material missing, normal to the flank", ge=-0.01, le=0.01)]


class TipRelief(Part):
    """Material missing at the tips, rising along the flank's path of contact; `amount` at the tip circle."""

    amount: Annotated[float, Measure(q.LENGTH, "relief at the tip, normal to the flank", ge=0.0, le=0.01)]
    length: Annotated[float, Measure(q.LENGTH, "length along the flank's path of contact", gt=0.0, le=1.0)]
    shape: Annotated[Literal["linear", "parabolic"], Field(description="how it rises towards the tip")] = (
        "linear"
    )

    @property
    def power(self) -> float:
        """Exponent of the relief over the distance from its start."""
        return 2.0 if self.shape == "parabolic" else 1.0


class ToothDeviations(Part):
    """Measured deviations, one item a tooth: number 0 first, then counter-clockwise.

    Tooth 0 points along the line of centres of the gear's first mesh at the start, or is the next one counter-clockwise.
    """

    pitch: Annotated[tuple[Position, ...], Listed(0, 10_000, "cumulative pitch deviation of each tooth")] = ()
    slope: Annotated[
        tuple[Missing, ...],
        Listed(0, 10_000, "profile slope of each tooth: missing at the tip less at the root"),
    ] = ()
    form: Annotated[
        tuple[Missing, ...], Listed(0, 10_000, "profile form of each tooth: half wave over the profile")
    ] = ()
    flank: Annotated[
        Literal["left", "right", "both"],
        Field(
            description="flanks that have them; left is the counter-clockwise one of an external tooth, of a ring the other"
        ),
    ] = "both"

    @property
    def deviate(self) -> bool:
        """Whether any of them differs from 0."""
        return any((*self.pitch, *self.slope, *self.form))
