"""Schema of sweep plans: axes, sampling, reductions."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Field, model_validator

from gearplay.model.reading import bundled_names, load_case
from gearplay.schema.fields import Listed, Measure, Name, Part, Problem, refuse
from gearplay.sweeps.plans.design import Bound, Design, Text, Varied
from gearplay.sweeps.plans.kept import Reduction
from gearplay.sweeps.plans.tolerance import Tolerance, tolerance_problems
from gearplay.vocabulary import quantities as q

Changes = Annotated[dict[str, Any], Field(description="changes of the case, by path")]
Scalar = bool | int | float | Text

MOST = 100_000_000
"""Most cases of one plan."""


class Axis(Varied):
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


class Carry(Part):
    """Continuation along one axis, a drive's speed: each case starts from the final state of the one before it.

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
            problems += tolerance_problems(self.tolerance, self.reduce, self.design, axes=bool(self.axes))
        if self.carry is not None:
            problems += _carry_problems(self.carry, {axis.name: axis for axis in self.axes})
        refuse(problems)
        return self

    def frozen(self) -> SweepPlan:
        """Return the plan with its case file embedded: resuming later or elsewhere must not depend on the file's path."""
        if not isinstance(self.case, str) or self.case in bundled_names():
            return self
        return self.model_copy(update={"case": load_case(self.case).resolved()})


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
