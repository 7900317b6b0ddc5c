"""Static condensation of coordinates without mass: exact, since no inertia acts on them.

Of M x'' + K x = 0 with M = diag(M_m, 0) the last rows are K_sm x_m + K_ss x_s = 0, which leaves K_mm - K_ms K_ss^-1 K_sm on
coordinates with mass (R. J. Guyan, AIAA J. 3 (1965) 380, exact where M_s = 0).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Springs = tuple[Floats, Floats]
"""P and N of a stiffness matrix P'P - N'N, shapes [spring, coordinate]."""

UNHELD = 1e-24
"""Stiffness on a coordinate, per that before others were condensed, that is the square of rounding in P and N."""
UNHELD_MATRIX = 1e-12
"""The same where only the matrix is known."""


class Condensed(NamedTuple):
    """A system without its massless coordinates.

    ``stiffness``, shape [master, master]; its ``springs``, None where they are not known or it is not symmetric; ``recover``,
    which returns all coordinates of those with mass, shape [coordinate, master].
    """

    stiffness: Floats
    springs: Springs | None
    recover: Floats


def condense(stiffness: Floats, springs: Springs | None, light: NDArray[np.bool_]) -> Condensed | int:
    """Return the system on the coordinates that are not ``light``, or the index of a light one without elastic support.

    With ``springs`` each light coordinate is condensed in P and N, so that soft springs keep their digits next to stiff ones.

    >>> row = np.array([[1.0, -1.0, 0.0], [0.0, -3.0, 3.0]])  # stiffnesses 1 and 9 in series: 0.9
    >>> found = condense(row.T @ row, (row, np.zeros((0, 3))), np.array([False, True, False]))
    >>> found.stiffness.round(12).tolist(), found.recover[1].round(12).tolist()
    ([[0.9, -0.9], [-0.9, 0.9]], [0.1, 0.9])

    """
    heavy = ~light
    if not light.any():
        return Condensed(stiffness, springs, np.eye(len(light)))
    if springs is None:
        return _condensed_matrix(stiffness, light)
    (pull, push), left = springs, set(np.flatnonzero(light).tolist())
    before = np.sum(pull**2, axis=0) + np.sum(push**2, axis=0)
    ways: list[tuple[int, Floats]] = []
    while left:
        pivots = {s: float(np.sum(pull[:, s] ** 2) - np.sum(push[:, s] ** 2)) for s in left}
        s = max(left, key=lambda s: abs(pivots[s]) / (before[s] or 1.0))
        if abs(pivots[s]) <= UNHELD * before[s]:
            return s
        (a, pull), (b, push) = _gathered(pull, s), _gathered(push, s)
        pivot = float((a[s] - b[s]) * (a[s] + b[s]))
        ways.append((s, -(a[s] * a - b[s] * b) / pivot))
        ways[-1][1][s] = 0.0
        if b[s] != 0.0:  # a^2 - b^2 where it is stationary
            rest = (b[s] * a - a[s] * b) / np.sqrt(abs(pivot))
            rest[s] = 0.0
            if pivot > 0.0:
                push = np.vstack([push, rest])
            else:
                pull = np.vstack([pull, rest])
        left.remove(s)
    recover = np.eye(len(light))[:, heavy]
    for s, way in reversed(ways):
        recover[s] = way @ recover
    pull, push = pull[:, heavy], push[:, heavy]
    return Condensed(pull.T @ pull - push.T @ push, (pull, push), recover)


def _gathered(rows: Floats, s: int) -> tuple[Floats, Floats]:
    """Turn rows, by rotations that keep the sum of their squares, so that only one has column s; return it and the others."""
    at = np.flatnonzero(rows[:, s])
    if not at.size:
        return np.zeros(rows.shape[1]), rows
    others = [np.delete(rows, at, axis=0)]
    whole, *more = rows[at[np.argsort(np.abs(rows[at, s]))]]
    for row in more:
        size = float(np.hypot(whole[s], row[s]))
        c, t = whole[s] / size, row[s] / size
        rest, whole = c * row - t * whole, c * whole + t * row
        rest[s], whole[s] = 0.0, size
        others.append(rest[None])
    return whole, np.concatenate(others)


def _condensed_matrix(stiffness: Floats, light: NDArray[np.bool_]) -> Condensed | int:
    """Return the system by the inverse of K_ss, or the index of a coordinate without elastic support."""
    own = np.sqrt(np.abs(np.diag(stiffness)[light]))
    places = np.flatnonzero(light)
    if not np.all(own > 0.0):
        return int(places[int(np.argmin(own))])
    inner = stiffness[np.ix_(light, light)] / np.outer(own, own)
    _, sizes, ways = np.linalg.svd(inner)
    if sizes[-1] <= UNHELD_MATRIX:
        return int(places[int(np.argmax(np.abs(ways[-1])))])
    recover = np.eye(len(light))[:, ~light]
    recover[light] = -np.linalg.solve(inner, stiffness[np.ix_(light, ~light)] / own[:, None]) / own[:, None]
    return Condensed(stiffness[~light] @ recover, None, recover)
