"""Natural frequencies, damping ratios and shapes of a linear system."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

Floats = NDArray[np.float64]

NOTHING = 1e-12
"""Square of a frequency over that of the highest one that is zero but for rounding."""
SYMMETRIC = 1e-9
"""Relative asymmetry of a stiffness matrix that is rounding."""


class Eigen(NamedTuple):
    """Modes, the lowest frequency first.

    ``frequency`` [Hz] of the undamped system, 0 for a free motion; ``damping_ratio`` [1] of the damped one; ``shape`` [mode,
    coordinate], of unit modal mass, complex where a carrier turns; ``unstable`` counts modes without a restoring force.
    """

    frequency: Floats
    damping_ratio: Floats
    shape: NDArray[np.complex128] | Floats
    unstable: int


def solve_at_rest(mass: Floats, stiffness: Floats, damping: Floats) -> Eigen:
    """Return the modes of M x'' + C x' + K x = 0, M diagonal, shapes those without damping.

    Damping ratios are those of the damped eigenvalues, -Re / modulus, each given to the undamped mode that it is nearest to when
    that is damped by its modal damping alone.
    """
    root = np.sqrt(mass)
    scaled = stiffness / np.outer(root, root)
    size = float(np.abs(scaled).max(initial=0.0))
    if float(np.abs(scaled - scaled.T).max(initial=0.0)) <= SYMMETRIC * size:
        squares, vectors = scipy.linalg.eigh(0.5 * (scaled + scaled.T))
    else:  # a control that measures elsewhere than it acts
        values, vectors = scipy.linalg.eig(scaled)
        order = np.argsort(values.real)
        squares, vectors = values.real[order], vectors.real[:, order]
        vectors = vectors / np.linalg.norm(vectors, axis=0)
    nothing = NOTHING * float(np.abs(squares).max(initial=0.0))
    unstable = int(np.sum(squares < -nothing))
    omega = np.sqrt(np.where(squares > nothing, squares, 0.0))
    shape = (vectors / root[:, None]).T
    modal = np.einsum("mi,ij,mj->m", shape, damping, shape)
    return Eigen(omega / (2.0 * np.pi), _ratios(mass, stiffness, damping, omega, modal), shape, unstable)


def _ratios(mass: Floats, stiffness: Floats, damping: Floats, omega: Floats, modal: Floats) -> Floats:
    """Return the damping ratios of undamped modes of angular frequency ``omega`` [rad/s] and modal damping [1/s]."""
    moving = omega > 0.0
    ratio = np.zeros_like(omega)
    ratio[moving] = 0.5 * modal[moving] / omega[moving]
    from scipy.optimize import linear_sum_assignment

    light = moving & (ratio < 0.99) & (ratio > 0.0)
    if not light.any():
        return ratio
    n = len(mass)
    matrix = np.zeros((2 * n, 2 * n))
    matrix[:n, n:] = np.eye(n)
    matrix[n:, :n], matrix[n:, n:] = -stiffness / mass[:, None], -damping / mass[:, None]
    values = scipy.linalg.eigvals(matrix)
    values = values[values.imag > 1e-9 * np.abs(values)]
    guessed = omega[light] * (-ratio[light] + 1j * np.sqrt(1.0 - ratio[light] ** 2))
    rows, columns = linear_sum_assignment(np.abs(guessed[:, None] - values[None, :]))
    places = np.flatnonzero(light)[rows]
    ratio[places] = -values[columns].real / np.abs(values[columns])
    return ratio


def solve_turning(mass: Floats, matrix: Floats, pairs: Sequence[tuple[int, int, float]]) -> Eigen:
    """Return the modes of z' = A z as seen from axes that turn.

    ``matrix`` is A in fixed axes at the instant where both agree, positions before velocities, shape [2 coordinate] squared;
    ``pairs`` are the places of x and y among the coordinates and the speed of the axes [rad/s] they are seen from: seen so they
    change by A - speed J.
    """
    n = len(mass)
    turned = matrix.copy()
    for x, y, speed in pairs:
        for at in (0, n):
            turned[at + x, at + y] += speed
            turned[at + y, at + x] -= speed
    values, vectors = scipy.linalg.eig(turned)
    size = float(np.abs(values).max(initial=0.0))
    kept = np.flatnonzero(
        (values.imag > np.sqrt(NOTHING) * size) | (np.abs(values) <= np.sqrt(NOTHING) * size)
    )
    still = kept[np.abs(values[kept]) <= np.sqrt(NOTHING) * size]
    kept = np.concatenate([still[::2], np.setdiff1d(kept, still)])  # a free motion is a double eigenvalue
    order = kept[np.argsort(np.abs(values[kept]), kind="stable")]
    shapes = vectors[:n, order].T
    shapes = shapes / np.sqrt(np.einsum("i,mi->m", mass, np.abs(shapes) ** 2))[:, None]
    shapes *= np.exp(-0.5j * np.angle(np.einsum("i,mi->m", mass, shapes**2)))[:, None]
    modulus = np.abs(values[order])
    with np.errstate(invalid="ignore", divide="ignore"):
        ratio = np.where(modulus > 0.0, -values[order].real / modulus, 0.0)
    zero = modulus <= np.sqrt(NOTHING) * size
    return Eigen(
        np.where(zero, 0.0, modulus) / (2.0 * np.pi),
        np.where(zero, 0.0, ratio),
        shapes,
        int(np.sum((values.real > 1e-9 * size) & (values.imag >= 0.0))),
    )
