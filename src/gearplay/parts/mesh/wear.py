"""Wear of the flanks of a mesh over its life (`gearplay.wear`)."""

from typing import Annotated

from pydantic import Field, model_validator

from gearplay.parts.wear_sides import both_sides, refuse_no_wear
from gearplay.schema.fields import Measure, Part, is_absent
from gearplay.vocabulary import quantities as q


class FlankWear(Part):
    """Archard's law on the flanks of both gears: worn volume = coefficient x normal force x sliding distance."""

    coefficient: Annotated[
        float,
        Measure(
            q.WEAR_COEFFICIENT,
            "wear coefficient k, hardness included; 0 for no wear of the driving gear",
            ge=0.0,
        ),
    ]
    driven_coefficient: (
        Annotated[
            float,
            Measure(q.WEAR_COEFFICIENT, "that of the driven gear, coefficient if not given", ge=0.0),
        ]
        | None
    ) = Field(default=None, exclude_if=is_absent)

    @model_validator(mode="after")
    def _check(self) -> "FlankWear":
        refuse_no_wear(self.coefficient, self.driven_coefficient, "driven_coefficient")
        return self

    @property
    def coefficients(self) -> tuple[float, float]:
        """Coefficients of driving and driven gear [m^2/N]."""
        return both_sides(self.coefficient, self.driven_coefficient)
