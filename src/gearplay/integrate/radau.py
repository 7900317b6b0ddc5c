"""Radau IIA methods of three and five stages, of orders 5 and 9, for equations of second order.

E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, 2nd ed., sections IV.5 and IV.8. Newton's method for all stages
of a step at once falls apart into systems of the size of one stage, a real and one or two complex ones (J. C. Butcher, BIT 16
(1976) 237). Tables have a row for each method, [method, ..], filled with zeros beyond its stages.
"""

import numpy as np
from numpy.polynomial import legendre

from gearplay.kernels.arrays import Floats

STAGES = np.array([3, 5])
MOST = 5
LOW, HIGH = 0, 1  # rows of the tables


def _nodes(stages: int) -> Floats:
    """Return the nodes: zeros of the difference of two Legendre polynomials, the last of them 1."""
    difference = np.zeros(stages + 1)
    difference[stages - 1 :] = -1.0, 1.0
    roots = np.sort(legendre.legroots(difference).real)
    for _ in range(3):
        roots -= legendre.legval(roots, difference) / legendre.legval(roots, legendre.legder(difference))
    roots[-1] = 1.0
    return 0.5 * (roots + 1.0)


def _integrals(nodes: Floats) -> Floats:
    """Return the integrals from 0 to each node of the Lagrange polynomials of the nodes, shape [node, polynomial]."""
    at, count = 2.0 * nodes - 1.0, nodes.size
    of_legendre = [0.5 * legendre.legval(at, legendre.legint(unit, lbnd=-1.0)) for unit in np.eye(count)]
    return np.ascontiguousarray(np.transpose(of_legendre) @ np.linalg.inv(legendre.legvander(at, count - 1)))


C, A, AA = np.zeros((2, MOST)), np.zeros((2, MOST, MOST)), np.zeros((2, MOST, MOST))
"""Nodes; velocities, then positions, from accelerations."""
REAL, LEFT_REAL, RIGHT_REAL = np.zeros(2), np.zeros((2, MOST)), np.zeros((2, MOST))
COMPLEX = np.zeros((2, 2), dtype=np.complex128)
LEFT_COMPLEX, RIGHT_COMPLEX = np.zeros((2, 2, MOST), dtype=complex), np.zeros((2, 2, MOST), dtype=complex)
"""Eigenvalues of A in the upper half plane, its left and its right vectors, scaled to each other."""
DENSE = np.zeros((2, MOST + 1, MOST + 1))
"""Coefficients [power - 1, node] of the integrals of Lagrange's polynomials of the step's start and its nodes."""

for _row, _count in enumerate(STAGES):
    _c = _nodes(_count)
    _a = _integrals(_c)
    C[_row, :_count], A[_row, :_count, :_count], AA[_row, :_count, :_count] = _c, _a, _a @ _a
    _values, _vectors = np.linalg.eig(_a)
    _inverse = np.linalg.inv(_vectors)
    _real = int(np.argmin(np.abs(_values.imag)))
    _scale = _vectors[0, _real]
    REAL[_row] = _values[_real].real
    RIGHT_REAL[_row, :_count] = (_vectors[:, _real] / _scale).real
    LEFT_REAL[_row, :_count] = (_inverse[_real] * _scale).real
    for _pair, _at in enumerate(np.flatnonzero(_values.imag > 1e-9)):
        COMPLEX[_row, _pair] = _values[_at]
        RIGHT_COMPLEX[_row, _pair, :_count], LEFT_COMPLEX[_row, _pair, :_count] = (
            _vectors[:, _at],
            _inverse[_at],
        )
    _all = np.array([0.0, *_c])
    _powers = np.linalg.inv(np.vander(_all, increasing=True))  # [power, node]
    DENSE[_row, : _count + 1, : _count + 1] = _powers / np.arange(1, _count + 2)[:, None]
