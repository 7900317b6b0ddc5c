"""Whether the spectral lines of a section keep their size: the motion on a cycle or a torus is a sum of constant lines.

Lines are found strongest first in the spectrum of what is left (CLEAN: Hoegbom, Astron. Astrophys. Suppl. 15 (1974) 417), all
signals sharing their frequencies, and fitted together by least squares. Then two models of the same lines are compared: constant
sizes, and sizes that change linearly over the record. On a torus the second explains no more than the first, however many lines
are left out of both; of a decay or growth it explains much more, and long before blocks of the record differ visibly.

Doubts: two lines less than about two turns in the record apart are one line that changes.
"""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

TAKEN: Final = (1, 1, 2, 4, 4)
"""Lines taken in each pass over the spectrum: few at first, so that the skirts of a changing line are not taken for lines."""

NEARBY: Final = 2.0
"""New lines keep this distance from known ones [turns per record]: nearer lies the main lobe of the Hann window."""

MERGED: Final = 1.0
"""Lines that come nearer than this in the fit are one [turns per record]."""

SLOWEST: Final = 0.4
"""Lines that turn less often in the record are the mean, which may change too."""

WEAK: Final = 1e-4
"""Lines below this share of the strongest (in power) wait for the next pass: they may be its side lobes."""

NOTHING: Final = 1e-9
"""What is left below this share of the motion is rounding."""

GAIN: Final = 2.5
"""Constant lines leaving so many times more than changing ones means drift: of 400 tori 99 in 100 had 2.1 and less, all of 327
slow decays and growths (time constants of 0.2 to 5 records) more."""


@dataclass(frozen=True)
class Lines:
    """Lines of a section and what they leave, each share a root mean square over that of the motion.

    ``turns`` are their frequencies [turns per period], shape [line]; ``constant`` is what is left by constant lines, ``changing``
    what is left by lines that change linearly, both after the pass in which they differ most; ``unexplained`` is what all lines
    leave as constant ones.
    """

    turns: Floats
    constant: float
    changing: float
    unexplained: float = 1.0

    @property
    def gain(self) -> float:
        """How many times more constant lines leave than changing ones."""
        return self.constant / self.changing

    @property
    def drift(self) -> float:
        """How much of the motion changing lines explain beyond constant ones, root mean square."""
        return math.sqrt(max(self.constant**2 - self.changing**2, 0.0))


def columns(turns: Floats, periods: int, *, change: bool) -> Floats:
    """Return the functions that lines and a mean are made of, shape [period, function].

    For each line a cosine and a sine, but at half a turn, where the sine vanishes, the cosine alone; with ``change`` all of them
    again times the time from the middle, -1 to 1 over the record.

    >>> columns(np.array([0.5]), 4, change=False).round(9).tolist()
    [[1.0, 1.0], [1.0, -1.0], [1.0, 1.0], [1.0, -1.0]]
    """
    n = np.arange(periods) - periods // 2
    angles = 2.0 * np.pi * np.outer(n, turns)
    waves = np.hstack([np.ones((periods, 1)), np.cos(angles), np.sin(angles[:, turns < 0.5])])
    return np.hstack([waves, waves * _time(periods)]) if change else waves


def _time(periods: int) -> Floats:
    return np.asarray(2.0 * (np.arange(periods) - periods // 2) / (periods - 1))[:, None]


def _fit(functions: Floats, samples: Floats) -> Floats:
    """Return the coefficients of least squares, shape [function, signal], by normal equations with a trace of damping."""
    square = functions.T @ functions
    square[np.diag_indices_from(square)] += 1e-13 * len(functions)
    return np.asarray(np.linalg.solve(square, functions.T @ samples))


def _left(functions: Floats, samples: Floats) -> Floats:
    return np.asarray(samples - functions @ _fit(functions, samples))


def _size(rest: Floats, taken: int) -> float:
    """Return the root mean square of a rest after a fit of so many functions."""
    return float(np.sqrt(np.sum(rest**2) / max(len(rest) - taken, 1)))


def _waves(fitted: Floats, turns: Floats) -> tuple[NDArray[np.complex128], NDArray[np.complex128]]:
    """Return the complex sizes of lines and their changes, shape [line, signal], from coefficients of changing lines."""
    both = turns < 0.5
    half, lines = len(fitted) // 2, len(turns)
    parts = []
    for start in (0, half):
        wave = fitted[start + 1 : start + 1 + lines].astype(np.complex128)
        wave[both] -= 1j * fitted[start + 1 + lines : start + half]
        parts.append(wave)
    return parts[0], parts[1]


def _sharpened(turns: Floats, samples: Floats, steps: int = 2) -> Floats:
    """Return frequencies nearer to the truth: a change at right angles to a line's size is an error of its frequency."""
    periods = len(samples)
    for _ in range(steps):
        sizes, changes = _waves(_fit(columns(turns, periods, change=True), samples), turns)
        across = np.sum((changes * sizes.conj()).imag, axis=1) / np.maximum(
            np.sum(np.abs(sizes) ** 2, axis=1), 1e-300
        )
        shift = across * 2.0 / (periods - 1) / (2.0 * np.pi)
        shift = np.where(turns < 0.5, np.clip(shift, -0.5 / periods, 0.5 / periods), 0.0)
        turns = _folded(turns + shift, periods)
    return _kept_apart(turns, periods)


def _settled(turns: Floats, samples: Floats, steps: int = 4) -> Floats:
    """Return the frequencies at which constant lines leave least, by Gauss and Newton's steps with the sizes fitted anew."""
    periods, time = len(samples), _time(len(samples))
    for _ in range(steps):
        functions = columns(turns, periods, change=False)
        fitted = _fit(functions, samples)
        rest = samples - functions @ fitted
        both, lines = turns < 0.5, len(turns)
        cosine, sine = functions[:, 1 : 1 + lines], np.zeros((periods, lines))
        sine[:, both] = functions[:, 1 + lines :]
        of_sine = np.zeros((lines, samples.shape[1]))
        of_sine[both] = fitted[1 + lines :]
        slopes = cosine[:, :, None] * of_sine - sine[:, :, None] * fitted[1 : 1 + lines]
        slopes = _left(functions, time * slopes.reshape(periods, -1)).reshape(slopes.shape)
        square = np.einsum("nls,nms->lm", slopes, slopes, optimize=True)
        against = np.einsum("nls,ns->l", slopes, rest, optimize=True)
        square[np.diag_indices_from(square)] += 1e-9 * np.trace(square) / lines + 1e-300
        shift = np.linalg.solve(square, against) * 2.0 / (periods - 1) / (2.0 * np.pi)
        turns = _folded(turns + np.clip(shift, -0.3 / periods, 0.3 / periods), periods)
    return turns


def _folded(turns: Floats, periods: int) -> Floats:
    """Return frequencies within 0 to 1/2; half a line from 1/2 nobody can tell from alternation."""
    turns = np.abs(turns)
    return np.where(turns > 0.5 - 0.5 / periods, 0.5, turns)


def _kept_apart(turns: Floats, periods: int) -> Floats:
    """Return the frequencies that are no repetition of an earlier one or of the mean."""
    kept: list[float] = []
    for turn in turns.tolist():
        if turn >= SLOWEST / periods and all(abs(turn - other) >= MERGED / periods for other in kept):
            kept.append(turn)
    return np.array(kept)


def _strongest(rest: Floats, known: Floats, most: int) -> Floats:
    """Return the frequencies of the strongest new lines in a rest's spectrum, at most ``most``."""
    periods = len(rest)
    size = 1 << (4 * periods - 1).bit_length()
    window = np.hanning(periods + 2)[1:-1, None]
    power = np.sum(np.abs(np.fft.rfft(rest * window, size, axis=0)) ** 2, axis=1)
    grid = np.arange(len(power)) / size
    found: list[float] = []
    first = 0.0
    for turn in (0.0, *known.tolist()):
        power[np.abs(grid - turn) < NEARBY / periods] = 0.0
    while len(found) < most:
        top = int(np.argmax(power))
        first = first or float(power[top])
        if power[top] <= WEAK * first:
            break
        found.append(float(grid[top]))
        power[np.abs(grid - grid[top]) < NEARBY / periods] = 0.0
    return np.array(found)


def find_lines(samples: Floats) -> Lines:
    """Return the lines of samples, shape [period, signal], and how much better changing ones explain them than constant ones.

    >>> n = np.arange(400.0)[:, None]
    >>> steady = find_lines(np.cos(0.7 * n) + 0.2 * np.cos(1.9 * n))
    >>> fading = find_lines(np.exp(-n / 2000.0) * np.cos(0.7 * n) + 0.2 * np.cos(1.9 * n))
    >>> steady.unexplained < 1e-6, round(float(steady.turns[0]) * 2.0 * np.pi, 6), fading.gain > 10.0
    (True, 0.7, True)
    """
    samples = samples - samples.mean(axis=0)
    periods, whole, turns = len(samples), _size(samples, 1), np.zeros(0)
    rest, best = samples, Lines(turns, 1.0, 1.0)
    for most in TAKEN:
        turns = np.concatenate([turns, _strongest(rest, turns, most)])
        turns = _kept_apart(_folded(turns, periods), periods)
        if turns.size:
            turns = _sharpened(turns, samples)
        found, rest = _compared(turns, samples, whole)
        best = max(best, found, key=_telling)
        if found.changing <= NOTHING:
            break
    return Lines(found.turns, best.constant, best.changing, found.constant)


def _telling(lines: Lines) -> tuple[float, float]:
    """Return how clearly lines change: by how much where `GAIN` says that they do, otherwise by their gain."""
    return (lines.drift if lines.gain >= GAIN else 0.0, lines.gain)


def _compared(turns: Floats, samples: Floats, whole: float) -> tuple[Lines, Floats]:
    """Return what lines leave as constant and as changing ones, and the rest of the latter."""
    periods, least, taken = len(samples), NOTHING * whole, 1 + 2 * len(turns)
    rest = _left(columns(turns, periods, change=True), samples)
    settled = _settled(turns, samples) if turns.size else turns
    constant = _size(_left(columns(settled, periods, change=False), samples), taken)
    again = _size(_left(columns(settled, periods, change=True), samples), 2 * taken)
    changing = min(_size(rest, 2 * taken), again)
    return Lines(settled, max(constant, least) / whole, max(changing, least) / whole), rest
