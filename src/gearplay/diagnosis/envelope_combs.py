"""Periodic impacts in a random signal: combs in the spectra of squared envelopes of many bands."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

from gearplay.diagnosis.shaft_speed import floor_of
from gearplay.files.record import Channel

Floats = NDArray[np.float64]

COUNTS: Final = (1, 2, 3, 4, 6, 8, 12, 16)
"""Numbers of equal bands tried, the halves and thirds of a fast kurtogram."""
FALSE_ALARM: Final = 1e-4
"""Probability that noise alone reaches the sum of prominences called chance."""
LEAST_LINES: Final = 64
"""Lines of the record that a band must hold."""
STANDS: Final = 7.0
"""Prominence from which a line stands out: noise reaches it once in a thousand lines."""
FLANK: Final = 4
"""Most lines to either side of a peak that belong to it: two of the window, and as many where elements slip."""


@dataclass(frozen=True)
class BandEnvelope:
    """Spectrum of the squared envelope of a band [Hz], in units of its mean: ``amplitude`` is the depth of modulation [1].

    ``prominence`` is the power of each line over the median around, ``kurtosis`` that of the envelope's analytic signal minus 2
    (Antoni: noise 0).
    """

    low: float
    high: float
    resolution: float
    amplitude: Floats
    prominence: Floats
    kurtosis: float


@dataclass(frozen=True)
class Comb:
    """Comb of harmonics in one band: its frequency [Hz] and relative distance from the expected one [1].

    ``prominence`` is their summed power over that of noise [1], ``chance`` the sum that noise alone exceeds in one of
    1 / `FALSE_ALARM` records, over all places and bands tried; ``depth`` of the highest line [1]; ``low`` and ``high`` [Hz].
    """

    frequency: float
    prominence: float
    chance: float
    depth: float
    off: float = 0.0
    low: float = 0.0
    high: float = 0.0

    @property
    def height(self) -> float:
        """Prominence relative to that expected of noise."""
        return self.prominence / self.chance


def band_envelopes(channel: Channel, least: float) -> list[BandEnvelope]:
    """Return the envelopes of all bands that are at least ``least`` wide [Hz], from 2.5 to 40 % of the sampling rate."""
    n, sampling = channel.size, channel.sampling
    transform = np.fft.rfft(channel.values - np.mean(channel.values))
    resolution = sampling / n
    first, last = 0.0125 * sampling, 0.4 * sampling
    found = []
    for count in COUNTS:
        for low, high in pairwise(np.linspace(first, last, count + 1)):
            lines = transform[math.ceil(low / resolution) : math.floor(high / resolution)]
            if high - low < least or lines.size < LEAST_LINES:
                continue
            square = np.abs(np.fft.ifft(lines)) ** 2
            mean = float(np.mean(square))
            if mean <= 0.0:
                continue
            relative = square / mean
            # A Hann window on the envelope: its lines are then two bins wide.
            window = np.hanning(relative.size + 1)[:-1]
            amplitude = 2.0 * np.abs(np.fft.rfft((relative - 1.0) * window)) / float(np.sum(window))
            power = amplitude**2
            prominence = power / (floor_of(power) / math.log(2.0))
            kurtosis = float(np.mean(relative**2)) - 2.0
            found.append(BandEnvelope(float(low), float(high), resolution, amplitude, prominence, kurtosis))
    return found


def best_comb(
    bands: Sequence[BandEnvelope],
    frequency: float,
    pattern: Sequence[tuple[float, float]],
    *,
    search: float = 0.0,
    without: Floats | None = None,
    peaks: Floats | None = None,
    balanced: Literal["multiples", "lines"] | None = None,
) -> Comb:
    """Return the comb of greatest prominence over all bands, its frequency within ``frequency`` (1 -+ ``search``) [Hz].

    ``pattern`` holds for each line its multiple of the frequency and an offset [Hz]; lines nearer than 1.5 bins to one of
    ``without`` [Hz], which belong to another source, do not count; nor does what stands out at ``peaks`` [Hz], as far as it
    falls off. ``balanced`` counts the highest of the multiples, each with its offsets, or of the lines at most as much as all
    others together.
    """
    best = Comb(frequency, 0.0, 1.0, 0.0)
    for band in bands:
        width = 0.45 * (band.high - band.low)
        usable = [
            (k, offset) for k, offset in pattern if 2.0 * band.resolution < k * frequency + offset < width
        ]
        if not usable:
            continue
        top = max(k for k, _ in usable)
        count = math.ceil(2.0 * search * frequency * top / (0.5 * band.resolution)) + 1
        trial = (
            np.linspace(1.0 - search, 1.0 + search, count) * frequency if count > 1 else np.array([frequency])
        )
        total = np.zeros(trial.size)
        shares: dict[float | tuple[float, float], Floats] = {}
        prominence = np.minimum(band.prominence, 1e5)
        if peaks is not None:
            prominence = np.where(_peaks(peaks / band.resolution, band.prominence), 0.0, prominence)
        taken = _taken(without, band) if without is not None else None
        for k, offset in usable:
            at = np.rint((k * trial + offset) / band.resolution).astype(int)
            at = np.clip(at, 1, prominence.size - 2)
            height = np.maximum(prominence[at], np.maximum(prominence[at - 1], prominence[at + 1]))
            if taken is not None:
                height = np.where(taken[at], 0.0, height)
            total += height
            share = k if balanced == "multiples" else (k, offset)
            shares[share] = shares.get(share, 0.0) + height
        alone = balanced == "lines" and len(shares) < 2  # nothing to be balanced with
        if balanced is not None and not alone:  # one that stands out may be of any comb
            total = np.minimum(total, 2.0 * (total - np.max([*shares.values()], axis=0)))
        at_best = _middle(total)
        chance = _chance(len(usable), count * len(bands))
        if total[at_best] / chance > best.height:
            places = np.array([round((k * trial[at_best] + o) / band.resolution) for k, o in usable])
            near = np.clip(places[:, None] + np.arange(-1, 2), 1, prominence.size - 1)
            depth = float(np.max(band.amplitude[near]))
            at_frequency = float(trial[at_best])
            best = Comb(
                at_frequency,
                float(total[at_best]),
                chance,
                depth,
                at_frequency / frequency - 1.0,
                band.low,
                band.high,
            )
    return best


def _middle(total: Floats) -> int:
    """Return the middle of the first run of greatest values: neighbouring trials meet the same lines."""
    first = int(np.argmax(total))
    below = np.flatnonzero(total[first:] < total[first])
    return first + (int(below[0]) if below.size else total.size - first) // 2


def _chance(lines: int, trials: int) -> float:
    """Return the limit of a sum of prominences that noise exceeds in any of the trials with probability `FALSE_ALARM`.

    Each is the largest of three lines two wide, about 1.5 times an exponentially distributed one.
    """
    from scipy.special import gammainccinv

    return 1.5 * float(gammainccinv(lines, FALSE_ALARM / trials))


def _taken(without: Floats, band: BandEnvelope) -> NDArray[np.bool_]:
    """Return which lines of a band's envelope belong to other sources."""
    found = np.zeros(band.prominence.size, dtype=bool)
    places = without[without < band.resolution * (found.size - 2)] / band.resolution
    for shift in (-1.0, 0.0, 1.0):
        found[np.clip(np.rint(places + shift).astype(int), 0, found.size - 1)] = True
    return found


def _peaks(places: Floats, prominence: Floats) -> NDArray[np.bool_]:
    """Return which lines are peaks within one line of ``places`` [lines] that stand out, down to the next minimum."""
    found = np.zeros(prominence.size, dtype=bool)
    for at in np.unique(np.rint(places).astype(int)):
        if not 1 < at < prominence.size - 2:
            continue
        top = int(at - 1 + np.argmax(prominence[at - 1 : at + 2]))
        if prominence[top] < STANDS:
            continue
        for step in (-1, 1):
            k = top
            found[k] = True
            while (
                0 < k < prominence.size - 1 and abs(k - top) < FLANK and prominence[k + step] < prominence[k]
            ):
                k += step
                found[k] = True
    return found
