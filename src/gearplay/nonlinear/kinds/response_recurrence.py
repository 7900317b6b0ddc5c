"""What becomes of states that once were close: on a cycle or a torus they stay close, in chaos they forget each other.

For each state the nearest one of another time is found; a quarter of the record later their distance is compared with that of any
two states. ``memory`` is the part of the closeness (in logarithms) that is left: about 1 on a torus, whose motion keeps
distances up to a factor, about 0 in chaos, where they grow until they are those of strangers. It is the late end of the curve of
Rosenstein, Collins and De Luca (Physica D 65 (1993) 117), whose early slope is the largest exponent.

Doubts: the largest exponent must have a quarter of the record to act; states of a torus of three frequencies are never close in a
short record (``closeness`` says how close they are); noise is told from chaos by ``unforeseen`` alone.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from gearplay.nonlinear.kinds.response_repeats import unfolded

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]

COORDINATES: Final = 6
"""Fewest coordinates of a state, filled up by delays: 2 d + 1 of them embed a set of dimension d (Takens), d being 1 to 2.5."""

DELAYS: Final = (1, 2, 3, 5, 8, 13, 21, 34, 55)
"""Delays tried [period], shortest first."""

WIDER: Final = (3, 5, 8)
"""Delays tried beside the shortest that spreads the states out."""

CLOSE: Final = 1.2
"""Closeness from which its loss means anything: neighbours a third as far apart as any two states."""

FLAT: Final = 0.1
"""A delay is too short where the states' second principal size is below this share of the first: they lie on a line."""

APART: Final = 10
"""Neighbours must be more than so many periods apart, so that they are no parts of one passage (Theiler)."""

LATER: Final = 4
"""Closeness is looked at again a record's part ``1 / LATER`` later, as a mean over `SPELL` periods."""

SPELL: Final = 10


@dataclass(frozen=True)
class Recurrence:
    """How states recur.

    ``memory`` is the share of the closeness of neighbours that is left a quarter of the record later, ``closeness`` the logarithm
    of the distance of any two states over that of neighbours, ``unforeseen`` the share of the variance that a neighbour's next
    sample leaves (about 1 for noise); ``distances`` of the neighbours have shape [state].
    """

    memory: float
    closeness: float
    unforeseen: float
    distances: Floats


def delay_states(samples: Floats, delay: int, coordinates: int = COORDINATES) -> Floats:
    """Return states made of each sample and later ones, shape [state, coordinate].

    >>> delay_states(np.arange(5.0)[:, None], 2, 2).tolist()
    [[0.0, 2.0], [1.0, 3.0], [2.0, 4.0]]
    """
    copies = -(-coordinates // samples.shape[1])
    count = len(samples) - (copies - 1) * delay
    return np.hstack([samples[i * delay : i * delay + count] for i in range(copies)])


def choose_delay(samples: Floats) -> int:
    """Return the shortest delay that spreads the states out in a second direction, at most a tenth of the record in all."""
    copies = -(-COORDINATES // samples.shape[1])
    best, widest = 1, 0.0
    for delay in DELAYS:
        if copies == 1 or (delay > 1 and (copies - 1) * delay > len(samples) // 10):
            break
        states = delay_states(samples, delay)
        sizes = np.linalg.svd(states - states.mean(axis=0), compute_uv=False)
        share = float(sizes[1] / sizes[0])
        if share > widest:
            best, widest = delay, share
        if share >= FLAT:
            break
    return best


def neighbours(states: Floats) -> tuple[Floats, Indices]:
    """Return the distance of each state's nearest one of another time, and where it is, both of shape [state]."""
    from scipy.spatial import cKDTree

    some = min(len(states), 2 * APART + 2)  # of so many at least one is of another time
    distances, places = cKDTree(states).query(states, k=some)
    other = np.abs(places - np.arange(len(states))[:, None]) > APART
    first = np.argmax(other, axis=1)
    rows = np.arange(len(states))
    return np.asarray(distances[rows, first]), np.asarray(places[rows, first])


def recurrence(samples: Floats, noise: float, bands: int = 1) -> Recurrence:
    """Return how the states recur of samples, shape [period, signal], each signal of standard deviation 1.

    ``noise`` is the size of what means nothing, as a distance of two samples; of ``bands`` bands only states of one are compared.
    Of the delays `WIDER` too, the one counts whose states stay close best, as far as they are close (`CLOSE`): a delay can only
    hide that they do, where it presses a torus flat.
    """
    copies = -(-COORDINATES // samples.shape[1])
    first = choose_delay(unfolded(samples, bands))
    fitting = [d for d in WIDER if copies > 1 and d > first and (copies - 1) * d <= len(samples) // 10]
    found = [_kept(delay_states(samples, d), samples.shape[1], noise, bands) for d in (first, *fitting)]
    memory, closeness = max([kept for kept in found if kept[1] >= CLOSE], default=found[0])
    distances, _ = neighbours(delay_states(samples, first))
    return Recurrence(memory, closeness, _unforeseen(samples, bands), distances)


def _kept(states: Floats, signals: int, noise: float, bands: int) -> tuple[float, float]:
    """Return the memory of states and their closeness."""
    floor = max(noise * np.sqrt(states.shape[1] / signals), 1e-12)
    late = len(states) // LATER
    early = states[: len(states) - late]
    close, near = neighbours(early)
    at = np.arange(len(early))
    apart = [_log_distance(states[at + h], states[near + h], floor) for h in range(late - SPELL, late + 1)]
    any_two = _of_strangers(states, bands, floor)
    closeness = any_two - float(np.mean(np.log(np.maximum(close, floor))))
    return (any_two - float(np.mean(apart))) / closeness if closeness > 0.0 else 0.0, closeness


def _log_distance(first: Floats, second: Floats, floor: float) -> float:
    return float(np.mean(np.log(np.maximum(np.linalg.norm(first - second, axis=1), floor))))


def _of_strangers(states: Floats, bands: int, floor: float) -> float:
    """Return the mean log distance of states of one band, taken at a quarter to three quarters of the record from each other."""
    count, logs = len(states), []
    for part in np.linspace(0.25, 0.75, 11):
        shift = max(round(part * count / bands), 1) * bands
        logs.append(_log_distance(states[shift:], states[:-shift], floor))
    return float(np.mean(logs))


def _unforeseen(samples: Floats, bands: int) -> float:
    """Return the share of the variance within bands that the sample after a neighbouring state of three coordinates leaves."""
    states = delay_states(samples, 1, 3)
    count = min(len(states), len(samples) - len(states[0]) // samples.shape[1])
    _, near = neighbours(states[:count])
    after = samples[len(samples) - count :]
    missed = float(np.mean(np.sum((after - after[near]) ** 2, axis=1)))
    return missed / (2.0 * float(np.sum(np.var(unfolded(samples, bands), axis=0))))
