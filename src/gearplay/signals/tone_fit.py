"""Least-squares fit of tones on the lines of a windowed Fourier transform, with covariance."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gearplay.signals.checks import TWO_PI

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]
Indices = NDArray[np.int64]

COSINES = {"boxcar": (1.0,), "hann": (0.5, 0.5), "blackman": (0.42, 0.5, 0.08)}
"""Windows as sums of c_j cos(2 pi j n' / N), n' counted from the middle of the record."""

REACH = 16
"""Lines on each side of a tone that its fit uses."""

STEP = 1e-3  # of a line, for the derivative of the window's transform


@dataclass(frozen=True)
class Transform:
    """Windowed transform of a record, phases counted from its middle.

    ``lines`` has shape [line], ``n`` is the number of samples, ``cosines`` are the window's coefficients.
    """

    lines: Complexes
    n: int
    cosines: tuple[float, ...]


def windowed_transform(values: Floats, window: str) -> Transform:
    """Return the transform of a record, shape [time], its mean taken off."""
    n = values.size
    phase = TWO_PI * (np.arange(n) - 0.5 * n) / n
    weights = sum(c * np.cos(j * phase) for j, c in enumerate(COSINES[window]))
    lines = np.fft.rfft((values - np.mean(values)) * weights)
    # The middle is sample n/2, so line m turns by m half turns, even where n is odd.
    lines[1::2] *= -1.0
    return Transform(lines, n, COSINES[window])


def _dirichlet(d: Floats, n: int) -> Complexes:
    """Return sum over samples of exp(2 pi i d (k - n/2) / n), d in lines."""
    result: Complexes = np.exp(-1j * np.pi * d / n) * (n * np.sinc(d) / np.sinc(d / n))
    return result


def kernel(d: Floats, n: int, cosines: tuple[float, ...]) -> Complexes:
    """Return the window's transform at a distance of ``d`` lines: sum of w_k exp(2 pi i d (k - n/2) / n).

    A tone a exp(2 pi i f (k - n/2) / n) has a times it, d = f - m, on line m. Of a window that is a sum of cosines it is one
    of shifted Dirichlet kernels: Harris, Proc. IEEE 66 (1978) 51.

    >>> [round(abs(complex(v)), 9) for v in kernel(np.array([0.0, 1.0, 2.0]), 100, COSINES["hann"])]
    [50.0, 25.0, 0.0]
    """
    total = cosines[0] * _dirichlet(d, n)
    for j, c in enumerate(cosines[1:], start=1):
        total = total + 0.5 * c * (_dirichlet(d - j, n) + _dirichlet(d + j, n))
    return total


def shapes(places: Floats, at: Indices, transform: Transform) -> tuple[Complexes, Complexes]:
    """Return the transforms of unit tones and of their mirror images at negative frequency on the lines ``at``, [tone, line]."""
    direct = kernel(places[:, None] - at, transform.n, transform.cosines)
    mirror = kernel(-places[:, None] - at, transform.n, transform.cosines)
    return direct, mirror


def model(places: Floats, amplitudes: Complexes, at: Indices, transform: Transform) -> Complexes:
    """Return the transform of each real tone at ``places`` [lines] with complex half ``amplitudes``, shape [tone, line]."""
    direct, mirror = shapes(places, at, transform)
    result: Complexes = amplitudes[:, None] * direct + np.conj(amplitudes)[:, None] * mirror
    return result


def _jacobian(places: Floats, amplitudes: Complexes, at: Indices, transform: Transform) -> Complexes:
    """Return the derivative by places, real and imaginary parts of the amplitudes, shape [line, 3 tones]."""
    ahead, behind = (model(places + step, amplitudes, at, transform) for step in (STEP, -STEP))
    direct, mirror = shapes(places, at, transform)
    return np.vstack([(ahead - behind) / (2.0 * STEP), direct + mirror, 1j * (direct - mirror)]).T


def _norms(jacobian: Complexes) -> Floats:
    """Return the column norms for scaling: next to a strong tone a weak one would be lost in the solver's tolerance otherwise."""
    norm = np.sqrt(np.sum(np.abs(jacobian) ** 2, axis=0))
    return np.asarray(np.where(norm > 0.0, norm, 1.0))


def _amplitudes(lines: Complexes, places: Floats, at: Indices, transform: Transform) -> Complexes:
    """Return the amplitudes that fit best for given places; they enter linearly."""
    direct, mirror = shapes(places, at, transform)
    basis = np.vstack([direct + mirror, 1j * (direct - mirror)]).T
    real = np.vstack([basis.real, basis.imag])
    best = np.linalg.lstsq(real, np.concatenate([lines.real, lines.imag]), rcond=None)[0]
    result: Complexes = best[: places.size] + 1j * best[places.size :]
    return result


def fit_tones(
    lines: Complexes, places: Floats, at: Indices, transform: Transform, *, steps: int = 30
) -> tuple[Floats, Complexes]:
    """Return (places [lines], complex half amplitudes) of all tones at once, nearest the lines ``at`` by least squares.

    Gauss-Newton in the places with the amplitudes eliminated in every step (variable projection): Golub and Pereyra, SIAM J.
    Numer. Anal. 10 (1973) 413. A step moves a tone by half a line at most, and none leaves its start by more than two.
    """
    start, found = places, places.copy()
    amplitudes = _amplitudes(lines, found, at, transform)
    for _ in range(steps):
        left = lines - np.sum(model(found, amplitudes, at, transform), axis=0)
        jacobian = _jacobian(found, amplitudes, at, transform)
        norm = _norms(jacobian)
        real = np.vstack([jacobian.real, jacobian.imag]) / norm
        best = np.linalg.lstsq(real, np.concatenate([left.real, left.imag]), rcond=None)[0]
        step = (best / norm)[: found.size]
        moved = np.clip(found + np.clip(step, -0.5, 0.5), start - 2.0, start + 2.0)
        change = float(np.max(np.abs(moved - found)))
        found = moved
        amplitudes = _amplitudes(lines, found, at, transform)
        if change < 1e-10:
            break
    return found, amplitudes


def covariance(
    places: Floats, amplitudes: Complexes, at: Indices, noise: Floats, transform: Transform
) -> Floats:
    """Return the covariance of (places, real parts, imaginary parts), shape [3 tones, 3 tones].

    For the noise e of the lines: theta - theta_0 = G^-1 Re(J^H e), G = Re(J^H J), so that cov = 1/2 G^-1 Re(J^H C J) G^-1 with
    C = E[e e^H]. A window correlates neighbouring lines: C_ml = s_m s_l q(m - l) / q(0), s_m^2 = ``noise`` the expected
    |e|^2 of line m and q the transform of w^2. With a boxcar it tends to the Cramer-Rao bounds of an isolated tone in noise of
    one-sided density S over a time T: var(f) = 3 S / (pi^2 A^2 T^3), var(A) = S / T.

    Source: White, Econometrica 48 (1980) 817, for errors of any covariance; bounds: Rife and Boorstyn, IEEE Trans. Inf. Theory
    20 (1974) 591.
    """
    jacobian = _jacobian(places, amplitudes, at, transform)
    squared = squared_window(transform.cosines)
    correlation = kernel(np.asarray(at[None, :] - at[:, None], dtype=np.float64), transform.n, squared)
    level = np.sqrt(noise)
    c = level[:, None] * level[None, :] * correlation / (squared[0] * transform.n)
    norm = _norms(jacobian)
    scaled = jacobian / norm
    inverse = np.linalg.pinv((scaled.conj().T @ scaled).real)
    result: Floats = 0.5 * inverse @ (scaled.conj().T @ c @ scaled).real @ inverse / np.outer(norm, norm)
    return result


def squared_window(cosines: tuple[float, ...]) -> tuple[float, ...]:
    """Return the coefficients of the window's square, again a sum of cosines."""
    two_sided = np.array([*(0.5 * c for c in cosines[:0:-1]), cosines[0], *(0.5 * c for c in cosines[1:])])
    product = np.convolve(two_sided, two_sided)
    middle = product.size // 2
    return (float(product[middle]), *(2.0 * float(v) for v in product[middle + 1 :]))
