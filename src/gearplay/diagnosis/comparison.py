"""Deviation of a record from the simulated records of each cause, over all severities, with its spread."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

ALLOWED: Final = 0.1
"""Deviation [decades] that a case may have from its machine, beside the spread."""
LARGE: Final = 3.0
"""Deviation of a feature, over spread and `ALLOWED`, from which it counts linearly: one feature alone decides nothing."""
AGREES: Final = 1.5
"""Deviation, root mean square over the features, up to which a simulation agrees with the record."""
ODDS: Final = 6.0
"""Difference of the sums of squares below which two causes are alike; 20 : 1 were the features independent."""
STEPS: Final = 8
"""Severities tried between two simulated ones."""


@dataclass(frozen=True)
class Deviation:
    """How a record deviates from a cause at the severity of best agreement.

    ``deviation`` is the root mean square over the features in units of spread and allowed error [1], ``spread`` its standard
    error over simulated members and pieces of the record, ``place`` the severity: 0 the case as it is, k its k-th level.
    ``alike`` counts those causes no further off than chance; ``expected`` are the features at ``place``, shape [feature].
    """

    deviation: float
    spread: float
    place: float
    alike: bool
    expected: Floats


def compared(record: Floats, causes: Sequence[Floats]) -> list[Deviation]:
    """Return the deviation of each cause; the first has one level, the case as it is.

    With r the record's mean, m(s) the mean of a cause at severity s, linear between levels, z = (r - m) / sqrt(v (1/p + 1/n) +
    a^2), v the variance over members pooled over all causes, n members, p pieces, a = `ALLOWED`. The deviation is the root of the
    mean of Huber's loss 2 rho(z), z^2 up to `LARGE`, at the severity where it is least. Two causes are alike where the sums of
    squares differ by less than `ODDS` or twice the standard error of their difference, a jackknife over members and pieces.

    Parameters
    ----------
    record
        Features of the pieces of the record, shape [piece, feature].
    causes
        Features of the simulated records of each cause, shape [level, member, feature]; those of the case as it is first, with
        one level, where the severity of each of the others begins. All finite.

    """
    members = causes[0].shape[1]
    variance = _pooled(causes)
    weight = 1.0 / (variance * (1.0 / members + 1.0 / record.shape[0]) + ALLOWED**2)
    means = [np.mean(each, axis=1) for each in causes]
    best = [_nearest(np.mean(record, axis=0), means[0], each, weight) for each in means]
    squares = np.array([each[0] for each in best])
    folds = [
        *(_fold(record, [np.delete(each, k, axis=1) for each in causes], weight) for k in range(members)),
        *(
            _fold(np.delete(record, k, axis=0), causes, weight)
            for k in range(record.shape[0])
            if record.shape[0] > 1
        ),
    ]
    groups = [folds[:members], folds[members:]]
    lead = int(np.argmin(squares))
    found = []
    for c, (square, place, expected) in enumerate(best):
        own = [np.array([math.sqrt(fold[c]) for fold in group]) for group in groups if group]
        against = [np.array([fold[c] - fold[lead] for fold in group]) for group in groups if group]
        count = record.shape[1]
        margin = max(ODDS, 2.0 * count * _jackknife(against))
        alike = c == lead or count * (square - squares[lead]) < margin
        found.append(Deviation(math.sqrt(square), _jackknife(own), place, alike, expected))
    return found


def _pooled(causes: Sequence[Floats]) -> Floats:
    """Return the variance over members, pooled over levels of all causes, shape [feature]."""
    each = np.concatenate([np.var(cause, axis=1, ddof=1) for cause in causes])
    return np.asarray(np.mean(each, axis=0))


def _nearest(record: Floats, sound: Floats, levels: Floats, weight: Floats) -> tuple[float, float, Floats]:
    """Return the least mean square, its severity, and the features there."""
    points = sound if levels is sound else np.concatenate([sound, levels])
    places = np.linspace(0.0, len(points) - 1.0, STEPS * (len(points) - 1) + 1)
    low = np.minimum(places.astype(int), max(len(points) - 2, 0))
    share = (places - low)[:, None]
    line = points[low] + share * (points[np.minimum(low + 1, len(points) - 1)] - points[low])
    z = np.abs(record - line) * np.sqrt(weight)
    loss = np.mean(np.where(z <= LARGE, z * z, 2.0 * LARGE * z - LARGE**2), axis=1)
    at = int(np.argmin(loss))
    return float(loss[at]), float(places[at]), line[at]


def _fold(record: Floats, causes: Sequence[Floats], weight: Floats) -> Floats:
    """Return the mean squares of all causes with some members or pieces left out, shape [cause]."""
    means = [np.mean(each, axis=1) for each in causes]
    return np.array([_nearest(np.mean(record, axis=0), means[0], each, weight)[0] for each in means])


def _jackknife(groups: Sequence[Floats]) -> float:
    """Return the standard error from values with one of each group left out in turn."""
    parts = [(len(x) - 1.0) / len(x) * float(np.sum((x - np.mean(x)) ** 2)) for x in groups if len(x) > 1]
    return math.sqrt(sum(parts))
