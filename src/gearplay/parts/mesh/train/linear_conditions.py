"""Linear constraints on the speeds of rotors: rows, matrices, rank-based solution."""

from collections.abc import Iterable, Mapping

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Row = tuple[tuple[int, float], ...]
"""Places of rotors and the factors of their speeds in a sum."""
Level = tuple[Floats, Floats]
"""Matrix and right-hand side of conditions of one rank."""


def matrix_of(rows: Iterable[Row], count: int) -> Floats:
    """Return the matrix of sums of ``count`` speeds."""
    rows = list(rows)
    matrix = np.zeros((len(rows), count))
    for i, row in enumerate(rows):
        for place, factor in row:
            matrix[i, place] += factor
    return matrix


def vanishing(matrix: Floats) -> Level:
    """Return the conditions matrix @ speeds = 0."""
    return matrix, np.zeros(len(matrix))


def picked(places: Mapping[str, int], speeds: Mapping[str, float]) -> Level:
    """Return the conditions that rotors have given speeds."""
    return np.eye(len(places))[[places[name] for name in speeds]], np.array([*speeds.values()], dtype=float)


def solved_by_rank(levels: Iterable[Level], count: int) -> Floats:
    """Return the minimum-norm solution of prioritised least-squares problems, each solved within the solutions of those before.

    >>> solved_by_rank([(np.array([[1.0, 1.0]]), np.array([2.0])), (np.array([[1.0, 0.0]]), np.array([5.0]))], 2).round(12)
    array([ 5., -3.])
    """
    x, free = np.zeros(count), np.eye(count)
    for matrix, target in levels:
        if not len(matrix) or not free.shape[1]:
            continue
        left, sizes, right = np.linalg.svd(matrix @ free)
        rank = int(np.sum(sizes > 1e-9))
        x = x + free @ (right[:rank].T @ ((left[:, :rank].T @ (target - matrix @ x)) / sizes[:rank]))
        free = free @ right[rank:].T
    return np.asarray(x)
