"""The points of a sweep: axes times drawn sample times members, by number, without a list of them."""

import math
import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gearplay.model.case import Case
from gearplay.study.plan_values import factor, number_in_si, value_in_si
from gearplay.study.sweeps.plan import MOST, Axis, SweepPlan
from gearplay.study.sweeps.plan_design import Design, Random
from gearplay.vocabulary.errors import Fault, InputError, ResourceError
from gearplay.vocabulary.optional import load_optional

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Points:
    """All points of a plan, in C order of ``shape``: the axes, then ``direction``, ``sample``, ``member`` where there are any.

    ``values`` holds each axis's values in SI (or factors), ``sample`` the drawn ones, shape [sample, parameter]. A *job* is what
    must run in one go: a point, or all points along the axis ``carried`` in one direction.
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
        """Return the varied values by name, and the member, of point ``index``; a carried one has its ``direction`` too."""
        place = [int(i) for i in np.unravel_index(index, self.shape)] if self.shape else []
        number = len(self.axes)
        found = {n: v[i] for n, v, i in zip(self.axes, self.values, place[:number], strict=True)}
        if self.directions:
            found["direction"] = self.directions[place[number]]
            number += 1
        if self.parameters:
            row = self.sample[place[number]]
            found |= {name: float(x) for name, x in zip(self.parameters, row, strict=True)}
        return found, place[-1] if self.members > 1 else 0

    @property
    def jobs(self) -> int:
        """Number of jobs."""
        return len(self) // len(self.values[self.carried]) if self.directions else len(self)

    def job(self, number: int) -> list[int]:
        """Return the points of a job, in the order in which they run."""
        if not self.directions:
            return [number]
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


def points_of(plan: SweepPlan, base: Case) -> Points:
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
        raise InputError(
            Fault(f"axes.{carried}", names[carried], rule, "Sort them; carry.directions has the way down")
        )
    return Points(
        axes=tuple(names),
        values=values,
        parameters=tuple(p.name for p in drawn),
        sample=draw(plan.design, base) if plan.design else np.zeros((1, 0)),
        members=plan.members,
        directions=tuple(plan.carry.directions) if plan.carry else (),
        carried=carried,
    )


def axis_values(axis: Axis, at: int, base: Case) -> tuple[Any, ...]:
    """Return an axis's values in SI; factors where it scales."""
    paths = (axis.path, *axis.also)
    if axis.values is not None:
        where = f"axes.{at}.values"
        if axis.mode == "scale":
            return tuple(factor(v, f"{where}.{i}") for i, v in enumerate(axis.values))
        return tuple(value_in_si(base, paths, v, f"{where}.{i}") for i, v in enumerate(axis.values))
    assert axis.count is not None
    low, high = (_number(axis, getattr(axis, n), f"axes.{at}.{n}", base) for n in ("low", "high"))
    if axis.scale == "log" and min(low, high) <= 0.0:
        rule = "must be above 0 on a log scale, like high"
        raise InputError(Fault(f"axes.{at}.low", axis.low, rule, "Raise it, or use linear"))
    grid = np.geomspace(low, high, axis.count) if axis.scale == "log" else np.linspace(low, high, axis.count)
    return tuple(float(v) for v in grid)


def _check_once(axis: Axis, at: int, values: tuple[Any, ...]) -> None:
    """Raise `InputError` where an axis has a value twice: its cases would run, and stand in the result, twice."""
    seen: set[str] = set()
    for place, value in enumerate(values):
        if repr(value) in seen:
            where = f"axes.{at}.values.{place}" if axis.values is not None else f"axes.{at}.high"
            shown = axis.values[place] if axis.values is not None else axis.high
            raise InputError(
                Fault(where, shown, f"must not be a value that {axis.name} already has", "Remove it")
            )
        seen.add(repr(value))


def _number(varied: Axis | Random, raw: Any, where: str, base: Case) -> float:
    if varied.mode == "scale":
        return factor(raw, where)
    return number_in_si(base, (varied.path, *varied.also), raw, where)


def sample_size(design: Design) -> int:
    """Return the number of points of a design."""
    return design.count * (len(design.parameters) + 2) if design.kind == "saltelli" else design.count


def draw(design: Design, base: Case) -> Floats:
    """Return a design's points in SI (or factors), shape [sample, parameter].

    Raises `InputError` for correlations that contradict each other or limits without room between them.
    """
    scores = correlated(unit_points(design), correlation_matrix(design))
    columns = [quantile(p, _limits(p, at, base), scores[:, at]) for at, p in enumerate(design.parameters)]
    return np.column_stack(columns)


def unit_points(design: Design) -> Floats:
    """Return even points of the unit cube, shape [sample, parameter], by the design's kind and seed."""
    dimension = len(design.parameters)
    if design.kind == "monte-carlo":
        return np.random.default_rng(design.seed).random((design.count, dimension))
    if design.kind == "saltelli":
        sampler = load_optional("SALib.sample.sobol", "sweeps")
        problem = {
            "num_vars": dimension,
            "names": [p.name for p in design.parameters],
            "bounds": [[0, 1]] * dimension,
        }
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # counts that are no power of 2 are less balanced, not wrong
            found = sampler.sample(problem, design.count, calc_second_order=False, seed=design.seed)
        return np.asarray(found, dtype=np.float64)
    from scipy.stats import qmc

    if design.kind == "latin-hypercube":
        return np.asarray(qmc.LatinHypercube(dimension, rng=design.seed).random(design.count))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return np.asarray(qmc.Sobol(dimension, rng=design.seed).random(design.count))


def correlation_matrix(design: Design) -> Floats | None:
    """Return the correlations of normal scores, shape [parameter, parameter]; None where there are none."""
    if not design.correlations:
        return None
    names = [p.name for p in design.parameters]
    matrix = np.eye(len(names))
    for each in design.correlations:
        i, j = (names.index(name) for name in each.between)
        matrix[i, j] = matrix[j, i] = each.value
    return matrix


def correlated(unit: Floats, matrix: Floats | None) -> Floats:
    """Return unit points whose normal scores have the wanted correlations (Gaussian copula)."""
    if matrix is None:
        return unit
    from scipy.special import ndtr, ndtri

    try:
        root = np.linalg.cholesky(matrix)
    except np.linalg.LinAlgError:
        rule = "must not contradict each other: together they are no correlation matrix"
        raise InputError(
            Fault("design.correlations", np.round(matrix, 3).tolist(), rule, "Lower some")
        ) from None
    return np.asarray(ndtr(ndtri(np.clip(unit, 1e-15, 1.0 - 1e-15)) @ root.T))


@dataclass(frozen=True)
class _Limits:
    low: float
    high: float
    mean: float
    deviation: float
    peak: float


def _limits(p: Random, at: int, base: Case) -> _Limits:
    where = f"design.parameters.{at}"
    plain = {
        n: _number(p, getattr(p, n), f"{where}.{n}", base)
        for n in ("low", "high", "mean", "peak")
        if getattr(p, n) is not None
    }
    if p.deviation is not None:
        exponent = p.distribution == "log-normal"
        plain["deviation"] = (
            factor(p.deviation, f"{where}.deviation")
            if exponent
            else _number(p, p.deviation, f"{where}.deviation", base)
        )
    found = _Limits(
        plain.get("low", -math.inf),
        plain.get("high", math.inf),
        plain.get("mean", 0.0),
        plain.get("deviation", 1.0),
        plain.get("peak", 0.5 * (plain.get("low", 0.0) + plain.get("high", 0.0))),
    )
    if not found.low < found.high:
        raise InputError(Fault(f"{where}.high", p.high, "must be above low", "Swap them"))
    if p.distribution == "triangular" and not found.low <= found.peak <= found.high:
        raise InputError(Fault(f"{where}.peak", p.peak, "must lie between low and high", "Correct it"))
    if p.distribution == "log-uniform" and found.low <= 0.0:
        raise InputError(
            Fault(f"{where}.low", p.low, "must be above 0 for a log-uniform distribution", "Raise it")
        )
    if p.distribution == "log-normal" and found.mean <= 0.0:
        raise InputError(
            Fault(f"{where}.mean", p.mean, "must be above 0 for a log-normal distribution", "Raise it")
        )
    if "normal" in p.distribution and not found.deviation > 0.0:
        raise InputError(
            Fault(f"{where}.deviation", p.deviation, "must be above 0", "Give the standard deviation")
        )
    return found


def quantile(p: Random, limits: _Limits, u: Floats) -> Floats:
    """Return the quantiles of a parameter's distribution at probabilities ``u``, shape [sample]."""
    low, high = limits.low, limits.high
    if p.distribution == "uniform":
        return low + (high - low) * u
    if p.distribution == "log-uniform":
        return np.asarray(low * (high / low) ** u)
    if p.distribution == "triangular":
        share = (limits.peak - low) / (high - low)
        rising = low + np.sqrt(u * (high - low) * (limits.peak - low))
        falling = high - np.sqrt((1.0 - u) * (high - low) * (high - limits.peak))
        return np.where(u < share, rising, falling)
    from scipy.special import ndtr, ndtri

    logarithmic = p.distribution == "log-normal"
    centre = math.log(limits.mean) if logarithmic else limits.mean
    ends = [
        (
            math.log(end)
            if logarithmic and 0.0 < end < math.inf
            else -math.inf
            if logarithmic and end <= 0.0
            else end
        )
        for end in (low, high)
    ]
    below, above = (float(ndtr((end - centre) / limits.deviation)) for end in ends)
    scores = centre + limits.deviation * ndtri(np.clip(below + u * (above - below), 1e-300, 1.0 - 1e-16))
    scores = np.clip(scores, ends[0], ends[1])
    return np.asarray(np.exp(scores) if logarithmic else scores)


def order_of(count: int) -> Sequence[int]:
    """Return a fixed shuffle of the points: costs come evenly, so that a progress bar's estimate holds."""
    order: Sequence[int] = np.random.default_rng(20210623).permutation(count)  # type: ignore[assignment]
    return order
