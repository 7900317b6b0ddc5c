"""Drawn points of a sweep: space-filling or random, correlated, as quantiles of each distribution."""

import math
import warnings
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gearplay.model.case import Case
from gearplay.model.plan_values import factor, number_in_si, value_at
from gearplay.model.reading import replace
from gearplay.sweeps.plans.design import Design, Random
from gearplay.sweeps.plans.plan import Axis
from gearplay.vocabulary.errors import InputError
from gearplay.vocabulary.optional import load_optional

Floats = NDArray[np.float64]
LEAST_SHARE = 0.001
"""Least share of a normal distribution between its limits."""


def varied_number(varied: Axis | Random, raw: Any, where: str, base: Case) -> float:
    """Return a bound of a varied field in SI, or as a factor, after a trial in the case."""
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
    columns = [
        quantile(p, limits_of(p, f"design.parameters.{at}", base), scores[:, at])
        for at, p in enumerate(design.parameters)
    ]
    return np.column_stack(columns)


def check_draws(design: Design, sample: Floats, base: Case) -> None:
    """Raise `InputError` where the case refuses the least or the largest value that the draws of a parameter reach."""
    for at, p in enumerate(design.parameters):
        for reached in (float(sample[:, at].min()), float(sample[:, at].max())):
            try_draw(p, f"design.parameters.{at}", reached, base)


def try_draw(p: Random, place: str, reached: float, base: Case) -> None:
    """Raise `InputError` where the case refuses a value that the draws reach."""
    try:
        replace(
            base,
            {
                path: reached * value_at(base, path) if p.mode == "scale" else reached
                for path in (p.path, *p.also)
            },
        )
    except InputError as error:
        fault = error.faults[0]
        where = f"{place}: the draws of {p.name} reach {fault.path}"
        cure = "Give low or high, or less deviation"
        raise InputError.of(where, fault.value, fault.rule, cure) from None


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
    """Return unit points whose normal scores have the given correlations (Gaussian copula)."""
    if matrix is None:
        return unit
    from scipy.special import ndtr, ndtri

    try:
        root = np.linalg.cholesky(matrix)
    except np.linalg.LinAlgError:
        rule = "must not contradict each other: together they are no correlation matrix"
        raise InputError.of("design.correlations", np.round(matrix, 3).tolist(), rule, "Lower some") from None
    return np.asarray(ndtr(ndtri(np.clip(unit, 1e-15, 1.0 - 1e-15)) @ root.T))


@dataclass(frozen=True)
class Limits:
    """A distribution's numbers in SI, or factors; infinite where it has no such limit."""

    low: float
    high: float
    mean: float
    deviation: float
    peak: float


def limits_of(p: Random, where: str, base: Case) -> Limits:
    """Return the numbers of the drawn parameter at ``where`` in its plan; `InputError` where they contradict each other."""
    plain = {
        n: varied_number(p, getattr(p, n), f"{where}.{n}", base)
        for n in ("low", "high", "mean", "peak")
        if getattr(p, n) is not None
    }
    if p.deviation is not None and p.distribution == "log-normal":  # of a logarithm: a factor
        plain["deviation"] = factor(p.deviation, f"{where}.deviation")
    elif p.deviation is not None:
        plain["deviation"] = varied_number(p, p.deviation, f"{where}.deviation", base)
    found = Limits(
        plain.get("low", -math.inf),
        plain.get("high", math.inf),
        plain.get("mean", 0.0),
        plain.get("deviation", 1.0),
        plain.get("peak", 0.5 * (plain.get("low", 0.0) + plain.get("high", 0.0))),
    )
    kind, above_0 = p.distribution, f"must be above 0 for a {p.distribution} distribution"
    for fits, name, rule, cure in (
        (found.low < found.high, "high", "must be above low", "Swap them"),
        (
            kind != "triangular" or found.low <= found.peak <= found.high,
            "peak",
            "must lie between low and high",
            "Correct it",
        ),
        (kind != "log-uniform" or found.low > 0.0, "low", above_0, "Raise it"),
        (kind != "log-normal" or found.mean > 0.0, "mean", above_0, "Raise it"),
        (
            "normal" not in kind or found.deviation > 0.0,
            "deviation",
            "must be above 0",
            "Give the standard deviation",
        ),
    ):
        if not fits:
            raise InputError.of(f"{where}.{name}", getattr(p, name), rule, cure)
    if "normal" in kind and _share_inside(p, found) < LEAST_SHARE:
        rule = f"must leave at least {LEAST_SHARE:g} of its distribution between low and high"
        raise InputError.of(where, p.name, rule, "Correct low, high, mean or deviation")
    return found


def _scores(p: Random, limits: Limits) -> tuple[float, float]:
    """Return the limits of a normal or log-normal distribution in standard deviations from its centre."""
    if p.distribution == "normal":
        low, high = limits.low - limits.mean, limits.high - limits.mean
    else:
        low = math.log(limits.low / limits.mean) if limits.low > 0.0 else -math.inf
        high = math.log(limits.high / limits.mean) if limits.high > 0.0 else -math.inf
    return low / limits.deviation, high / limits.deviation


def _share_inside(p: Random, limits: Limits) -> float:
    from scipy.special import ndtr

    low, high = _scores(p, limits)
    return float(ndtr(high) - ndtr(low) if low < 0.0 else ndtr(-low) - ndtr(-high))


def quantile(p: Random, limits: Limits, u: Floats) -> Floats:
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

    least, most = _scores(p, limits)
    below, above = float(ndtr(least)), float(ndtr(most))
    scores = ndtri(np.clip(below + u * (above - below), 1e-300, 1.0 - 1e-16))
    scores = limits.deviation * np.clip(scores, least, most)
    return np.asarray(
        limits.mean * np.exp(scores) if p.distribution == "log-normal" else limits.mean + scores
    )
