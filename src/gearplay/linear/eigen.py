"""Natural frequencies, damping ratios and shapes of a linear system."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

from gearplay.linear.condense import Condensed

Floats = NDArray[np.float64]

FREE = 1e-12
"""Stiffness of a motion, per that of its coordinates alone, that is rounding."""
FREE_TURNING = 1e-10
"""The same in the frame of a turning carrier, where forces of inertia must cancel too."""
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
    """Return orthonormal rigid-body motions in scaled coordinates (unit diagonal stiffness), and the scale.

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
    mass: Floats, stiffness: Floats, damping: Floats, condensed: Condensed | None = None
) -> Eigen:
    """Return the modes of M x'' + C x' + K x = 0, M diagonal, shapes those without damping.

    Free motions are the null space of K; of the others the frequencies are the singular values of M^-1/2 P where K = P'P, so that
    low ones keep their digits in the presence of high ones, as they do in P.
    ``condensed`` is the system without massless coordinates, which it must have where there are any: as many modes are returned
    as coordinates have mass.

    Damping ratios are those of the damped eigenvalues, -Re / modulus, each given to the undamped mode that it is nearest to when
    that is damped by its modal damping alone.
    """
    light = mass == 0.0
    reduced, springs, recover = condensed or Condensed(stiffness, None, np.eye(len(mass)))
    root = np.sqrt(mass[~light])
    scaled = reduced / np.outer(root, root)
    size = float(np.abs(scaled).max(initial=0.0))
    scale, *motions = free_motions(reduced).T
    free = np.array(motions).reshape(-1, len(root)) * scale * root
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
    shape = (recover @ (vectors / root[:, None])).T
    ratio = _ratios(omega, shape @ damping @ shape.T, _relaxing(shape, stiffness, damping, light))
    return Eigen(omega / (2.0 * np.pi), ratio, shape, unstable)


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


class Relaxing(NamedTuple):
    """Massless coordinates r coupled to the modes q: q'' + C_qq q' + C_qr r' + ... = 0 and C_rq q' + C_rr r' + K_rr r = 0."""

    stiffness: Floats
    damping: Floats
    on_modes: Floats
    by_modes: Floats


def _relaxing(shape: Floats, stiffness: Floats, damping: Floats, light: NDArray[np.bool_]) -> Relaxing | None:
    """Return the relaxation of massless coordinates beyond the static condensation; None without a damper on them."""
    if not np.any(damping[light]) and not np.any(damping[:, light]):
        return None
    inner = stiffness[np.ix_(light, light)]
    scale = 1.0 / np.sqrt(np.abs(np.diag(inner)))
    both = np.outer(scale, scale)
    on_modes, by_modes = shape @ damping[:, light] * scale, scale[:, None] * damping[light] @ shape.T
    return Relaxing(inner * both, damping[np.ix_(light, light)] * both, on_modes, by_modes)


def _ratios(omega: Floats, modal: Floats, relaxing: Relaxing | None) -> Floats:
    """Return damping ratios of undamped modes of angular frequency ``omega`` [rad/s] by their damping matrix ``modal`` [1/s]."""
    moving = omega > 0.0
    ratio, modulus, drag = np.zeros_like(omega), omega.copy(), np.diag(modal).copy()
    if relaxing is not None:
        drag, modulus = _with_relaxed(omega, drag, relaxing)
    ratio[moving] = 0.5 * drag[moving] / modulus[moving]
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
    values = scipy.linalg.eigvals(matrix) if relaxing is None else _with_relaxing(matrix, relaxing, n)
    values = values[values.imag > 1e-9 * np.abs(values)]
    guessed = modulus[light] * (-ratio[light] + 1j * np.sqrt(1.0 - ratio[light] ** 2))
    rows, columns = linear_sum_assignment(np.abs(guessed[:, None] - values[None, :]) / omega[light][:, None])
    found = np.flatnonzero(light)[rows]
    ratio[found] = -values[columns].real / np.abs(values[columns])
    return ratio


def _with_relaxed(omega: Floats, drag: Floats, relaxing: Relaxing) -> tuple[Floats, Floats]:
    """Return damping [1/s] and modulus [rad/s] of each mode alone with massless coordinates that follow at its frequency.

    These add w^2 C_qr (K_rr + i w C_rr)^-1 C_rq to its dynamic stiffness.
    """
    inner, damping, on_modes, by_modes = relaxing
    found = np.array(
        [
            w * on_modes[m] @ np.linalg.solve(inner + 1j * w * damping, by_modes[:, m])
            for m, w in enumerate(omega)
        ]
    )
    return drag + found.imag, np.sqrt(np.maximum(omega * (omega + found.real), omega**2))


def _with_relaxing(matrix: Floats, relaxing: Relaxing, modes: int) -> NDArray[np.complex128]:
    """Return the finite eigenvalues of the modes, z' = A z, velocities first, and massless coordinates together."""
    inner, damping, on_modes, by_modes = relaxing
    size = float(np.abs(matrix).max(initial=0.0))
    slow = 1.0 / np.sqrt(1.0 + size * np.abs(np.diag(damping)))
    n, more = len(matrix), len(inner)
    left, right = np.zeros((n + more, n + more)), np.eye(n + more)
    left[:n, :n], left[n:, n:] = matrix, -size * inner * np.outer(slow, slow)
    left[n:, :modes] = -size * slow[:, None] * by_modes
    right[:modes, n:], right[n:, n:] = on_modes * slow, size * damping * np.outer(slow, slow)
    return _finite(scipy.linalg.eigvals(left, right, homogeneous_eigvals=True), size)[0]


def _finite(ratios: NDArray[np.complex128], size: float) -> tuple[NDArray[np.complex128], NDArray[np.bool_]]:
    """Return the finite ones of eigenvalues alpha / beta, shape [2, eigenvalue], of a system with the largest frequency ``size``,
    and which they are.
    """
    alpha, beta = ratios
    finite = np.abs(alpha) < 1e9 * size * np.abs(beta)
    return alpha[finite] / beta[finite], finite


def solve_turning(mass: Floats, stiffness: Floats, damping: Floats, turning: Floats) -> Eigen:
    """Return the modes of a system in rotating axes.

    ``stiffness`` and ``damping`` are K and C in fixed axes at the instant where both agree, ``turning`` the matrix W of the
    velocities W q of places at rest in the turning axes, shapes [coordinate, coordinate]. There K + C W + M W W acts on the
    positions and C + 2 M W on the velocities. Free motions are the null space of the first, a double eigenvalue each. As many
    modes are returned as coordinates have mass.
    """
    n, heavy, light = len(mass), np.flatnonzero(mass > 0.0), np.flatnonzero(mass == 0.0)
    pull = stiffness + damping @ turning + mass[:, None] * (turning @ turning)
    drag = damping + 2.0 * mass[:, None] * turning
    free = free_motions(pull, tolerance=FREE_TURNING).shape[1] - 1
    # Of unit modal mass, positions times a frequency between the lowest and the highest: entries of like size.
    root = np.sqrt(mass[heavy])
    size = np.sqrt(float(np.abs(pull[heavy][:, heavy] / mass[heavy, None]).max(initial=1.0)))
    own = np.sqrt(np.abs(np.diag(pull)[light]) + size * np.abs(np.diag(drag)[light]))
    # Positions with and without mass, then velocities: those without mass are not accelerated.
    places, speeds = np.concatenate([heavy, light]), np.arange(n, n + len(heavy))
    left, right = np.zeros((n + len(heavy), n + len(heavy))), np.eye(n + len(heavy))
    left[: len(heavy), speeds] = np.eye(len(heavy))
    rows, back = np.concatenate([light, heavy]), slice(len(heavy), None)
    left[back, :n], left[back, n:] = -pull[np.ix_(rows, places)], -drag[np.ix_(rows, heavy)]
    right[back, len(heavy) : n], right[speeds, speeds] = drag[np.ix_(rows, light)], mass[heavy]
    weights = np.concatenate([size * root, own, root])
    scales = np.concatenate([size * root, size / own, 1.0 / root])
    left, right = scales[:, None] * left / weights, scales[:, None] * right / weights
    if light.size:
        ratios, vectors = scipy.linalg.eig(left, right, homogeneous_eigvals=True)
        values, finite = _finite(ratios, size)
        vectors = vectors[:, finite]
    else:
        values, vectors = scipy.linalg.eig(left)
    vectors = (vectors / weights[:, None])[np.argsort(places)]
    still, others = np.split(np.argsort(np.abs(values), kind="stable"), [2 * free])
    largest = float(np.abs(values).max(initial=0.0))
    swinging = others[values[others].imag > 1e-12 * largest]
    real = others[
        np.abs(values[others].imag) <= 1e-12 * largest
    ]  # of motions that are damped more than critically
    order = np.concatenate([still[::2], swinging, real[::2][: len(heavy) - free - len(swinging)]])
    order = np.concatenate(
        [order[:free], order[free:][np.argsort(np.abs(values[order[free:]]), kind="stable")]]
    )
    shapes = vectors[:, order].T
    shapes = shapes / np.sqrt(np.einsum("i,mi->m", mass, np.abs(shapes) ** 2))[:, None]
    shapes *= np.exp(-0.5j * np.angle(np.einsum("i,mi->m", mass, shapes**2)))[:, None]
    modulus = np.abs(values[order])
    modulus[:free] = 0.0
    with np.errstate(invalid="ignore", divide="ignore"):
        ratio = np.where(modulus > 0.0, -values[order].real / modulus, 0.0)
    unstable = int(np.sum((values[others].real > 1e-9 * largest) & (values[others].imag >= 0.0)))
    return Eigen(modulus / (2.0 * np.pi), ratio, shapes, unstable)
