"""Wear of a plain bearing over its life (`gearplay.wear`)."""

import math
from typing import Annotated

from pydantic import Field, model_validator

from gearplay.parts.wear_sides import both_sides, refuse_no_wear
from gearplay.schema.fields import Measure, Part, is_absent
from gearplay.vocabulary import quantities as q


class BushWear(Part):
    """Archard's law on journal and bush: worn volume = coefficient x normal force x sliding distance."""

    coefficient: Annotated[
        float,
        Measure(
            q.WEAR_COEFFICIENT, "wear coefficient k, hardness included; 0 for no wear of the journal", ge=0.0
        ),
    ]
    bush_coefficient: (
        Annotated[float, Measure(q.WEAR_COEFFICIENT, "that of the bush, coefficient if not given", ge=0.0)]
        | None
    ) = Field(default=None, exclude_if=is_absent)
    length: Annotated[float, Measure(q.LENGTH, "length of the contact along the axis", gt=0.0, le=100.0)]
    arc: Annotated[
        float,
        Measure(q.ANGLE, "whole angle over which the contact is spread", gt=0.0, le=2.0 * math.pi),
    ] = math.radians(60.0)

    @model_validator(mode="after")
    def _check(self) -> "BushWear":
        refuse_no_wear(self.coefficient, self.bush_coefficient, "bush_coefficient")
        return self

    @property
    def coefficients(self) -> tuple[float, float]:
        """Coefficients of journal and bush [m^2/N]."""
        return both_sides(self.coefficient, self.bush_coefficient)
