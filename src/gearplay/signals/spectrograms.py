"""Spectrograms: amplitude or density over time and frequency, by the short-time Fourier transform."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gearplay.files.record import Channel
from gearplay.results.spectra import check_window
from gearplay.signals.checks import check_channel, check_choice, check_count, check_overlap, refuse

Floats = NDArray[np.float64]

KINDS = ("amplitude", "density")
MOST_CELLS = 20_000_000
"""Most values of a spectrogram; more fill the memory and no picture shows them."""


@dataclass(frozen=True)
class Spectrogram:
    """Amplitude [unit] or density [unit^2/Hz] over time and frequency.

    ``time`` [s], shape [slice], is that of the middle of each segment; ``frequency`` [Hz] has shape [line] and ``values``
    shape [line, slice]. ``segment`` and ``hop`` are in samples, ``overlap`` is a share.
    """

    time: Floats
    frequency: Floats
    values: Floats
    kind: str
    unit: str
    window: str
    segment: int
    hop: int
    sampling: float
    name: str = ""

    @property
    def overlap(self) -> float:
        """Overlap of consecutive segments, as a share of their length."""
        return 1.0 - self.hop / self.segment

    @property
    def resolution(self) -> float:
        """Distance of two lines [Hz]."""
        return self.sampling / self.segment

    @property
    def caption(self) -> str:
        """The settings in one line."""
        return (
            f"window {self.window}, {self.time.size} segments of {self.segment}, overlap {100.0 * self.overlap:.3g} %, "
            f"line spacing {self.resolution:.4g} Hz, {1000.0 * self.hop / self.sampling:.4g} ms apart"
        )


def _segment(n: int) -> int:
    """Return the power of two near a hundredth of ``n`` samples, but from 64 to 8192 and at most half of them."""
    return min(max(n // 2, 8), max(64, min(8192, 1 << max(n // 100, 1).bit_length())))


def spectrogram(
    channel: Channel,
    *,
    kind: str = "amplitude",
    window: str = "hann",
    segment: int | None = None,
    overlap: float = 0.5,
) -> Spectrogram:
    """Return the spectrogram of a channel, its mean subtracted; only complete segments are used.

    "amplitude": a sine of amplitude a is a ridge of height a (window's coherent gain corrected). "density": one-sided, as
    `power_density`. Source: scipy.signal.ShortTimeFFT; Groechenig, Foundations of Time-Frequency Analysis (2001), section 3.

    Parameters
    ----------
    channel
        Signal, shape [time].
    kind
        "amplitude" or "density".
    window
        Name of a window of `scipy.signal`.
    segment
        Length of a segment [samples].
    overlap
        Share of a segment that the next one takes again, 0 to 0.95.

    Returns
    -------
    Spectrogram
        ``values``, shape [line, time], over ``frequency`` [Hz] and ``time`` [s].

    Raises
    ------
    InputError
        For samples that are too few or not finite, impossible settings, or more than 2e7 values.

    Examples
    --------
    >>> t = np.arange(1000) / 1000.0
    >>> s = spectrogram(Channel("acc", 3.0 * np.cos(2.0 * np.pi * 100.0 * t), 1000.0, "m/s^2"), segment=100)
    >>> bool(np.allclose(s.values[10], 3.0)), float(s.frequency[10]), s.values.shape
    (True, 100.0, (51, 19))
    >>> float(s.time[0])
    0.05

    """
    from scipy.signal import ShortTimeFFT

    values = check_channel(channel, 16)
    check_choice("kind", kind, KINDS)
    length = _segment(values.size) if segment is None else segment
    check_count("segment", length, 8, values.size, "Shorten it")
    hop = max(1, length - round(check_overlap(overlap) * length))
    weights = check_window(window, length)
    slices = 1 + (values.size - length) // hop
    if slices * (length // 2 + 1) > MOST_CELLS:
        rule = f"must leave at most {MOST_CELLS} values"
        refuse("overlap", overlap, rule, "Lower the overlap or cut the record")
    transform = ShortTimeFFT(
        weights, hop, channel.sampling, fft_mode="onesided2X",
        scale_to="magnitude" if kind == "amplitude" else "psd",
    )  # fmt: skip
    first, last = transform.lower_border_end[1], transform.upper_border_begin(values.size)[1]
    modulus = np.abs(transform.stft(values - np.mean(values), first, last))
    time = channel.start + transform.delta_t * np.arange(first, last)
    shown = modulus if kind == "amplitude" else modulus**2
    unit = channel.unit if kind == "amplitude" or not channel.unit else f"({channel.unit})^2/Hz"
    return Spectrogram(time, np.asarray(transform.f), shown, kind, unit, window, length, hop, channel.sampling,
                       channel.name)  # fmt: skip
