"""Condition indicators of one gear, from the synchronous average over one of its turns."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gearplay.files.record import Channel
from gearplay.signals.checks import check_channel, check_count, refuse
from gearplay.signals.statistics import signal_statistics
from gearplay.signals.synchronous import SynchronousAverage

Floats = NDArray[np.float64]

SHAFT_ORDERS = (1, 2)
"""Orders of the shaft that count as regular."""


@dataclass(frozen=True)
class SplitAverage:
    """Parts of a synchronous average over one turn, each of shape [sample], in its unit and without its mean.

    ``regular`` holds the mesh harmonics and the shaft orders 1 and 2, ``difference`` the average without these and without the
    first-order sidebands of each mesh harmonic; ``residual`` keeps the sidebands. ``mesh`` are the amplitudes of the mesh
    harmonics, shape [harmonic], and ``sidebands`` those one order below and above each, shape [harmonic, 2].
    """

    average: Floats
    regular: Floats
    difference: Floats
    residual: Floats
    mesh: Floats
    sidebands: Floats
    teeth: int


@dataclass(frozen=True)
class GearIndicators:
    """Condition indicators of one gear; ``rms`` and ``sideband_index`` in ``unit``, the others [1].

    An indicator is NaN where the part of the signal that it is computed from is zero. ``turns`` are those that were averaged,
    where the average has their number.
    """

    rms: float
    kurtosis: float
    crest_factor: float
    fm0: float
    fm4: float
    m6a: float
    m8a: float
    na4: float
    nb4: float
    energy_ratio: float
    sideband_index: float
    sideband_level_factor: float
    teeth: int
    samples: int
    unit: str = ""
    name: str = ""
    turns: int | None = None


def _one_turn(average: "SynchronousAverage | Floats", teeth: int) -> tuple[Floats, str, str]:
    """Return the samples of one turn without their mean, with unit and name."""
    check_count("teeth", teeth, 3, 10_000, "Give the number of teeth of the gear on this shaft")
    unit, name = "", "average"
    if isinstance(average, SynchronousAverage):
        if average.period != 1:
            refuse(
                "average.period", average.period, "must be 1 revolution of the gear", "Average over period=1"
            )
        values, unit, name = average.average, average.unit, average.name
    else:
        values = average
    x = check_channel(Channel(name or "average", values, 1.0))
    if x.size < 4 * teeth:
        rule = f"must be at least 4 samples for each of {teeth} teeth, so that mesh order and sidebands are in it"
        refuse("average", f"{x.size} samples", rule, "Raise samples_per_revolution, or sample faster")
    return x - np.mean(x), unit, name


def split_average(average: "SynchronousAverage | Floats", teeth: int) -> SplitAverage:
    """Return regular, difference and residual signal of a synchronous average over one turn of a gear.

    Source: Lebold, McClintic, Campbell, Byington, Maynard, 54th MFPT (2000) 623; parts as in MATLAB's ``gearConditionMetrics``.

    Parameters
    ----------
    average
        Of one turn of the gear: a `SynchronousAverage` with period 1, or its samples, shape [sample].
    teeth
        Teeth of the gear.

    Returns
    -------
    SplitAverage
        The parts, and the amplitudes of mesh harmonics and of their first sidebands.

    Raises
    ------
    InputError
        For fewer than 4 samples a tooth, samples that are not finite, or an average over several turns.

    Examples
    --------
    >>> p = 2.0 * np.pi * np.arange(256) / 256
    >>> parts = split_average(np.cos(20 * p) + 0.1 * np.cos(21 * p) + 0.01 * np.cos(33 * p), 20)
    >>> [round(float(np.max(each)), 9) for each in (parts.regular, parts.difference)]
    [1.0, 0.01]

    """
    x, _, _ = _one_turn(average, teeth)
    transform = np.fft.rfft(x)
    orders = np.arange(transform.size)
    harmonics = np.arange(teeth, transform.size, teeth)
    regular = np.isin(orders, [*harmonics, *SHAFT_ORDERS])
    beside = np.isin(orders, [*(harmonics - 1), *(harmonics + 1)]) & ~regular

    def part(kept: NDArray[np.bool_]) -> Floats:
        return np.asarray(np.fft.irfft(np.where(kept, transform, 0.0), x.size))

    amplitude = np.append(2.0 * np.abs(transform) / x.size, 0.0)
    sidebands = np.stack([amplitude[harmonics - 1], amplitude[harmonics + 1]], axis=1)
    return SplitAverage(
        x, part(regular), part(~(regular | beside)), part(~regular), amplitude[harmonics], sidebands, teeth
    )


def _envelope(x: Floats, teeth: int) -> Floats:
    """Return the envelope of the band half a mesh order around the first mesh harmonic."""
    transform, half = np.fft.fft(x), teeth // 2
    band = np.zeros_like(transform)
    band[teeth - half : teeth + half + 1] = 2.0 * transform[teeth - half : teeth + half + 1]
    return np.asarray(np.abs(np.fft.ifft(band)))


def _scaled(x: Floats) -> tuple[Floats, float]:
    """Return deviations from the mean over their maximum, and that maximum; zeros where it is of rounding size."""
    central = x - np.mean(x)
    largest = float(np.max(np.abs(central)))
    return (central / largest, largest) if largest > 0.0 else (central, 0.0)


def normalised_moment(x: Floats, power: int, floor: float = 0.0) -> float:
    """Return m_p / m_2^(p/2), m_k being the k-th central moment; nan of a signal no larger than ``floor``.

    >>> round(normalised_moment(np.cos(2.0 * np.pi * np.arange(64) / 64), 6), 12)
    2.5
    """
    unit, largest = _scaled(x)
    if largest <= floor:
        return math.nan
    return float(np.mean(unit**power)) / float(np.mean(unit * unit)) ** (power // 2)


def _against(parts: Sequence[Floats], floor: float) -> float:
    """Return the fourth moment of the last signal over the squared mean of the variances of all."""
    central, largest = _scaled(parts[-1])
    if largest <= floor:
        return math.nan
    variances = [float(np.var(each / largest)) for each in parts]
    return float(np.mean(central**4)) / float(np.mean(variances)) ** 2


def gear_indicators(
    average: "SynchronousAverage | Floats",
    teeth: int,
    *,
    history: "Sequence[SynchronousAverage | Floats]" = (),
) -> GearIndicators:
    """Return the condition indicators of a gear from its synchronous average.

    With difference d, residual r and regular part of `split_average`, m_k the k-th central moment, A_h the amplitude of mesh
    harmonic h: FM0 = (peak to peak) / sum A_h; FM4, M6A, M8A = m_4 / m_2^2, m_6 / m_2^3, m_8 / m_2^4 of d; NA4 = m_4(r) over the
    squared mean of m_2(r) of ``history`` and this record; NB4 the same of the envelope of the band z - z//2 .. z + z//2;
    energy ratio = rms(d) / rms(regular); sideband index = half the sum of the first sidebands of the first mesh harmonic,
    sideband level factor = that sum over the rms. Of a Gaussian d FM4, M6A, M8A are 3, 15, 105; of a sine 1.5, 2.5, 4.375.

    Kurtosis and crest factor of the average hardly change with damage of a single tooth, FM0 and NA4 fall at first.

    Source: Lebold, McClintic, Campbell, Byington, Maynard, Review of vibration analysis methods for gearbox diagnostics and
    prognostics, 54th MFPT (2000) 623; definitions as in MATLAB's ``gearConditionMetrics``; bands of NB4 ours.

    Parameters
    ----------
    average
        Of one turn of the gear: a `SynchronousAverage` with period 1, or its samples, shape [sample].
    teeth
        Teeth of the gear.
    history
        Earlier averages of the same gear, against which NA4 and NB4 are taken.

    Returns
    -------
    GearIndicators
        Indicators, with unit and name of the average.

    Raises
    ------
    InputError
        As `split_average`.

    Examples
    --------
    >>> p = 2.0 * np.pi * np.arange(256) / 256
    >>> found = gear_indicators(np.cos(20 * p) + 0.1 * np.cos(19 * p) + 0.02 * np.cos(33 * p), 20)
    >>> [round(each, 6) for each in (found.fm4, found.m6a, found.m8a, found.energy_ratio, found.sideband_index)]
    [1.5, 2.5, 4.375, 0.02, 0.05]

    """
    x, unit, name = _one_turn(average, teeth)
    now = split_average(x, teeth)
    earlier = [_one_turn(each, teeth)[0] for each in history]
    parts = [split_average(each, teeth) for each in earlier]
    every = [*(each.residual for each in parts), now.residual]
    envelopes = [_envelope(each, teeth) for each in (*earlier, x)]
    plain = signal_statistics(Channel(name, x, 1.0, unit))
    floor = 1e-12 * float(np.max(np.abs(x)))  # what the transform leaves of nothing
    mesh, sides = float(np.sum(now.mesh)), float(np.sum(now.sidebands[0]))
    regular = float(np.std(now.regular))
    fm4, m6a, m8a = (normalised_moment(now.difference, power, floor) for power in (4, 6, 8))
    return GearIndicators(
        plain.rms,
        plain.kurtosis,
        plain.crest_factor,
        plain.peak_to_peak / mesh if mesh > floor else math.nan,
        fm4,
        m6a,
        m8a,
        _against(every, floor),
        _against(envelopes, floor),
        float(np.std(now.difference)) / regular if regular > floor else math.nan,
        0.5 * sides,
        sides / plain.rms if plain.rms > 0.0 else math.nan,
        teeth,
        x.size,
        unit,
        name,
        average.periods if isinstance(average, SynchronousAverage) else None,
    )
