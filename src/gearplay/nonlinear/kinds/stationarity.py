"""Stationarity of a section: amplitude change of its spectral lines, steps between blocks, and slow motion.

A settled regular motion is a sum of constant lines. Lines are found strongest first in the spectrum of what is left (CLEAN:
Hoegbom, Astron. Astrophys. Suppl. 15 (1974) 417), all signals sharing their frequencies, and fitted by least squares with
amplitudes that change linearly over the record; the part of the change in phase with the line is a change of amplitude, that in
quadrature an error of the frequency. Irregular motion is compared block by block.

Limits: two lines less than about two turns in the record apart are one line that changes.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gearplay.nonlinear.kinds.thresholds import LINE_RATIO

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]

PASSES = (1, 1, 2, 4, 4)
"""Lines taken in each pass: few at first, so that the skirts of a changing line are not taken for lines."""

APART = 2.0
"""Distance of a new line from the mean and from known lines [turns per record]: the half width of the Hann window's main lobe."""

BLOCKS = 16
"""Blocks of a record: of 300 periods each holds 18, more than most correlations last."""


class LineChange(NamedTuple):
    """Change of the amplitudes of spectral lines over the record.

    ``ratio`` and ``share`` are a linear change over what lines leave unexplained, and over the motion (root mean squares);
    ``slow`` is the share of the variance that a modulation of the lines, or of the mean, with less than two turns in the record
    makes up.
    """

    ratio: float
    share: float
    slow: float


def line_change(samples: Floats) -> LineChange:
    """Return the change of the spectral lines of samples, shape [period, signal], of the pass with the largest linear change.

    Later lines may take up a change of their neighbour.

    >>> n = np.arange(400.0)[:, None]
    >>> steady, fading = np.cos(0.7 * n) + 0.2 * np.cos(1.9 * n), np.exp(-n / 2000.0) * np.cos(0.7 * n)
    >>> line_change(steady).ratio < 0.1, line_change(fading).ratio > 10.0, round(line_change(fading).share, 2)
    (True, True, 0.06)
    >>> round(line_change((1.0 + 0.5 * np.cos(3.0 * np.pi * n / 400.0)) * np.cos(0.7 * n)).slow, 2)  # 1/8 of 9/8
    0.11
    """
    samples = samples - samples.mean(axis=0)
    whole = math.sqrt(float(np.mean(np.sum(samples**2, axis=1))))
    turns, rest, found = np.zeros(0), samples, (0.0, 0.0)
    for most in PASSES:
        turns = np.append(turns, _strongest(rest, turns, most))
        for _ in range(2):
            _, sizes, changes, _ = _fit(samples, turns)
            turns = _sharpened(turns, sizes, changes, len(samples))
        rest, sizes, changes, trend = _fit(samples, turns)
        in_phase = (changes * sizes.conj()).real / np.maximum(np.abs(sizes), 1e-300)
        square = (
            np.where(turns < 0.5, 0.5, 1.0) @ in_phase**2 + trend**2
        )  # alternation is not half the time near zero
        change = math.sqrt(float(np.sum(square)) / 3.0)
        free = max(len(samples) - 2 - 4 * len(turns), 1)
        left = max(math.sqrt(float(np.sum(rest**2)) / free), 1e-9 * whole)
        found = max(found, (change / left, change / whole), key=_clarity)
        if left <= 1e-9 * whole:
            break
    return LineChange(*found, _slow_share(samples, turns))


def _slow_share(samples: Floats, turns: Floats) -> float:
    """Return the share of the variance of slow modulations of the mean and of lines with such frequencies.

    They are lines less than two turns in the record from a stronger one or from the mean, and of what all lines leave the terms
    of the cosine transform with a half, one and one and a half turns, of the rest times each wave.
    """
    count = len(samples)
    n = np.arange(count) - count // 2
    waves = np.exp(2j * math.pi * np.outer(n, turns))
    both = np.hstack([np.ones((count, 1)), waves.real, waves.imag])
    fitted = np.linalg.lstsq(both, samples, rcond=1e-6)[0]
    power = np.sum(np.square(fitted[1:]).reshape(2, len(turns), -1), axis=(0, 2)) / 2.0
    close = np.abs(turns[:, None] - turns) < APART / count
    weaker = np.any(close & (power[:, None] < power), axis=1) | (turns < APART / count)
    rest, found = samples - both @ fitted, count * float(np.sum(power[weaker]))
    slow = np.cos(math.pi * np.outer((1.0, 2.0, 3.0), (np.arange(count) + 0.5) / count))
    for turn in (0.0, *turns[~weaker].tolist()):
        part = slow @ (rest * np.exp(-2j * math.pi * turn * n)[:, None])
        found += (4.0 if 0.0 < turn < 0.5 else 2.0) / count * float(np.sum(np.abs(part) ** 2))
    return found / max(float(np.sum(samples**2)), 1e-300)


def _clarity(change: tuple[float, float]) -> tuple[float, float]:
    """Return how clearly lines change: by the share where the ratio is `LINE_RATIO` or more, otherwise by the ratio."""
    return (change[1] if change[0] >= LINE_RATIO else 0.0, change[0])


def _fit(samples: Floats, turns: Floats) -> tuple[Floats, Complex, Complex, Floats]:
    """Return the rest, sizes and changes of lines (complex, shape [line, signal]), and the trend of the mean, shape [signal]."""
    count, lines = len(samples), len(turns)
    n = np.arange(count) - count // 2
    angles = 2.0 * math.pi * np.outer(n, turns)
    waves = np.hstack([np.ones((count, 1)), np.cos(angles), np.sin(angles)])
    waves = np.hstack([waves, waves * (2.0 * n / (count - 1))[:, None]])
    square = waves.T @ waves
    square[np.diag_indices_from(square)] += 1e-11 * count  # at half a turn the sine vanishes
    fitted = np.linalg.solve(square, waves.T @ samples)
    still, moving = fitted[: 1 + 2 * lines], fitted[1 + 2 * lines :]
    sizes, changes = (part[1 : 1 + lines] - 1j * part[1 + lines :] for part in (still, moving))
    return samples - waves @ fitted, sizes, changes, moving[0]


def _sharpened(turns: Floats, sizes: Complex, changes: Complex, periods: int) -> Floats:
    """Return corrected frequencies, without those that coincide with an earlier one or with 0."""
    across = np.sum((changes * sizes.conj()).imag, axis=1)
    shift = across / np.maximum(np.sum(np.abs(sizes) ** 2, axis=1), 1e-300) / (math.pi * (periods - 1))
    turns = np.abs(turns + np.clip(shift, -0.5 / periods, 0.5 / periods))
    turns = np.where(turns > 0.5 - 0.5 / periods, 0.5, turns)
    kept: list[float] = []
    for turn in turns.tolist():
        if turn >= 0.4 / periods and all(abs(turn - other) >= 1.0 / periods for other in kept):
            kept.append(turn)
    return np.array(kept)


def _strongest(rest: Floats, known: Floats, most: int) -> Floats:
    """Return the frequencies of the strongest new lines in a rest's spectrum, at most ``most``, down to 1e-4 of the strongest."""
    periods = len(rest)
    size = 1 << (4 * periods - 1).bit_length()
    window = np.hanning(periods + 2)[1:-1, None]
    power = np.sum(np.abs(np.fft.rfft(rest * window, size, axis=0)) ** 2, axis=1)
    grid = np.arange(len(power)) / size
    for turn in (0.0, *known.tolist()):
        power[np.abs(grid - turn) < APART / periods] = 0.0
    found: list[float] = []
    least = 1e-4 * float(power.max())
    while len(found) < most and power.max() > least:
        found.append(float(grid[np.argmax(power)]))
        power[np.abs(grid - found[-1]) < APART / periods] = 0.0
    return np.array(found)


def block_change(samples: Floats, bands: int = 1) -> float:
    """Return the largest Student's t of a step or a line between blocks, of means, squares and products with the next sample.

    A step (three blocks at least on each side) or a line that explains the part ``b`` of the sum of squares between B blocks has
    ``t^2 = b / (1 - b) (B - 2)``. Blocks hold complete visits to all ``bands`` bands, where they hold two or more.
    """
    now, later = samples[:-1], samples[1:]
    table = np.hstack([now, now**2, now * later])
    each = len(table) // BLOCKS
    each -= each % bands if 2 * bands <= each else 0
    means = table[: BLOCKS * each].reshape(BLOCKS, each, -1).mean(axis=1)
    rest = means - means.mean(axis=0)
    whole = np.sum(rest**2, axis=0)
    before = np.arange(3, BLOCKS - 2)
    steps = np.cumsum(rest, axis=0)[before - 1] ** 2 * (BLOCKS / (before * (BLOCKS - before)))[:, None]
    place = np.arange(BLOCKS) - 0.5 * (BLOCKS - 1)
    explained = np.maximum(steps.max(axis=0), (place @ rest) ** 2 / np.sum(place**2))
    left = np.maximum(whole - explained, 1e-12 * whole + 1e-18)
    return math.sqrt(float(np.max(explained / left)) * (BLOCKS - 2))
