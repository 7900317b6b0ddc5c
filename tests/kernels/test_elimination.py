"""Elimination against NumPy's solver; what it factors is the matrix with its rows exchanged."""

import numpy as np
import pytest

from gearplay.kernels.elimination import eliminate, substitute


@pytest.mark.parametrize("kind", [float, complex])
@pytest.mark.parametrize("count", [1, 2, 5, 12])
def test_it_solves_what_numpy_solves(kind: type, count: int) -> None:
    rng = np.random.default_rng(count)
    matrix, right = np.full((14, 14), np.nan, dtype=kind), np.full(14, np.nan, dtype=kind)  # room for more
    inner = rng.standard_normal((count, count)) + (1j if kind is complex else 0) * rng.standard_normal(
        (count, count)
    )
    inner[0, 0] = 0.0 if count > 1 else 2.0  # which only an exchange gets over
    matrix[:count, :count], right[:count] = inner, rng.standard_normal(count)
    expected = np.linalg.solve(inner, right[:count])
    swaps = np.zeros(14, dtype=np.int64)
    assert eliminate(matrix, swaps, count) == 0
    assert np.all(swaps[:count] >= np.arange(count))
    lower = np.tril(matrix[:count, :count], -1)
    assert np.all(np.abs(lower.real) + np.abs(lower.imag) <= 2.0)  # no factor that lets errors grow
    substitute(matrix, swaps, right, count)
    assert right[:count] == pytest.approx(expected, rel=1e-11)


@pytest.mark.parametrize("kind", [float, complex])
def test_a_singular_matrix_is_told(kind: type) -> None:
    matrix = np.array([[1.0, 2.0], [2.0, 4.0]], dtype=kind)
    assert eliminate(matrix, np.zeros(2, dtype=np.int64), 2) == 1
