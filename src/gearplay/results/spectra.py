"""One-sided amplitude spectra with stated window and normalisation; ensemble averages with their spread."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from gearplay.pictures.words import shown_in
from gearplay.vocabulary.errors import InputError

Floats = NDArray[np.float64]
NORMALISATIONS = ("amplitude", "unnormalised")


@dataclass(frozen=True, repr=False)
class Spectrum:
    """An amplitude spectrum of one record or of an ensemble, as `amplitude_spectrum` and `ensemble_spectrum` return it.

    Parameters
    ----------
    frequency
        Of the lines [Hz], shape [line].
    amplitude
        Shape [line]. With ``normalisation`` "amplitude" a sine of amplitude a gives a line of height a, in the signal's unit;
        "unnormalised" is the bare magnitude of the discrete Fourier transform, which grows with the number of samples.
    window, normalisation, unit
        How it was made.
    members
        Records behind it.
    spread
        Standard deviation of log10(amplitude) over the members [decades], None for one record; the mean has it divided by
        sqrt(members).
    each
        Amplitudes of the members, shape [member, line].

    Examples
    --------
    >>> s = amplitude_spectrum(np.sin(np.arange(100.0)), 50.0, unit="m/s^2")
    >>> s.resolution, s.amplitude.shape
    (0.5, (51,))

    """

    frequency: Floats
    amplitude: Floats
    window: str
    normalisation: str
    unit: str
    members: int = 1
    spread: Floats | None = None
    each: Floats | None = None  # [member, line], amplitudes of the members

    @property
    def resolution(self) -> float:
        """Distance of two lines [Hz]."""
        return float(self.frequency[1] - self.frequency[0])

    def rows(self) -> list[tuple[str, str]]:
        """Return lines, largest one and how it was made, as name and text."""
        at = int(np.argmax(self.amplitude))
        unit, factor = (
            ("", 1.0)
            if self.normalisation == "unnormalised"
            else shown_in(self.unit, float(self.amplitude[at]))
        )
        made = f"{self.normalisation}, window {self.window}" + (
            f", {self.members} members" if self.members > 1 else ""
        )
        return [
            (
                "lines",
                f"{self.frequency.size} to {self.frequency[-1]:.6g} Hz, {self.resolution:.4g} Hz apart",
            ),
            (
                "largest",
                f"{factor * self.amplitude[at]:.4g} {unit}".rstrip() + f" at {self.frequency[at]:.6g} Hz",
            ),
            ("normalisation", made),
        ]

    def __repr__(self) -> str:
        return f"<gearplay spectrum: {'; '.join(f'{name} {text}' for name, text in self.rows())}>"

    def _repr_html_(self) -> str:
        from gearplay.pictures.pages import html_table, sparkline

        return html_table(self.rows()) + sparkline(self.amplitude, "amplitude over frequency")


def amplitude_spectrum(
    signal: Floats, sampling: float, *, window: str = "hann", normalisation: str = "amplitude", unit: str = ""
) -> Spectrum:
    """Return the one-sided amplitude spectrum of a record, shape [time], sampled at ``sampling`` [Hz].

    The mean is taken off first. "amplitude": 2 |X_k| / sum(w), the window's coherent gain corrected. "unnormalised": |X_k|.

    Parameters
    ----------
    signal
        Samples, shape [time].
    sampling
        Sampling rate [Hz].
    window
        Name of a window of `scipy.signal`.
    normalisation
        "amplitude" or "unnormalised".
    unit
        Unit of the signal.

    Returns
    -------
    Spectrum
        ``frequency`` [Hz] and ``amplitude`` [unit], shape [line].

    Raises
    ------
    InputError
        For a record that is too short or not finite, or an unknown window or normalisation.

    Examples
    --------
    >>> t = np.arange(1000) / 1000.0
    >>> s = amplitude_spectrum(3.0 * np.sin(2.0 * np.pi * 50.0 * t), 1000.0)
    >>> round(float(s.amplitude[50]), 9)
    3.0

    """
    if normalisation not in NORMALISATIONS:
        cure = f"Choose from {NORMALISATIONS}"
        raise InputError.of("normalisation", normalisation, "must be a known normalisation", cure)
    signal = np.asarray(signal)
    is_real = signal.dtype.kind in "fiub"
    if not is_real or signal.ndim != 1 or signal.size < 8 or not np.all(np.isfinite(signal)):
        rule = "must be one record of at least 8 finite samples"
        cure = "Simulate longer, or pick one rotor and one member"
        raise InputError.of("signal", f"{signal.shape} of {signal.dtype}", rule, cure)
    n = signal.size
    weights = check_window(window, n)
    transform: Floats = np.abs(np.fft.rfft((signal - np.mean(signal)) * weights))
    if normalisation == "amplitude":
        transform *= 2.0 / np.sum(weights)
        transform[0] *= 0.5
        if n % 2 == 0:
            transform[-1] *= 0.5
    frequency: Floats = np.asarray(np.fft.rfftfreq(n, 1.0 / sampling), dtype=np.float64)
    return Spectrum(frequency, transform, window, normalisation, unit)


def ensemble_spectrum(
    signals: Sequence[Floats],
    sampling: float,
    *,
    window: str = "hann",
    normalisation: str = "amplitude",
    unit: str = "",
) -> Spectrum:
    """Return the rms average of the members' amplitude spectra, with the spread of log10(amplitude) in decades.

    Motion with clearances is chaotic: a single record's spectrum repeats to some 0.2 decades only, so comparisons
    use this average.

    Parameters
    ----------
    signals
        Records of one length, each of shape [time].
    sampling
        Sampling rate [Hz].
    window
        Name of a window of `scipy.signal`.
    normalisation
        "amplitude" or "unnormalised".
    unit
        Unit of the signals.

    Returns
    -------
    Spectrum
        With ``spread``, the standard deviation of log10(amplitude) over the members [decades].

    Raises
    ------
    InputError
        For records of different lengths, whose spectra have different lines, and as `amplitude_spectrum` does.

    Examples
    --------
    >>> both = ensemble_spectrum([np.sin(np.arange(64.0)), 2.0 * np.sin(np.arange(64.0))], 64.0)
    >>> both.members, both.amplitude.shape
    (2, (33,))

    """
    if not (isinstance(signals, (Sequence, np.ndarray)) and all(np.ndim(each) == 1 for each in signals)):
        raise InputError.of("signals", signals, "must be a list of records", "Give the arrays of the members")
    lengths = {len(signal) for signal in signals}
    if len(lengths) != 1:
        rule = "must have one length: a member that stopped early has other lines"
        shown = ", ".join(map(str, sorted(lengths))) or "no records"
        raise InputError.of("signals", f"{shown} samples", rule, "Leave out members that did not finish")
    each = [
        amplitude_spectrum(s, sampling, window=window, normalisation=normalisation, unit=unit)
        for s in signals
    ]
    table = np.array([s.amplitude for s in each])
    tiny = np.finfo(float).tiny
    return Spectrum(
        frequency=each[0].frequency,
        amplitude=np.sqrt(np.mean(table**2, axis=0)),
        window=window,
        normalisation=normalisation,
        unit=unit,
        members=len(each),
        spread=np.std(np.log10(np.maximum(table, tiny)), axis=0, ddof=1) if len(each) > 1 else None,
        each=table,
    )


def smoothed(spectrum: Spectrum, low: float, high: float, width: float) -> tuple[Floats, Floats]:
    """Return (frequency, amplitude) between ``low`` and ``high`` [Hz], smoothed in power.

    The kernel is a Gaussian of relative standard deviation ``width``, so that a hump keeps its shape on a logarithmic axis.
    """
    f, power = spectrum.frequency, spectrum.amplitude**2
    centres = f[(f >= low) & (f <= high) & (f > 0.0)]
    weights = np.exp(-0.5 * ((f[None, 1:] - centres[:, None]) / (width * centres[:, None])) ** 2)
    return centres, np.sqrt(weights @ power[1:] / np.sum(weights, axis=1))


LONGEST_KEPT = 100_000
"""A longer window [samples] is not cached."""


def _window(name: str, n: int) -> Floats:
    """Return a periodic window; ``ValueError`` for an unknown name."""
    from scipy.signal import get_window

    weights = np.asarray(get_window(name, n, fftbins=True), dtype=np.float64)
    weights.flags.writeable = False  # it may be cached
    return weights


_short_window = lru_cache(maxsize=16)(_window)
"""Cached, since the records of a sweep or an ensemble are alike."""


def check_window(name: str, n: int) -> Floats:
    """Return the periodic `scipy.signal` window ``name`` of ``n`` samples, shape [sample].

    Raises `InputError` for an unknown name, or a window that needs a parameter.

    >>> check_window("hann", 4).tolist()
    [0.0, 0.5, 1.0, 0.5]
    """
    try:
        if not isinstance(name, str):
            raise ValueError
        return _short_window(name, n) if n <= LONGEST_KEPT else _window(name, n)
    except ValueError:
        rule = "must be a window of scipy.signal without parameters"
        raise InputError.of("window", name, rule, "Try 'hann', 'boxcar' or 'flattop'") from None


def student_widening(count: int) -> float:
    """Return half the 95 % confidence interval of the mean of ``count`` values over their standard deviation.

    >>> round(student_widening(8), 3), round(student_widening(1000), 4)
    (0.836, 0.0621)
    """
    from scipy.special import stdtrit

    return float(stdtrit(count - 1, 0.975)) / math.sqrt(count)
