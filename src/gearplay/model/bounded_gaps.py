"""Bounded least squares for gaps: closest to their targets, between 0 and an upper bound."""

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

FEASIBLE = 1e-6
"""Least norm of the residual of the dual problem, in which bounds are of size 1, where the bounds can be kept."""
SOFT = 1e-4
"""Weight of the distance from the targets against that beyond the bounds, where these cannot be kept."""


def nearest_gaps(ways: Floats, gaps: Floats, bounds: Floats, targets: Floats) -> Floats:
    """Return z so that ``gaps - ways @ z`` is nearest to ``targets`` between 0 and ``bounds``.

    Where no z keeps the bounds, the sum of squares beyond them is the least. A least-distance problem, solved by non-negative
    least squares (C. L. Lawson, R. J. Hanson, Solving Least Squares Problems, 1974, chapter 23).

    Parameters
    ----------
    ways
        Orthonormal columns, shape [gap, way].
    gaps, bounds, targets
        [m], shape [gap].

    Examples
    --------
    Two gaps of which one opens as the other closes, then three that cannot all be open:

    >>> one = np.array([[1.0], [-1.0]]) / np.sqrt(2.0)
    >>> z = nearest_gaps(one, np.array([-1.0, 5.0]), np.array([3.0, 3.0]), np.zeros(2))
    >>> (np.array([-1.0, 5.0]) - one @ z).round(9)
    array([2., 2.])
    >>> z = nearest_gaps(one, np.array([-1.0, -3.0]), np.array([3.0, 3.0]), np.zeros(2))
    >>> (np.array([-1.0, -3.0]) - one @ z).round(6)
    array([-2., -2.])

    """
    z = ways.T @ (gaps - targets)
    left = gaps - ways @ z
    # Conditions A y >= h on what z is changed by.
    rows, least = np.concatenate([-ways, ways]), np.concatenate([-left, left - bounds])
    size = float(np.max(least))
    if size <= 0.0:
        return np.asarray(z)
    found = _least_distance(rows, least / size)
    if found is None:  # with one slack for each condition
        found = _least_distance(np.concatenate([rows / SOFT, np.eye(len(rows))], axis=1), least / size)
        assert found is not None, "slacks fulfil every condition"
        found = found[: ways.shape[1]] / SOFT
    return np.asarray(z + size * found)


def _least_distance(rows: Floats, least: Floats) -> Floats | None:
    """Return the shortest y with ``rows @ y >= least``, None where there is none."""
    from scipy.optimize import nnls  # takes long, and few starts need it

    count = rows.shape[1]
    matrix = np.concatenate([rows.T, least[None, :]])
    unit = np.zeros(count + 1)
    unit[-1] = 1.0
    dual, residual = nnls(matrix, unit, maxiter=50 * (len(rows) + 10))
    if residual < FEASIBLE:
        return None
    rest = matrix @ dual - unit
    return np.asarray(-rest[:-1] / rest[-1])
