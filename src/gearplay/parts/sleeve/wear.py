"""Wear of a plain bearing over its life (`gearplay.wear`)."""

import math
from typing import Annotated

from pydantic import Field

from gearplay.schema.fields import Measure, Part, is_absent
from gearplay.vocabulary import quantities as q


class BushWear(Part):
    """Archard's law on journal and bush: worn volume = coefficient x normal force x sliding distance."""

    coefficient: Annotated[
        float, Measure(q.WEAR_COEFFICIENT, "wear coefficient k, hardness included", gt=0.0)
    ]
    bush_coefficient: (
        Annotated[float, Measure(q.WEAR_COEFFICIENT, "that of the bush, coefficient if not given", gt=0.0)]
        | None
    ) = Field(default=None, exclude_if=is_absent)
    length: Annotated[float, Measure(q.LENGTH, "length of the contact along the axis", gt=0.0, le=100.0)]
    arc: Annotated[
        float,
        Measure(q.ANGLE, "whole angle over which the contact is spread", gt=0.0, le=2.0 * math.pi),
    ] = math.radians(60.0)
