"""Allowances in case files: a class of a standard, or an upper and a lower limit."""

import re
from dataclasses import dataclass
from typing import Annotated, Any, Final

from pydantic import Discriminator, GetCoreSchemaHandler, GetJsonSchemaHandler, Tag, model_validator
from pydantic_core import CoreSchema, core_schema

from gearplay.schema.fields import Measure, Part, Problem, refuse
from gearplay.toothing.allowances import CLASS
from gearplay.vocabulary import quantities as q

UPPER: Final = Measure(q.LENGTH, "upper allowance", ge=-0.1, le=0.1)


class Limits(Part):
    """Upper and lower limit of a size, from its nominal value; in a file also a list of the two."""

    upper: Annotated[float, UPPER]
    lower: Annotated[float, Measure(q.LENGTH, "lower allowance", ge=-0.1, le=0.1)]

    @model_validator(mode="before")
    @classmethod
    def _of_two(cls, given: Any) -> Any:
        if isinstance(given, (list, tuple)) and len(given) == 2:
            lower, upper = sorted(UPPER.read(each) for each in given)
            return {"upper": upper, "lower": lower}
        return given

    @model_validator(mode="after")
    def _check(self) -> "Limits":
        if self.lower > self.upper:
            rule = f"must be at most upper, {1e6 * self.upper:.6g} um"
            refuse([Problem(("lower",), rule, "Exchange the two")])
        return self

    @property
    def middle(self) -> float:
        """Mean of both limits [m]."""
        return 0.5 * (self.upper + self.lower)


def allowance_middle(allowance: str | Limits | None) -> float:
    """Return the middle [m] of an allowance of a centre distance; that of a class js is 0."""
    return allowance.middle if isinstance(allowance, Limits) else 0.0


@dataclass(frozen=True)
class ClassName:
    """Text that names a class of a standard."""

    pattern: re.Pattern[str]
    rule: str
    cure: str

    def read(self, value: Any) -> str:
        """Return the name, or refuse the value."""
        if not isinstance(value, str) or not self.pattern.fullmatch(value):
            refuse([Problem((), self.rule, self.cure)])
        return str(value)

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.no_info_plain_validator_function(self.read)

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        return {"type": "string", "pattern": f"^({self.pattern.pattern})$", "description": self.rule}


def _class_or_limits(value: Any) -> str:
    return "kind:limits" if isinstance(value, (dict, list, tuple, Limits)) else "kind:class"


ThicknessAllowance = Annotated[
    Annotated[Limits, Tag("kind:limits")]
    | Annotated[
        str,
        ClassName(
            CLASS,
            "must be a class of DIN 3967 (a, ab, b, bc, c, cd, d, e, f, g or h, and 21 to 30), or a table of upper and lower",
            'Write for example "c25", or { upper = "-85 um", lower = "-125 um" }',
        ),
        Tag("kind:class"),
    ],
    Discriminator(_class_or_limits),
]
"""Allowance of the normal tooth thickness."""
DISTANCE_CLASS: Final = re.compile(r"js(5|6|7|8|9|10|11)")
DistanceAllowance = Annotated[
    Annotated[Limits, Tag("kind:limits")]
    | Annotated[
        str,
        ClassName(
            DISTANCE_CLASS,
            "must be a class of DIN 3964 (js5 to js11), or a table of upper and lower",
            'Write for example "js7", or { upper = "20 um", lower = "-20 um" }',
        ),
        Tag("kind:class"),
    ],
    Discriminator(_class_or_limits),
]
"""Allowance of the centre distance."""
