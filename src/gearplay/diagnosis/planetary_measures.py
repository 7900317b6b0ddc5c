"""Measures of planetary sets: lines of uneven planets and eccentric gears, events of a tooth of the standing ring."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import count, islice
from typing import Final

import numpy as np
from numpy.typing import NDArray

from gearplay.diagnosis.planetary_set import LOUD, PlanetarySet
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
NOISE: Final = 1.5
"""Amplitude of noise, as the largest of three lines, over its median."""
SIDE: Final = 0.25
"""Width on either side of mesh harmonics that the passing planets fill, of the mesh frequency."""
BESIDE: Final = (1.5, 6.0)
"""Distance of the teeth with which an event of a ring's tooth is compared, in pitches."""


@dataclass(frozen=True)
class SetMeasure:
    """Measures of a planetary set at a fixed sensor, nan where the record cannot show them.

    ``uneven``, ``sun`` and ``planet`` are the lines of uneven planets, of an eccentric sun and of an eccentric planet over those
    of like planets, root sums of squares [1]; ``ring`` the rms of the event of a tooth of the standing ring over that of the
    teeth beside it and the noise [1].
    """

    uneven: float
    sun: float
    planet: float
    ring: float

    def rows(self) -> dict[str, float]:
        """Return the measures that the record can show, by what they measure."""
        found = {"uneven planets": self.uneven, "an eccentric sun": self.sun, "an eccentric planet": self.planet,
                 "a tooth of the ring": self.ring}  # fmt: skip
        return {name: value for name, value in found.items() if math.isfinite(value)}


def set_measure(each: PlanetarySet, spectrum: Spectrum, f: float, average: ShaftAverage | None) -> SetMeasure:
    """Return the measures of a set at a speed of the first shaft [Hz]; ``average`` is that over the carrier's turn."""
    power = spectrum.amplitude**2
    level = floor_of(power)

    def lines(orders: Sequence[float]) -> Floats:
        """Return the powers of the lines that the spectrum has, and the level around, shape [2, line]."""
        at = np.rint(np.array(orders) * f / spectrum.resolution).astype(int)
        at = at[(at >= 3) & (at < power.size - 3)]
        return np.stack([np.max([power[at - 1], power[at], power[at + 1]], axis=0), level[at]])

    def total(orders: Sequence[float]) -> float:
        """Return the power of lines above that of noise, of which the largest of three bins is taken."""
        own, around = lines(orders)
        return float(np.sum(np.maximum(own - NOISE**2 * around, 0.0)))

    def stands(h: int) -> bool:
        own, around = lines(each.alike(h))
        return bool(np.any(own > STANDS_OUT**2 * around))

    kept = [h for h in range(1, HARMONICS + 1) if stands(h)]
    like = sum(total(each.alike(h)) for h in kept)

    def ratio(orders: Callable[[int], Sequence[float]], apart: float) -> float:
        """Return the lines over those of like planets; nan where other lines lie nearer than ``apart``, an order."""
        if not any(orders(h) for h in kept) or apart * f < APART * spectrum.resolution:
            return math.nan
        return math.sqrt(sum(total(orders(h)) for h in kept) / like)

    return SetMeasure(
        ratio(each.uneven, each.apart("uneven")),
        ratio(each.eccentric_sun, each.apart("sun")),
        ratio(each.eccentric_planet, each.apart("planet")),
        math.nan if average is None else _ring_event(average, each),
    )


def tooth_pattern(each: PlanetarySet, k: int, f: float, harmonics: int) -> list[tuple[float, float]]:
    """Return the envelope lines of a damaged tooth of sun or planet, gear ``k``: multiples, and modulation by its place [Hz].

    A tooth of a planet is carried past the sensor with the carrier; one of the sun meets planets all around, with its own turns.
    """
    turn = each.carrier if k == each.gears[1] else each.carrier + each.sun
    plain = [float(h) for h in range(1, harmonics + 1)]
    if k != each.gears[1]:  # it meets planets at their angles: multiples of its turn against the carrier
        multiples = (m for m in count(1) if each.sum_at(m) >= LOUD)
        plain = [m / each.planets for m in islice(multiples, harmonics)]
    return [
        *((h, 0.0) for h in plain),
        *((h, side * turn * f) for h in plain[:2] for side in (-1.0, 1.0)),
    ]


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
        rolled = [np.roll(mean, round(angle / (2.0 * math.pi) * size)) for angle in each.angles]
        return np.asarray(np.mean(rolled, axis=0))

    shared, noise = np.maximum(over_pitch(even * odd), 0.0), over_pitch((0.5 * (even - odd)) ** 2)
    at = int(np.argmax(shared))
    near = np.arange(*(round(times * pitch) for times in BESIDE))
    beside = np.concatenate([shared[(at + near) % size], shared[(at - near) % size]])
    floor = float(np.median(beside)) + float(np.median(noise))
    return math.sqrt(float(shared[at]) / floor) if floor > 0.0 else 0.0
