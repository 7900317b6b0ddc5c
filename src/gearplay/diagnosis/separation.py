"""Separation of a record into averages synchronous with each shaft, sidebands of planetary sets, and a random residual."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from gearplay.diagnosis.machine import Machine
from gearplay.diagnosis.planetary_set import PlanetarySet
from gearplay.files.record import Channel
from gearplay.signals.checks import TWO_PI
from gearplay.signals.resampling import resampled

Floats = NDArray[np.float64]

LEAST_TURNS: Final = 8
"""Turns of a shaft from which an average separates it from the others."""
SIDEBANDS: Final = 8
"""Mesh harmonics whose sidebands are taken from the rest."""
MULTIPLES: Final = 2
"""Multiples of the turns of both gears of a mesh whose sums and differences are taken from the rest."""
LEAST_SHARE: Final = 0.5
"""Least share of such sums and differences in the power around a harmonic, from which they are lines."""


@dataclass(frozen=True)
class ShaftAverage:
    """Average over the turns of one shaft after subtraction of the averages of faster shafts.

    ``average`` and ``alone`` [unit], shape [sample], over one turn: of the whole signal, and of what the other shafts leave;
    ``halves``, shape [2, sample], the latter over even and over odd turns; ``turns`` their number.
    """

    shaft: int
    average: Floats
    alone: Floats
    halves: Floats
    turns: int


@dataclass(frozen=True)
class Separation:
    """Averages of the shafts that turn often enough, fastest first, and the ``rest`` that repeats with none.

    From the rest sidebands of mesh harmonics are taken, too, that no average holds: at sums and differences of the turns of both
    gears, of planetary sets at the turns of sun and planets against the carrier.
    """

    shafts: tuple[ShaftAverage, ...]
    rest: Channel

    def of(self, shaft: int | None) -> ShaftAverage | None:
        """Return the average of a shaft, or None."""
        return next((each for each in self.shafts if each.shaft == shaft), None)


def separated(channel: Channel, machine: Machine, speed: float) -> Separation:
    """Return the averages of the shafts at the first one's speed [Hz], fastest shaft first, and the rest.

    Source: Randall, Sawalhi, Coats, Mech. Syst. Signal Process. 25 (2011) 1769 (separation of gear and bearing signals).
    """
    rest = channel
    found: list[ShaftAverage] = []
    order = sorted(range(len(machine.shafts)), key=lambda k: -machine.shafts[k].order)
    for k in order:
        frequency = speed * machine.shafts[k].order
        if frequency * channel.duration < LEAST_TURNS + 1 or frequency > 0.1 * channel.sampling:
            continue
        if any(
            abs(machine.shafts[k].order / machine.shafts[each.shaft].order - 1.0) < 1e-9 for each in found
        ):
            continue  # turns with another one: one average holds both
        table = _turns(rest, frequency)
        whole = table if rest is channel else _turns(channel, frequency)
        alone = np.mean(table, axis=0)
        found.append(
            ShaftAverage(
                k, np.mean(whole, axis=0), alone,
                np.stack([np.mean(table[::2], axis=0), np.mean(table[1::2], axis=0)]), table.shape[0],
            )
        )  # fmt: skip
        rest = Channel(channel.name, rest.values - _repeated(alone, frequency, channel), channel.sampling,
                       channel.unit, channel.start)  # fmt: skip
    averaged = {each.shaft for each in found}
    for mesh in machine.meshes:
        shafts = {machine.gears[k].shaft for k in mesh.gears}
        if len(shafts) == 2 and shafts <= averaged:
            turns = [speed * machine.gears[k].order for k in mesh.gears]
            rest = _without_sidebands(rest, speed * mesh.order, _sums(*turns), LEAST_SHARE)
    for each in machine.sets:
        if speed * each.carrier * channel.duration >= LEAST_TURNS + 1:
            rest = _without_sidebands(rest, speed * each.carrier * each.teeth, speed * _against_carrier(each))
    return Separation(tuple(found), rest)


def _sums(one: float, other: float) -> Floats:
    """Return the distances [Hz] of sidebands at sums and differences of multiples of two turns: both gears modulate the mesh."""
    multiples = np.array([k for k in range(-MULTIPLES, MULTIPLES + 1) if k])
    return np.ravel(multiples[:, None] * one + multiples * other)


def _against_carrier(each: PlanetarySet) -> Floats:
    """Return the distances of sidebands at the turns of sun and planets against the carrier, as orders."""
    shifts = [k * member for member in (each.sun, each.planet) for k in (-2, -1, 1, 2)]
    around = each.carrier * np.arange(-2 * each.planets, 2 * each.planets + 1)
    return np.array([shift + m for shift in shifts for m in around])


def _without_sidebands(channel: Channel, mesh: float, distances: Floats, least: float = 0.0) -> Channel:
    """Return a signal without lines at some distances [Hz] from the harmonics of a mesh [Hz], which no average holds.

    The lines around each harmonic are fitted to the spectrum by least squares, and taken where they are at least a share
    ``least`` of the power there: in what a jitter of the angle smears there are none.
    """
    n = channel.size
    transform = np.fft.rfft(channel.values)
    lines = distances * channel.duration  # in lines of the spectrum, as all below
    reach = 1.2 * float(np.max(lines))
    for h in range(1, SIDEBANDS + 1):
        middle = h * mesh * channel.duration
        if middle + 2.0 * reach > 0.5 * n:
            break
        wide = np.arange(max(1, math.ceil(middle - 2.0 * reach)), math.floor(middle + 2.0 * reach))
        shapes = _line_shapes(wide, middle + lines, n)
        near = np.abs(wide - middle) < reach
        fitted = np.linalg.lstsq(shapes[near], transform[wide[near]], rcond=1e-3)[0]
        after = transform[wide] - shapes @ fitted
        if np.sum(np.abs(after[near]) ** 2) <= (1.0 - least) * np.sum(np.abs(transform[wide][near]) ** 2):
            transform[wide] = after
    return Channel(channel.name, np.fft.irfft(transform, n), channel.sampling, channel.unit, channel.start)


def _line_shapes(at: NDArray[np.int64], lines: Floats, n: int) -> NDArray[np.complex128]:
    """Return the discrete Fourier transform of exp(2 pi i line k / n), k = 0 ... n - 1, over n, shape [at, line]."""
    off = lines[None, :] - at[:, None]
    # The geometric sum for n much greater than off.
    return np.asarray(np.sinc(off) * np.exp(1j * np.pi * off * (1.0 - 1.0 / n)))


def _turns(channel: Channel, frequency: float) -> Floats:
    """Return the signal over the turns of a shaft, shape [turn, sample], from the start of the record."""
    start = Channel(channel.name, channel.values, channel.sampling, channel.unit)
    record = resampled(start, TWO_PI * frequency)
    per = record.samples_per_revolution
    skipped = -record.first % per
    count = (record.values.size - skipped) // per
    return record.values[skipped : skipped + count * per].reshape(count, per)


def _repeated(average: Floats, frequency: float, channel: Channel) -> Floats:
    """Return an average over one turn as it repeats in time, shape [time]."""
    from scipy.ndimage import map_coordinates
    from scipy.signal import resample

    fine = resample(average, 4 * average.size)
    angle = (np.arange(channel.size) * (frequency / channel.sampling)) % 1.0
    return np.asarray(map_coordinates(fine, [angle * fine.size], order=3, mode="grid-wrap"))
