"""Tolerance answers against closed forms: coverage of intervals, Sobol indices, the largest factor, and the draws themselves."""

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.stats import norm, truncnorm

from gearplay.model.reading import load_case
from gearplay.sweeps.cases.draws import draw, unit_points
from gearplay.sweeps.plans.design import Design
from gearplay.sweeps.tolerances.allowable import largest_scale
from gearplay.sweeps.tolerances.statistics import LEVELS, distribution, exceedance
from gearplay.sweeps.variance import emulated_indices, sobol_indices

Floats = NDArray[np.float64]
Measured = Callable[[str, float, str], None]
REPEATS = 200
FEWEST = 184  # of 200 at 95 %: two standard deviations below 190


def design_of(kind: str, count: int, *parameters: dict[str, Any], seed: int = 0, **more: Any) -> Design:
    """Return a design of factors, which need no field in a case."""
    drawn = tuple({"path": p["name"], "mode": "scale", **p} for p in parameters)
    return Design.model_validate({"kind": kind, "count": count, "seed": seed, "parameters": drawn, **more})


def ishigami(x: Floats) -> Floats:
    return np.asarray(np.sin(x[:, 0]) + 7.0 * np.sin(x[:, 1]) ** 2 + 0.1 * x[:, 2] ** 4 * np.sin(x[:, 0]))


def test_sobol_indices_of_the_ishigami_function(measured: Measured) -> None:
    """Sobol indices of the Ishigami function, drawn as a plan draws, are the exact ones."""
    a, b, pi = 7.0, 0.1, math.pi
    parts = (0.5 * (1.0 + b * pi**4 / 5.0) ** 2, a**2 / 8.0, b**2 * pi**8 * 8.0 / 225.0)
    first = np.array([parts[0], parts[1], 0.0]) / sum(parts)
    total = np.array([parts[0] + parts[2], parts[1], parts[2]]) / sum(parts)
    assert first == pytest.approx([0.3139, 0.4424, 0.0], abs=1e-4)
    assert total == pytest.approx([0.5576, 0.4424, 0.2437], abs=1e-4)
    ranges = [{"name": n, "low": -pi, "high": pi} for n in "abc"]
    worst = 0.0
    for seed in range(3):
        design = design_of("saltelli", 2048, *ranges, seed=seed)
        found = sobol_indices(design, ishigami(draw(design, load_case("han2021"))))
        errors = np.abs(np.array([found.first, found.total]) - [first, total])
        worst = max(worst, float(errors.max()))
        assert np.all(errors <= [found.first_error, found.total_error])
    measured("Sobol indices of the Ishigami function, 2048 blocks: largest error", worst, "0.02")
    assert worst < 0.02


@pytest.mark.parametrize("kind", ["monte-carlo", "latin-hypercube", "sobol"])
def test_polynomial_indices_of_a_polynomial(kind: str) -> None:
    """Indices of a quadratic with an interaction, from the polynomial fitted to any design, are the exact ones."""
    design = design_of(kind, 64, *({"name": n, "low": 0.0, "high": 1.0} for n in "abc"))
    a, b, c = unit_points(design).T
    found = emulated_indices(design, a + 2.0 * b + 3.0 * (a - 0.5) * (b - 0.5) + 0.5 * c**2)
    variance = np.array([1.0 / 12.0, 4.0 / 12.0, 0.25 * (1.0 / 5.0 - 1.0 / 9.0)])
    both = 9.0 / 144.0
    whole = variance.sum() + both
    assert found.first == pytest.approx(variance / whole, abs=1e-9)
    assert found.total == pytest.approx((variance + np.array([both, both, 0.0])) / whole, abs=1e-9)
    assert found.unexplained < 1e-20


def test_polynomial_indices_keep_to_their_intervals_under_noise() -> None:
    """With noise the exact indices lie within the polynomial's intervals, nearly as often as these say."""
    generator, inside = np.random.default_rng(1), 0
    ranges = [{"name": n, "low": 0.0, "high": 1.0} for n in "ab"]
    exact = np.array([1.0, 4.0]) / 12.0 / (5.0 / 12.0 + 0.25)
    for seed in range(REPEATS):
        design = design_of("monte-carlo", 120, *ranges, seed=seed)
        values = unit_points(design) @ [1.0, 2.0] + 0.5 * generator.normal(size=120)
        found = emulated_indices(design, values)
        inside += int(np.sum(np.abs(np.array(found.first) - exact) <= found.first_error))
    assert inside >= 0.88 * 2 * REPEATS


@pytest.mark.parametrize(("count", "probability"), [(30, 0.1), (100, 0.02), (300, 0.3), (1000, 0.005)])
def test_coverage_of_the_exceedance_probability(count: int, probability: float, measured: Measured) -> None:
    """The interval of an exceedance probability holds that of a known distribution in 95 % of 200 repeats."""
    generator, inside = np.random.default_rng([count, 1]), 0
    for _ in range(REPEATS):
        found = exceedance(generator.normal(size=count), float(norm.isf(probability)))
        inside += found.low <= probability <= found.high
    measured(
        "exceedance probability within its 95 % interval: share of 200 repeats",
        inside / REPEATS,
        "at least 0.92",
    )
    assert inside >= FEWEST


@pytest.mark.parametrize(
    ("samples", "members", "probability", "common"),
    [(20, 8, 0.1, 0.3), (50, 4, 0.05, 0.3), (100, 4, 0.05, 0.6), (100, 8, 0.3, 0.05), (200, 8, 0.01, 0.3)],
)
def test_coverage_of_the_exceedance_probability_with_members(
    samples: int, members: int, probability: float, common: float, measured: Measured
) -> None:
    """So it does where members share their point's parameters, which explain the part ``common`` of the variance."""
    generator, inside = np.random.default_rng([samples, members, 2]), 0
    for _ in range(REPEATS):
        values = math.sqrt(common) * generator.normal(size=(samples, 1))
        values = values + math.sqrt(1.0 - common) * generator.normal(size=(samples, members))
        found = exceedance(values, float(norm.isf(probability)))
        inside += found.low <= probability <= found.high
    measured("the same with members that share their point", inside / REPEATS, "at least 0.92")
    assert inside >= FEWEST


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["latin-hypercube", "sobol"])
def test_even_designs_scatter_less_than_their_interval_says(kind: str) -> None:
    """The interval is wide enough for designs whose points are more even than independent ones."""
    parameters = [{"name": n, "distribution": "normal", "mean": 0.0, "deviation": 1.0} for n in "ab"]
    limit, inside = float(norm.isf(0.1)) * math.sqrt(2.0), 0
    for seed in range(REPEATS):
        design = design_of(kind, 64, *parameters, seed=seed)
        found = exceedance(draw(design, load_case("han2021")).sum(axis=1), limit)
        inside += found.low <= 0.1 <= found.high
    assert inside >= FEWEST


@pytest.mark.slow
@pytest.mark.parametrize(
    ("samples", "members", "common"), [(60, 1, 1.0), (300, 1, 1.0), (40, 8, 0.3), (100, 4, 0.8)]
)
def test_coverage_of_quantiles(samples: int, members: int, common: float, measured: Measured) -> None:
    """Intervals of quantiles hold those of a known distribution in 95 % of 200 repeats."""
    generator, inside = np.random.default_rng([samples, members, 3]), np.zeros(len(LEVELS))
    for _ in range(REPEATS):
        values = math.sqrt(common) * generator.normal(size=(samples, 1))
        values = values + math.sqrt(1.0 - common) * generator.normal(size=(samples, members))
        found = distribution(values).quantiles
        inside += [q.low <= norm.ppf(q.level) <= q.high for q in found]
    measured(
        "quantile within its 95 % interval: share of 200 repeats, worst level",
        inside.min() / REPEATS,
        "at least 0.92",
    )
    assert inside.min() >= FEWEST


def test_the_largest_factor_has_a_closed_form(measured: Measured) -> None:
    """For factor times |normal| the largest factor is limit / quantile; its span holds it; what is called safe is."""
    generator, inside = np.random.default_rng(7), 0
    exact = 1.2 / float(norm.ppf(0.95))  # P(|normal| <= quantile) = 0.9
    errors, wrong, unsafe = [], 0, 0
    for _ in range(REPEATS):
        sample, fresh = np.abs(generator.normal(size=(2, 400)))
        found = largest_scale(
            lambda f, s=sample: f * s,
            1.2,
            probability=0.9,
            factors=(0.2, 2.0),
            steps=16,
            check=lambda f, s=fresh: f * s,
        )
        inside += found.span[0] <= exact <= found.span[1]
        errors.append(found.factor / exact - 1.0)
        assert found.safe
        unsafe += found.advised > exact
        wrong += (found.confirmed is True and found.advised > exact) or (
            found.confirmed is False and found.advised < exact
        )
    measured("largest factor within its 95 % span: share of 200 repeats", inside / REPEATS, "at least 0.92")
    assert inside >= FEWEST
    assert abs(float(np.mean(errors))) < 0.01
    measured("factors called safe that are not: share of 200 repeats", unsafe / REPEATS, "at most 0.05")
    assert unsafe <= 0.05 * REPEATS
    assert wrong <= 0.05 * REPEATS


def moments(values: Floats) -> tuple[float, float, float]:
    """Return mean and variance of a sample, and the standard error of the mean."""
    return float(np.mean(values)), float(np.var(values)), float(np.std(values)) / math.sqrt(len(values))


def known_distributions() -> list[tuple[dict[str, Any], float, float]]:
    cut = truncnorm(-1.0, 0.5, loc=10.0, scale=2.0)
    ratio = math.log(4.0 / 0.5)
    spread = math.exp(0.3**2)
    return [
        ({"distribution": "uniform", "low": 1.0, "high": 4.0}, 2.5, 0.75),
        ({"distribution": "log-uniform", "low": 0.5, "high": 4.0}, 3.5 / ratio, 15.75 / (2.0 * ratio) - (3.5 / ratio) ** 2),
        ({"distribution": "triangular", "low": 0.0, "high": 3.0, "peak": 1.0}, 4.0 / 3.0, 7.0 / 18.0),
        ({"distribution": "normal", "mean": 10.0, "deviation": 2.0}, 10.0, 4.0),
        ({"distribution": "normal", "mean": 10.0, "deviation": 2.0, "low": 8.0, "high": 11.0}, cut.mean(), cut.var()),
        ({"distribution": "log-normal", "mean": 2.0, "deviation": 0.3}, 2.0 * math.sqrt(spread), 4.0 * spread * (spread - 1.0)),
    ]  # fmt: skip


@pytest.mark.parametrize("kind", ["monte-carlo", "latin-hypercube", "sobol"])
@pytest.mark.parametrize(("parameter", "mean", "variance"), known_distributions())
def test_draws_have_the_moments_of_their_distribution(
    kind: str, parameter: dict[str, Any], mean: float, variance: float
) -> None:
    """Mean and variance of what is drawn are those of the distribution, and its bounds hold."""
    design = design_of(kind, 8192, {"name": "a", **parameter})
    values = draw(design, load_case("han2021"))[:, 0]
    found_mean, found_variance, error = moments(values)
    assert found_mean == pytest.approx(mean, abs=3.5 * error)
    assert found_variance == pytest.approx(variance, rel=0.08)
    assert values.min() >= parameter.get("low", -math.inf)
    assert values.max() <= parameter.get("high", math.inf)


@pytest.mark.parametrize("wanted", [-0.8, 0.3, 0.95])
def test_draws_have_the_wanted_correlation_of_normal_scores(wanted: float, measured: Measured) -> None:
    """The normal scores of two drawn parameters have the wanted correlation, whatever their distributions; a third has none."""
    parameters = [
        {"name": "a", "distribution": "triangular", "low": 0.0, "high": 3.0, "peak": 0.5},
        {"name": "b", "distribution": "log-normal", "mean": 2.0, "deviation": 0.4},
        {"name": "c", "distribution": "uniform", "low": 0.0, "high": 1.0},
    ]
    count = 4000
    design = design_of(
        "monte-carlo", count, *parameters, seed=11, correlations=[{"between": ("a", "b"), "value": wanted}]
    )
    drawn = draw(design, load_case("han2021"))
    ranks = np.argsort(np.argsort(drawn, axis=0), axis=0)
    found = np.corrcoef(norm.ppf((ranks + 0.5) / count), rowvar=False)
    error = 3.5 * (1.0 - wanted**2) / math.sqrt(count)
    measured("correlation of normal scores: error", abs(found[0, 1] - wanted), "3.5 standard errors")
    assert found[0, 1] == pytest.approx(wanted, abs=error)
    assert found[0, 2] == pytest.approx(0.0, abs=3.5 / math.sqrt(count))
    assert found[1, 2] == pytest.approx(0.0, abs=3.5 / math.sqrt(count))
