"""What the data say of the parameters: nested sampling (dynesty) on an emulator of the trials.

The likelihood is normal in log10 of each datum, with the variance of measurement and emulator, and a common scatter
of the model itself where the plan allows a discrepancy. The common factor of the un-normalised reading is integrated out.
"""

import math
from collections.abc import Sequence
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
    points: int = 200,
    seed: int = 0,
) -> Posterior:
    """Sample the posterior of ``parameters`` in the unit cube from the chosen data, with ``points`` live points."""
    import dynesty

    data = np.ones(len(surrogate.comparison.data), dtype=bool) if chosen is None else chosen
    low, high = np.log(SCATTER[0]), np.log(SCATTER[1])

    def scatter_at(cube: Floats) -> float:
        return math.exp(low + (high - low) * cube[-1]) if discrepancy else 0.0

    def log_likelihood(cube: Floats) -> float:
        return float(surrogate.log_densities(cube[None, :parameters], scatter_at(cube), data)[0])

    sampler = dynesty.NestedSampler(
        log_likelihood,
        lambda cube: cube,
        parameters + int(discrepancy),
        nlive=points,
        sample="rwalk",
        rstate=np.random.default_rng(seed),
    )
    sampler.run_nested(dlogz=0.2, print_progress=False)
    found = sampler.results
    weights = np.exp(found.logwt - np.max(found.logwt))
    samples = np.asarray(found.samples, dtype=np.float64)
    keep = weights > 1e-6 * weights.max()
    samples, weights = samples[keep], weights[keep]
    return Posterior(
        units=samples[:, :parameters],
        scatter=np.array([scatter_at(s) for s in samples]),
        weights=weights / weights.sum(),
        log_evidence=float(found.logz[-1]),
        log_evidence_error=float(found.logzerr[-1]),
    )
