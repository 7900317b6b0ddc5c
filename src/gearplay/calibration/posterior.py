"""Posterior of the parameters: tempered sampling on an emulator of the trials.

Sequential Monte Carlo (Del Moral, Doucet, Jasra, J. R. Stat. Soc. B 68 (2006) 411): a cloud of points drawn from the prior
is led to the posterior by raising the likelihood to powers from 0 to 1, with Metropolis moves at each. Every move of the whole
cloud is one call of the emulator, so a posterior takes a second; nested sampling (dynesty) is its control in the tests.

The likelihood of each datum is a Student t in its log10, since its own uncertainty comes from few groups of members, with
the variance of measurement and emulator, and a common scatter of the model itself where the plan allows a discrepancy.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gearplay.calibration.objective import Comparison
from gearplay.calibration.trials import Problem, Trial
from gearplay.surrogates.polynomials import Emulator, nearness

Floats = NDArray[np.float64]
SCATTER = (0.005, 0.5)  # decades, range of the models' own scatter, uniform in its logarithm
FACTOR = (-8.0, 8.0)  # log10, range of the common factor of the un-normalised reading, uniform
TAILS = 4.0  # degrees of freedom of the likelihood
LEAST_ERROR = 0.6  # of the leave-one-out scatter, that the emulator's mean is taken to be wrong by at least
KNOWN = 0.25  # a parameter is identified when half its 90 % interval is at most this share of its median
KEPT = 0.5  # of the effective number of points, from one power to the next
MOVES, MOST_STEPS = 4.0, 60  # accepted moves of each point at each power, and the most tried
QUANTILES = (0.05, 0.5, 0.95)


def fewest_trials(parameters: int) -> int:
    """Return the number of good trials that an emulator of a number of parameters needs."""
    return 2 * parameters + 2


@dataclass(frozen=True)
class Points:
    """Points of all that is unknown.

    ``units`` of shape [point, parameter] in the unit cube, ``scatter`` of the model itself [decades] and ``factor``,
    log10 of the common factor, both of shape [point].
    """

    units: Floats
    scatter: Floats
    factor: Floats


@dataclass(frozen=True)
class Surrogate:
    """An emulator for one reading of the ordinate, with the error of its mean [decades], shape [datum].

    ``tails`` are the degrees of freedom of the likelihood's Student t; infinity makes it normal.
    """

    comparison: Comparison
    emulator: Emulator
    error: Floats
    tails: float = TAILS

    @classmethod
    def of(cls, comparison: Comparison, trials: Sequence[Trial], *, everywhere: bool = False) -> "Surrogate":
        """Fit to the finished trials, weighted towards the best, or ``everywhere`` with equal weights.

        The mean's error is the leave-one-out scatter less what single trials scatter by themselves, but at least
        `LEAST_ERROR` of it: the polynomial's own noise, and trials whose own errors are overestimated.
        """
        good = [trial for trial in trials if trial.good]
        logs, errors = comparison.logs_of(good)
        units = np.array([trial.unit for trial in good])
        weights = np.ones(len(good)) if everywhere else nearness(comparison.objective(logs, errors))
        emulator = Emulator.fit(units, logs, weights)
        own = np.average(errors**2, axis=0, weights=weights)
        least = (LEAST_ERROR * emulator.scatter) ** 2
        return cls(comparison, emulator, np.sqrt(np.maximum(emulator.scatter**2 - own, least)))

    def simulated(self, points: Points) -> Floats:
        """Return log10 of the predicted measurements, shape [point, datum]: the emulator, times the factor."""
        return self.emulator(points.units) + points.factor[:, None] * self.comparison.amplitudes

    def log_densities(self, points: Points) -> Floats:
        """Return the log likelihood of each datum, shape [point, datum]."""
        c = self.comparison
        variance = (c.uncertainty**2 + self.error**2)[None, :] + points.scatter[:, None] ** 2
        squares = (self.simulated(points) - c.measured) ** 2 / variance
        if math.isinf(self.tails):
            return np.asarray(-0.5 * (squares + np.log(2.0 * math.pi * variance)))
        nu = self.tails
        constant = math.lgamma(0.5 * (nu + 1.0)) - math.lgamma(0.5 * nu) - 0.5 * math.log(nu * math.pi)
        return np.asarray(constant - 0.5 * np.log(variance) - 0.5 * (nu + 1.0) * np.log1p(squares / nu))


@dataclass(frozen=True)
class Interval:
    """One parameter's median and 90 % interval in SI (or as a factor), and whether it is identified."""

    name: str
    low: float
    median: float
    high: float

    @property
    def half_width(self) -> float:
        """Half the 90 % interval over the median."""
        return (self.high - self.low) / (2.0 * abs(self.median)) if self.median else math.inf

    @property
    def identified(self) -> bool:
        """Whether the half-width of the parameter's interval is at most a quarter (`KNOWN`)."""
        return self.half_width <= KNOWN


@dataclass(frozen=True)
class Posterior:
    """Equally weighted sample of the posterior; ``log_evidence`` with its error is ln of the mean likelihood over the prior."""

    points: Points
    log_evidence: float
    log_evidence_error: float

    def quantiles(self, values: Floats) -> Floats:
        """Return the 5, 50 and 95 % points of values, shape [point]."""
        return np.asarray(np.quantile(values, QUANTILES))

    def intervals(self, problem: Problem) -> tuple[Interval, ...]:
        """Return median and 90 % interval of each parameter."""
        ends = np.transpose([self.quantiles(u) for u in self.points.units.T])
        table = [problem.values(unit) for unit in ends]
        return tuple(Interval(p.name, *(row[p.name] for row in table)) for p in problem.parameters)

    def correlation(self) -> Floats:
        """Return the correlation of the parameters on their scales, shape [parameter, parameter]."""
        return np.asarray(np.corrcoef(self.points.units.T).reshape(self.points.units.shape[1], -1))


def sample_posterior(
    surrogate: Surrogate,
    parameters: int,
    *,
    discrepancy: bool,
    chosen: NDArray[np.bool_] | None = None,
    points: int = 1000,
    seed: int = 0,
) -> Posterior:
    """Sample ``points`` from the posterior in the unit cube of ``parameters`` dimensions; ``chosen`` masks the data."""
    c = surrogate.comparison
    data = np.ones(len(c.data), dtype=bool) if chosen is None else chosen
    free = c.reading == "unnormalised" and bool(c.amplitudes.any())
    low, high = np.log(SCATTER[0]), np.log(SCATTER[1])

    def unknowns(cubes: Floats) -> Points:
        nothing = np.zeros(len(cubes))
        return Points(
            cubes[:, :parameters],
            np.exp(low + (high - low) * cubes[:, parameters]) if discrepancy else nothing,
            FACTOR[0] + (FACTOR[1] - FACTOR[0]) * cubes[:, -1] if free else nothing,
        )

    def log_likelihood(cubes: Floats) -> Floats:
        return np.asarray(np.sum(surrogate.log_densities(unknowns(cubes))[:, data], axis=1))

    size = parameters + int(discrepancy) + int(free)
    cubes, evidence, error = temper(log_likelihood, size, points, np.random.default_rng(seed))
    return Posterior(unknowns(cubes), evidence, error)


def temper(
    log_likelihood: Callable[[Floats], Floats], size: int, points: int, generator: np.random.Generator
) -> tuple[Floats, float, float]:
    """Return points of the posterior over the unit cube, shape [point, size], the log evidence and its standard error.

    Each power of the likelihood keeps `KEPT` of the effective number of points; then the cloud is resampled and moved by
    Metropolis steps of its own covariance until every point had on average `MOVES` accepted ones.
    """
    at = generator.random((points, size))
    logs = log_likelihood(at)
    power, evidence, variance = 0.0, 0.0, 0.0
    scale = 2.38 / math.sqrt(size)
    while power < 1.0:
        step = _next_step(logs, 1.0 - power)
        weights, gain = _normalised(step * logs)
        evidence, variance = evidence + gain, variance + float(np.sum(weights**2)) - 1.0 / points
        power = 1.0 if step >= 1.0 - power else power + step
        at, logs = _resampled(at, logs, weights, generator)
        at, logs, scale = _moved(at, logs, log_likelihood, power, scale, generator)
    return at, evidence, math.sqrt(max(variance, 0.0))


def _normalised(logs: Floats) -> tuple[Floats, float]:
    """Return normalised weights and the log of their mean before."""
    top = float(np.max(logs))
    weights = np.exp(logs - top)
    return weights / weights.sum(), top + math.log(float(weights.mean()))


def _next_step(logs: Floats, rest: float) -> float:
    """Return the largest step of the power, up to ``rest``, that keeps `KEPT` of the effective number of points."""

    def effective(step: float) -> float:
        return 1.0 / float(np.sum(_normalised(step * logs)[0] ** 2)) / logs.size

    if effective(rest) >= KEPT:
        return rest
    low, high = 0.0, rest
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if effective(middle) >= KEPT else (low, middle)
    return high


def _resampled(
    at: Floats, logs: Floats, weights: Floats, generator: np.random.Generator
) -> tuple[Floats, Floats]:
    """Draw points in proportion to their weights, evenly (systematic resampling)."""
    places = (generator.random() + np.arange(logs.size)) / logs.size
    chosen = np.minimum(np.searchsorted(np.cumsum(weights), places), logs.size - 1)
    return at[chosen], logs[chosen]


def _moved(
    at: Floats,
    logs: Floats,
    log_likelihood: Callable[[Floats], Floats],
    power: float,
    scale: float,
    generator: np.random.Generator,
) -> tuple[Floats, Floats, float]:
    """Return the cloud after Metropolis steps at this power, and the scale of the steps, led to a third accepted."""
    spread = np.linalg.cholesky(np.cov(at.T).reshape(at.shape[1], -1) + 1e-12 * np.eye(at.shape[1]))
    accepted, steps = 0.0, 0
    while accepted < MOVES and steps < MOST_STEPS:
        tried = at + scale * generator.normal(size=at.shape) @ spread.T
        # Steps out of the cube are refused: to reflect them would favour some directions where the steps are correlated.
        inside = np.all((tried > 0.0) & (tried < 1.0), axis=1)
        found = log_likelihood(np.clip(tried, 0.0, 1.0))
        better = inside & (np.log(generator.random(logs.size)) < power * (found - logs))
        at, logs = np.where(better[:, None], tried, at), np.where(better, found, logs)
        share = float(better.mean())
        accepted, steps = accepted + share, steps + 1
        scale *= math.exp(0.5 * (share - 0.3))
    return at, logs, scale
