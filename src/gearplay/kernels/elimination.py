"""Linear equations by elimination within an envelope, real and complex ones alike; in place, the first ``count`` of them.

Rows are not exchanged: the equations of a stage, I + g h M^-1 C + (g h)^2 M^-1 K with g off the negative axis, need none. Row i
begins at column ``first[i]``, and column i at that row: what lies before is zero and stays so (A. George, J. W.-H. Liu, Computer
Solution of Large Sparse Positive Definite Systems, 1981, chapter 4). Pivots are kept as their reciprocals: factors are used far
more often than they are made, and a complex division is slow.
"""

from typing import Any

from numpy.typing import NDArray

from gearplay.kernels.arrays import Ints
from gearplay.kernels.compiled import compiled_inline

SMALLEST = 1e-10  # pivot, of the size of its row: a smaller one counts as singular


@compiled_inline
def size_of(z: complex) -> float:
    """Return how large a number is, without a root."""
    return abs(z.real) + abs(z.imag)


@compiled_inline
def eliminate(matrix: NDArray[Any], first: Ints, count: int) -> int:
    """Turn a matrix into its factors; return 1 where a pivot vanishes."""
    for row in range(count):
        largest = 0.0
        for column in range(first[row], row):
            start = max(first[row], first[column])
            left, above = matrix[row, column], matrix[column, row]
            largest = max(largest, size_of(left))
            for k in range(start, column):
                left -= matrix[row, k] * matrix[k, column]
                above -= matrix[column, k] * matrix[k, row]
            matrix[row, column] = left * matrix[column, column]
            matrix[column, row] = above
        pivot = matrix[row, row]
        largest = max(largest, size_of(pivot))
        for k in range(first[row], row):
            pivot -= matrix[row, k] * matrix[k, row]
        if not size_of(pivot) > SMALLEST * largest:
            return 1
        matrix[row, row] = 1.0 / pivot
    return 0


@compiled_inline
def substitute(factors: NDArray[Any], first: Ints, x: NDArray[Any], count: int) -> None:
    """Turn a right-hand side into the solution."""
    for row in range(count):
        total = x[row]
        for k in range(first[row], row):
            total -= factors[row, k] * x[k]
        x[row] = total
    for back in range(count):
        column = count - 1 - back
        total = x[column] * factors[column, column]
        x[column] = total
        for k in range(first[column], column):
            x[k] -= factors[k, column] * total
