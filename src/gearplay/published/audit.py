"""Audit of the article's tables: one free factor, and the scatter of their readings."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gearplay.published.article import printed_rows

Floats = NDArray[np.float64]
SOURCES = ("test", "coupled", "uncoupled")
MESH_LINES = ("mesh_1x", "mesh_2x")


def best_factor(test: Floats, simulated: Floats) -> float:
    """Return the factor a for which the mean of |a simulated / test - 1| is least.

    It is a weighted median of test / simulated, with the weights simulated / test.

    >>> best_factor(np.array([2.0, 4.0, 60.0]), np.array([1.0, 2.0, 3.0]))
    2.0
    """
    ratio = test / simulated
    order = np.argsort(ratio)
    weight = np.cumsum(1.0 / ratio[order])
    return float(ratio[order][np.searchsorted(weight, 0.5 * weight[-1])])


def mean_error(test: Floats, simulated: Floats, factor: float = 1.0) -> float:
    """Return the mean error [%] of simulated values times a factor."""
    return float(100.0 * np.mean(np.abs(factor * simulated / test - 1.0)))


@dataclass(frozen=True)
class FreeFactor:
    """The mean error [%] of one printed model's 18 amplitudes: as printed, and with the one factor that makes it least."""

    model: str
    as_printed: float
    factor: float
    with_factor: float


def free_factor(model: str) -> FreeFactor:
    """Return what one free factor does to a printed model, "coupled" or "uncoupled"."""
    rows = [r for r in printed_rows() if r.quantity == "amplitude_as_printed"]
    test = np.array([r.test for r in rows])
    values = np.array([getattr(r, model) for r in rows])
    factor = best_factor(test, values)
    return FreeFactor(model, mean_error(test, values), factor, mean_error(test, values, factor))


def mesh_readings(line: str) -> Floats:
    """Return by how much [Hz] the readings of a mesh line differ from what the speed makes it, shape [source, condition].

    ``line`` is "mesh_1x" or "mesh_2x"; the sources are the test and both printed models.
    """
    rows = [r for r in printed_rows() if r.quantity == "frequency_hz" and r.line == line]
    harmonic = MESH_LINES.index(line) + 1
    return np.array(
        [[getattr(r, source) - harmonic * r.condition.mesh_frequency for r in rows] for source in SOURCES]
    )


def reading_scatter(line: str) -> float:
    """Return the rms [Hz] of all 18 readings of a mesh line about what the speed makes it."""
    return float(np.sqrt(np.mean(mesh_readings(line) ** 2)))


def harmonic_correlation() -> tuple[float, float]:
    """Return the correlation of what f_m and 2 f_m are read wrong by, over all 18 pairs of readings, and its p value.

    A speed that differs from the nominal one would move both together.
    """
    from scipy.stats import pearsonr

    found = pearsonr(*(mesh_readings(line).ravel() for line in MESH_LINES))
    return float(found.statistic), float(found.pvalue)


def radial_error(model: str) -> float:
    """Return the rms error [Hz] of a printed model's six radial frequencies."""
    rows = [r for r in printed_rows() if r.quantity == "frequency_hz" and r.line == "radial"]
    return math.sqrt(sum((getattr(r, model) - r.test) ** 2 for r in rows) / len(rows))


def error_of_readings(seed: int = 0, draws: int = 20_000) -> tuple[float, float]:
    """Return the 5 and 95 % points of the mean error [%] of f_r that reading errors alone would make.

    Six true frequencies, the test's, are read twice with independent normal errors of the rms of f_m's readings.
    """
    rows = [r for r in printed_rows() if r.quantity == "frequency_hz" and r.line == "radial"]
    test = np.array([r.test for r in rows])
    generator = np.random.default_rng(seed)
    twice = generator.normal(0.0, reading_scatter("mesh_1x"), (draws, 2, test.size))
    first, second = test + twice[:, 0], test + twice[:, 1]
    errors = np.mean(np.abs(second / np.maximum(first, 0.1) - 1.0), axis=1)
    low, high = np.percentile(errors, [5.0, 95.0])
    return 100.0 * float(low), 100.0 * float(high)
