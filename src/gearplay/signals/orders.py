"""Order analysis: content at constant multiples of a shaft's speed."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gearplay.files.record import Channel
from gearplay.signals.angle import AngleRecord, ShaftAngle
from gearplay.signals.averaging import AveragedSpectrum, averaged_spectrum
from gearplay.signals.checks import TWO_PI, check_overlap, check_positive, refuse
from gearplay.signals.resampling import resampled
from gearplay.signals.spectrograms import spectrogram

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class OrderSpectrum:
    """Amplitude over order, averaged over segments of the turned angle.

    ``order`` [1] and ``amplitude`` [unit] have shape [line]; ``speed_low`` and ``speed_high`` [rad/s] bound the record's
    speed; ``spectrum`` holds the settings, its "hertz" being orders.
    """

    order: Floats
    amplitude: Floats
    unit: str
    spectrum: AveragedSpectrum
    samples_per_revolution: int
    speed_low: float
    speed_high: float
    source: str
    name: str = ""

    @property
    def resolution(self) -> float:
        """Distance of two lines [order]."""
        return self.spectrum.resolution

    @property
    def caption(self) -> str:
        """The settings in one line."""
        s = self.spectrum
        return (
            f"window {s.window}, {s.averages} segment{'s' if s.averages > 1 else ''} of {1.0 / s.resolution:.5g} revolutions, "
            f"overlap {100.0 * s.overlap:.3g} %, line spacing {s.resolution:.4g} orders, "
            f"{_speeds(self.speed_low, self.speed_high)}; {self.source}"
        )


@dataclass(frozen=True)
class OrderMap:
    """Amplitude over order and revolution, with time and speed of each slice.

    ``order`` has shape [line]; ``revolution`` [rev], ``time`` [s] and ``speed`` [rad/s] of the middle of each segment have
    shape [slice]; ``amplitude`` [unit] has shape [line, slice]; ``segment`` is in revolutions.
    """

    order: Floats
    revolution: Floats
    time: Floats
    speed: Floats
    amplitude: Floats
    unit: str
    window: str
    segment: float
    overlap: float
    source: str
    name: str = ""

    @property
    def caption(self) -> str:
        """The settings in one line."""
        return (
            f"window {self.window}, {self.time.size} segments of {self.segment:.4g} revolutions, "
            f"overlap {100.0 * self.overlap:.3g} %, line spacing {1.0 / self.segment:.4g} orders; {self.source}"
        )


@dataclass(frozen=True)
class OrderTracks:
    """Amplitude and phase of chosen orders over revolution, time and speed.

    ``orders`` has shape [order]; ``revolution`` [rev], ``time`` [s], ``speed`` [rad/s] have shape [block]; ``amplitude``
    [unit] and ``phase`` [rad] have shape [order, block]: a cos(order angle + phase), angle from the shaft's zero.
    ``residual_share`` [block] is the share of the block's mean square, weighted by the window, that the orders leave.
    """

    orders: Floats
    revolution: Floats
    time: Floats
    speed: Floats
    amplitude: Floats
    phase: Floats
    residual_share: Floats
    unit: str
    block: float
    overlap: float
    source: str
    name: str = ""

    @property
    def caption(self) -> str:
        """The settings in one line."""
        return (
            f"least squares, Hann-weighted, {self.time.size} blocks of {self.block:.4g} revolutions, "
            f"overlap {100.0 * self.overlap:.3g} %; {self.source}"
        )


def _speeds(low: float, high: float) -> str:
    low, high = 60.0 * low / TWO_PI, 60.0 * high / TWO_PI
    return f"{low:.5g} rpm" if high - low < 1e-4 * high else f"{low:.4g} to {high:.4g} rpm"


def _samples(record: AngleRecord, revolutions: float | None, default: float) -> int:
    """Return the length of a segment [sample] of a number of revolutions."""
    wanted = min(default, record.revolutions) if revolutions is None else revolutions
    check_positive("revolutions", wanted, "")
    samples = round(wanted * record.samples_per_revolution)
    if not 8 <= samples <= record.values.size:
        rule = f"must be at most {record.revolutions:.5g}, all of the record, and hold 8 samples"
        refuse("revolutions", wanted, rule, "Choose another number of revolutions")
    return samples


def order_spectrum(
    channel: Channel,
    speed: float | Channel | ShaftAngle,
    *,
    highest: float | None = None,
    revolutions: float | None = None,
    window: str = "hann",
    overlap: float = 0.5,
    averaging: str = "mean",
) -> OrderSpectrum:
    """Return the amplitude spectrum over orders of a shaft, averaged over segments of ``revolutions`` turns.

    The record is first taken to equal angles (`resampled`, which see for ``speed`` and ``highest``). Without ``revolutions``
    all whole revolutions are one segment. Source: Brandt, Noise and Vibration Analysis (2011), chapter 12.

    Parameters
    ----------
    channel
        Signal, shape [time].
    speed
        Of the shaft: a constant [rad/s], a speed channel, or a `ShaftAngle`.
    highest
        Highest order; as far as the sampling allows if not given.
    revolutions
        Revolutions of a segment; all whole ones if not given.
    window
        Name of a window of `scipy.signal`.
    overlap
        Share of a segment that the next one takes again, 0 to 0.95.
    averaging
        "mean" or "median" over segments.

    Returns
    -------
    OrderSpectrum
        ``order`` [1/rev] and ``amplitude`` [unit], shape [line].

    Raises
    ------
    InputError
        For a speed that is not positive, too short a record, or impossible settings.

    Examples
    --------
    >>> c = Channel("acc", 2.0 * np.cos(2.0 * np.pi * 30.0 * np.arange(4001) / 1000.0), 1000.0, "m/s^2")
    >>> s = order_spectrum(c, 2.0 * np.pi * 10.0)
    >>> at = int(np.argmax(s.amplitude))
    >>> round(float(s.order[at]), 9), round(float(s.amplitude[at]), 3)
    (3.0, 2.0)

    """
    record = resampled(channel, speed, highest=highest)
    segment = _samples(record, revolutions, float(int(record.revolutions)))
    s = averaged_spectrum(
        record.channel(), window=window, segment=segment, overlap=overlap, averaging=averaging
    )
    kept = s.frequency <= record.highest * (1.0 + 1e-12)
    return OrderSpectrum(
        s.frequency[kept], s.values[kept], channel.unit, s, record.samples_per_revolution,
        float(record.speed.min()), float(record.speed.max()), record.source, channel.name,
    )  # fmt: skip


def order_map(
    channel: Channel,
    speed: float | Channel | ShaftAngle,
    *,
    highest: float | None = None,
    revolutions: float | None = None,
    window: str = "hann",
    overlap: float = 0.5,
) -> OrderMap:
    """Return the amplitude over order and revolution, from segments of ``revolutions`` turns (default 8).

    Source and faults as `order_spectrum`.

    Parameters
    ----------
    channel
        Signal, shape [time].
    speed
        Of the shaft: a constant [rad/s], a speed channel, or a `ShaftAngle`.
    highest
        Highest order; as far as the sampling allows if not given.
    revolutions
        Revolutions of a segment, 8 if not given.
    window
        Name of a window of `scipy.signal`.
    overlap
        Share of a segment that the next one takes again, 0 to 0.95.

    Returns
    -------
    OrderMap
        ``amplitude`` [unit], shape [order, segment].

    Raises
    ------
    InputError
        As `order_spectrum`.

    Examples
    --------
    >>> c = Channel("acc", 2.0 * np.cos(2.0 * np.pi * 30.0 * np.arange(4001) / 1000.0), 1000.0, "m/s^2")
    >>> m = order_map(c, 2.0 * np.pi * 10.0, revolutions=4)
    >>> m.amplitude.shape[1], float(m.order[12]), bool(np.allclose(m.amplitude[12], 2.0, rtol=1e-3))
    (19, 3.0, True)

    """
    record = resampled(channel, speed, highest=highest)
    segment = _samples(record, revolutions, 8.0)
    made = spectrogram(record.channel(), window=window, segment=segment, overlap=overlap)
    kept = made.frequency <= record.highest * (1.0 + 1e-12)
    middle = np.round((made.time * record.samples_per_revolution) - record.first).astype(int)
    return OrderMap(
        made.frequency[kept], made.time, record.time[middle], record.speed[middle], made.values[kept], channel.unit,
        window, segment / record.samples_per_revolution, made.overlap, record.source, channel.name,
    )  # fmt: skip


def _check_orders(orders: Sequence[float], record: AngleRecord, turns: float) -> Floats:
    wanted = np.array([check_positive(f"orders[{i}]", o, "") for i, o in enumerate(orders)])
    if wanted.size == 0:
        refuse("orders", list(orders), "must name at least one order", "Give orders, for example (1, 20)")
    ordered = np.sort(wanted)
    closest = float(np.min(np.diff(ordered))) if ordered.size > 1 else np.inf
    if min(closest, float(ordered[0])) * turns < 2.0:
        shown = ", ".join(f"{o:g}" for o in ordered[:8])
        rule = f"must lie at least {2.0 / turns:.4g} apart and from zero, 2 lines of a block of {turns:g} revolutions"
        refuse("orders", shown, rule, "Lengthen the blocks")
    if ordered[-1] > record.highest * (1.0 + 1e-9):
        rule = f"must be at most {record.highest:.5g}, the highest order kept"
        refuse("orders", float(ordered[-1]), rule, "Raise `highest` or sample faster")
    return wanted


def track_orders(
    channel: Channel,
    speed: float | Channel | ShaftAngle,
    orders: Sequence[float],
    *,
    revolutions: float = 8.0,
    overlap: float = 0.5,
    highest: float | None = None,
) -> OrderTracks:
    """Return amplitude and phase of the ``orders`` in blocks of ``revolutions`` turns.

    In each block cosine and sine of all orders and a constant are fitted at once by least squares, weighted by a Hann window,
    so that an order need not fall on a line, neighbours do not leak and other content hardly does.

    Source: Blough, Mech. Syst. Signal Process. 17 (2003) 1187 (orthogonality compensation); weights: ours.

    Parameters
    ----------
    channel
        Signal, shape [time].
    speed
        Of the shaft: a constant [rad/s], a speed channel, or a `ShaftAngle`.
    orders
        Orders to follow [1/rev].
    revolutions
        Revolutions of a block.
    overlap
        Share of a segment that the next one takes again, 0 to 0.95.
    highest
        Highest order; as far as the sampling allows if not given.

    Returns
    -------
    OrderTracks
        ``amplitude`` [unit] and ``phase`` [rad], shape [order, block].

    Raises
    ------
    InputError
        For a speed that is not positive, orders too close or too high, or too short a record.

    Examples
    --------
    >>> c = Channel("acc", 2.0 * np.cos(2.0 * np.pi * 30.0 * np.arange(4001) / 1000.0), 1000.0, "m/s^2")
    >>> tracks = track_orders(c, 2.0 * np.pi * 10.0, (1.0, 3.0), revolutions=4.0)
    >>> np.round(np.abs(tracks.amplitude[:, 5]), 3).tolist(), round(abs(float(tracks.phase[1, 5])), 3)
    ([0.0, 2.0], 0.0)

    """
    record = resampled(channel, speed, highest=highest)
    segment = _samples(record, revolutions, revolutions)
    per = record.samples_per_revolution
    wanted = _check_orders(orders, record, segment / per)
    hop = max(1, segment - round(check_overlap(overlap) * segment))
    turn = TWO_PI * np.arange(segment) / per
    basis = np.hstack([
        np.cos(np.outer(turn, wanted)), np.sin(np.outer(turn, wanted)), np.ones((segment, 1))
    ])  # fmt: skip
    weights = np.hanning(segment + 2)[1:-1]
    inverse = np.linalg.pinv(basis * weights[:, None])
    blocks = np.lib.stride_tricks.sliding_window_view(record.values, segment)[::hop]
    fitted = np.array([inverse @ (block * weights) for block in blocks])
    left = np.array([np.sum((weights * (b - basis @ c)) ** 2) for b, c in zip(blocks, fitted, strict=True)])
    held = np.array([np.sum((weights * b) ** 2) for b in blocks])
    complexes = (fitted[:, : wanted.size] - 1j * fitted[:, wanted.size : 2 * wanted.size]).T
    starts = np.arange(blocks.shape[0]) * hop
    phase = np.angle(complexes * np.exp(-1j * TWO_PI * np.outer(wanted, (record.first + starts) / per)))
    middle = starts + segment // 2
    return OrderTracks(
        wanted, (record.first + middle) / per, record.time[middle], record.speed[middle], np.abs(complexes), phase,
        left / np.maximum(held, np.finfo(float).tiny), channel.unit, segment / per, 1.0 - hop / segment, record.source,
        channel.name,
    )  # fmt: skip
