"""Largest clearances that keep a measure within its limit with a given probability, checked by independent draws.

A factor multiplies what is drawn; every factor is simulated at the same points of the unit cube (common random numbers), so
that neighbouring factors differ by the factor alone. Five factors spread over the range show where the required probability is
crossed, bisection narrows the last crossing, and an independent sample there checks the result.
"""

import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gearplay.sweeps.plans.design import Design, Random
from gearplay.sweeps.plans.plan import SweepPlan
from gearplay.sweeps.plans.tolerance import Tolerance
from gearplay.sweeps.tolerances.statistics import proportion
from gearplay.sweeps.variance import as_table, independent_rows

Floats = NDArray[np.float64]
Evaluate = Callable[[float], Floats]
FOUND, ALL, NONE, UNKNOWN = "found", "all", "none", "unknown"
SCAN = 5  # factors spread over the range before bisection
_LEADING = re.compile(r"([+-]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]+)?)(.*)", re.DOTALL)


@dataclass(frozen=True)
class Step:
    """One factor simulated: the probability to keep to the limit, with its interval; a failed case does not keep to it."""

    factor: float
    meets: float
    low: float
    high: float
    cases: int
    failed: int


@dataclass(frozen=True)
class Allowable:
    """The result of `largest_scale`.

    ``verdict`` is "found", "all" (the largest factor keeps to the limit), "none" (no simulated factor does) or "unknown" (no
    case finished). ``factor`` is the largest that keeps to it (NaN for none), ``resolution`` how much larger the next one is that
    does not. ``span`` holds the true factor with the given confidence, an infinite end where that lies beyond the range.
    ``single`` is false where a smaller factor fails too. ``check`` is a fresh sample at `advised`; ``steps`` are in the order of
    their factors.
    """

    verdict: str
    factor: float
    resolution: float
    span: tuple[float, float]
    single: bool
    wanted: float
    confidence: float
    steps: tuple[Step, ...]
    check: Step | None

    @property
    def safe(self) -> bool:
        """Whether some factor keeps to the limit with the whole interval of its probability."""
        return math.isfinite(self.span[0])

    @property
    def advised(self) -> float:
        """The largest safe factor; where none is, the largest that keeps to the limit by the sample alone; NaN for none."""
        return self.span[0] if self.safe else self.factor

    @property
    def confirmed(self) -> bool | None:
        """Whether the out-of-sample check confirms the advised factor (True), refutes it (False), or does not decide (None)."""
        if self.check is None:
            return None
        return True if self.check.low >= self.wanted else False if self.check.high < self.wanted else None


def step_of(factor: float, values: Floats, limit: float, confidence: float = 0.95) -> Step:
    """Return the probability to keep to ``limit``, from values of shape [sample] or [sample, member].

    >>> step_of(1.0, np.array([1.0, 2.0, np.nan, 4.0]), 2.0).meets  # a failed case does not keep to it
    0.5
    """
    table = as_table(values)
    found = proportion((table <= limit).astype(np.float64), confidence)
    failed = int(np.isnan(table).sum())
    return Step(factor, found.value, found.low, found.high, table.size, failed)


def largest_scale(
    evaluate: Evaluate,
    limit: float,
    *,
    probability: float = 0.95,
    confidence: float = 0.95,
    factors: tuple[float, float] = (0.25, 4.0),
    steps: int = 12,
    check: Evaluate | None = None,
) -> Allowable:
    """Return the largest factor with which a measure keeps to ``limit`` at the required ``probability``.

    ``evaluate(factor)`` returns the measure's values, shape [sample] or [sample, member], from the same points for every
    factor; ``check(factor)`` the same from fresh points. ``steps`` factors are simulated: five, and then the middle of where the
    estimate or an end of its interval crosses the wanted probability, whichever is known worst, the lower end, from which the
    advice comes, counted twice.
    The span has the pointwise confidence where the probability falls with the factor: with common random numbers the
    ends of the interval then fall too, and cross the wanted probability once.

    >>> normal = np.random.default_rng(0).normal(size=400)
    >>> found = largest_scale(lambda f: f * np.abs(normal), 1.96, factors=(0.5, 2.0))  # P(|normal| <= 1.96) = 0.95
    >>> found.verdict, 0.9 < found.factor < 1.1
    ('found', True)
    """
    low, high = factors
    taken: dict[float, Step] = {}

    for factor in np.linspace(low, high, SCAN):
        taken[float(factor)] = step_of(float(factor), evaluate(float(factor)), limit, confidence)
    best, next_up = _crossing(taken, "meets", probability)
    for _ in range(steps - SCAN):
        if not best < next_up:  # all factors keep to the limit, or none does
            break
        gaps = [(best, next_up), *(_crossing(taken, end, probability) for end in ("low", "high"))]
        widths = [
            weight * (above - below) for weight, (below, above) in zip((1.0, 2.0, 1.0), gaps, strict=True)
        ]
        middle = 0.5 * sum(gaps[int(np.nanargmax(widths))])
        taken[middle] = step_of(middle, evaluate(middle), limit, confidence)
        best, next_up = _crossing(taken, "meets", probability)
    done = tuple(taken[factor] for factor in sorted(taken))
    finished = any(step.failed < step.cases for step in done)
    met = not math.isnan(best)
    verdict = UNKNOWN if not finished else NONE if not met else ALL if next_up == best else FOUND
    found = Allowable(
        verdict=verdict,
        factor=best,
        resolution=next_up - best,
        span=(
            max((s.factor for s in done if s.low >= probability), default=-math.inf),
            min((s.factor for s in done if s.high < probability), default=math.inf),
        ),
        single=all(s.meets >= probability for s in done if s.factor <= best),
        wanted=probability,
        confidence=confidence,
        steps=done,
        check=None,
    )
    if check is None or not met:
        return found
    return replace(found, check=step_of(found.advised, check(found.advised), limit, confidence))


def _crossing(taken: Mapping[float, Step], field: str, wanted: float) -> tuple[float, float]:
    """Return the largest factor where a field of its step is at least ``wanted``, and the next simulated; NaN for none."""
    factors = sorted(taken)
    passing = [at for at, factor in enumerate(factors) if getattr(taken[factor], field) >= wanted]
    if not passing:
        return math.nan, math.nan
    return factors[passing[-1]], factors[min(passing[-1] + 1, len(factors) - 1)]


def search_cases(plan: SweepPlan) -> int:
    """Return the largest number of cases of the search of a plan, its fresh sample included; 0 without a search."""
    tolerance = plan.tolerance
    if tolerance is None or not tolerance.scale or plan.design is None:
        return 0
    points = scaled(plan.design, tolerance, 1.0).count
    return (tolerance.steps + 1) * points * plan.members


def search_plan(plan: SweepPlan, tolerance: Tolerance, factor: float, *, fresh: bool = False) -> SweepPlan:
    """Return the plan of the simulations at one factor of the search, with independent points if ``fresh``.

    The points of the unit cube do not depend on the factor. A saltelli design, whose points repeat values, becomes a
    ``sobol`` one.
    """
    assert plan.design is not None
    return plan.model_copy(update={"design": scaled(plan.design, tolerance, factor, fresh=fresh)})


def scaled(design: Design, tolerance: Tolerance, factor: float, *, fresh: bool = False) -> Design:
    """Return a design whose parameters named in ``tolerance.scale`` are ``factor`` times as large."""
    parameters = tuple(
        _larger(p, tolerance.scaling, factor) if p.name in tolerance.scale else p for p in design.parameters
    )
    return design.model_copy(
        update={
            "kind": "sobol" if design.kind == "saltelli" else design.kind,
            "count": tolerance.count or len(independent_rows(design)),
            "seed": (design.seed + 1) % 2**31 if fresh else design.seed,
            "parameters": parameters,
        }
    )


def size_words(p: Random, scaling: str = "size", factor: float = 1.0) -> str:
    """Return the distribution of a parameter as text, ``factor`` times as large, in the units of the plan.

    >>> size_words(Random(name="e", path="p", distribution="triangular", low="0.1 um", high="2 um", peak="0.5 um"), "size", 0.68)
    '0.068 to 1.36 µm, peak 0.34 µm'
    >>> size_words(Random(name="c", path="p", distribution="normal", mean="100 um", deviation="20 um"))
    '100 ± 20 µm'
    """
    larger = _larger(p, scaling, factor) if factor != 1.0 else p

    def shown(bound: Any) -> tuple[str, str]:
        found = _LEADING.fullmatch(str(bound).strip(" "))
        if found is None:
            return str(bound), ""
        unit = re.sub(r"\bum\b", "µm", found[2].strip())
        return f"{float(found[1]):.3g}", f" {unit}" if unit else ""

    def pair(first: Any, second: Any, between: str) -> str:
        (one, unit), (other, last) = shown(first), shown(second)
        return f"{one}{'' if unit == last else unit} {between} {other}{last}"

    if "normal" in p.distribution:
        words = pair(larger.mean, larger.deviation, "±")
        if p.distribution == "log-normal":
            words = f"median {''.join(shown(larger.mean))}, deviation of its logarithm {shown(larger.deviation)[0]}"
    else:
        words = pair(larger.low, larger.high, "to")
    if larger.peak is not None:
        words += f", peak {''.join(shown(larger.peak))}"
    return words + (" times the case's" if p.mode == "scale" else "")


def _larger(p: Random, scaling: str, factor: float) -> Random:
    """Return a parameter whose drawn values, or whose upper end, are ``factor`` times as large."""
    if scaling == "high":
        changed = ["high"]
    else:  # the deviation of a log-normal one is that of a logarithm: a factor leaves it
        changed = ["low", "high", "mean", "peak"] + ["deviation"] * (p.distribution != "log-normal")
    return p.model_copy(update={name: _times(getattr(p, name), factor) for name in changed})


def _times(bound: Any, factor: float) -> Any:
    """Return a number, or a text of a number with its unit, times a factor.

    >>> _times("50 um", 1.5), _times(2.0, 1.5), _times(None, 1.5)
    ('75.0 um', 3.0, None)
    """
    if bound is None or factor == 1.0:
        return bound
    if not isinstance(bound, str):
        return bound * factor
    found = _LEADING.fullmatch(bound.strip(" "))
    return bound if found is None else f"{float(found[1]) * factor!r}{found[2]}"
