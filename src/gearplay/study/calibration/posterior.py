"""What the data say of the parameters: tempered sampling of the posterior on an emulator of the trials.

Sequential Monte Carlo (Del Moral, Doucet, Jasra, J. R. Stat. Soc. B 68 (2006) 411): a cloud of points drawn from the prior
is led to the posterior by raising the likelihood to powers from 0 to 1, with Metropolis moves at each. Every move of the whole
cloud is one call of the emulator, so a posterior takes a second; nested sampling (dynesty) is its control in the tests.

The likelihood is normal in log10 of each datum, with the variance of measurement and emulator, and a common scatter
of the model itself where the plan allows a discrepancy. The common factor of the un-normalised reading is integrated out.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gearplay.study.calibration.emulator import Emulator, nearness
from gearplay.study.calibration.objective import Comparison
from gearplay.study.calibration.trials import Trial

Floats = NDArray[np.float64]
SCATTER = (0.005, 0.5)  # decades, range of the models' own scatter, uniform in its logarithm
FACTOR_RANGE = 8.0  # decades, of the common factor's uniform prior
KNOWN = 0.25  # a parameter is identified when half its 90 % interval is at most this share of its median
KEPT = 0.5  # of the effective number of points, from one power to the next
MOVES, MOST_STEPS = 4.0, 60  # accepted moves of each point at each power, and the most tried
QUANTILES = (0.05, 0.5, 0.95)


@dataclass(frozen=True)
class Surrogate:
    """An emulator for one reading of the ordinate, with the error of its mean [decades], shape [datum]."""

    comparison: Comparison
    emulator: Emulator
    error: Floats

    @classmethod
    def of(cls, comparison: Comparison, trials: Sequence[Trial], *, everywhere: bool = False) -> "Surrogate":
        """Fit to the good trials: those that matter near the best, or ``everywhere`` alike.

        The mean's error is the leave-one-out scatter less what single trials scatter by themselves, but at least a third of it.
        """
        good = [trial for trial in trials if trial.good]
        logs, errors = comparison.logs_of(good)
        units = np.array([trial.unit for trial in good])
        weights = np.ones(len(good)) if everywhere else nearness(comparison.objective(logs, errors))
        emulator = Emulator.fit(units, logs, weights)
        own = np.average(errors**2, axis=0, weights=weights)
        error = np.sqrt(np.maximum(emulator.scatter**2 - own, (emulator.scatter / 3.0) ** 2))
        return cls(comparison, emulator, error)

    def log_likelihood(self, units: Floats, scatter: Floats | float = 0.0) -> Floats:
        """Return the log likelihood of all data at points of the unit cube, shape [point]."""
        return np.asarray(self.log_densities(units, scatter, np.ones(len(self.comparison.data), dtype=bool)))

    def log_densities(self, units: Floats, scatter: Floats | float, chosen: NDArray[np.bool_]) -> Floats:
        """Return the log likelihood of the chosen data, shape [point]; the common factor integrated out."""
        c = self.comparison
        logs = self.emulator(units)
        variance = (c.uncertainty**2 + self.error**2)[None, :] + np.reshape(np.square(scatter), (-1, 1))
        raw = (logs - c.measured)[:, chosen]
        v = np.broadcast_to(variance, logs.shape)[:, chosen]
        total = -0.5 * np.sum(np.log(2.0 * np.pi * v), axis=1)
        free = (
            c.amplitudes[chosen] if c.reading == "unnormalised" else np.zeros(int(chosen.sum()), dtype=bool)
        )
        if free.any():
            w = free / v
            whole = np.sum(w, axis=1)
            raw = raw - free * (np.sum(raw * w, axis=1) / whole)[:, None]
            total += 0.5 * np.log(2.0 * np.pi / whole) - math.log(FACTOR_RANGE)
        return np.asarray(total - 0.5 * np.sum(raw**2 / v, axis=1))


@dataclass(frozen=True)
class Interval:
    """One parameter's median and 90 % interval in SI (or as a factor), and whether the data tell it."""

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
        """Whether the data tell the parameter to within a quarter (`KNOWN`)."""
        return self.half_width <= KNOWN


@dataclass(frozen=True)
class Posterior:
    """Weighted points of the posterior.

    ``units`` has shape [sample, parameter] in the unit cube, ``scatter`` [sample] the models' own scatter [decades],
    ``weights`` [sample] sum to 1; ``log_evidence`` with its error is ln of the mean likelihood over the prior.
    """

    units: Floats
    scatter: Floats
    weights: Floats
    log_evidence: float
    log_evidence_error: float

    def quantiles(self, values: Floats) -> Floats:
        """Return the weighted 5, 50 and 95 % points of values, shape [sample]."""
        order = np.argsort(values)
        cumulative = np.cumsum(self.weights[order]) - 0.5 * self.weights[order]
        return np.asarray(np.interp(QUANTILES, cumulative, values[order]))

    def correlation(self) -> Floats:
        """Return the correlation of the parameters on their scales, shape [parameter, parameter]."""
        centred = self.units - np.average(self.units, axis=0, weights=self.weights)
        covariance = (centred * self.weights[:, None]).T @ centred
        size = np.sqrt(np.maximum(np.diag(covariance), 1e-300))
        return np.asarray(covariance / np.outer(size, size))


def sample_posterior(
    surrogate: Surrogate,
    parameters: int,
    *,
    discrepancy: bool,
    chosen: NDArray[np.bool_] | None = None,
    points: int = 1000,
    seed: int = 0,
) -> Posterior:
    """Sample the posterior of ``parameters`` in the unit cube from the chosen data, with a cloud of ``points``."""
    data = np.ones(len(surrogate.comparison.data), dtype=bool) if chosen is None else chosen
    low, high = np.log(SCATTER[0]), np.log(SCATTER[1])

    def scatter_at(cubes: Floats) -> Floats:
        return np.exp(low + (high - low) * cubes[:, -1]) if discrepancy else np.zeros(len(cubes))

    def log_likelihood(cubes: Floats) -> Floats:
        return surrogate.log_densities(cubes[:, :parameters], scatter_at(cubes), data)

    cubes, log_evidence, error = temper(
        log_likelihood, parameters + int(discrepancy), points, np.random.default_rng(seed)
    )
    weights = np.full(points, 1.0 / points)
    return Posterior(cubes[:, :parameters], scatter_at(cubes), weights, log_evidence, error)


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
        tried = 1.0 - np.abs(1.0 - np.abs(tried) % 2.0)  # reflected at the faces of the cube
        found = log_likelihood(tried)
        better = np.log(generator.random(logs.size)) < power * (found - logs)
        at, logs = np.where(better[:, None], tried, at), np.where(better, found, logs)
        share = float(better.mean())
        accepted, steps = accepted + share, steps + 1
        scale *= math.exp(0.5 * (share - 0.3))
    return at, logs, scale
