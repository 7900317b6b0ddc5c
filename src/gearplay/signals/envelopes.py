"""Envelopes of a frequency band, and their spectra."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from gearplay.files.record import Channel
from gearplay.signals.averaging import AveragedSpectrum, averaged_spectrum
from gearplay.signals.checks import check_band, check_channel, check_choice, check_count, refuse

Floats = NDArray[np.float64]

FILTERS = ("fft", "butterworth")


@dataclass(frozen=True)
class Envelope:
    """Envelope of a signal's band from ``low`` to ``high`` [Hz].

    ``channel`` holds the envelope, shape [time], in the signal's unit; ``band`` the filtered signal; ``filter`` is "fft" (a
    sharp band, circular) or "butterworth" (of ``order``, forwards and backwards).
    """

    channel: Channel
    band: Channel
    low: float
    high: float
    filter: str
    order: int

    @property
    def caption(self) -> str:
        """The settings in one line."""
        kind = "FFT band-pass" if self.filter == "fft" else f"zero-phase Butterworth of order {self.order}"
        return f"{kind} {self.low:.6g} to {self.high:.6g} Hz, Hilbert envelope"


@dataclass(frozen=True)
class EnvelopeSpectrum:
    """Amplitude spectrum of an envelope, with the envelope it was made from."""

    spectrum: AveragedSpectrum
    envelope: Envelope

    @property
    def caption(self) -> str:
        """The settings in one line."""
        return f"{self.envelope.caption}\n{self.spectrum.caption}"


def _analytic_by_fft(values: Floats, sampling: float, low: float, high: float) -> NDArray[np.complex128]:
    """Return the analytic signal of the band: its positive frequencies alone, doubled."""
    n = values.size
    transform = np.fft.fft(values)
    frequency = np.fft.fftfreq(n, 1.0 / sampling)
    # Zero and half the sampling rate have no mirror image, so doubling them would count them twice.
    gain = np.where((frequency > 0.0) & (frequency < 0.5 * sampling), 2.0, 1.0)
    magnitude = np.where(frequency == -0.5 * sampling, -frequency, frequency)
    gain[(magnitude < low) | (magnitude > high)] = 0.0
    result: NDArray[np.complex128] = np.fft.ifft(transform * gain)
    return result


def _analytic_by_butterworth(
    channel: Channel, values: Floats, low: float, high: float, order: int
) -> NDArray[np.complex128]:
    from scipy.signal import butter, hilbert, sosfiltfilt

    if low == 0.0 or high >= 0.5 * channel.sampling:
        rule = "must lie strictly between 0 Hz and half the sampling rate for a Butterworth band-pass"
        refuse("band", f"{low:g} to {high:g} Hz", rule, "Narrow the band or take filter 'fft'")
    sections = butter(order, (low, high), btype="bandpass", fs=channel.sampling, output="sos")
    padding = min(values.size - 1, 3 * (2 * order + 1))
    result: NDArray[np.complex128] = hilbert(sosfiltfilt(sections, values, padlen=padding))
    return result


def envelope(channel: Channel, low: float, high: float, *, filter: str = "fft", order: int = 4) -> Envelope:
    """Return the envelope of the band from ``low`` to ``high`` [Hz]: the modulus of its analytic signal.

    Both filters shift no phase. "fft" cuts the band sharply and takes the record as periodic, so its ends influence each
    other; "butterworth" has sloping sides, order 2 ``order`` each after both passes, and settles at the ends.

    Source: Randall, Vibration-based Condition Monitoring (2011), section 3.3 and chapter 5.

    Parameters
    ----------
    channel
        Signal, shape [time].
    low, high
        Ends of the band [Hz].
    filter
        "fft" or "butterworth".
    order
        Of the Butterworth filter.

    Returns
    -------
    Envelope
        The envelope as a channel [unit of the signal], with its settings in ``caption``.

    Raises
    ------
    InputError
        For samples that are too few or not finite, a band that is empty or above half the sampling rate, and an unknown filter.

    Examples
    --------
    >>> t = np.arange(400) / 400.0
    >>> c = Channel("acc", 2.0 * np.cos(2.0 * np.pi * 100.0 * t) + np.cos(2.0 * np.pi * 10.0 * t), 400.0)
    >>> e = envelope(c, 80.0, 120.0)
    >>> bool(np.allclose(e.channel.values, 2.0)), e.caption
    (True, 'FFT band-pass 80 to 120 Hz, Hilbert envelope')

    """
    values = check_channel(channel, 32)
    low, high = check_band(channel, low, high)
    check_choice("filter", filter, FILTERS)
    check_count("order", order, 1, 12, "4 is usual")
    if filter == "fft":
        analytic = _analytic_by_fft(values, channel.sampling, low, high)
    else:
        analytic = _analytic_by_butterworth(channel, values, low, high, order)
    made = [
        Channel(f"{channel.name}, {word}", part, channel.sampling, channel.unit, channel.start)
        for word, part in (("envelope", np.abs(analytic)), ("band", np.ascontiguousarray(analytic.real)))
    ]
    return Envelope(made[0], made[1], low, high, filter, order)


def envelope_spectrum(
    channel: Channel,
    low: float,
    high: float,
    *,
    filter: str = "fft",
    order: int = 4,
    window: str = "hann",
    segment: int | None = None,
    overlap: float = 0.5,
) -> EnvelopeSpectrum:
    """Return the amplitude spectrum of the envelope of the band from ``low`` to ``high`` [Hz], its mean taken off.

    Of a (1 + m cos(2 pi f t)) modulated carrier it holds a line of height a m at f. ``segment`` is all of the record unless
    given [samples]. Source and faults as `envelope` and `averaged_spectrum`.

    Parameters
    ----------
    channel
        Signal, shape [time].
    low, high
        Ends of the band [Hz].
    filter, order
        As `envelope` takes them.
    window, overlap
        As `averaged_spectrum` takes them.
    segment
        Length of a segment [samples]; all of the record if not given.

    Returns
    -------
    EnvelopeSpectrum
        ``spectrum`` of the envelope, and its settings.

    Raises
    ------
    InputError
        As `envelope` and `averaged_spectrum`.

    Examples
    --------
    >>> t = np.arange(1000) / 1000.0
    >>> x = (1.0 + 0.5 * np.cos(2.0 * np.pi * 5.0 * t)) * np.cos(2.0 * np.pi * 200.0 * t)
    >>> s = envelope_spectrum(Channel("acc", x, 1000.0), 150.0, 250.0).spectrum
    >>> round(float(s.values[5]), 6), float(s.frequency[5])
    (0.5, 5.0)

    """
    made = envelope(channel, low, high, filter=filter, order=order)
    length = made.channel.values.size if segment is None else segment
    spectrum = averaged_spectrum(made.channel, window=window, segment=length, overlap=overlap)
    return EnvelopeSpectrum(spectrum, made)


def most_impulsive_band(channel: Channel, *, levels: int = 4) -> tuple[float, float]:
    """Return the band [Hz] whose envelope has the greatest kurtosis, of 2, 3, 4, 6, 8, 12 ... equal bands.

    Bands and measure are those of the fast kurtogram (its tree of halves and thirds), each cut sharply by FFT instead of by its
    filters: a resonance that shocks excite stands out. The lowest and highest twentieth of the frequencies are left out, where
    the mean and an anti-aliasing filter live. One shock in the whole record has a large kurtosis too.

    Source: Antoni, Mech. Syst. Signal Process. 21 (2007) 108.

    Parameters
    ----------
    channel
        Signal, shape [time].
    levels
        How often the frequencies are halved; between two halvings thirds are tried.

    Returns
    -------
    tuple of float
        Ends of the band [Hz].

    Raises
    ------
    InputError
        For samples that are too few or not finite.

    Examples
    --------
    >>> c = Channel("acc", np.cos(2.0 * np.pi * 300.0 * np.arange(2000) / 1000.0) * (np.arange(2000) % 250 < 10), 1000.0)
    >>> low, high = most_impulsive_band(c, levels=2)
    >>> low < 300.0 < high
    True

    """
    values = check_channel(channel, 256)
    first, last = 0.025 * channel.sampling, 0.475 * channel.sampling
    best, chosen = -np.inf, (first, last)
    for count in sorted({2**k for k in range(1, levels + 1)} | {3 * 2**k for k in range(levels - 1)}):
        edges = np.linspace(first, last, count + 1)
        for low, high in pairwise(edges):
            if (high - low) * channel.duration < 16.0:
                continue
            power = np.abs(_analytic_by_fft(values, channel.sampling, low, high)) ** 2
            mean = float(np.mean(power))
            kurtosis = float(np.mean(power * power)) / mean**2 if mean > 0.0 else 0.0
            if kurtosis > best:
                best, chosen = kurtosis, (float(low), float(high))
    return chosen
