"""Backlash and centre distance of meshes in case files."""

from contextlib import suppress
from typing import Annotated, Any

from pydantic import Discriminator, Field, Tag, model_validator

from gearplay.schema.fields import Measure, Part, Problem, refuse
from gearplay.schema.units import UnitError, parse_quantity
from gearplay.vocabulary import quantities as q


class BacklashForm(Part):
    """Backlash as an angle or an arc."""

    angle: Annotated[float, Measure(q.ANGLE, "of the driven gear", ge=0.0, le=1.0)] | None = Field(
        default=None, exclude_if=lambda given: given is None
    )
    circumferential: (
        Annotated[float, Measure(q.LENGTH, "along the working pitch circle", ge=0.0, le=10.0)] | None
    ) = Field(default=None, exclude_if=lambda given: given is None)

    @model_validator(mode="after")
    def _check(self) -> "BacklashForm":
        if (self.angle is None) == (self.circumferential is None):
            refuse([Problem((), "must have one of angle and circumferential", "Give one of the two")])
        return self


class BacklashMeasure(Measure):
    """A length, or text with an angle, which is that of the driven gear.

    >>> round(BacklashMeasure(q.LENGTH, "backlash").read("5 arcmin").angle, 9)
    0.001454441
    """

    def read(self, value: Any) -> Any:
        """Return the length in SI, or the angle as a `BacklashForm`."""
        if isinstance(value, str):
            with suppress(UnitError):  # what is neither is refused as a length
                parse_quantity(value, self.quantity or q.LENGTH)
                return super().read(value)
            with suppress(UnitError):
                return BacklashForm(angle=parse_quantity(value, q.ANGLE))
        return super().read(value)


def _length_or_form(value: Any) -> str:
    return "kind:form" if isinstance(value, (dict, BacklashForm)) else "kind:length"


Backlash = Annotated[
    Annotated[
        float,
        BacklashMeasure(
            q.LENGTH,
            "total backlash, normal, at the working centre distance; from thicknesses and allowances if not given",
            ge=0.0,
            le=10.0,
        ),
        Tag("kind:length"),
    ]
    | Annotated[BacklashForm, Tag("kind:form")],
    Discriminator(_length_or_form),
]
CenterDistance = Annotated[
    float,
    Measure(
        q.LENGTH,
        "working centre distance; if not given, from positions of gears with profile shift, else without backlash by the shifts",
        gt=0.0,
        le=100.0,
    ),
]
