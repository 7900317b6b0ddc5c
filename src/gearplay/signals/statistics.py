"""Statistics of a record in time: level, peaks, shape of the distribution."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gearplay.files.record import Channel
from gearplay.signals.checks import check_channel

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class SignalStatistics:
    """Statistics of one record, ``mean`` to ``peak_to_peak`` in ``unit``.

    ``rms`` and ``peak`` (largest modulus) are about zero, or about the mean with ``about`` "mean"; ``crest_factor`` is peak
    over rms. ``kurtosis`` is Pearson's (a normal distribution has 3) and, as ``skewness``, about the mean. Of a record that
    does not vary the ratios are not defined: nan.
    """

    mean: float
    rms: float
    peak: float
    peak_to_peak: float
    crest_factor: float
    skewness: float
    kurtosis: float
    samples: int
    about: str
    unit: str
    name: str = ""


def signal_statistics(channel: Channel, *, remove_mean: bool = False) -> SignalStatistics:
    """Return the statistics of a record.

    With m_k the k-th central moment: skewness m_3 / m_2^1.5, kurtosis m_4 / m_2^2 (Pearson, normal 3, not the excess), without
    a correction for few samples. ``remove_mean`` takes rms, peak and crest factor about the mean.

    Source: Randall, Vibration-based Condition Monitoring (2011), section 5.3; Kendall, Advanced Theory of Statistics 1.

    Parameters
    ----------
    channel
        Signal, shape [time].
    remove_mean
        Whether rms, peak and crest factor are about the mean.

    Returns
    -------
    SignalStatistics
        Rms, peak values [unit], crest factor, skewness and kurtosis [1].

    Raises
    ------
    InputError
        For fewer than 8 samples or samples that are not finite.

    Examples
    --------
    >>> s = signal_statistics(Channel("acc", np.array([1.0, -1.0] * 4), 100.0, "m/s^2"))
    >>> s.rms, s.crest_factor, s.kurtosis, s.skewness, s.peak_to_peak
    (1.0, 1.0, 1.0, 0.0, 2.0)

    """
    values = check_channel(channel)
    mean = float(np.mean(values))
    largest = float(np.max(np.abs(values)))
    central = values - mean
    scale = float(np.max(np.abs(central)))
    shape = [math.nan, math.nan]
    # A deviation of rounding size is no variation; scaling by it keeps the fourth power within range.
    if scale > 8.0 * np.finfo(float).eps * largest:
        unit = central / scale
        square = unit * unit  # a power of three or four takes thirty times as long
        second = float(np.mean(square))
        shape = [float(np.mean(square * unit)) / second**1.5, float(np.mean(square * square)) / second**2]
    taken, peak = (central, scale) if remove_mean else (values, largest)
    rms = rms_of(taken, peak)
    return SignalStatistics(
        mean=mean,
        rms=rms,
        peak=peak,
        peak_to_peak=float(np.ptp(values)),
        crest_factor=peak / rms if rms > 0.0 else math.nan,
        skewness=shape[0],
        kurtosis=shape[1],
        samples=values.size,
        about="mean" if remove_mean else "zero",
        unit=channel.unit,
        name=channel.name,
    )


def rms_of(values: Floats, peak: float) -> float:
    """Return the root mean square of values with a given largest modulus.

    >>> rms_of(np.array([3.0, -4.0, 0.0, 0.0]), 4.0)
    2.5
    """
    return peak * math.sqrt(float(np.mean((values / peak) ** 2))) if peak > 0.0 else 0.0
