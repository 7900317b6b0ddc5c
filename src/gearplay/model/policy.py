"""Settings of a run: duration, sampling and ensemble; those of the computation: error tolerance, method, limits."""

from typing import Annotated, Any, Final, Literal

from pydantic import ConfigDict, Field, ValidationError, model_validator

from gearplay.model.wording import translate
from gearplay.schema.fields import Measure, Part, Problem, refuse
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
FixedStepContacts = Annotated[
    Literal["step", "stage"],
    Field(
        description="where contacts are judged with a fixed step: frozen over the step, or at every stage of it, as a "
        "script does whose right-hand side asks if delta > 0",
        exclude_if=lambda given: given == "step",
    ),
]
MostSteps = Annotated[int, Field(ge=1, le=2**62, description="limit on steps per run")]
MostWallTime = Annotated[
    float,
    Measure(
        q.TIME,
        "limit on wall time of all runs of a request together; in a sweep or calibration of each run",
        gt=0.0,
    ),
]

DEFAULT_TOLERANCE: Final = 1e-6
"""The largest at which no statistic of an ensemble differs and loaded pairs err by less than 1e-11 m (docs/performance).

The formulation as_published at a negative backlash needs 1e-7: its force jumps there."""

LIMITS: Final = ("max_steps", "max_wall_time")
"""Fields that may end a run and change nothing else: no part of a case's digest."""


def check_contacts(step: float | None, contacts: str) -> None:
    """Refuse ``fixed_step_contacts`` without a fixed step: contacts are then updated at their located events."""
    if contacts != "step" and step is None:
        rule = "must not be given without fixed_step: contacts are then updated at their located events"
        refuse([Problem(("fixed_step_contacts",), rule, "Give fixed_step too, or remove it")])


class Policy(Part):
    """Numerical settings of a run, as `gearplay.simulate` takes them; a case file has the same fields in its ``[run]``.

    Parameters
    ----------
    tolerance
        Error tolerance on scaled states [1], 1e-13 to 1e-2.
    fixed_step
        Length of all steps [s], contacts noticed at their ends; None locates contacts.
    fixed_step_contacts
        Where contacts are judged with a fixed step: "step" freezes them over the step, "stage" judges them at every stage
        of it, as a script does whose right-hand side asks ``if delta > 0``.
    max_steps
        Limit on steps per run; None for none.
    max_wall_time
        Limit on wall time of a request, all its runs together [s]; None for none. In sweeps and calibrations it is of each run.

    Raises
    ------
    InputError
        Where a value is out of its range or no such field.

    Examples
    --------
    >>> Policy(tolerance=1e-8, max_steps=1000).changes()  # doctest: +NORMALIZE_WHITESPACE
    {'run.tolerance': 1e-08, 'run.fixed_step': None, 'run.fixed_step_contacts': 'step', 'run.max_steps': 1000,
     'run.max_wall_time': None}

    """

    model_config = ConfigDict(defer_build=False)

    tolerance: Tolerance = DEFAULT_TOLERANCE
    fixed_step: FixedStep | None = None
    fixed_step_contacts: FixedStepContacts = "step"
    max_steps: MostSteps | None = None
    max_wall_time: MostWallTime | None = None

    def __init__(self, **given: Any) -> None:
        try:
            super().__init__(**given)
        except ValidationError as error:
            raise InputError(translate(error, given, Policy)) from None

    @model_validator(mode="after")
    def _check(self) -> "Policy":
        check_contacts(self.fixed_step, self.fixed_step_contacts)
        return self

    def changes(self) -> dict[str, Any]:
        """Return the policy as changes of a case, by path."""
        return {f"run.{name}": getattr(self, name) for name in type(self).model_fields}


Start = Annotated[
    Literal["given", "drawn"],
    Field(
        description="the first member's start: as the case says, exactly centred where it says nothing, or drawn like the others",
        exclude_if=lambda chosen: chosen == "given",
    ),
]


class Run(Part):
    """Settings of the simulation: duration, sampling, tolerance, ensemble, limits."""

    duration: Annotated[float, Measure(q.TIME, "recorded time", gt=0.0, le=1e6)]
    transient: Annotated[float, Measure(q.TIME, "time simulated before recording starts", ge=0.0, le=1e6)] = (
        0.0
    )
    sampling: Annotated[float, Measure(q.FREQUENCY, "samples per second", ge=1.0, le=1e7)] = 1e5
    ensemble: Annotated[int, Field(ge=1, le=100_000, description="number of runs from perturbed starts")] = 1
    seed: Annotated[int, Field(ge=0, le=2**63 - 1, description="seed of the perturbations")] = 0
    start: Start = "given"
    tolerance: Tolerance = DEFAULT_TOLERANCE
    fixed_step: FixedStep | None = None
    fixed_step_contacts: FixedStepContacts = "step"
    max_steps: MostSteps | None = None
    max_wall_time: MostWallTime | None = None

    @model_validator(mode="after")
    def _check(self) -> "Run":
        check_contacts(self.fixed_step, self.fixed_step_contacts)
        return self
