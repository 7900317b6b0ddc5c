"""Measures of planetary sets: lines of unlike planets and of an eccentric sun, events of a tooth of the standing ring."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from gearplay.diagnosis.machine import PlanetarySet
from gearplay.diagnosis.separation import ShaftAverage
from gearplay.diagnosis.shaft_speed import floor_of
from gearplay.results.spectra import Spectrum

Floats = NDArray[np.float64]

HARMONICS: Final = 4
"""Mesh harmonics whose lines are taken together."""
STANDS_OUT: Final = 4.0
"""Amplitude of the strongest line of like planets over the level around, from which a harmonic counts."""
APART: Final = 3.0
"""Least distance of two lines that can be told apart, in lines of the spectrum."""
SIDE: Final = 0.25
"""Width on either side of mesh harmonics that the passing planets fill, of the mesh frequency."""
BESIDE: Final = (1.5, 6.0)
"""Distance of the teeth with which an event of a ring's tooth is compared, in pitches."""


@dataclass(frozen=True)
class SetMeasure:
    """Measures of a planetary set at a fixed sensor, nan where the record cannot show them.

    ``unlike`` and ``eccentric`` are the lines of unlike planets and of an eccentric sun over those of like planets, root sums of
    squares [1]; ``ring`` the rms of the event of a tooth of the standing ring over that of the teeth beside it and the noise [1].
    """

    unlike: float
    eccentric: float
    ring: float


def set_measure(each: PlanetarySet, spectrum: Spectrum, f: float, average: ShaftAverage | None) -> SetMeasure:
    """Return the measures of a set at a speed of the first shaft [Hz]; ``average`` is that over the carrier's turn."""
    harmonics = [(each.alike(h), each.unlike(h), each.eccentric(h)) for h in range(1, HARMONICS + 1)]
    power = spectrum.amplitude**2
    level = floor_of(power)

    def heights(orders: Sequence[float]) -> Floats:
        """Return the powers of lines above the level, and 0 for those beyond the spectrum."""
        at = np.rint(np.array(orders) * f / spectrum.resolution).astype(int)
        inside = (at >= 3) & (at < power.size - 3)
        at = np.where(inside, at, 3)
        near = np.maximum(power[at], np.maximum(power[at - 1], power[at + 1]))
        return np.where(inside, np.maximum(near - (1.5**2) * level[at], 0.0), 0.0)

    kept = []
    for alike, *others in harmonics:
        at = np.clip(np.rint(np.array(alike) * f / spectrum.resolution).astype(int), 3, power.size - 4)
        if np.max(heights(alike) / level[at]) > STANDS_OUT**2:
            kept.append((alike, *others))
    total = sum(float(np.sum(heights(alike))) for alike, _, _ in kept)

    def ratio(place: int) -> float:
        return (
            math.sqrt(sum(float(np.sum(heights(lines[place]))) for lines in kept) / total)
            if kept
            else math.nan
        )

    turn = each.carrier * f / spectrum.resolution
    between = abs(each.sun / each.carrier - round(each.sun / each.carrier)) * turn
    return SetMeasure(
        ratio(1) if turn > APART else math.nan,
        ratio(2) if min(between, turn) > APART else math.nan,
        math.nan if average is None else _ring_event(average, each),
    )


def _ring_event(found: ShaftAverage, each: PlanetarySet) -> float:
    """Return the event of a ring's tooth: what passes with every planet, in one pitch, and is no modulation of the mesh."""
    size, z = found.average.size, each.teeth
    if size < 8 * z:
        return math.nan
    order = np.arange(size // 2 + 1)
    smooth = np.abs(order / z - np.round(order / z)) <= SIDE
    halves = []
    for half in found.halves:
        transform = np.fft.rfft(half)
        transform[smooth] = 0.0
        halves.append(np.fft.irfft(transform, size))
    even, odd = halves
    pitch = max(1, round(size / z))

    def over_pitch(x: Floats) -> Floats:
        """Return the mean over a pitch and over the planets, which pass alike."""
        total = np.cumsum(np.concatenate([x, x[:pitch]]))
        mean = (total[pitch:] - total[:-pitch]) / pitch
        rolled = [np.roll(mean, -round(k * size / each.planets)) for k in range(each.planets)]
        return np.asarray(np.mean(rolled, axis=0))

    shared, noise = np.maximum(over_pitch(even * odd), 0.0), over_pitch((0.5 * (even - odd)) ** 2)
    at = int(np.argmax(shared))
    near = np.arange(*(round(times * pitch) for times in BESIDE))
    beside = np.concatenate([shared[(at + near) % size], shared[(at - near) % size]])
    floor = float(np.median(beside)) + float(np.median(noise))
    return math.sqrt(float(shared[at]) / floor) if floor > 0.0 else 0.0
