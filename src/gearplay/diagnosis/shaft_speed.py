"""Speed of the first shaft from the lines of the record: the nominal one may be off by some per cent."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from gearplay.diagnosis.machine import Gear, Machine, Mesh, Shaft
from gearplay.files.record import Channel
from gearplay.results.spectra import Spectrum, amplitude_spectrum
from gearplay.signals.lines import find_line

Floats = NDArray[np.float64]

SEARCH: Final = 0.025
"""Relative half width of the range searched: 2 % and some margin."""
HARMONICS: Final = 4
"""Harmonics of each mesh in the comb."""
TURNS: Final = 3
"""Multiples of the turns of each shaft in the comb."""
STANDS_OUT: Final = 8.0
"""Amplitude of a line over the median of its surroundings, from which it fixes the speed."""
LOCATED: Final = 0.67
"""Standard deviation of the place of a line, in lines of the spectrum, times its amplitude over the median around."""
NO_LINE: Final = (
    f"none of the first {HARMONICS} mesh harmonics and {TURNS} multiples of a turn is {STANDS_OUT:g} times above the lines "
    "around it"
)

SOURCES: Final = {
    "mesh": "by its mesh lines",
    "shaft": "by the lines of its turns",
    "measured": "as measured, with its deviation over the record",
    "envelope": "by its turns in an envelope",
    "nominal": f"as given, since {NO_LINE}",
}
"""How a speed was found, as text."""


@dataclass(frozen=True)
class FoundSpeed:
    """Speed of the first shaft [Hz], its standard uncertainty [Hz], and ``source``.

    That is "mesh", "shaft", "measured", "envelope" (turns in an envelope, too coarse for averages over turns) or "nominal". Of a
    measured one, whose sensor's uncertainty is not known, the ``uncertainty`` is the standard deviation over the record.
    """

    frequency: float
    uncertainty: float
    source: str

    @property
    def known(self) -> bool:
        """Whether the lines of the spectrum, or a speed channel, fix the speed."""
        return self.source not in ("nominal", "envelope")

    @property
    def seen(self) -> bool:
        """Whether the record shows the speed, if only in an envelope."""
        return self.source != "nominal"

    @property
    def kind(self) -> str:
        """What the uncertainty is, as text."""
        return "standard deviation over the record" if self.source == "measured" else "standard uncertainty"

    @property
    def words(self) -> str:
        """Speed and uncertainty [rpm], to two of its digits, with how they were found.

        >>> FoundSpeed(29.950123, 0.00021, "shaft").words, FoundSpeed(25.0, 0.5, "envelope").words
        ('1797.007 ± 0.013 rpm, by the lines of its turns', '1500 ± 30 rpm, by its turns in an envelope')
        """
        rpm, off = 60.0 * self.frequency, 60.0 * self.uncertainty
        if off < 1e-9 * rpm:
            return f"{rpm:.9g} rpm, {SOURCES[self.source]}"
        places = max(0, 1 - math.floor(math.log10(off)))
        return f"{rpm:.{places}f} ± {off:.{places}f} rpm, {SOURCES[self.source]}"


def floor_of(power: Floats, block: int = 10, blocks: int = 11) -> Floats:
    """Return the median of ``power`` around each line: the median of the medians of blocks of lines, interpolated."""
    from scipy.ndimage import median_filter

    count = max(1, power.size // block)
    middle = np.median(power[: count * block].reshape(count, -1), axis=1)
    level = median_filter(middle, size=min(blocks, count), mode="reflect")
    places = (np.arange(count) + 0.5) * (power.size // count) - 0.5
    largest = float(np.max(power, initial=0.0))
    return np.asarray(np.maximum(np.interp(np.arange(power.size), places, level), 1e-24 * largest + 1e-300))


def found_speed(spectrum: Spectrum, machine: Machine, nominal: float) -> FoundSpeed:
    """Return the speed of greatest prominence of the mesh harmonics, else of the shaft orders.

    The comb is summed in logarithms, so that one strong neighbour, as a sideband, does not win; the lines that stand out are then
    located between the bins, and weighed by their order.
    """
    resolution = spectrum.resolution
    top = float(spectrum.frequency[-1]) / (1.0 + SEARCH) - 4.0 * resolution
    mesh = machine.mesh_lines(HARMONICS)
    shaft = [k * each.order for each in machine.shafts for k in range(1, TURNS + 1)]
    for source, own, more in (("mesh", mesh, shaft[:2]), ("shaft", shaft, [])):
        low = 3.0 * resolution / (1.0 - SEARCH)
        orders = np.array(sorted({o for o in own if low < o * nominal < top}))
        if not orders.size:
            continue
        beside = np.array([o for o in more if low < o * nominal < top])
        at = _best(spectrum, orders, beside, nominal)
        found = located(spectrum, orders, at)
        if found is not None:
            return FoundSpeed(*found, source)
    return FoundSpeed(nominal, 0.02 * nominal, "nominal")


def speed_of_gear(channel: Channel, teeth: int, nominal: float) -> FoundSpeed:
    """Return the speed of a shaft with a gear, near a nominal one [Hz], from the lines of a signal: see `found_speed`."""
    machine = Machine(
        (Shaft("shaft", 1.0),), (Gear("gear", teeth, 1.0, 0),), (Mesh("mesh", float(teeth), (0,)),)
    )
    values = channel.values - np.mean(channel.values)
    return found_speed(amplitude_spectrum(values, channel.sampling, unit=channel.unit), machine, nominal)


def _best(spectrum: Spectrum, orders: Floats, beside: Floats, nominal: float) -> float:
    """Return the speed [Hz] of the highest comb."""
    power = spectrum.amplitude**2
    height = np.log1p(power / floor_of(power))
    step = 0.25 * spectrum.resolution / float(orders[-1])
    count = min(400_000, math.ceil(2.0 * SEARCH * nominal / step) + 1)
    speeds = np.linspace((1.0 - SEARCH) * nominal, (1.0 + SEARCH) * nominal, count)
    lines = np.arange(power.size)
    total = np.zeros(count)
    for weight, some in ((1.0, orders), (0.3, beside)):
        for order in some:
            total += weight * np.interp(speeds * order / spectrum.resolution, lines, height)
    # Of equal combs the one nearest to the nominal speed.
    total -= 1e-6 * np.abs(speeds / nominal - 1.0)
    return float(speeds[int(np.argmax(total))])


def located(spectrum: Spectrum, orders: Floats, speed: float) -> tuple[float, float] | None:
    """Return speed and uncertainty [Hz] from the prominent lines, None without any."""
    power = spectrum.amplitude**2
    level = np.sqrt(floor_of(power))
    values, weights = [], []
    for order in orders:
        expected = order * speed
        at = round(expected / spectrum.resolution)
        if not 3 <= at < power.size - 3:
            continue
        near = slice(at - 1, at + 2)
        if float(np.max(spectrum.amplitude[near] / level[near])) < STANDS_OUT:
            continue
        line = find_line(spectrum, expected, search=1e-9)
        if abs(line.frequency - expected) > 1.6 * spectrum.resolution:
            continue
        values.append(line.frequency / order)
        weights.append((order * min(line.amplitude / float(level[at]), 1e3)) ** 2)
    if not values:
        return None
    w = np.array(weights)
    mean = float(np.average(values, weights=w))
    own = LOCATED * spectrum.resolution / math.sqrt(float(np.sum(w)))
    # Lines further apart than that, as of a speed that drifts, raise it (Birge).
    scatter = math.sqrt(
        float(np.average((np.array(values) - mean) ** 2, weights=w)) / max(1, len(values) - 1)
    )
    return mean, max(own, scatter, 1e-9 * mean)
