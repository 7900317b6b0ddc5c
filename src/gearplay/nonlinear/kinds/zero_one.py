"""The 0-1 test for chaos: whether a walk driven by the section stays bounded (regular motion) or diffuses (chaos).

For an angle c a series phi drives a walk in the plane, ``z(n) = sum_{j=1..n} phi(j) exp(i j c)``. K is the correlation of its
mean square displacement with the number of steps: near 0 for regular motion, near 1 for chaos, at nearly every c.

Source: Gottwald and Melbourne, SIAM J. Appl. Dyn. Syst. 8 (2009) 129 (correlation method, median over random c).

Limits: noise diffuses too; a torus needs records of many turns of its slowest beat; weak chaos on a large cycle looks regular
until the cycle is subtracted.
"""

import math

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

LONGEST = 10
"""The record is so many times longer than the longest displacement (n <= N / 10 in the source)."""

LOWEST, HIGHEST = math.pi / 5.0, 4.0 * math.pi / 5.0
"""Angles c are drawn between these [rad]: nearer 0 they respond to slow drifts, nearer pi to alternation."""

ANGLES = 100
"""Random angles; more change no quartile by more than 0.02."""


def displacement(samples: Floats, angles: Floats) -> Floats:
    """Return the mean square displacement of the walks, summed over signals, shape [angle, step], for 1 to N / 10 steps.

    ``samples`` has shape [period, signal]. It is the mean of ``|z(j + n) - z(j)|^2`` over j = 1 to N - N / 10. The mean of each
    signal is subtracted first; the source's oscillating term, which is that of the mean, is then zero.

    A series that alternates at c = pi makes equal steps, so that n of them lead to n^2:

    >>> displacement(np.tile([[1.0], [-1.0]], (50, 1)), np.array([math.pi]))[0, :3].round(9).tolist()
    [1.0, 4.0, 9.0]
    """
    return np.array([_displacement(samples - samples.mean(axis=0), float(angle)) for angle in angles])


def _displacement(centred: Floats, angle: float) -> Floats:
    """Return the displacement at one angle; ``|a - b|^2 = |a|^2 + |b|^2 - 2 Re(a* b)``: running sums and a correlation by FFT."""
    from scipy.fft import fft, ifft, next_fast_len

    count = len(centred)
    longest, steps = count // LONGEST, np.arange(1, count // LONGEST + 1)
    spans, size = (
        count - longest,
        next_fast_len(count),
    )  # no span reaches past the end, so nothing wraps around
    walk = np.cumsum(centred * np.exp(1j * angle * np.arange(1, count + 1))[:, None], axis=0)
    walk -= walk.mean(axis=0)  # of no effect on displacements, but on rounding
    across = ifft(np.sum(np.conj(fft(walk[:spans], size, axis=0)) * fft(walk, size, axis=0), axis=1))
    running = np.cumsum(np.sum(np.abs(walk) ** 2, axis=1))
    ends = running[spans - 1 + steps] - running[steps - 1]
    return np.asarray(running[spans - 1] + ends - 2.0 * across[steps].real) / spans


def correlations(moved: Floats) -> Floats:
    """Return K of each angle, shape [angle]: the correlation of its displacement with the number of steps; 0 for no motion.

    >>> correlations(np.array([[1.0, 2.0, 3.0], [2.0, 2.0, 2.0], [3.0, 2.0, 1.0]])).round(9).tolist()
    [1.0, 0.0, -1.0]
    """
    steps = np.arange(moved.shape[1], dtype=np.float64)
    steps -= steps.mean()
    rest = moved - moved.mean(axis=1, keepdims=True)
    size = np.sqrt(np.sum(rest**2, axis=1) * np.sum(steps**2))
    return np.where(size > 0.0, rest @ steps / np.where(size > 0.0, size, 1.0), 0.0)


def zero_one(samples: Floats) -> float:
    """Return K of samples once per period, shape [period, signal]: the lower quartile over 100 random angles.

    The source takes the median. Near a spectral line K is large for regular motion too, and short records of many lines have no
    angle that is far from all; chaos has a large K at every angle.

    >>> full = [0.3]
    >>> for _ in range(999):
    ...     full.append(4.0 * full[-1] * (1.0 - full[-1]))
    >>> zero_one(np.array(full)[:, None]) > 0.99, abs(zero_one(np.cos(np.arange(1000.0))[:, None])) < 0.05
    (True, True)
    """
    angles = np.random.default_rng(0).uniform(LOWEST, HIGHEST, ANGLES)
    return float(np.quantile(correlations(displacement(samples, angles)), 0.25))
