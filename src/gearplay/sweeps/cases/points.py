"""Points of a sweep by number: axes times drawn sample times members, generated lazily."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from gearplay.model.case import Case
from gearplay.model.plan_values import factor, value_in_si
from gearplay.sweeps.cases.draws import check_draws, draw, sample_size, varied_number
from gearplay.sweeps.plans.design import Design
from gearplay.sweeps.plans.plan import MOST, Axis, Carry
from gearplay.vocabulary.errors import InputError, ResourceError

Floats = NDArray[np.float64]

MOST_MEMBERS = 16
"""Members of a job at most: they share their case, and the work of several jobs is easily spread over workers."""


@dataclass(frozen=True)
class Points:
    """All points of a plan, in C order of ``shape``: the axes, then ``direction``, ``sample``, ``member`` where there are any.

    ``values`` holds each axis's values in SI (or factors), ``sample`` the drawn ones, shape [sample, parameter]. A *job* is what
    runs in one go: some members of one case, or all points along the axis ``carried`` in one direction.
    """

    axes: tuple[str, ...]
    values: tuple[tuple[Any, ...], ...]
    parameters: tuple[str, ...]
    sample: Floats
    members: int
    directions: tuple[str, ...] = ()
    carried: int = -1  # place of the carried axis

    @property
    def dims(self) -> tuple[str, ...]:
        """Names of the dimensions; a design and several members have one each."""
        drawn = (*(("direction",) if self.directions else ()), *(("sample",) if self.parameters else ()))
        return (*self.axes, *drawn, *(("member",) if self.members > 1 else ()))

    @property
    def shape(self) -> tuple[int, ...]:
        """Length of each dimension."""
        drawn = (len(self.sample),) if self.parameters else ()
        turned = (len(self.directions),) if self.directions else ()
        return (*map(len, self.values), *turned, *drawn, *((self.members,) if self.members > 1 else ()))

    def __len__(self) -> int:
        return math.prod(self.shape)

    def at(self, index: int) -> tuple[dict[str, Any], int]:
        """Return the varied values by name, and the member, of point ``index``; with its ``direction`` along a continued axis.

        A drawn point has members of its own: were their initial states shared by all points, the common part of these few starts
        would appear as a property of the mechanism.
        """
        place = [int(i) for i in np.unravel_index(index, self.shape)] if self.shape else []
        number = len(self.axes)
        found = {n: v[i] for n, v, i in zip(self.axes, self.values, place[:number], strict=True)}
        if self.directions:
            found["direction"] = self.directions[place[number]]
            number += 1
        if self.parameters:
            row = self.sample[place[number]]
            found |= {name: float(x) for name, x in zip(self.parameters, row, strict=True)}
        member = place[-1] if self.members > 1 else 0
        return found, 1 + place[number] * self.members + member if self.parameters else member

    @property
    def job_size(self) -> int:
        """Points of a job."""
        if self.directions:
            return len(self.values[self.carried])
        return max(size for size in range(1, MOST_MEMBERS + 1) if self.members % size == 0)

    @property
    def jobs(self) -> int:
        """Number of jobs."""
        return len(self) // self.job_size

    def job(self, number: int) -> list[int]:
        """Return the points of a job, in the order in which they run."""
        if not self.directions:
            return list(range(number * self.job_size, (number + 1) * self.job_size))
        shape = list(self.shape)
        length = shape.pop(self.carried)
        place = [int(i) for i in np.unravel_index(number, shape)]
        steps = (
            range(length) if self.directions[place[len(self.axes) - 1]] == "up" else reversed(range(length))
        )
        return [
            int(np.ravel_multi_index((*place[: self.carried], step, *place[self.carried :]), self.shape))
            for step in steps
        ]


class Spanned(Protocol):
    """Part of a plan that determines its points."""

    @property
    def axes(self) -> tuple[Axis, ...]: ...  # noqa: D102
    @property
    def design(self) -> Design | None: ...  # noqa: D102
    @property
    def carry(self) -> Carry | None: ...  # noqa: D102
    @property
    def members(self) -> int: ...  # noqa: D102


def points_of(plan: Spanned, base: Case) -> Points:
    """Return a plan's points; every listed value and every bound is tried in the case.

    Raises `InputError` with a value that the case does not take, `ResourceError` for more than `MOST` points.
    """
    values = tuple(axis_values(axis, at, base) for at, axis in enumerate(plan.axes))
    for at, listed in enumerate(values):
        _check_once(plan.axes[at], at, listed)
    drawn = plan.design.parameters if plan.design else ()
    count = math.prod(map(len, values)) * plan.members * (sample_size(plan.design) if plan.design else 1)
    count *= len(plan.carry.directions) if plan.carry else 1
    if count > MOST:
        raise ResourceError(
            f"sweep: {count:.3g} cases are more than the limit of {MOST:.0e}. Coarsen an axis."
        )
    names = [axis.name for axis in plan.axes]
    carried = names.index(plan.carry.axis) if plan.carry else -1
    if plan.carry and (len(values[carried]) < 2 or any(b <= a for a, b in pairwise(values[carried]))):
        rule = "must have at least two values, rising, where it is carried along"
        raise InputError.of(
            f"axes.{carried}", names[carried], rule, "Sort them; carry.directions has the way down"
        )
    sample = draw(plan.design, base) if plan.design else np.zeros((1, 0))
    if plan.design:
        check_draws(plan.design, sample, base)
    return Points(
        axes=tuple(names),
        values=values,
        parameters=tuple(p.name for p in drawn),
        sample=sample,
        members=plan.members,
        directions=tuple(plan.carry.directions) if plan.carry else (),
        carried=carried,
    )


def axis_values(axis: Axis, at: int, base: Case) -> tuple[Any, ...]:
    """Return the values of an axis in SI, or its factors where its mode is "scale"."""
    paths = (axis.path, *axis.also)
    if axis.values is not None:
        where = f"axes.{at}.values"
        if axis.mode == "scale":
            return tuple(factor(v, f"{where}.{i}") for i, v in enumerate(axis.values))
        return tuple(value_in_si(base, paths, v, f"{where}.{i}") for i, v in enumerate(axis.values))
    assert axis.count is not None
    low, high = (varied_number(axis, getattr(axis, n), f"axes.{at}.{n}", base) for n in ("low", "high"))
    if axis.scale == "log" and min(low, high) <= 0.0:
        rule = "must be above 0 on a log scale, like high"
        raise InputError.of(f"axes.{at}.low", axis.low, rule, "Raise it, or use linear")
    grid = np.geomspace(low, high, axis.count) if axis.scale == "log" else np.linspace(low, high, axis.count)
    return tuple(float(v) for v in grid)


def _check_once(axis: Axis, at: int, values: tuple[Any, ...]) -> None:
    """Raise `InputError` where an axis has a value twice: its cases would be computed and stored twice."""
    seen: set[str] = set()
    for place, value in enumerate(values):
        if repr(value) in seen:
            where = f"axes.{at}.values.{place}" if axis.values is not None else f"axes.{at}.high"
            shown = axis.values[place] if axis.values is not None else axis.high
            raise InputError.of(
                where, shown, f"must not be a value that {axis.name} already has", "Remove it"
            )
        seen.add(repr(value))


def order_of(count: int) -> Sequence[int]:
    """Return a fixed shuffle of the points: costs come evenly, so that a progress bar's estimate holds."""
    order: Sequence[int] = np.random.default_rng(20210623).permutation(count)  # type: ignore[assignment]
    return order
