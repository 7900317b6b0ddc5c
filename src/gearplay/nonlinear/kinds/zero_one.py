"""The 0-1 test for chaos: whether a walk driven by the series stays in place (regular) or diffuses (chaotic).

For an angle c the series phi drives a walk in the plane, ``z(n) = sum_{j=1..n} phi(j) exp(i j c)``. Driven by regular motion the
walk stays bounded for nearly every c, driven by chaos it spreads like a random walk: its mean square displacement grows
linearly with the number of steps. K is the correlation of that displacement with the number of steps, near 0 or near 1.

Sources: Gottwald and Melbourne, SIAM J. Appl. Dyn. Syst. 8 (2009) 129 (the test as run here: displacement less its oscillating
term, correlation method, median over random c); Proc. R. Soc. Lond. A 460 (2004) 603 (the first form).

Doubts: noise diffuses too, so K says nothing of a motion of the size of the noise; a series of many samples an oscillation looks
regular; a torus needs records of many turns of its slowest beat; weak chaos beside a large cycle looks regular until the cycle
is taken off.
"""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gearplay.vocabulary.errors import Fault, InputError

Floats = NDArray[np.float64]

LEAST: Final = 100
"""Fewest samples taken: the displacement is known for a tenth as many steps, and ten points make a correlation."""

SHARE: Final = 10
"""The longest displacement has one step for so many samples: n <= N / 10, as the paper has it."""

LOWEST, HIGHEST = math.pi / 5.0, 4.0 * math.pi / 5.0
"""Angles c are drawn between these [rad]: nearer 0 they answer to slow drifts, nearer pi to alternation."""

AT_ONCE: Final = 1 << 21
"""Complex numbers held at once (32 MB): angles are taken in batches of as many as fit."""


@dataclass(frozen=True)
class ZeroOne:
    """The 0-1 test of a series: near 0 for regular motion, near 1 for chaos.

    ``k`` is the median over the angles, ``low`` and ``high`` are the quartiles; ``values`` (K of each angle) and ``angles`` [rad]
    have shape [angle].
    """

    k: float
    low: float
    high: float
    values: Floats
    angles: Floats


def draw_angles(seed: int, count: int) -> Floats:
    """Return random angles c [rad] between pi / 5 and 4 pi / 5, shape [angle]."""
    return np.random.default_rng(seed).uniform(LOWEST, HIGHEST, count)


def displacement(series: Floats, angles: Floats) -> Floats:
    """Return the mean square displacement D_c(n) of the walks, shape [angle, step], for n = 1 to N / 10 steps.

    ``series`` has shape [sample] or [sample, signal]; the displacements of several signals are added. With M_c(n) the mean of
    ``|z(j + n) - z(j)|^2`` over j = 1 to N - N / 10, ``D_c(n) = M_c(n) - V_osc(n)`` and
    ``V_osc(n) = (mean of phi)^2 (1 - cos(n c)) / (1 - cos c)``. The mean is taken off before the series drives the walk: V_osc
    is then zero, and with it are gone the cross terms between mean and motion that it leaves in short records.

    A series that alternates at c = pi makes equal steps, so that n of them lead to n^2:

    >>> displacement(np.tile([1.0, -1.0], 50), np.array([math.pi]))[0, :3].round(9).tolist()
    [1.0, 4.0, 9.0]
    """
    from scipy.fft import next_fast_len

    table = series.reshape(len(series), -1)
    centred = table - np.mean(table, axis=0)
    size = next_fast_len(len(table))  # no span reaches past the end, so nothing wraps around
    batch = max(1, AT_ONCE // size)
    parts = [_of_batch(centred, angles[i : i + batch], size) for i in range(0, len(angles), batch)]
    return np.concatenate(parts) if parts else np.zeros((0, len(table) // SHARE))


def _of_batch(centred: Floats, angles: Floats, size: int) -> Floats:
    """Return D_c(n) of some angles; ``|a - b|^2 = |a|^2 + |b|^2 - 2 Re(a* b)``: two running sums and a correlation by FFT."""
    longest = len(centred) // SHARE
    spans, steps = len(centred) - longest, np.arange(1, longest + 1)
    turning = np.exp(1j * np.outer(angles, np.arange(1, len(centred) + 1)))
    total = np.zeros((len(angles), longest))
    for column in centred.T:
        walk = np.cumsum(column * turning, axis=1)
        walk -= walk.mean(axis=1, keepdims=True)  # displacements do not see it, rounding does
        start = np.fft.fft(walk[:, :spans], size)
        across = np.fft.ifft(np.conj(start) * np.fft.fft(walk, size))[:, 1 : longest + 1].real
        running = np.cumsum(np.abs(walk) ** 2, axis=1)
        ends = running[:, spans - 1 + steps] - running[:, steps - 1]
        total += (running[:, spans - 1 : spans] + ends - 2.0 * across) / spans
    return total


def correlations(moved: Floats) -> Floats:
    """Return K_c, the correlation of each displacement with the number of steps, shape [angle]; 0 where nothing moves.

    >>> correlations(np.array([[1.0, 2.0, 3.0], [2.0, 2.0, 2.0], [3.0, 2.0, 1.0]])).round(9).tolist()
    [1.0, 0.0, -1.0]
    """
    steps = np.arange(moved.shape[1], dtype=np.float64)
    steps -= steps.mean()
    rest = moved - moved.mean(axis=1, keepdims=True)
    size = np.sqrt(np.sum(rest**2, axis=1) * np.sum(steps**2))
    return np.where(size > 0.0, rest @ steps / np.where(size > 0.0, size, 1.0), 0.0)


def zero_one_test(series: ArrayLike, *, seed: int = 0, count: int = 100) -> ZeroOne:
    """Return the 0-1 test of a series, shape [sample], seen once per period (not oversampled), at ``count`` random angles.

    K depends neither on the series' scale nor on its mean; that of a constant series is 0. Raises `InputError` for fewer than
    100 samples, for a sample that is no finite number, or for no angle.

    >>> full = [0.3]
    >>> for _ in range(999):
    ...     full.append(4.0 * full[-1] * (1.0 - full[-1]))
    >>> zero_one_test(full).k > 0.99, abs(zero_one_test(np.cos(np.arange(1000.0))).k) < 0.05
    (True, True)
    """
    values = _check_series(series)
    if isinstance(count, bool) or not isinstance(count, (int, np.integer)) or count < 1:
        raise InputError(Fault("count", count, "must be a whole number of 1 or more", "100 angles suit"))
    angles = draw_angles(seed, int(count))
    largest = float(np.max(np.abs(values)))
    if (
        float(np.max(values / (largest or 1.0))) - float(np.min(values / (largest or 1.0)))
        <= 8.0 * np.finfo(float).eps
    ):
        found = np.zeros(len(angles))  # constant to rounding
    else:
        found = correlations(displacement(_unit(values / largest), angles))
    low, middle, high = np.quantile(found, [0.25, 0.5, 0.75])
    return ZeroOne(float(middle), float(low), float(high), found, angles)


def _unit(values: Floats) -> Floats:
    """Return values less their mean, of largest size 1."""
    centred = values - np.mean(values)
    return np.asarray(centred / np.max(np.abs(centred)))


def _check_series(series: ArrayLike) -> Floats:
    raw = np.asarray(series)
    if raw.dtype.kind not in "fiub" or raw.ndim != 1:
        rule = "must be one series of real numbers, shape [sample]"
        raise InputError(
            Fault("series", f"{raw.dtype}, shape {raw.shape}", rule, "Take one signal of the section")
        )
    if raw.size < LEAST:
        cure = "Take a longer record"
        raise InputError(Fault("series", f"{raw.size} samples", f"must have at least {LEAST} samples", cure))
    values = raw.astype(np.float64)
    bad = np.flatnonzero(~np.isfinite(values))
    if bad.size:
        found = f"{values[bad[0]]} at sample {bad[0]}, {bad.size} in all"
        raise InputError(Fault("series", found, "must be finite numbers", "Cut or repair these samples"))
    return values
