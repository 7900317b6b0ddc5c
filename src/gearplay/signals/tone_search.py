"""Sequential detection of tones, strongest first, with a joint fit after each."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gearplay.signals.tone_fit import (
    REACH,
    Complexes,
    Indices,
    Transform,
    covariance,
    fit_tones,
    kernel,
    model,
)

Floats = NDArray[np.float64]

SIDE = 64  # lines on each side from which the noise around a line is taken
MARGIN = 24  # lines beyond a searched band in which neighbours are searched
RANGE = 1e-10  # of the strongest line: below lies rounding
LOBES = {
    1: 20_000,
    2: 1000,
    3: 1000,
}  # lines to which side lobes reach, by the number of the window's cosines
LOBE = 2  # lines on each side of a tone that hold nearly all of it


@dataclass(frozen=True)
class Tone:
    """A tone fitted: ``place`` [lines], complex half ``amplitude``, covariance of (place, real, imaginary), shape [3, 3].

    ``noise`` is the expected power of noise on a line nearby, ``explained`` the share of power around it that it explains.
    """

    place: float
    amplitude: complex
    covariance: Floats
    noise: float
    explained: float


class _Zone:
    """A searched range of lines: its tones, and its part of the residual of the transform after all zones' tones."""

    def __init__(self, transform: Transform, left: Complexes, first: int, last: int, floor: float) -> None:
        low, high = max(1, first - SIDE), min(transform.lines.size - 2, last + SIDE)
        self.transform, self.first, self.last, self.floor = transform, first, last, floor
        self.at: Indices = np.arange(low, high + 1)
        self.everywhere, self.left = left, left[low : high + 1]
        self.places: list[float] = []
        self.amplitudes: list[complex] = []

    def noise(self) -> Floats:
        """Return the expected power of noise on each line: the local median of the residual, over ln 2.

        A line's power is exponentially distributed, its median ln 2 times its mean; tones left over hardly move a median.
        """
        from scipy.ndimage import median_filter

        power = np.abs(self.left) ** 2
        for place in self.places:  # lines reduced by the fit are lower than the noise
            power[self._near(place, LOBE)] = np.nan
        kept = np.isfinite(power)
        level = np.full(power.size, self.floor)
        if np.any(kept):
            median = median_filter(power[kept], size=2 * SIDE + 1, mode="reflect") / math.log(2.0)
            level = np.interp(self.at, self.at[kept], median)
        return np.asarray(np.maximum(level, self.floor))

    def candidates(self, threshold: float) -> Indices:
        """Return the places in ``at`` of lines that stand out over the noise by ``threshold`` in power, local maxima only.

        Weaker ones than a thousandth of the strongest wait for the next pass: they may be its side lobes.
        """
        from scipy.ndimage import maximum_filter1d

        power = np.abs(self.left) ** 2
        inside = (self.at >= self.first) & (self.at <= self.last) & (power > threshold * self.noise())
        inside[1:-1] &= (power[1:-1] >= power[:-2]) & (power[1:-1] > power[2:])
        inside[[0, -1]] = False
        for place in self.places:
            inside[self._near(place, LOBE)] = False
        masked = np.where(inside, power, 0.0)
        top = masked == maximum_filter1d(masked, 4 * REACH + 1, mode="constant")
        return np.flatnonzero(inside & top & (masked > 1e-6 * masked.max()))

    def _near(self, place: float, reach: int) -> slice:
        """Return the slice of ``at`` with the lines at most ``reach`` from a place."""
        low, high = math.ceil(place - reach) - self.at[0], math.floor(place + reach) - self.at[0]
        return slice(int(max(0, low)), int(max(0, high + 1)))

    def _add(self, member: int, sign: float) -> None:
        """Add a tone to the residual, in all zones, or subtract it, as far as its side lobes matter."""
        reach, middle = LOBES[len(self.transform.cosines)], round(self.places[member])
        low, high = max(1, middle - reach), min(self.transform.lines.size - 2, middle + reach)
        place, amplitude = np.array([self.places[member]]), np.array([self.amplitudes[member]])
        tone = model(place, amplitude, np.arange(low, high + 1), self.transform)[0]
        self.everywhere[low : high + 1] += sign * tone

    def take(self, index: int) -> None:
        """Add a tone at a line and fit it again together with its neighbours."""
        near = np.abs(self.left[index - 1 : index + 2])
        place = float(self.at[index]) + _between(near[0], near[1], near[2], self.transform)
        self.places.append(place)
        self.amplitudes.append(0.0j)
        self.fit(self.group(len(self.places) - 1), steps=6)

    def search(self, threshold: float, most: int) -> None:
        """Take tones until none stands out, at most ``most``."""
        while len(self.places) < most:
            indices = self.candidates(threshold)[: most - len(self.places)]
            if indices.size == 0:
                break
            for index in indices:
                self.take(int(index))

    def group(self, member: int) -> list[int]:
        """Return the tones whose fitted lines touch those of ``member``."""
        place = self.places[member]
        return [i for i, other in enumerate(self.places) if abs(other - place) <= 2 * REACH]

    def lines_of(self, group: list[int]) -> Indices:
        """Return the indices in ``at`` of the lines that the fit of a group uses."""
        every = np.arange(self.at.size)
        return np.unique(np.concatenate([every[self._near(self.places[i], REACH)] for i in group]))

    def fit(self, group: list[int], *, steps: int = 30) -> None:
        """Fit a group of tones jointly to the residual of the others."""
        for i in group:
            self._add(i, 1.0)
        seen = self.lines_of(group)
        places = np.array([self.places[i] for i in group])
        found, amplitudes = fit_tones(self.left[seen], places, self.at[seen], self.transform, steps=steps)
        for i, f, a in zip(group, found, amplitudes, strict=True):
            self.places[i], self.amplitudes[i] = float(f), complex(a)
            self._add(i, -1.0)

    def tone(self, member: int, noise: Floats) -> Tone:
        """Return one tone with its uncertainty."""
        group = self.group(member)
        seen = self.lines_of(group)
        places, amplitudes = np.array(self.places)[group], np.array(self.amplitudes)[group]
        full = covariance(places, amplitudes, self.at[seen], noise[seen], self.transform)
        k, m = group.index(member), len(group)
        own = full[np.ix_([k, m + k, 2 * m + k], [k, m + k, 2 * m + k])]
        at = int(np.argmin(np.abs(self.at - self.places[member])))
        lobe = slice(max(0, at - LOBE - 1), at + LOBE + 2)
        itself = model(places[k : k + 1], amplitudes[k : k + 1], self.at[lobe], self.transform)[0]
        left = float(np.sum(np.abs(self.left[lobe]) ** 2))
        held = float(np.sum(np.abs(itself + self.left[lobe]) ** 2))
        return Tone(self.places[member], self.amplitudes[member], own, float(noise[at]), 1.0 - left / held)


def _between(left: float, peak: float, right: float, transform: Transform) -> float:
    """Return the offset of an isolated tone from its highest line [lines], from the ratio of the neighbours."""
    trial = np.linspace(-0.5, 0.5, 41)
    shape = [np.abs(kernel(trial - j, transform.n, transform.cosines)) for j in (-1, 0, 1)]
    against = (shape[2] - shape[0]) / shape[1]
    return float(np.interp((right - left) / peak, against, trial))


def _merged(bands: list[tuple[int, int]], last: int) -> list[tuple[int, int, int]]:
    """Return (first line, last line, number of bands) of the joined bands with their margins."""
    zones: list[tuple[int, int, int]] = []
    for low, high in sorted(bands):
        low, high = max(2, low - MARGIN), min(last, high + MARGIN)
        if zones and low <= zones[-1][1] + 2 * REACH:
            zones[-1] = (zones[-1][0], max(high, zones[-1][1]), zones[-1][2] + 1)
        else:
            zones.append((low, high, 1))
    return zones


def find_tones(
    transform: Transform, bands: list[tuple[int, int]], false_alarm: float
) -> tuple[list[Tone], Floats]:
    """Return the tones in and around the ``bands`` of lines, and the mean power of noise on a line of each band.

    Noise alone exceeds p times its mean power on one of n lines with probability n exp(-p); p follows from ``false_alarm``.
    The strongest lines above that are taken, all tones near them are fitted again, and the search continues in the residual
    (CLEAN: Hoegbom, Astron. Astrophys. Suppl. 15 (1974) 417), up to 4 tones a band and 6 more.
    """
    floor = (RANGE * float(np.max(np.abs(transform.lines)))) ** 2
    level, left = np.full(len(bands), floor), transform.lines.copy()
    if floor == 0.0:
        return [], level
    ranges = _merged(bands, transform.lines.size - 3)
    zones = [_Zone(transform, left, first, last, floor) for first, last, _ in ranges]
    for _ in range(2):  # again once the side lobes of the other zones' tones are off
        for zone, (first, last, count) in zip(zones, ranges, strict=True):
            zone.search(power_threshold(last - first + 1, false_alarm), 6 + 4 * count)
    for zone in zones * 2:
        for i in range(len(zone.places)):
            zone.fit(zone.group(i))
    tones = []
    for zone in zones:
        noise = zone.noise()
        tones += [zone.tone(i, noise) for i in range(len(zone.places))]
        for i, (low, high) in enumerate(bands):
            if zone.first <= low and high <= zone.last:
                level[i] = float(np.median(noise[(zone.at >= low) & (zone.at <= high)]))
    return tones, level


def power_threshold(lines: int, false_alarm: float) -> float:
    """Return the power over its mean that noise exceeds on any of a number of lines with probability ``false_alarm``.

    >>> round(power_threshold(100, 0.1), 6) == round(math.log(1000.0), 6)
    True
    """
    return math.log(max(lines, 1) / false_alarm)
