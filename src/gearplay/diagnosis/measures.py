"""Measures of a record from which hypotheses are weighed: tooth events, modulation, combs of envelopes."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from gearplay.diagnosis.bearing_combs import bearing_combs, turns_of_envelopes
from gearplay.diagnosis.envelope_combs import BandEnvelope, Comb, band_envelopes, best_comb
from gearplay.diagnosis.machine import Gear, Machine
from gearplay.diagnosis.planetary_measures import SetMeasure, set_measure, tooth_pattern
from gearplay.diagnosis.quantisation import is_quantisation
from gearplay.diagnosis.separation import Separation, ShaftAverage, separated
from gearplay.diagnosis.shaft_speed import FoundSpeed
from gearplay.files.record import Channel
from gearplay.results.spectra import amplitude_spectrum
from gearplay.signals.envelopes import envelope
from gearplay.signals.indicators import GearIndicators, gear_indicators, split_average
from gearplay.signals.statistics import SignalStatistics, signal_statistics

Floats = NDArray[np.float64]

MODULATED: Final = 4
"""Mesh harmonics whose sidebands are taken together."""
CARRIER: Final = 4.0
"""Amplitude of a mesh harmonic over the level around, from which its sidebands count."""


@dataclass(frozen=True)
class GearMeasure:
    """Measures of one gear from the average over its turns.

    ``event`` is the rms of the difference signal in the pitch where it is largest, as both halves of the record agree on it, over
    that of the rest of the turn and the noise [1]; ``size`` that rms [unit]; ``tooth`` its place, counted from the start of the
    record; ``modulation`` the sum of both first sidebands over the mesh harmonics, above the sidebands further out [1].
    ``average`` over one turn [unit], shape [sample].
    """

    indicators: GearIndicators
    event: float
    size: float
    tooth: int
    modulation: float
    turns: int
    average: Floats


@dataclass(frozen=True)
class Measures:
    """Measures of one record: statistics, gears by index, bearings' parts by (bearing, part), combs of the random residual.

    ``mesh`` has for each mesh the comb of the envelope of ``rest``, what repeats with no shaft; ``events`` that of the gears of
    planetary sets, whose turns are not averaged; ``sets`` further measures of the sets. ``impulsive`` is the kurtosis of the most
    impulsive ``band`` [Hz] of the rest, less that of noise, in the quarter of the record where it is least; ``waveform`` that of
    the mean mesh period; ``rest_share`` the part of the rest in the mean square; ``step`` that of quantisation [unit], 0.0 where
    the record shows none.
    """

    speed: FoundSpeed
    statistics: SignalStatistics
    gears: dict[int, GearMeasure]
    bearings: dict[tuple[int, str], Comb]
    mesh: tuple[Comb, ...]
    events: dict[int, Comb]
    sets: tuple[SetMeasure, ...]
    impulsive: float
    band: tuple[float, float]
    waveform: float
    rest_share: float
    rest: Channel
    step: float = 0.0

    @property
    def quantised(self) -> bool:
        """Whether what repeats with no shaft may be quantisation, whose noise follows the meshing."""
        return is_quantisation(float(np.std(self.rest.values)), self.step)


def measured(
    channel: Channel,
    machine: Machine,
    speed: FoundSpeed,
    healthy: Measures | None = None,
    *,
    step: float = 0.0,
) -> Measures:
    """Return the measures of a record, quantised in a ``step``; NA4 and NB4 are against a healthy one."""
    f = speed.frequency
    # Without the speed nothing can be averaged over turns.
    parts = separated(channel, machine, f) if speed.known else Separation((), channel)
    earlier = {k: each.average for k, each in healthy.gears.items()} if healthy is not None else {}
    gears = {
        k: found
        for k, gear in enumerate(machine.gears)
        if (found := _gear(gear, parts, earlier.get(k))) is not None
    }
    fastest = max((each.order for each in machine.shafts), default=1.0) * f
    lines = [
        f * b.order * order
        for b in machine.bearings
        for order in (b.orders.bpfo, b.orders.bpfi, b.orders.bsf)
    ]
    bands = band_envelopes(parts.rest, 8.0 * max([fastest, *(0.6 * each for each in lines)]))
    if not speed.known:
        speed = turns_of_envelopes(bands, machine, speed)
        f = speed.frequency
    events = _tooth_events(machine, bands, f)
    # A shaft whose own turn stands in the envelope of the rest, by gears or a load, has its multiples there too.
    turning = [each for each in machine.shafts if speed.seen and _stands(bands, each.order * f)]
    taken = np.array(
        [k * each.order * f for each in turning for k in range(1, 11)] + _lines_of(machine, events, f)
    )
    combs = bearing_combs(bands, machine, f, taken)
    loudest = max(bands, key=lambda band: band.kurtosis, default=None)
    band = (loudest.low, loudest.high) if loudest is not None else (0.0, 0.0)
    mean = float(np.var(channel.values))
    return Measures(
        speed,
        signal_statistics(channel, remove_mean=True),
        gears,
        combs,
        tuple(_fixed_comb(bands, each.order * f, (1.0, 2.0, 3.0)) for each in machine.meshes),
        events,
        _of_sets(channel, machine, f, parts) if speed.known else (),
        _shocks(parts.rest, band),
        band,
        _waveform(machine, parts),
        float(np.var(parts.rest.values)) / mean if mean > 0.0 else 0.0,
        parts.rest,
        step,
    )


def _fixed_comb(bands: list[BandEnvelope], frequency: float, multiples: tuple[float, ...]) -> Comb:
    return best_comb(bands, frequency, [(k, 0.0) for k in multiples])


def _shocks(rest: Channel, band: tuple[float, float]) -> float:
    """Return the least kurtosis of the band over the quarters of a record, less that of noise: a single shock does not count."""
    if band[1] <= band[0]:
        return 0.0
    square = envelope(rest, *band).channel.values ** 2
    means = [float(np.mean(q)) for q in np.array_split(square, 4)]
    if min(means) <= 0.0:
        return 0.0
    quarters = [q / mean for q, mean in zip(np.array_split(square, 4), means, strict=True)]
    return min(float(np.mean(q * q)) for q in quarters) - 2.0


def _stands(bands: list[BandEnvelope], frequency: float) -> bool:
    comb = _fixed_comb(bands, frequency, (1.0,))
    return comb.height > 1.0


def _tooth_events(machine: Machine, bands: list[BandEnvelope], f: float) -> dict[int, Comb]:
    """Return the combs of one tooth's contacts of the planetary sets' gears, but of rings that stand.

    One multiple alone decides nothing: an eccentric gear has the first one, and with slip a line of a bearing may lie at another.
    """
    found = {}
    for k, gear in enumerate(machine.gears):
        own = machine.set_of(k)
        if gear.shaft is not None or (own is not None and k == own.gears[2]):
            continue
        plain = [(float(h), 0.0) for h in (1, 2, 3, 4)]
        pattern = plain if own is None else tooth_pattern(own, k, f, harmonics=4)
        found[k] = best_comb(bands, gear.order * f, pattern, balanced="multiples")
    return found


def _lines_of(machine: Machine, events: dict[int, Comb], f: float) -> list[float]:
    """Return the lines [Hz] of teeth of planetary sets whose events stand in the envelope."""
    found = []
    for k, comb in events.items():
        own, order = machine.set_of(k), machine.gears[k].order
        if own is not None and comb.height > 1.0:
            found += [h * order * f + offset for h, offset in tooth_pattern(own, k, f, harmonics=20)]
    return found


def _of_sets(channel: Channel, machine: Machine, f: float, parts: Separation) -> tuple[SetMeasure, ...]:
    """Return the measures of the planetary sets."""
    if not machine.sets:
        return ()
    spectrum = amplitude_spectrum(channel.values, channel.sampling)
    standing = [machine.gears[each.gears[2]].teeth == each.teeth for each in machine.sets]
    return tuple(
        set_measure(each, spectrum, f, parts.of(each.shaft) if ring else None)
        for each, ring in zip(machine.sets, standing, strict=True)
    )


def _gear(gear: Gear, parts: Separation, earlier: Floats | None) -> GearMeasure | None:
    """Return the measures of one gear, None where its shaft turns too seldom or carries too few samples."""
    found = parts.of(gear.shaft) if gear.shaft is not None else None
    if found is None or found.average.size < 4 * gear.teeth:
        return None
    size, event, tooth = _event(found, gear.teeth)
    history = () if earlier is None else (earlier,)
    return GearMeasure(
        gear_indicators(found.average, gear.teeth, history=history), event, size, tooth,
        _modulation(found, gear.teeth), found.turns, found.average,
    )  # fmt: skip


def _event(found: ShaftAverage, z: int) -> tuple[float, float, int]:
    """Return size and ratio of the local event, and its tooth."""
    even, odd = (split_average(half, z).difference for half in found.halves)
    pitch = max(1, round(even.size / z))

    def over_pitch(x: Floats) -> Floats:
        total = np.cumsum(np.concatenate([x, x[:pitch]]))
        return np.asarray((total[pitch:] - total[:-pitch]) / pitch)

    # What both halves share is no noise: their product has the event's energy, their difference the noise's.
    shared, noise = over_pitch(even * odd), over_pitch((0.5 * (even - odd)) ** 2)
    at = int(np.argmax(shared))
    size = math.sqrt(max(float(shared[at]), 0.0))
    beside = float(np.median(np.maximum(shared, 0.0))) + float(np.median(noise))
    ratio = size / math.sqrt(beside) if beside > 0.0 else 0.0
    if size < 1e-9 * float(np.max(np.abs(found.average))):
        return 0.0, 0.0, 1
    return size, ratio, int((at + 0.5 * pitch) * z / even.size) % z + 1


def _modulation(found: ShaftAverage, z: int) -> float:
    """Return the ratio of both first sidebands to their mesh harmonics, less the level of the surrounding orders.

    Harmonics that do not stand out of that level are left out.
    """
    amplitude = 2.0 * np.abs(np.fft.rfft(found.average)) / found.average.size
    sides, carriers = 0.0, 0.0
    for h in range(1, MODULATED + 1):
        at, half = h * z, max(3, z // 2)
        if at + half >= amplitude.size:
            break
        around = np.concatenate([amplitude[at - half : at - 2], amplitude[at + 3 : at + half + 1]])
        level = 1.5 * float(np.median(around)) if around.size else 0.0
        if float(amplitude[at]) < CARRIER * level:
            continue
        sides += sum(max(0.0, float(amplitude[k]) - level) for k in (at - 1, at + 1)) ** 2
        carriers += max(0.0, float(amplitude[at]) - level) ** 2
    return math.sqrt(sides / carriers) if carriers > 0.0 else 0.0


def _waveform(machine: Machine, parts: Separation) -> float:
    """Return the largest kurtosis of the mean mesh period of a gear; 1.5 of a sine."""
    found = [1.5]
    for gear in machine.gears:
        average = parts.of(gear.shaft) if gear.shaft is not None else None
        if average is None or average.average.size < 8 * gear.teeth:
            continue
        transform = np.fft.rfft(average.average)
        kept = np.zeros_like(transform)
        kept[gear.teeth :: gear.teeth] = transform[gear.teeth :: gear.teeth]
        wave = np.fft.irfft(kept, average.average.size)
        square = wave * wave
        mean = float(np.mean(square))
        found.append(float(np.mean(square * square)) / mean**2 if mean > 0.0 else 1.5)
    return max(found)
