"""Linear equations by elimination with row exchanges, real and complex ones alike; in place, the first ``count`` of them.

Pivots are kept as their reciprocals: factors are used far more often than they are made, and a complex division is slow.
"""

from typing import Any

from numpy.typing import NDArray

from gearplay.kernels.arrays import Ints
from gearplay.kernels.compiled import compiled_inline


@compiled_inline
def size_of(z: complex) -> float:
    """Return how large a number is, without a root."""
    return abs(z.real) + abs(z.imag)


@compiled_inline
def eliminate(matrix: NDArray[Any], swaps: Ints, count: int) -> int:
    """Turn a matrix into its factors, and note the exchanges of rows; return 1 where it is singular."""
    for column in range(count):
        best = column
        for row in range(column + 1, count):
            if size_of(matrix[row, column]) > size_of(matrix[best, column]):
                best = row
        swaps[column] = best
        for j in range(count):
            held = matrix[column, j]
            matrix[column, j], matrix[best, j] = matrix[best, j], held
        if size_of(matrix[column, column]) == 0.0:
            return 1
        matrix[column, column] = 1.0 / matrix[column, column]
        for row in range(column + 1, count):
            factor = matrix[row, column] * matrix[column, column]
            matrix[row, column] = factor
            for j in range(column + 1, count):
                matrix[row, j] -= factor * matrix[column, j]
    return 0


@compiled_inline
def substitute(factors: NDArray[Any], swaps: Ints, x: NDArray[Any], count: int) -> None:
    """Turn a right-hand side into the solution."""
    for row in range(count):
        held = x[row]
        x[row], x[swaps[row]] = x[swaps[row]], held
    for row in range(count):
        total = x[row]
        for j in range(row):
            total -= factors[row, j] * x[j]
        x[row] = total
    for back in range(count):
        row = count - 1 - back
        total = x[row]
        for j in range(row + 1, count):
            total -= factors[row, j] * x[j]
        x[row] = total * factors[row, row]
