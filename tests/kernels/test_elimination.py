"""Elimination within an envelope against NumPy's solver."""

import numpy as np
import pytest

from gearplay.kernels.elimination import eliminate, substitute


@pytest.mark.parametrize("kind", [float, complex])
@pytest.mark.parametrize("count", [1, 2, 5, 12])
def test_linear_solver__equals_numpy(kind: type, count: int) -> None:
    """Rows begin where they like; what lies outside the envelope is not looked at, nor is room for more equations."""
    rng = np.random.default_rng(count)
    first = np.array([int(rng.integers(0, row + 1)) for row in range(count)] + [0] * (14 - count))
    matrix, right = np.full((14, 14), np.nan, dtype=kind), np.full(14, np.nan, dtype=kind)
    inner = np.zeros((count, count), dtype=kind)
    for row in range(count):
        for column in range(first[row], row + 1):
            for at in {(row, column), (column, row)}:
                inner[at] = rng.standard_normal() + (1j * rng.standard_normal() if kind is complex else 0.0)
                matrix[at] = inner[at]
        inner[row, row] += 6.0
        matrix[row, row] = inner[row, row]
    right[:count] = rng.standard_normal(count)
    expected = np.linalg.solve(inner, right[:count])
    assert eliminate(matrix, first, count) == 0
    substitute(matrix, first, right, count)
    assert right[:count] == pytest.approx(expected, rel=1e-11)


@pytest.mark.parametrize("kind", [float, complex])
def test_a_singular_matrix_is_refused(kind: type) -> None:
    matrix = np.array([[1.0, 2.0], [2.0, 4.0]], dtype=kind)
    assert eliminate(matrix, np.zeros(2, dtype=np.int64), 2) == 1
