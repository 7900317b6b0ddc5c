"""Polynomial emulator of sensor values over the parameters, with its own error.

Each log10 of a datum is a sum of products of Legendre polynomials of total degree at most d (a polynomial chaos
surrogate: Sudret, Reliab. Eng. Syst. Saf. 93 (2008) 964). The degree is the one with the least leave-one-out error, which
for least squares has a closed form: r_i / (1 - h_i) with the leverage h (Allen's PRESS, Technometrics 16 (1974) 125).
"""

from dataclasses import dataclass
from functools import lru_cache
from itertools import combinations_with_replacement

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
DEGREES = (1, 2, 3, 4, 5)
POINTS_PER_TERM = 2.0  # trials that a term of the polynomial needs at least

NEAR = 8  # trials near the best for each term of a quadratic


@lru_cache(maxsize=64)
def terms(parameters: int, degree: int) -> NDArray[np.int64]:
    """Return the exponents of every term of total degree at most ``degree``, shape [term, parameter].

    >>> terms(2, 1).tolist()
    [[0, 0], [1, 0], [0, 1]]
    """
    found = []
    for total in range(degree + 1):
        for chosen in combinations_with_replacement(range(parameters), total):
            found.append([chosen.count(p) for p in range(parameters)])
    return np.array(found, dtype=np.int64)


@lru_cache(maxsize=64)
def products(parameters: int, degree: int) -> list[tuple[int, int, int]]:
    """Return for every term: the term without its last parameter, that parameter and its exponent; zeros for the constant term.

    >>> products(2, 1)
    [(0, 0, 0), (0, 0, 1), (0, 1, 1)]
    """
    exponents = [tuple(each) for each in terms(parameters, degree).tolist()]
    places = {each: place for place, each in enumerate(exponents)}
    found = [(0, 0, 0)]
    for each in exponents[1:]:
        last = max(p for p in range(parameters) if each[p])
        shorter = each[:last] + (0,) * (parameters - last)
        found.append((places[shorter], last, each[last]))
    return found


def design(units: Floats, degree: int) -> Floats:
    """Return the polynomials at points of the unit cube, shape [point, term].

    >>> design(np.array([[1.0, 0.5]]), 1).tolist()
    [[1.0, 1.0, 0.0]]
    """
    one_way = np.polynomial.legendre.legvander((2.0 * units - 1.0).T, degree)  # [parameter, point, degree]
    columns = np.ascontiguousarray(np.moveaxis(one_way, 2, 1))  # [parameter, degree, point]
    factors = products(units.shape[1], degree)
    table = np.ones((len(factors), len(units)))  # the first term is 1
    for term, (shorter, parameter, exponent) in enumerate(factors[1:], start=1):
        np.multiply(table[shorter], columns[parameter, exponent], out=table[term])
    return np.ascontiguousarray(table.T)


@dataclass(frozen=True)
class Emulator:
    """Polynomials fitted to trials.

    ``coefficients`` has shape [term, datum], ``scatter`` [datum] the leave-one-out error of one trial [decades], its own
    ensemble error included.
    """

    degree: int
    coefficients: Floats
    scatter: Floats

    def __call__(self, units: Floats) -> Floats:
        """Return log10 of every datum at points of the unit cube, shape [point, datum]."""
        return design(units, self.degree) @ self.coefficients

    @classmethod
    def fit(cls, units: Floats, logs: Floats, weights: Floats | None = None) -> "Emulator":
        """Fit to trials at ``units`` [trial, parameter] with ``logs`` [trial, datum]; weights favour the trials that matter.

        The degree with the least leave-one-out error wins, among those with enough trials for their terms.
        """
        w = np.ones(len(units)) if weights is None else weights / np.mean(weights)
        root = np.sqrt(w)[:, None]
        best: Emulator | None = None
        for degree in DEGREES:
            table = design(units, degree)
            if best is not None and POINTS_PER_TERM * table.shape[1] > len(units):
                break
            q, r = np.linalg.qr(table * root)
            coefficients = np.linalg.lstsq(r, q.T @ (logs * root), rcond=1e-10)[0]
            leverage = np.minimum(np.sum(q**2, axis=1), 0.99)[:, None]
            left_out = (logs - table @ coefficients) / (1.0 - leverage)
            scatter = np.sqrt(np.average(left_out**2, axis=0, weights=w))
            if best is None or np.mean(np.log(scatter + 1e-12)) < np.mean(np.log(best.scatter + 1e-12)):
                best = cls(degree, coefficients, scatter)
        assert best is not None
        return best

    @classmethod
    def near(cls, units: Floats, logs: Floats, values: Floats) -> "Emulator":
        """Fit to the trials of least objective ``values`` [trial], with weights that fall with it: see `nearness`.

        As many trials as settle a quadratic: more would cost time, and lie where the polynomial need not fit.
        """
        order = np.argsort(values, kind="stable")[: NEAR * len(terms(units.shape[1], 2))]
        return cls.fit(units[order], logs[order], nearness(values[order]))


def nearness(values: Floats) -> Floats:
    """Return weights of trials by their objective, shape [trial]: 1 for the best, a quarter where the excess is the reference.

    The reference is the median excess of the best fifth.

    >>> nearness(np.array([3.0, 5.0])).tolist()
    [1.0, 0.1111111111111111]
    """
    excess = values - np.min(values)
    reference = max(float(np.median(np.sort(excess)[: max(2, len(excess) // 5)])), 1e-12)
    return np.asarray(1.0 / (1.0 + excess / reference) ** 2)
