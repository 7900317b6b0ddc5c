"""Environment: temperatures and thermal expansion of materials."""

from typing import Annotated, Final

from pydantic import Field, model_validator

from gearplay.schema.fields import Listed, Measure, Part, Problem, is_absent, refuse
from gearplay.vocabulary import quantities as q

REFERENCE: Final = 293.15
"""Default temperature at which lengths hold [K]: 20 degC, ISO 1."""

Temperature = Annotated[float, Measure(q.TEMPERATURE, "temperature", gt=0.0)]
Expansion = Annotated[float, Measure(q.EXPANSION, "coefficient of linear expansion", ge=-1e-4, le=1e-3)]


class Material(Part):
    """Material of a rotor. Only the expansion acts on the motion."""

    modulus: Annotated[float, Measure(q.PRESSURE, "Young's modulus", gt=0.0)] | None = None
    poisson: Annotated[float, Measure(None, "Poisson's ratio", ge=0.0, lt=0.5)] | None = None
    density: Annotated[float, Measure(q.MASS_DENSITY, "mass density", gt=0.0)] | None = None
    expansion: Expansion


class Housing(Part):
    """Housing: its thermal expansion moves the seats on the ground."""

    expansion: Expansion
    temperature: Temperature | None = None


class Environment(Part):
    """Temperature of all parts without one of their own; lengths of the case hold at ``reference_temperature``."""

    temperature: Temperature
    reference_temperature: Temperature = REFERENCE
    housing: Housing | None = None
    temperature_range: (
        Annotated[
            tuple[Temperature, Temperature],
            Listed(
                2, 2, "coldest and hottest temperature, at which `gearplay check` names the backlash left"
            ),
        ]
        | None
    ) = Field(default=None, exclude_if=is_absent)

    @model_validator(mode="after")
    def _check(self) -> "Environment":
        if self.temperature_range is not None and self.temperature_range[0] >= self.temperature_range[1]:
            rule = "must be the coldest and then the hottest temperature"
            refuse([Problem(("temperature_range",), rule, "Exchange the two")])
        return self
