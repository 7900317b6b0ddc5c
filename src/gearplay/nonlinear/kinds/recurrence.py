"""Recurrence of states: the loss of closeness of neighbouring states, and how well neighbours forecast each other.

For each state the nearest one of another time is found; a quarter of the record later their distance is compared with that of two
arbitrary states. ``loss`` is the share of the closeness (in logarithms) that is gone: near 0 on a torus, whose motion keeps
distances up to a factor, near 1 in chaos. It is the late end of the curve of Rosenstein, Collins and De Luca (Physica D 65 (1993)
117), whose early slope is the largest exponent. States are made of six coordinates by delays (Takens: 2 d + 1 for a set of
dimension d); a delay can only hide closeness, so the one with the least loss counts.

Limits: the largest exponent must act within a quarter of the record; states on a torus of three frequencies are never close in a
short record, and give no result.
"""

import math

import numpy as np
from numpy.typing import NDArray

from gearplay.nonlinear.kinds.repetition import unfolded
from gearplay.nonlinear.kinds.thresholds import CLEAR

Floats = NDArray[np.float64]

COORDINATES = 6
DELAYS = (1, 2, 3, 5, 8)
"""Delays [period]; all that fit into a tenth of the record are tried."""

THEILER = 10
"""Neighbours are more than so many periods apart, so that they are not parts of one passage."""


def delay_states(samples: Floats, delay: int, coordinates: int = COORDINATES) -> Floats:
    """Return states made of each sample and later ones, shape [state, coordinate].

    >>> delay_states(np.arange(5.0)[:, None], 2, 2).tolist()
    [[0.0, 2.0], [1.0, 3.0], [2.0, 4.0]]
    """
    copies = -(-coordinates // samples.shape[1])
    count = len(samples) - (copies - 1) * delay
    return np.hstack([samples[i * delay : i * delay + count] for i in range(copies)])


def neighbours(states: Floats) -> tuple[Floats, NDArray[np.intp]]:
    """Return the distance and the index of each state's nearest neighbour at another time, both of shape [state]."""
    from scipy.spatial import cKDTree

    count = min(len(states), 2 * THEILER + 2)  # at least one of so many is of another time
    distances, places = cKDTree(states).query(states, k=count)
    rows = np.arange(len(states))
    first = np.argmax(np.abs(places - rows[:, None]) > THEILER, axis=1)
    return np.asarray(distances[rows, first]), np.asarray(places[rows, first])


def closeness_loss(samples: Floats, noise: float, bands: int = 1) -> float:
    """Return the least loss of closeness over the delays, NaN where neighbours are not `CLEAR` closer than arbitrary states.

    ``samples`` has shape [period, signal], each signal of standard deviation 1; ``noise`` is the distance of two samples that
    means nothing. Arbitrary states are those of one of ``bands`` bands.

    >>> n = np.arange(600.0)[:, None]
    >>> round(closeness_loss(np.cos(2.0 * np.pi * 0.5**0.5 * n) * 2.0**0.5, 1e-6), 2)
    0.0
    """
    copies = -(-COORDINATES // samples.shape[1])
    longest = len(samples) // 10 if copies > 1 else 1
    delays = [d for d in DELAYS if d == 1 or (copies - 1) * d <= longest]
    floor = max(noise * math.sqrt(copies), 1e-12)
    losses = [_loss(delay_states(samples, delay), floor, bands) for delay in delays]
    return min((loss for loss in losses if math.isfinite(loss)), default=math.nan)


def _loss(states: Floats, floor: float, bands: int) -> float:
    late = len(states) // 4
    early = states[: len(states) - late]
    distances, near = neighbours(early)
    at = np.arange(len(early))
    later = [_log_distance(states[at + h], states[near + h], floor) for h in range(late - THEILER, late + 1)]
    shifts = [max(round(part * len(states) / bands), 1) * bands for part in np.linspace(0.25, 0.75, 11)]
    arbitrary = float(np.mean([_log_distance(states[s:], states[:-s], floor) for s in shifts]))
    closeness = arbitrary - float(np.mean(np.log(np.maximum(distances, floor))))
    return 1.0 - (arbitrary - float(np.mean(later))) / closeness if closeness >= math.log(CLEAR) else math.nan


def _log_distance(first: Floats, second: Floats, floor: float) -> float:
    return float(np.mean(np.log(np.maximum(np.linalg.norm(first - second, axis=1), floor))))


def forecast_error(samples: Floats, bands: int = 1) -> float:
    """Return the error variance of a forecast from neighbours, relative to that of the best linear forecast.

    Neighbours have three coordinates, the linear forecast has six, within the ``bands`` bands. Noise, white or coloured, gives
    about 1, chaos less. It is meaningless for regular motion, which a linear law may forecast without error.
    """
    samples = unfolded(samples, bands)
    states, after = _before_and_after(samples, 3)
    _, near = neighbours(states)
    by_neighbours = float(np.mean((after - after[near]) ** 2)) / 2.0
    states, after = _before_and_after(samples, COORDINATES)
    linear = after - states @ np.linalg.lstsq(states, after, rcond=None)[0]
    return by_neighbours / max(float(np.mean(linear**2)), 1e-12 * float(np.mean(after**2)))


def _before_and_after(samples: Floats, coordinates: int) -> tuple[Floats, Floats]:
    """Return states of successive samples and the sample that follows each."""
    states = delay_states(samples, 1, coordinates)
    after = samples[states.shape[1] // samples.shape[1] :]
    return states[: len(after)], after
