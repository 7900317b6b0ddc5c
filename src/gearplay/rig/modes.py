"""Analog filters as sums of modes, and their exact response to sampled input.

A transfer function with distinct poles is ``H(s) = sum r_i / (s - p_i)``. Each mode obeys ``dx/dt = p x + u``, which is solved
exactly over a sampling interval T for an input that is constant or linear within it. The sampled response is then that of
the analog filter to the reconstructed input: in magnitude ``|H(f)| sinc^2(f T)`` in both cases (mean over an interval, then
held; or joined by straight lines), without any delay. `sharpen` takes the sinc^2 off to fourth order.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]


@dataclass(frozen=True)
class Modes:
    """Poles [rad/s] and residues of a strictly proper filter, shape [mode].

    Of each complex pair only the pole with positive imaginary part is kept.
    """

    poles: tuple[complex, ...]
    residues: tuple[complex, ...]

    def response(self, frequency: Floats) -> Complex:
        """Return H at each frequency [Hz], shape [frequency].

        >>> corner = Modes((-2.0 * np.pi + 0j,), (2.0 * np.pi + 0j,))  # first-order low-pass, 1 Hz
        >>> bool(np.isclose(corner.response(np.array([1.0]))[0], 1.0 / (1.0 + 1.0j)))
        True
        """
        s = 2j * np.pi * np.asarray(frequency, dtype=np.float64)
        total = np.zeros(s.shape, dtype=np.complex128)
        for pole, residue in zip(self.poles, self.residues, strict=True):
            total += residue / (s - pole)
            if pole.imag > 0.0:
                total += np.conj(residue) / (s - np.conj(pole))
        return total

    def hold(self, means: Floats, interval: float) -> Floats:
        """Return the response at the start of each interval [s] to an input constant within each, from rest.

        ``means`` has shape [time], item k held from k to k + 1 intervals; item 0 of the result is 0, the state of rest.
        """
        return self._run(means, [(0.0, interval * grow(p * interval)[0]) for p in self.poles], interval)

    def join(self, samples: Floats, interval: float) -> Floats:
        """Return the response at each sample to the input that joins the samples by straight lines, from rest."""
        shares = []
        for pole in self.poles:
            one, two = grow(pole * interval)
            shares.append((interval * two, interval * (one - two)))
        return self._run(samples, shares, interval)

    def _run(self, u: Floats, shares: list[tuple[complex, complex]], interval: float) -> Floats:
        """Sum the modes ``x_k = exp(p T) x_k-1 + b_0 u_k + b_1 u_k-1`` of real or paired poles."""
        from scipy.signal import lfilter

        y = np.zeros(u.size)
        for pole, residue, (b_0, b_1) in zip(self.poles, self.residues, shares, strict=True):
            e = np.exp(pole * interval)
            c_0, c_1 = residue * b_0, residue * b_1
            if pole.imag > 0.0:  # the mode and its conjugate, over one real denominator
                top = [2.0 * c_0.real, 2.0 * (c_1 - c_0 * np.conj(e)).real, -2.0 * (c_1 * np.conj(e)).real]
                y += lfilter(top, [1.0, -2.0 * e.real, abs(e) ** 2], u)
            else:
                y += lfilter([c_0.real, c_1.real], [1.0, -e.real], u)
        return y


def sharpen(u: Floats) -> Floats:
    """Return samples whose reconstruction follows the signal: ``u_k - (u_k+1 - 2 u_k + u_k-1) / 12``, shape [time].

    Its response is 1 + sin^2(z) / 3 with z = pi f T, against sinc^2 = 1 - z^2 / 3 + 2 z^4 / 45: together 1 - 8 z^4 / 45.

    >>> sharpen(np.array([0.0, 0.0, 12.0, 0.0, 0.0])).tolist()
    [0.0, -1.0, 14.0, -1.0, 0.0]
    """
    sharp = u.copy()
    sharp[1:-1] -= (u[2:] - 2.0 * u[1:-1] + u[:-2]) / 12.0
    return sharp


def grow(z: complex) -> tuple[complex, complex]:
    """Return phi_1 = (exp(z) - 1) / z and phi_2 = (phi_1 - 1) / z, by their series where z is small.

    >>> [round(float(phi.real), 6) for phi in grow(1.0 + 0j)], [phi.real for phi in grow(0j)]  # e - 1, e - 2
    ([1.718282, 0.718282], [1.0, 0.5])
    """
    if abs(z) < 1e-3:  # the first term left out is z^5 / 5040
        return (
            1.0 + z / 2 * (1.0 + z / 3 * (1.0 + z / 4 * (1.0 + z / 5))),
            0.5 + z / 6 * (1.0 + z / 4 * (1.0 + z / 5 * (1.0 + z / 6))),
        )
    one = complex(np.expm1(z)) / z
    return one, (one - 1.0) / z
