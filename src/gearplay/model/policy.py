"""How a case is computed: error tolerance, method and limits; what is computed is the rest of the case."""

from __future__ import annotations

from typing import Annotated, Any, Final

from pydantic import Field, ValidationError

from gearplay.model.fields import Measure, Part
from gearplay.model.wording import translate
from gearplay.vocabulary import quantities as q
from gearplay.vocabulary.errors import InputError

Tolerance = Annotated[float, Measure(None, "error tolerance on scaled states", ge=1e-13, le=1e-2)]
FixedStep = Annotated[
    float,
    Measure(
        q.TIME,
        "length of all steps, contacts noticed at their ends; without it contacts are located",
        gt=0.0,
        le=1.0,
    ),
]
MostSteps = Annotated[int, Field(ge=1, le=2**62, description="limit on steps per run")]
MostWallTime = Annotated[float, Measure(q.TIME, "limit on wall time", gt=0.0)]

DEFAULT_TOLERANCE: Final = 1e-6
"""The largest at which no statistic of an ensemble differs and loaded pairs err by less than 1e-11 m (docs/performance)."""

LIMITS: Final = ("max_steps", "max_wall_time")
"""Fields that may end a run and change nothing else: no part of a case's digest."""


class Policy(Part):
    """How to compute a case, as `gearplay.simulate` takes it; a case file has the same fields in its ``[run]``.

    Parameters
    ----------
    tolerance
        Error tolerance on scaled states [1], 1e-13 to 1e-2.
    fixed_step
        Length of all steps [s], contacts noticed at their ends; None locates contacts.
    max_steps
        Limit on steps per run; None for none.
    max_wall_time
        Limit on wall time [s]; None for none.

    Raises
    ------
    InputError
        Where a value is out of its range or no such field.

    Examples
    --------
    >>> Policy(tolerance=1e-8, max_wall_time=10.0).changes()
    {'run.tolerance': 1e-08, 'run.fixed_step': None, 'run.max_steps': None, 'run.max_wall_time': 10.0}

    """

    tolerance: Tolerance = DEFAULT_TOLERANCE
    fixed_step: FixedStep | None = None
    max_steps: MostSteps | None = None
    max_wall_time: MostWallTime | None = None

    def __init__(self, **given: Any) -> None:
        try:
            super().__init__(**given)
        except ValidationError as error:
            raise InputError(translate(error, given, Policy)) from None

    def changes(self) -> dict[str, Any]:
        """Return the policy as changes of a case, by path."""
        return {f"run.{name}": getattr(self, name) for name in type(self).model_fields}
