"""Amplitude spectra: sharp lines between bins, broad humps, rms levels of bands."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gearplay.results.spectra import Spectrum, check_window, smoothed
from gearplay.signals.checks import refuse

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Line:
    """A line of a spectrum: frequency [Hz], amplitude [unit of the spectrum], prominence over its surroundings [1]."""

    frequency: float
    amplitude: float
    prominence: float


def _band(spectrum: Spectrum, low: float, high: float) -> tuple[int, int]:
    inside = np.nonzero((spectrum.frequency >= low) & (spectrum.frequency <= high))[0]
    if inside.size < 3:
        rule = f"must hold at least 3 lines of the spectrum (one each {spectrum.resolution:.4g} Hz)"
        refuse("band", f"{low:.4g}..{high:.4g} Hz", rule, "Widen the band or take a longer record")
    return int(inside[0]), int(inside[-1])


def _offset(window: str, left: float, peak: float, right: float) -> tuple[float, float]:
    """Return (place in bins between -0.5 and 0.5, true over largest amplitude) of an isolated tone.

    Hann: the ratio a of the larger neighbour to the peak gives (2a - 1) / (a + 1); boxcar: a / (1 + a). Others: a
    parabola through the logarithms.
    """
    side = 1.0 if right >= left else -1.0
    ratio = max(left, right) / peak if peak > 0.0 else 0.0
    if window == "hann":
        d = max(0.0, (2.0 * ratio - 1.0) / (ratio + 1.0))
        return side * d, (1.0 - d * d) / float(np.sinc(d))
    if window == "boxcar":
        d = ratio / (1.0 + ratio)
        return side * d, 1.0 / float(np.sinc(d))
    low, middle, high = (math.log(max(v, 1e-300)) for v in (left, peak, right))
    curvature = low - 2.0 * middle + high
    d = 0.5 * (low - high) / curvature if curvature < 0.0 else 0.0
    return d, math.exp(-0.25 * (low - high) * d)


def find_line(spectrum: Spectrum, expected: float, *, search: float = 0.03) -> Line:
    """Return the highest line within ``expected`` (1 -+ ``search``) [Hz], its frequency resolved between the bins.

    Prominence is its height over the median of the spectrum from half to one and a half times ``expected``.

    Parameters
    ----------
    spectrum
        Amplitude spectrum of a record or an ensemble.
    expected
        Where the line should be [Hz].
    search
        Relative half width of the band searched.

    Returns
    -------
    Line
        Frequency [Hz], resolved between the bins, amplitude [unit] and prominence [1].

    Raises
    ------
    InputError
        Where the band holds fewer than three lines.

    Examples
    --------
    >>> from gearplay.results.spectra import amplitude_spectrum
    >>> t = np.arange(4000) / 1000.0
    >>> line = find_line(amplitude_spectrum(2.0 * np.sin(2.0 * np.pi * 40.1 * t), 1000.0), 40.0)
    >>> round(line.frequency, 3), round(line.amplitude, 2)
    (40.1, 2.0)

    """
    margin = max(search * expected, 1.5 * spectrum.resolution)
    low, high = _band(spectrum, expected - margin, expected + margin)
    at = low + int(np.argmax(spectrum.amplitude[low : high + 1]))
    at = min(max(at, 1), spectrum.amplitude.size - 2)
    place, gain = _offset(spectrum.window, *(float(v) for v in spectrum.amplitude[at - 1 : at + 2]))
    first, last = _band(spectrum, 0.5 * expected, 1.5 * expected)
    floor = float(np.median(spectrum.amplitude[first : last + 1]))
    height = float(spectrum.amplitude[at]) * gain
    frequency = float(spectrum.frequency[at]) + place * spectrum.resolution
    return Line(frequency, height, height / floor if floor > 0.0 else math.inf)


def find_hump(spectrum: Spectrum, low: float, high: float, *, width: float = 0.08) -> Line:
    """Return the highest broad hump between ``low`` and ``high`` [Hz], after smoothing over a relative ``width``.

    Its amplitude is that of the smoothed spectrum, so it depends on the record's length as all noise-like content does.

    Parameters
    ----------
    spectrum
        Amplitude spectrum of a record or an ensemble.
    low, high
        Ends of the band [Hz].
    width
        Relative width of the smoothing.

    Returns
    -------
    Line
        Frequency [Hz], amplitude [unit] and prominence [1].

    Raises
    ------
    InputError
        Where the band holds fewer than three lines.

    Examples
    --------
    >>> from gearplay.results.spectra import amplitude_spectrum
    >>> noise = np.random.default_rng(1).standard_normal(4000)
    >>> 1.0 < find_hump(amplitude_spectrum(noise, 100.0), 1.0, 10.0).frequency < 10.0
    True

    """
    _band(spectrum, low, high)
    frequency, inside = smoothed(spectrum, low, high, width)
    # A true hump has lower sides; without a hump the result is the band's highest value.
    tops = [i for i in range(1, inside.size - 1) if inside[i] >= inside[i - 1] and inside[i] > inside[i + 1]]
    at = max(tops, key=lambda i: inside[i]) if tops else int(np.argmax(inside))
    place = 0.0
    if 0 < at < inside.size - 1:
        place, _ = _offset("parabola", *(float(v) for v in inside[at - 1 : at + 2]))
    height, floor = float(inside[at]), float(np.median(inside))
    top = float(frequency[at]) + min(max(place, -0.5), 0.5) * spectrum.resolution
    return Line(top, height, height / floor if floor > 0.0 else math.inf)


def band_levels(spectrum: Spectrum, samples: int, edges: Floats) -> Floats:
    """Return the rms value [unit of the spectrum] between neighbouring ``edges`` [Hz], shape [band].

    Half the squared amplitudes of the lines, over the window's equivalent noise bandwidth n sum w^2 / (sum w)^2, so that levels
    of adjoining bands add up (Parseval). ``samples`` is the length of the record behind the spectrum; a line on an edge counts
    above it, on the last edge below.
    """
    weights = check_window(spectrum.window, samples)
    bandwidth = weights.size * float(np.sum(weights**2)) / float(np.sum(weights)) ** 2
    f = spectrum.frequency
    inside = (f >= edges[0]) & (f <= edges[-1])
    place = np.minimum(np.searchsorted(edges, f[inside], side="right") - 1, len(edges) - 2)
    squares = np.bincount(place, weights=spectrum.amplitude[inside] ** 2, minlength=len(edges) - 1)
    return np.asarray(np.sqrt(squares / (2.0 * bandwidth)))


def band_level(spectrum: Spectrum, samples: int, low: float, high: float) -> float:
    """Return the rms value from ``low`` to ``high`` [Hz]; see `band_levels`.

    Parameters
    ----------
    spectrum
        Amplitude spectrum of a record or an ensemble.
    samples
        Length of the record behind it.
    low, high
        Ends of the band [Hz].

    Returns
    -------
    float
        Rms value [unit of the spectrum].

    Examples
    --------
    >>> from gearplay.results.spectra import amplitude_spectrum
    >>> t = np.arange(1000) / 1000.0
    >>> s = amplitude_spectrum(np.sqrt(2.0) * np.sin(2.0 * np.pi * 50.0 * t), 1000.0)
    >>> round(band_level(s, 1000, 40.0, 60.0), 6)
    1.0

    """
    return float(band_levels(spectrum, samples, np.array([low, high]))[0])
