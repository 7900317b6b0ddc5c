"""Averaged spectra: one-sided power spectral density and amplitude spectrum by Welch's method, settings stated."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gearplay.files.record import Channel
from gearplay.results.spectra import check_window
from gearplay.signals.checks import check_channel, check_choice, check_count, check_overlap, default_segment

Floats = NDArray[np.float64]

AVERAGINGS = ("mean", "median")
CORRECTIONS = ("amplitude", "energy")
DETRENDS = {"none": False, "mean": "constant", "linear": "linear"}
CHUNK = 1_000_000  # samples transformed at once


@dataclass(frozen=True)
class AveragedSpectrum:
    """A spectrum averaged over segments of one record, with everything a caption needs.

    ``frequency`` [Hz] and ``values`` [``unit``] have shape [line]. ``kind`` is "density" (mean square per hertz) or
    "amplitude" (peak value of a sine); ``correction`` says which property of the signal the window's correction keeps: of an
    amplitude spectrum "amplitude" (a line's height) or "energy" (mean square of noise); of a density always "energy".
    ``segment`` is in samples, ``overlap`` a share, ``averages`` the number of segments, ``sampling`` [Hz].
    """

    frequency: Floats
    values: Floats
    kind: str
    unit: str
    window: str
    segment: int
    overlap: float
    averages: int
    averaging: str
    correction: str
    detrend: str
    sampling: float
    noise_bandwidth: float
    name: str = ""

    @property
    def resolution(self) -> float:
        """Distance of two lines [Hz]; the window smears a tone over ``noise_bandwidth`` [Hz]."""
        return self.sampling / self.segment

    @property
    def caption(self) -> str:
        """The settings in one line."""
        averages = f"1 segment of {self.segment}" if self.averages == 1 else (
            f"{self.averaging} of {self.averages} segments of {self.segment}, overlap {100.0 * self.overlap:.3g} %"
        )  # fmt: skip
        return (
            f"window {self.window}, {averages}, line spacing {self.resolution:.4g} Hz, "
            f"{self.correction}-corrected, detrend {self.detrend}"
        )


def _power(values: Floats, weights: Floats, step: int, detrend: str, averaging: str) -> tuple[Floats, int]:
    """Return |X|^2 averaged over the windowed segments, shape [line], and their number."""
    from scipy.signal import detrend as straighten

    segments = np.lib.stride_tricks.sliding_window_view(values, weights.size)[::step]
    rows = max(1, CHUNK // weights.size)  # a long record's segments together would fill the memory
    kind, total, parts = DETRENDS[detrend], np.zeros(weights.size // 2 + 1), []
    for first in range(0, segments.shape[0], rows):
        chunk = segments[first : first + rows]
        chunk = straighten(chunk, axis=1, type=kind) if kind else chunk
        power = np.abs(np.fft.rfft(chunk * weights, axis=1)) ** 2
        if averaging == "median":
            parts.append(power)
        else:
            total += np.sum(power, axis=0)
    count = segments.shape[0]
    return (np.median(np.concatenate(parts), axis=0) if parts else total / count), count


def _median_bias(n: int) -> float:
    """Return the median over the mean of ``n`` powers of Gaussian noise (exponentially distributed), 1 - 1/2 + 1/3 - ..."""
    return 1.0 + sum(1.0 / (2 * k + 1) - 1.0 / (2 * k) for k in range(1, (n - 1) // 2 + 1))


def _averaged(
    channel: Channel,
    window: str,
    segment: int | None,
    overlap: float,
    averaging: str,
    detrend: str,
    *,
    kind: str,
    correction: str,
) -> AveragedSpectrum:
    """Return the density or amplitude spectrum averaged over the segments of a record."""
    values = check_channel(channel)
    n = values.size
    length = default_segment(n) if segment is None else check_count("segment", segment, 8, n, "Shorten it")
    check_overlap(overlap)
    check_choice("averaging", averaging, AVERAGINGS)
    check_choice("detrend", detrend, tuple(DETRENDS))
    w = check_window(window, length)
    step = max(1, length - round(overlap * length))
    power, averages = _power(values, w, step, detrend, averaging)
    energy, gain, unit = float(np.sum(w * w)), float(np.sum(w)) ** 2, channel.unit
    bias = _median_bias(averages) if averaging == "median" and correction == "energy" else 1.0
    if kind == "density":
        found = 2.0 * power / (channel.sampling * energy) / bias
        unit = f"({channel.unit})^2/Hz" if channel.unit else ""
    else:
        found = 2.0 * np.sqrt(power / bias / (gain if correction == "amplitude" else length * energy))
    found[0] *= 0.5  # zero and, of an even number of samples, half the sampling rate have no mirror image
    if length % 2 == 0:
        found[-1] *= 0.5
    frequency = np.asarray(np.fft.rfftfreq(length, 1.0 / channel.sampling), dtype=np.float64)
    return AveragedSpectrum(
        frequency, found, kind, unit, window, length, 1.0 - step / length, averages, averaging, correction, detrend,
        channel.sampling, channel.sampling * energy / gain, channel.name,
    )  # fmt: skip


def power_density(
    channel: Channel,
    *,
    window: str = "hann",
    segment: int | None = None,
    overlap: float = 0.5,
    averaging: str = "mean",
    detrend: str = "mean",
) -> AveragedSpectrum:
    """Return the one-sided power spectral density by Welch's method.

    S_k = c_k |X_k|^2 / (f_s sum w^2), averaged over segments; c = 2, but 1 at zero and at half the sampling rate. Its sum
    times the line spacing is sum (w x)^2 / sum w^2, which a boxcar makes the mean square (Parseval). A median over segments
    shrugs off single shocks; it is divided by its bias for Gaussian noise.

    Source: Welch, IEEE Trans. Audio Electroacoust. 15 (1967) 70; bias of the median: Allen et al., Phys. Rev. D 85 (2012)
    122006, appendix B.

    Parameters
    ----------
    channel
        Signal, shape [time].
    window
        Name of a window of scipy.signal.
    segment
        Length of a segment [samples]; without it a power of two near an eighth of the record.
    overlap
        Share of a segment that the next one takes again, 0 to 0.95.
    averaging
        "mean" or "median".
    detrend
        What is taken off each segment: "none", "mean" or "linear".

    Returns
    -------
    AveragedSpectrum
        ``frequency`` [Hz] and ``values`` [unit^2/Hz], shape [line], with the settings in ``caption``.

    Raises
    ------
    InputError
        For samples that are too few or not finite, and unknown or impossible settings.

    Examples
    --------
    >>> c = Channel("acc", np.array([1.0, -1.0] * 4), 8.0, "m/s^2")
    >>> s = power_density(c, window="boxcar", segment=8)
    >>> s.values.tolist(), s.unit  # mean square 1 (m/s^2)^2 in the line at 4 Hz, 1 Hz wide
    ([0.0, 0.0, 0.0, 0.0, 1.0], '(m/s^2)^2/Hz')

    """
    return _averaged(
        channel, window, segment, overlap, averaging, detrend, kind="density", correction="energy"
    )


def averaged_spectrum(
    channel: Channel,
    *,
    window: str = "hann",
    segment: int | None = None,
    overlap: float = 0.5,
    averaging: str = "mean",
    correction: str = "amplitude",
    detrend: str = "mean",
) -> AveragedSpectrum:
    """Return the one-sided amplitude spectrum, the root of the segments' averaged powers.

    ``correction`` "amplitude": 2 |X_k| / sum w, so that a sine of amplitude a on a line is a line of height a. "energy":
    2 |X_k| / sqrt(N sum w^2), so that half the sum of the squares is the mean square of the windowed record, but a line reads
    high or low. The median over segments is divided by its bias for noise with "energy" only; a steady line has none.

    Source: Brandt, Noise and Vibration Analysis (2011), sections 9.3 and 10.2. Parameters as `power_density`.

    Parameters
    ----------
    channel
        Signal, shape [time].
    window, segment, overlap, averaging, detrend
        As `power_density` takes them.
    correction
        "amplitude" or "energy".

    Returns
    -------
    AveragedSpectrum
        ``frequency`` [Hz] and ``values`` [unit], shape [line], with the settings in ``caption``.

    Raises
    ------
    InputError
        For samples that are too few or not finite, and unknown or impossible settings.

    Examples
    --------
    >>> t = np.arange(64) / 64.0
    >>> c = Channel("acc", 3.0 * np.cos(2.0 * np.pi * 8.0 * t), 64.0, "m/s^2")
    >>> s = averaged_spectrum(c, segment=32)
    >>> round(float(s.values[4]), 9), float(s.frequency[4]), s.averages, s.unit
    (3.0, 8.0, 3, 'm/s^2')

    """
    check_choice("correction", correction, CORRECTIONS)
    return _averaged(
        channel, window, segment, overlap, averaging, detrend, kind="amplitude", correction=correction
    )


def mean_square(spectrum: AveragedSpectrum, *, low: float = 0.0, high: float = math.inf) -> float:
    """Return the mean square [unit^2] of a density between two frequencies [Hz], its sum times the line spacing.

    Parameters
    ----------
    spectrum
        A density, as `power_density` returns it.
    low, high
        Ends of the band [Hz].

    Returns
    -------
    float
        Mean square [unit^2].

    Examples
    --------
    >>> c = Channel("acc", np.array([1.0, -1.0] * 4), 8.0)
    >>> mean_square(power_density(c, window="boxcar"))
    1.0

    """
    check_choice("kind", spectrum.kind, ("density",))
    inside = (spectrum.frequency >= low) & (spectrum.frequency <= high)
    return float(np.sum(spectrum.values[inside])) * spectrum.resolution
