"""Sweep plans: what varies, how it is sampled, and what is kept of each simulation."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Field, Tag, model_validator

from gearplay.model.fields import ByKind, Listed, Measure, Name, Part, Problem, refuse
from gearplay.study.sweeps.tolerance_plan import Tolerance, tolerance_problems
from gearplay.vocabulary import quantities as q

Text = Annotated[str, Field(min_length=1, max_length=200, pattern=r"^[^\p{Cc}\p{Cf}]*$")]
Changes = Annotated[dict[str, Any], Field(description="changes of the case, by path")]
Bound = float | Text
Frequency = Annotated[float, Measure(q.FREQUENCY, "frequency", gt=0.0)]
Band = Annotated[tuple[Frequency, Frequency], Listed(2, 2, "lowest and highest frequency")]
Scalar = bool | int | float | Text

MOST = 100_000_000
"""Most cases of one plan."""


class _Varied(Part):
    """One field of the case, or several that move together.

    ``mode`` "set" puts the value there; "scale" multiplies what the base case has there.
    """

    name: Name
    path: Text
    also: Annotated[tuple[Text, ...], Listed(0, 32, "further fields that get the same value")] = ()
    mode: Literal["set", "scale"] = "set"


class Axis(_Varied):
    """A dimension of the result: listed ``values``, or ``count`` of them from ``low`` to ``high``."""

    values: Annotated[tuple[Scalar, ...], Listed(1, 100_000, "values")] | None = None
    low: Bound | None = None
    high: Bound | None = None
    count: Annotated[int, Field(ge=2, le=1_000_000)] | None = None
    scale: Literal["linear", "log"] = "linear"

    @model_validator(mode="after")
    def _check(self) -> Axis:
        ranged = [self.low is not None, self.high is not None, self.count is not None]
        if (self.values is not None) == any(ranged) or any(ranged) != all(ranged):
            rule = "must be given, or low, high and count, but not both"
            refuse([Problem(("values",), rule, "Give a list, or a range with its count")])
        return self


class Random(_Varied):
    """A parameter that is drawn: every distribution but the normal ones lies between ``low`` and ``high``.

    ``normal`` has ``mean`` and ``deviation`` (standard) and is cut off at ``low`` and ``high`` where they are given;
    ``log-normal`` is the exponential of one, with ``mean`` its median and ``deviation`` that of the natural logarithm;
    ``triangular`` has its ``peak``, the middle if not given.
    """

    distribution: Literal["uniform", "log-uniform", "triangular", "normal", "log-normal"] = "uniform"
    low: Bound | None = None
    high: Bound | None = None
    mean: Bound | None = None
    deviation: Bound | None = None
    peak: Bound | None = None

    @model_validator(mode="after")
    def _check(self) -> Random:
        needed = ("mean", "deviation") if "normal" in self.distribution else ("low", "high")
        allowed = {"low", "high", *needed} | ({"peak"} if self.distribution == "triangular" else set())
        given = {n for n in ("low", "high", "mean", "deviation", "peak") if getattr(self, n) is not None}
        rule = f"a {self.distribution} distribution has {', '.join(sorted(allowed))}"
        problems = [Problem((n,), f"must be given: {rule}", "Add it") for n in needed if n not in given]
        problems += [
            Problem((n,), f"does not belong here: {rule}", "Remove it") for n in sorted(given - allowed)
        ]
        refuse(problems)
        return self


class Correlation(Part):
    """Correlation of the normal scores of two drawn parameters (a Gaussian copula)."""

    between: Annotated[tuple[Name, Name], Listed(2, 2, "two parameters")]
    value: Annotated[float, Field(ge=-1.0, le=1.0)]


class Design(Part):
    """Points drawn together, along one dimension ``sample``.

    ``saltelli`` makes count (parameters + 2) points for Sobol indices; the others ``count``.
    """

    kind: Literal["latin-hypercube", "sobol", "monte-carlo", "saltelli"] = "latin-hypercube"
    count: Annotated[int, Field(ge=1, le=10_000_000)]
    seed: Annotated[int, Field(ge=0, le=2**31 - 1)] = 0
    parameters: Annotated[tuple[Random, ...], Listed(1, 64, "drawn parameters")]
    correlations: Annotated[tuple[Correlation, ...], Listed(0, 2016, "correlations")] = ()

    @model_validator(mode="after")
    def _check(self) -> Design:
        names, problems = [p.name for p in self.parameters], []
        for at, each in enumerate(self.correlations):
            for name in each.between:
                if name not in names:
                    rule = "must be drawn parameters of this design"
                    problems.append(
                        Problem(("correlations", at, "between"), rule, f"Known: {', '.join(names)}")
                    )
        if self.kind == "saltelli" and self.correlations:
            rule = "must be empty for saltelli: Sobol indices need independent parameters"
            problems.append(Problem(("correlations",), rule, "Choose another kind, or remove them"))
        refuse(problems)
        return self


class _Reduction(Part):
    name: Name


class _OfSignal(_Reduction):
    """One sampled signal. ``ax`` and ``ay`` are increments of velocity over a sampling interval: impacts do not alias."""

    signal: Text
    at: Text  # rotor, sleeve or mesh


class StatisticReduction(_OfSignal):
    """A number of the whole record."""

    kind: Literal["statistic"] = "statistic"
    statistic: Literal["rms", "mean", "peak", "peak_to_peak", "kurtosis", "crest_factor"] = "rms"


class LineReduction(_OfSignal):
    """Amplitude and frequency of a line near ``order`` times the first mesh's frequency, or near ``near`` [Hz]."""

    kind: Literal["line"] = "line"
    order: Annotated[int, Field(ge=1, le=64)] | None = None
    near: Frequency | None = None
    search: Annotated[float, Measure(None, "relative half-width of the search", gt=0.0, lt=1.0)] = 0.03

    @model_validator(mode="after")
    def _check(self) -> LineReduction:
        if (self.order is None) == (self.near is None):
            refuse([Problem(("order",), "must be given, or near, but not both", "Say which line is meant")])
        return self


class HumpReduction(_OfSignal):
    """Amplitude and frequency of the highest broad hump within a band."""

    kind: Literal["hump"] = "hump"
    band: Band
    width: Annotated[float, Measure(None, "relative width of the smoothing", gt=0.0, lt=1.0)] = 0.08


class LevelReduction(_OfSignal):
    """The rms value within a band."""

    kind: Literal["level"] = "level"
    band: Band


class SpectrumReduction(_OfSignal):
    """The rms value within each of ``count`` equal parts of a band: a spectrum on one grid for all cases."""

    kind: Literal["spectrum"] = "spectrum"
    band: Band
    count: Annotated[int, Field(ge=2, le=100_000)] = 200


class ContactReduction(_Reduction):
    """A statistic of one contact (``contact`` = ``ring`` or ``pinion-ring:drive``)."""

    kind: Literal["contact"] = "contact"
    contact: Text
    statistic: Literal[
        "share_of_time",
        "impacts_per_second",
        "mean_impact_speed",
        "rms_impact_speed",
        "max_impact_speed",
        "peak_force",
        "max_penetration",
    ]


class JamReduction(_Reduction):
    """Share of time in which both flanks of a mesh are pressed at once."""

    kind: Literal["jam"] = "jam"
    mesh: Text


class HistoryReduction(_OfSignal):
    """The raw samples of one signal: only for few cases."""

    kind: Literal["history"] = "history"


Reduction = Annotated[
    Annotated[StatisticReduction, Tag("kind:statistic")]
    | Annotated[LineReduction, Tag("kind:line")]
    | Annotated[HumpReduction, Tag("kind:hump")]
    | Annotated[LevelReduction, Tag("kind:level")]
    | Annotated[SpectrumReduction, Tag("kind:spectrum")]
    | Annotated[ContactReduction, Tag("kind:contact")]
    | Annotated[JamReduction, Tag("kind:jam")]
    | Annotated[HistoryReduction, Tag("kind:history")],
    ByKind("statistic", "line", "hump", "level", "spectrum", "contact", "jam", "history"),
]


class Carry(Part):
    """Go along one axis, a drive's speed, without starting anew: each case goes on where the one before it ended.

    ``steps`` holds each speed and ramps to the next one within ``ramp``, a part of the transient (quasi-static, hysteresis).
    ``run-up`` ramps all the time; each case is the window in which the speed passes half-way to its neighbours.
    """

    axis: Name
    mode: Literal["steps", "run-up"] = "steps"
    directions: Annotated[tuple[Literal["up", "down"], ...], Listed(1, 2, "directions")] = ("up", "down")
    ramp: Annotated[float, Measure(q.TIME, "time from one speed to the next", gt=0.0)] = 0.1


class SweepPlan(Part):
    """A sweep: every combination of the axes, for every drawn point, for every member of the ensemble."""

    title: Annotated[str, Field(max_length=200, pattern=r"^[^\p{Cc}\p{Cf}]*$")] = ""
    case: Text | dict[str, Any]
    set: Changes = Field(default_factory=dict)
    axes: Annotated[tuple[Axis, ...], Listed(0, 16, "axes")] = ()
    design: Design | None = None
    carry: Carry | None = None
    tolerance: Tolerance | None = None
    members: Annotated[int, Field(ge=1, le=100_000)] = 1
    reduce: Annotated[tuple[Reduction, ...], Listed(1, 200, "reductions")]

    @model_validator(mode="after")
    def _check(self) -> SweepPlan:
        problems = []
        named: list[tuple[tuple[str | int, ...], str]] = [
            (("axes", at, "name"), each.name) for at, each in enumerate(self.axes)
        ]
        for at, drawn in enumerate(self.design.parameters if self.design else ()):
            named.append((("design", "parameters", at, "name"), drawn.name))
        named += [(("reduce", at, "name"), reduction.name) for at, reduction in enumerate(self.reduce)]
        seen: set[str] = {"sample", "member", "direction", "status", "reason", "time"}
        for place, name in named:
            if name in seen:
                problems.append(Problem(place, "must be a name of its own", "Rename it"))
            seen.add(name)
        paths: dict[str, str] = {}
        for each in (*self.axes, *(self.design.parameters if self.design else ())):
            for path in (each.path, *each.also):
                if path in paths:
                    rule = f"must be varied once: {path} belongs to {paths[path]} too"
                    problems.append(Problem(("axes",), rule, "Remove one of them"))
                paths[path] = each.name
        if self.tolerance is not None:
            problems += tolerance_problems(self, self.tolerance)
        if self.carry is not None:
            problems += _carry_problems(self.carry, {axis.name: axis for axis in self.axes})
        refuse(problems)
        return self


def _carry_problems(carry: Carry, axes: dict[str, Axis]) -> list[Problem]:
    axis = axes.get(carry.axis)
    if axis is None:
        return [Problem(("carry", "axis"), "must be the name of an axis", f"Axes: {', '.join(axes)}")]
    problems = []
    if not axis.path.endswith(".drive.speed") or axis.also or axis.mode != "set":
        rule = "must set the speed of one drive: other fields cannot change while the parts move"
        problems.append(Problem(("carry", "axis"), rule, "Carry along rotors.NAME.drive.speed"))
    if len(set(carry.directions)) < len(carry.directions):
        problems.append(Problem(("carry", "directions"), "must not name a direction twice", "Remove one"))
    return problems
