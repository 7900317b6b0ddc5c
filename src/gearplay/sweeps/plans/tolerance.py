"""The table ``[tolerance]`` of a sweep plan: limit of a measure, and the clearances to enlarge."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Any, Literal

from pydantic import Field, PlainValidator, WithJsonSchema, model_validator

from gearplay.schema.fields import Listed, Measure, Name, Part, Problem, refuse
from gearplay.schema.units import LONGEST, UnitError, parse_quantity
from gearplay.sweeps.plans.design import Design
from gearplay.sweeps.plans.kept import Reduction, scalar_names
from gearplay.vocabulary.errors import InputError
from gearplay.vocabulary.quantities import Quantity
from gearplay.vocabulary.suggestions import did_you_mean


def _read_limit(value: Any) -> float | str:
    if isinstance(value, str) and 0 < len(value) <= LONGEST and value.isprintable():
        return value
    if isinstance(value, (int, float)) and not isinstance(value, bool) and abs(value) < 1e300:
        return float(value)
    rule = "must be a number in the measure's SI unit, or text with a unit"
    refuse([Problem((), rule, 'Write for example 2.5 or "2.5 m/s^2"')])
    raise AssertionError


Limit = Annotated[
    float | str,
    PlainValidator(_read_limit),
    WithJsonSchema(
        {
            "anyOf": [{"type": "number"}, {"type": "string", "minLength": 1, "maxLength": LONGEST}],
            "description": "limit of the measure: a number in its SI unit, or text with a unit",
        }
    ),
]
Share = Annotated[float, Measure(None, "probability", gt=0.0, lt=1.0)]
Factor = Annotated[float, Measure(None, "factor", gt=0.0, le=1e6)]


class Tolerance(Part):
    """A limit for one measure of a design's points, and the search for the largest clearances that keep to it.

    ``measure`` is a reduction with one number per case (``mesh_amplitude`` of a line called mesh). It is to stay within
    ``limit`` with the given ``probability``; intervals have the given ``confidence``.

    ``scale`` names drawn parameters whose clearances grow together in the search, none for no search. Their whole
    distribution is multiplied, or with ``scaling`` "high" only its upper end. Of ``factors`` between two bounds the largest is
    sought by simulating ``steps`` of them, each at ``count`` drawn points, as many as the design draws if not given.
    """

    measure: Annotated[str, Field(min_length=1, max_length=64, pattern=r"^[^\p{Cc}\p{Cf}]*$")]
    limit: Limit
    probability: Share = 0.95
    confidence: Share = 0.95
    scale: Annotated[tuple[Name, ...], Listed(0, 64, "names of drawn parameters")] = ()
    scaling: Literal["size", "high"] = "size"
    factors: Annotated[tuple[Factor, Factor], Listed(2, 2, "smallest and largest factor")] = (0.25, 4.0)
    steps: Annotated[int, Field(ge=5, le=24)] = 12
    count: Annotated[int, Field(ge=10, le=10_000_000)] | None = None

    @model_validator(mode="after")
    def _check(self) -> Tolerance:
        problems = []
        if not self.factors[0] < self.factors[1]:
            problems.append(Problem(("factors",), "must rise", "Give the smallest factor first"))
        if len(set(self.scale)) < len(self.scale):
            problems.append(Problem(("scale",), "must name each parameter once", "Remove one of them"))
        refuse(problems)
        return self

    def limit_in(self, unit: str) -> float:
        """Return the limit in the measure's SI unit.

        Raises `InputError` for text with a unit of another kind.

        >>> Tolerance(measure="rms", limit="250 mm/s^2").limit_in("m/s^2")
        0.25
        """
        quantity = Quantity(self.measure, self.measure, unit, unit, 1.0, f"limit of {self.measure}")
        try:
            return parse_quantity(self.limit, quantity)
        except UnitError as error:
            raise InputError.of("tolerance.limit", self.limit, error.rule, error.cure) from None


def tolerance_problems(
    tolerance: Tolerance, reductions: Sequence[Reduction], design: Design | None, *, axes: bool
) -> list[Problem]:
    """Return where the part ``[tolerance]`` does not fit the rest of its plan; ``axes``: whether it has any."""
    problems, names = [], scalar_names(reductions)
    if tolerance.measure not in names:
        rule = "must be a reduction with one number per case"
        problems.append(
            Problem(("tolerance", "measure"), rule, did_you_mean(tolerance.measure, names, "Choose from"))
        )
    if design is None:
        problems.append(Problem(("tolerance",), "needs drawn parameters", "Add a [design] of parameters"))
        return problems
    drawn = {p.name: p for p in design.parameters}
    for at, name in enumerate(tolerance.scale):
        place = ("tolerance", "scale", at)
        if name not in drawn:
            problems.append(Problem(place, "must be a drawn parameter", did_you_mean(name, drawn)))
        elif tolerance.scaling == "high" and drawn[name].high is None:
            rule = 'must have a high bound for scaling "high"'
            problems.append(Problem(place, rule, "Give it one, or scale the size"))
    if tolerance.scale and axes:
        rule = "must be empty for a plan with axes: the search is for one condition"
        problems.append(Problem(("tolerance", "scale"), rule, "Put the condition into [set], without axes"))
    return problems
