"""Levels: rms value of a spectrum within bands."""

import numpy as np
from numpy.typing import NDArray

from gearplay.results.spectra import Spectrum, check_window

Floats = NDArray[np.float64]


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
