"""Natural frequencies, damping ratios and shapes of a linear system."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

Floats = NDArray[np.float64]

FREE = 1e-12
"""Stiffness of a motion, per that of its coordinates alone, that is rounding."""
FREE_TURNING = 1e-10
"""The same seen from a carrier that turns, where forces of inertia must cancel too."""
SYMMETRIC = 1e-9
"""Relative asymmetry of a stiffness matrix that is rounding."""
UNSTABLE = -1e-13
"""Square of a frequency over that of the highest one that is no rounding."""


class Eigen(NamedTuple):
    """Modes, the lowest frequency first.

    ``frequency`` [Hz] of the undamped system, 0 for a free motion; ``damping_ratio`` [1] of the damped one; ``shape`` [mode,
    coordinate], of unit modal mass, complex where a carrier turns; ``unstable`` counts modes without a restoring force.
    """

    frequency: Floats
    damping_ratio: Floats
    shape: NDArray[np.complex128] | Floats
    unstable: int


def free_motions(stiffness: Floats, *, tolerance: float = FREE) -> Floats:
    """Return orthonormal motions without a restoring force, in coordinates of unit own stiffness, and what scales these.

    That is the null space of K_ij / sqrt(|K_ii K_jj|): its rank does not depend on how far stiffnesses are apart. A free motion
    is the returned column times the scales, shape [coordinate, 1 + motion], the first column.

    >>> chain = np.array([[1.0, -1.0, 0.0], [-1.0, 1.0 + 1e9, -1e9], [0.0, -1e9, 1e9]])
    >>> scale, motion = free_motions(chain).T
    >>> (scale * motion / (scale * motion)[0]).round(6)
    array([1., 1., 1.])

    """
    own = np.sqrt(np.abs(np.diag(stiffness)))
    scale = np.divide(1.0, own, out=np.ones_like(own), where=own > 0.0)
    _, sizes, ways = np.linalg.svd(scale[:, None] * stiffness * scale)
    rank = int(np.sum(sizes > tolerance))
    return np.concatenate([scale[:, None], ways[rank:].T], axis=1)


def solve_at_rest(
    mass: Floats, stiffness: Floats, damping: Floats, springs: tuple[Floats, Floats] | None = None
) -> Eigen:
    """Return the modes of M x'' + C x' + K x = 0, M diagonal, shapes those without damping.

    Free motions are the null space of K; of the others the frequencies are the singular values of M^-1/2 P where K = P'P, so that
    low ones beside high ones keep their digits as they do in P.
    ``springs`` are P and N of K = P'P - N'N, shapes [spring, coordinate].

    Damping ratios are those of the damped eigenvalues, -Re / modulus, each given to the undamped mode that it is nearest to when
    that is damped by its modal damping alone.
    """
    root = np.sqrt(mass)
    scaled = stiffness / np.outer(root, root)
    size = float(np.abs(scaled).max(initial=0.0))
    scale, *motions = free_motions(stiffness).T
    free = np.array(motions).reshape(-1, len(mass)) * scale * root
    basis = np.linalg.qr(free.T, mode="complete")[0]
    still, moving = basis[:, : len(free)], basis[:, len(free) :]
    if float(np.abs(scaled - scaled.T).max(initial=0.0)) <= SYMMETRIC * size:
        if springs is None:
            squares, vectors = scipy.linalg.eigh(moving.T @ (0.5 * (scaled + scaled.T)) @ moving)
        else:
            squares, vectors = _squares(springs[0] / root @ moving, springs[1] / root @ moving)
        squares = np.concatenate([np.zeros(len(free)), squares])
        vectors = np.concatenate([still, moving @ vectors], axis=1)
    else:  # a control that measures elsewhere than it acts
        values, vectors = scipy.linalg.eig(scaled)
        order = np.concatenate([(by := np.argsort(np.abs(values)))[: len(free)], by[len(free) :]])
        squares, vectors = values.real[order], vectors.real[:, order]
        squares[: len(free)] = 0.0
        vectors = vectors / np.linalg.norm(vectors, axis=0)
    order = np.argsort(squares, kind="stable")
    squares, vectors = squares[order], vectors[:, order]
    unstable = int(np.sum(squares < UNSTABLE * float(np.abs(squares).max(initial=0.0))))
    omega = np.sqrt(np.maximum(squares, 0.0))
    shape = (vectors / root[:, None]).T
    modal = shape @ damping @ shape.T
    return Eigen(omega / (2.0 * np.pi), _ratios(omega, modal), shape, unstable)


def _squares(pull: Floats, push: Floats) -> tuple[Floats, Floats]:
    """Return the eigenvalues of P'P - N'N and its vectors, shape [coordinate, mode], by the singular values of P."""
    count = pull.shape[1]
    _, sizes, ways = np.linalg.svd(pull, full_matrices=True)
    sizes = np.concatenate([sizes, np.zeros(count - len(sizes))])
    if not len(push):
        return sizes**2, ways.T
    against = push @ ways.T
    squares, vectors = scipy.linalg.eigh(np.diag(sizes**2) - against.T @ against, lower=True)
    return squares, ways.T @ vectors


def _ratios(omega: Floats, modal: Floats) -> Floats:
    """Return damping ratios of undamped modes of angular frequency ``omega`` [rad/s] by their damping matrix ``modal`` [1/s]."""
    moving = omega > 0.0
    ratio = np.zeros_like(omega)
    ratio[moving] = 0.5 * np.diag(modal)[moving] / omega[moving]
    light = moving & (ratio < 0.99) & (ratio > 0.0)
    if not light.any():
        return ratio
    from scipy.optimize import linear_sum_assignment

    # Of the velocities, and of the displacements times their frequencies.
    places = np.flatnonzero(moving)
    n = len(omega)
    matrix = np.zeros((n + len(places), n + len(places)))
    matrix[:n, :n] = -modal
    matrix[places, n + np.arange(len(places))] = -omega[places]
    matrix[n + np.arange(len(places)), places] = omega[places]
    values = scipy.linalg.eigvals(matrix)
    values = values[values.imag > 1e-9 * np.abs(values)]
    guessed = omega[light] * (-ratio[light] + 1j * np.sqrt(1.0 - ratio[light] ** 2))
    rows, columns = linear_sum_assignment(np.abs(guessed[:, None] - values[None, :]) / omega[light][:, None])
    found = np.flatnonzero(light)[rows]
    ratio[found] = -values[columns].real / np.abs(values[columns])
    return ratio


def solve_turning(mass: Floats, matrix: Floats, pairs: Sequence[tuple[int, int, float]]) -> Eigen:
    """Return the modes of z' = A z as seen from axes that turn.

    ``matrix`` is A in fixed axes at the instant where both agree, positions before velocities, shape [2 coordinate] squared;
    ``pairs`` are the places of x and y among the coordinates and the speed of the axes [rad/s] they are seen from: seen so they
    change by A - speed J. Free motions are the null space of A, a double eigenvalue each.
    """
    n = len(mass)
    turned = matrix.copy()
    for x, y, speed in pairs:
        for at in (0, n):
            turned[at + x, at + y] += speed
            turned[at + y, at + x] -= speed
    # Positions at rest there have the velocities -A_11 q: what pulls them back is K q.
    stiffness = -mass[:, None] * (turned[n:, :n] - turned[n:, n:] @ turned[:n, :n])
    free = free_motions(stiffness, tolerance=FREE_TURNING).shape[1] - 1
    # Of unit modal mass, positions times a frequency between the lowest and the highest: entries of like size.
    size = np.sqrt(float(np.abs(turned[n:, :n]).max(initial=1.0)))
    weights = np.concatenate([size * np.sqrt(mass), np.sqrt(mass)])
    values, vectors = scipy.linalg.eig(weights[:, None] * turned / weights)
    vectors = vectors / weights[:, None]
    still, others = np.split(np.argsort(np.abs(values), kind="stable"), [2 * free])
    largest = float(np.abs(values).max(initial=0.0))
    swinging = others[values[others].imag > 1e-12 * largest]
    real = others[
        np.abs(values[others].imag) <= 1e-12 * largest
    ]  # of motions that are damped more than critically
    order = np.concatenate([still[::2], swinging, real[::2]])
    order = np.concatenate(
        [order[:free], order[free:][np.argsort(np.abs(values[order[free:]]), kind="stable")]]
    )
    shapes = vectors[:n, order].T
    shapes = shapes / np.sqrt(np.einsum("i,mi->m", mass, np.abs(shapes) ** 2))[:, None]
    shapes *= np.exp(-0.5j * np.angle(np.einsum("i,mi->m", mass, shapes**2)))[:, None]
    modulus = np.abs(values[order])
    modulus[:free] = 0.0
    with np.errstate(invalid="ignore", divide="ignore"):
        ratio = np.where(modulus > 0.0, -values[order].real / modulus, 0.0)
    unstable = int(np.sum((values[others].real > 1e-9 * largest) & (values[others].imag >= 0.0)))
    return Eigen(modulus / (2.0 * np.pi), ratio, shapes, unstable)
