"""Wear of the flanks of a mesh over its life (`gearplay.wear`)."""

from typing import Annotated

from pydantic import Field

from gearplay.schema.fields import Measure, Part, is_absent
from gearplay.vocabulary import quantities as q


class FlankWear(Part):
    """Archard's law on the flanks of both gears: worn volume = coefficient x normal force x sliding distance."""

    coefficient: Annotated[
        float, Measure(q.WEAR_COEFFICIENT, "wear coefficient k, hardness included", gt=0.0)
    ]
    driven_coefficient: (
        Annotated[
            float,
            Measure(q.WEAR_COEFFICIENT, "that of the driven gear, coefficient if not given", gt=0.0),
        ]
        | None
    ) = Field(default=None, exclude_if=is_absent)
