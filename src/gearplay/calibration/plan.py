"""Schema of calibration plans: parameters, conditions with measured values, models."""

from __future__ import annotations

import math
from typing import Annotated, Any, Literal

from pydantic import Field, Tag, model_validator

from gearplay.rig.plan import Accelerometer
from gearplay.schema.fields import ByKind, Listed, Measure, Name, Part, Problem, refuse
from gearplay.vocabulary import quantities as q
from gearplay.vocabulary.quantities import CONTACT_STATISTICS
from gearplay.vocabulary.suggestions import did_you_mean

Text = Annotated[str, Field(min_length=1, max_length=200, pattern=r"^[^\p{Cc}\p{Cf}]*$")]
Changes = Annotated[dict[str, Any], Field(description="changes of the case, by path")]
Positive = Annotated[float, Measure(None, "measured value", gt=0.0)]
Decades = Annotated[float, Measure(None, "standard uncertainty [decades]", gt=0.0, le=2.0)]
Frequency = Annotated[float, Measure(q.FREQUENCY, "frequency", gt=0.0)]
Band = Annotated[tuple[Frequency, Frequency], Listed(2, 2, "lowest and highest frequency")]

Reading = Literal["absolute", "unnormalised", "displacement"]


class Parameter(Part):
    """One free parameter: a field of the case between two bounds.

    ``mode`` "set" puts the value there; "scale" multiplies what each condition has there. ``also`` names further fields
    that get the same value.
    """

    name: Name
    path: Text
    also: Annotated[tuple[Text, ...], Listed(0, 32, "further fields")] = ()
    low: float | Text
    high: float | Text
    scale: Literal["log", "linear"] = "log"
    mode: Literal["set", "scale"] = "set"


class _Target(Part):
    name: Name
    uncertainty: Decades | None = None  # of its amplitude or value; the plan's if not given
    frequency_uncertainty: Decades | None = None


class LineTarget(_Target):
    """A sharp line: near ``order`` times the mesh frequency, or near ``near`` [Hz]."""

    kind: Literal["line"] = "line"
    order: Annotated[int, Field(ge=1, le=64)] | None = None
    near: Frequency | None = None
    search: Annotated[float, Measure(None, "relative half-width of the search", gt=0.0, lt=1.0)] = 0.03

    @model_validator(mode="after")
    def _check(self) -> LineTarget:
        if (self.order is None) == (self.near is None):
            refuse([Problem(("order",), "must be given, or near, but not both", "Say which line is meant")])
        return self


class HumpTarget(_Target):
    """The highest broad hump within a band."""

    kind: Literal["hump"] = "hump"
    band: Band
    width: Annotated[float, Measure(None, "relative width of the smoothing", gt=0.0, lt=1.0)] = 0.08


class LevelTarget(_Target):
    """The rms value within a band."""

    kind: Literal["level"] = "level"
    band: Band


STATISTICS = ("rms", "kurtosis", "crest_factor")
OF_CONTACTS = tuple(
    name for name in CONTACT_STATISTICS if name not in ("rms_impact_speed", "max_penetration")
)


class StatisticTarget(_Target):
    """A statistic of the whole record, or of one contact (``contact`` = ``ring`` or ``pinion-ring:drive``)."""

    kind: Literal["statistic"] = "statistic"
    statistic: Literal[(*STATISTICS, *OF_CONTACTS)]  # type: ignore[valid-type]
    contact: Text | None = None

    @model_validator(mode="after")
    def _check(self) -> StatisticTarget:
        if (self.statistic in OF_CONTACTS) != (self.contact is not None):
            rule = "is required for a statistic of a contact and must be left out for others"
            refuse([Problem(("contact",), rule, f"Statistics of records: {', '.join(STATISTICS)}")])
        return self


Target = Annotated[
    Annotated[LineTarget, Tag("kind:line")]
    | Annotated[HumpTarget, Tag("kind:hump")]
    | Annotated[LevelTarget, Tag("kind:level")]
    | Annotated[StatisticTarget, Tag("kind:statistic")],
    ByKind("line", "hump", "level", "statistic"),
]


class Measured(Part):
    """Measured datum of one target: amplitude [unit of the ordinate] and frequency of a line, or a value."""

    amplitude: Positive | None = None
    frequency: Frequency | None = None
    value: Positive | None = None


class Condition(Part):
    """One test condition: changes of the case, and measured values by target or a record to read them from."""

    name: Text
    set: Changes = Field(default_factory=dict)
    measured: Annotated[dict[str, Measured], Field(description="measured values, by target")] = Field(
        default_factory=dict
    )
    record: Text | None = None  # a file, read by the same code as the simulation
    channel: Text | None = None

    @model_validator(mode="after")
    def _check(self) -> Condition:
        if bool(self.measured) == (self.record is not None):
            refuse(
                [Problem(("measured",), "must be given, or record, but not both", "Say what was measured")]
            )
        return self


class Model(Part):
    """One of the compared models: changes of the case and its free parameters; other parameters keep the value of the case."""

    name: Text
    set: Changes = Field(default_factory=dict)
    parameters: (
        Annotated[tuple[Name, ...], Listed(1, 32, "free parameters of this model; all if not given")] | None
    ) = Field(default=None, exclude_if=lambda given: given is None)


class Sensor(Part):
    """Observed quantity: a rotor's acceleration in one direction, averaged over each sampling interval."""

    rotor: Name
    direction: Annotated[float, Measure(q.ANGLE, "direction, from the x axis")] = 0.0
    accelerometer: Accelerometer | None = (
        None  # its response shapes the simulated acceleration; ideal if not given
    )

    @model_validator(mode="after")
    def _check(self) -> Sensor:
        for name in ("rotor", "mesh", "angle", "transverse_sensitivity", "paths"):
            given = getattr(self.accelerometer, name, None)
            if given and given != Accelerometer.model_fields[name].default:
                rule = "must not be given: rotor and direction of the sensor place it, and its response alone acts"
                refuse([Problem(("accelerometer", name), rule, "Remove it")])
        return self


class Simulation(Part):
    """Simulation of each trial: members with common random numbers."""

    members: Annotated[int, Field(ge=2, le=10_000)] = 4
    duration: Annotated[float, Measure(q.TIME, "record of each member", gt=0.0)] = 4.0
    transient: Annotated[float, Measure(q.TIME, "time before the record", ge=0.0)] = 0.5
    sampling: Annotated[float, Measure(q.FREQUENCY, "rate of the mean acceleration", gt=0.0)] = 1000.0
    window: Text = "hann"


class Effort(Part):
    """Effort of the search: trials per model, of which the last ``polish`` refine the best."""

    evaluations: Annotated[int, Field(ge=8, le=1_000_000)] = 2000
    startup: Annotated[int, Field(ge=4, le=1_000_000)] = 256  # evenly spread, before the guided search
    polish: Annotated[int, Field(ge=0, le=1_000_000)] = 150
    polish_members: Annotated[int, Field(ge=2, le=10_000)] = 16
    check_members: Annotated[int, Field(ge=2, le=10_000)] = 64  # fresh members that check the best
    seed: Annotated[int, Field(ge=0, le=2**31 - 1)] = 0


class Plan(Part):
    """A calibration plan. Every model gets the same targets, effort and bounds, and all parameters unless it names its own."""

    title: Annotated[str, Field(max_length=200, pattern=r"^[^\p{Cc}\p{Cf}]*$")] = ""
    case: Text | dict[str, Any]
    set: Changes = Field(default_factory=dict)
    parameters: Annotated[tuple[Parameter, ...], Listed(1, 32, "free parameters")]
    models: Annotated[tuple[Model, ...], Listed(1, 16, "models")] = (Model(name="model"),)
    sensor: Sensor
    simulation: Simulation = Simulation()
    effort: Effort = Effort()
    readings: Annotated[tuple[Reading, ...], Listed(1, 3, "readings of the ordinate")] = ("absolute",)
    uncertainty: Decades = 0.03
    frequency_uncertainty: Decades = 0.03
    discrepancy: Annotated[
        bool, Field(description="let the models be wrong by a common scatter, which is estimated")
    ] = True
    targets: Annotated[tuple[Target, ...], Listed(1, 200, "targets")]
    conditions: Annotated[tuple[Condition, ...], Listed(1, 200, "conditions")]

    @model_validator(mode="after")
    def _check(self) -> Plan:
        problems = []
        for field in ("parameters", "models", "conditions", "targets"):
            names = [each.name for each in getattr(self, field)]
            for at, name in enumerate(names):
                if name in names[:at]:
                    problems.append(Problem((field, at, "name"), "must not be given twice", "Rename one"))
        targets = {target.name: target for target in self.targets}
        for at, condition in enumerate(self.conditions):
            for name, measured in condition.measured.items():
                problems += _measured_problems(
                    ("conditions", at, "measured", name), targets.get(name), measured
                )
        problems += self._freed_problems()
        if self.effort.startup + self.effort.polish > self.effort.evaluations:
            rule = f"must be at least startup + polish = {self.effort.startup + self.effort.polish}"
            problems.append(Problem(("effort", "evaluations"), rule, "Raise it, or lower those"))
        refuse(problems)
        return self

    def parameters_of(self, model: str) -> tuple[Parameter, ...]:
        """Return the free parameters of a model; all parameters for an unknown name."""
        freed = next((each.parameters for each in self.models if each.name == model), None)
        return tuple(p for p in self.parameters if freed is None or p.name in freed)

    def _freed_problems(self) -> list[Problem]:
        known, used = [p.name for p in self.parameters], set[str]()
        problems = []
        for at, model in enumerate(self.models):
            used |= set(known if model.parameters is None else model.parameters)
            for place, name in enumerate(model.parameters or ()):
                where = ("models", at, "parameters", place)
                if name not in known:
                    cure = did_you_mean(name, known, "Parameters")
                    problems.append(Problem(where, "must be the name of a parameter of the plan", cure))
                elif name in (model.parameters or ())[:place]:
                    problems.append(Problem(where, "must not be given twice", "Remove one"))
        for at, name in enumerate(known):
            if name not in used:
                rule = "must be freed by a model"
                problems.append(Problem(("parameters", at, "name"), rule, "Name it in a model, or remove it"))
        return problems


def _measured_problems(
    at: tuple[str | int, ...],
    target: LineTarget | HumpTarget | LevelTarget | StatisticTarget | None,
    measured: Measured,
) -> list[Problem]:
    if target is None:
        return [Problem(at, "must be the name of a target", "Add the target, or correct the name")]
    allowed = {
        "line": ("amplitude", "frequency"),
        "hump": ("amplitude", "frequency"),
        "level": ("amplitude",),
    }
    fields = allowed.get(target.kind, ("value",))
    given = [name for name in ("amplitude", "frequency", "value") if getattr(measured, name) is not None]
    wrong = [
        Problem((*at, name), f"does not belong to a {target.kind}", f"It has: {', '.join(fields)}")
        for name in given
        if name not in fields
    ]
    return wrong if given else [Problem(at, "must hold a value", f"Give {' or '.join(fields)}")]


def to_value(unit: float, low: float, high: float, scale: str) -> float:
    """Return the parameter at ``unit``, 0 at ``low`` and 1 at ``high``, on its scale.

    >>> round(to_value(0.5, 1.0, 100.0, "log"), 12), to_value(0.5, 1.0, 3.0, "linear")
    (10.0, 2.0)
    """
    if scale == "log":
        return math.exp((1.0 - unit) * math.log(low) + unit * math.log(high))
    return (1.0 - unit) * low + unit * high
