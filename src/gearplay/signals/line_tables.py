"""Tables of spectral lines: frequency, amplitude and phase of expected tones with uncertainty."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gearplay.files.record import Channel
from gearplay.signals.checks import check_channel, check_choice, check_positive, refuse
from gearplay.signals.tone_fit import COSINES, Transform, squared_window, windowed_transform
from gearplay.signals.tone_search import Tone, find_tones, power_threshold

Floats = NDArray[np.float64]

NEAR = 8.0  # lines on each side in which a hump shows itself
ALONE = 0.6  # least share of the fitted power that near; a carrier modulated in full has 2/3
SHARP = 0.5  # least share of the power around a line that one tone explains
CLOSEST = 3.0  # lines between two expected frequencies, a Hann window's main lobe resolves no less


@dataclass(frozen=True)
class LineRow:
    """Result for one expected line, with standard uncertainties (68 %; 1.96 times them cover 95 %).

    ``expected``, ``frequency``, ``frequency_uncertainty`` [Hz]; ``amplitude``, ``amplitude_uncertainty`` and ``limit``, the
    smallest amplitude distinguishable from noise [unit]; ``phase``, ``phase_uncertainty`` [rad], of a cosine at the
    first sample; ``prominence`` the line's height over the rms noise of a line [1]; ``noise`` the one-sided density
    nearby [unit^2/Hz]. Without a line (``found`` false) the numbers of the line are nan and ``remark`` says why.
    """

    expected: float
    found: bool
    frequency: float
    frequency_uncertainty: float
    amplitude: float
    amplitude_uncertainty: float
    phase: float
    phase_uncertainty: float
    prominence: float
    limit: float
    noise: float
    remark: str = ""


@dataclass(frozen=True)
class LineTable:
    """Rows in the order of the expected frequencies, with the settings: ``resolution`` [Hz], ``false_alarm`` a probability."""

    rows: tuple[LineRow, ...]
    unit: str
    window: str
    resolution: float
    samples: int
    sampling: float
    search: float
    false_alarm: float
    name: str = ""

    @property
    def found(self) -> tuple[LineRow, ...]:
        """Rows with a line."""
        return tuple(row for row in self.rows if row.found)

    @property
    def caption(self) -> str:
        """The settings in one line."""
        return (
            f"window {self.window}, least squares of all tones at once, line spacing {self.resolution:.4g} Hz, "
            f"search within {100.0 * self.search:.3g} %, false alarms {100.0 * self.false_alarm:.3g} %"
        )


def _bands(expected: Floats, search: float, resolution: float, last: int) -> list[tuple[int, int]]:
    """Return the lines (first, last) in which each expected tone is sought; neighbours part midway."""
    order = np.argsort(expected)
    bands = [(0, 0)] * expected.size
    for at, i in enumerate(order):
        place = expected[i] / resolution
        margin = max(search * place, 1.5)
        low, high = place - margin, place + margin
        if at > 0:
            low = max(low, 0.5 * (place + expected[order[at - 1]] / resolution))
        if at + 1 < order.size:
            high = min(high, 0.5 * (place + expected[order[at + 1]] / resolution))
        bands[i] = (max(2, math.ceil(low)), min(last, math.floor(high)))
    return bands


def _check_expected(expected: Sequence[float], channel: Channel) -> Floats:
    wanted = np.array([check_positive(f"expected[{i}]", f, "Hz") for i, f in enumerate(expected)])
    if wanted.size == 0:
        cure = "Give the frequencies to look for [Hz]"
        refuse("expected", "none", "must name at least one frequency", cure)
    resolution = 1.0 / channel.duration
    low, high = 3.0 * resolution, 0.5 * channel.sampling - 2.0 * resolution
    for i in np.flatnonzero((wanted < low) | (wanted > high)):
        rule = f"must lie from {low:.4g} to {high:.6g} Hz, within what the record resolves"
        refuse(f"expected[{i}]", float(wanted[i]), rule, "Take a longer record or sample faster")
    gaps = np.diff(np.sort(wanted))
    if gaps.size and float(np.min(gaps)) < CLOSEST * resolution:
        rule = f"must lie at least {CLOSEST * resolution:.4g} Hz apart, {CLOSEST:g} lines of the record"
        found = f"{float(np.min(gaps)):.4g} Hz apart"
        refuse("expected", found, rule, "Take a longer record or name one of them")
    return wanted


def line_table(
    channel: Channel,
    expected: Sequence[float],
    *,
    search: float = 0.03,
    window: str = "hann",
    false_alarm: float = 1e-3,
) -> LineTable:
    """Return the strongest tone near each expected frequency, within ``expected`` (1 -+ ``search``) [Hz], with uncertainties.

    All tones that stand out near the expected frequencies, sidebands too, are fitted at once by least squares on the lines of
    the windowed transform (see `fit_tones`), so that neighbours bias nothing. The uncertainty comes from the noise
    density around the line, what is left after the fit (see `covariance`). A tone counts where its line stands so far over
    the local noise that noise alone does so with probability ``false_alarm`` in the band searched, and where a tone explains at
    least half of the power around it, without unexpected neighbours of like height: a broad hump is no line.

    Parameters
    ----------
    channel
        Signal, shape [time], at least 128 samples.
    expected
        Frequencies [Hz], at least 3 lines of the record apart.
    search
        Relative half width of the band searched, at least 1.5 lines; it ends midway to the next expected frequency.
    window
        "hann" and "blackman" keep far lines out; "boxcar" has the least uncertainty in white noise (Cramer-Rao).
    false_alarm
        Probability of finding a line where there is noise alone.

    Returns
    -------
    LineTable
        A row for each expected frequency: frequency [Hz], amplitude [unit] and phase [rad] with standard uncertainties.

    Raises
    ------
    InputError
        For samples that are too few or not finite, frequencies that the record does not resolve, and unknown settings.

    Examples
    --------
    >>> t = np.arange(4000) / 1000.0
    >>> x = 2.0 * np.cos(2.0 * np.pi * 40.1 * t + 0.5) + 0.1 * np.random.default_rng(1).standard_normal(4000)
    >>> table = line_table(Channel("acc", x, 1000.0, "m/s^2"), (40.0, 90.0))
    >>> line, none = table.rows
    >>> round(line.frequency, 2), round(line.amplitude, 1), round(line.phase, 1), line.amplitude_uncertainty < 0.005
    (40.1, 2.0, 0.5, True)
    >>> none.found, none.limit < 0.02
    (False, True)

    """
    values = check_channel(channel, 128)
    check_choice("window", window, tuple(COSINES))
    if not 0.0 < search <= 0.5:
        refuse("search", search, "must be a share above 0 and at most 0.5", "0.03 is usual")
    if not 0.0 < false_alarm < 1.0:
        refuse("false_alarm", false_alarm, "must be a probability between 0 and 1", "0.001 is usual")
    wanted = _check_expected(expected, channel)
    resolution = channel.sampling / values.size
    transform = windowed_transform(values, window)
    bands = _bands(wanted, search, resolution, transform.lines.size - 3)
    tones, noise = find_tones(transform, bands, false_alarm)
    rows = []
    for i, band in enumerate(bands):
        unexpected = [t for t in tones if not any(_holds(other, t) for other in bands if other != band)]
        # A sharp line, however weak, comes before a broad hump.
        best = max(
            (t for t in unexpected if _holds(band, t)),
            key=lambda t: (_sharp(t, unexpected), abs(t.amplitude)),
            default=None,
        )
        power = best.noise if best is not None else float(noise[i])
        least = math.sqrt(power_threshold(band[1] - band[0] + 1, false_alarm) * power)
        limit = 2.0 * least / (transform.n * transform.cosines[0])
        found = best is not None and _sharp(best, unexpected)
        rows.append(_row(float(wanted[i]), best, found, power, limit, transform, channel))
    return LineTable(tuple(rows), channel.unit, window, resolution, values.size, channel.sampling, search, false_alarm,
                     channel.name)  # fmt: skip


def _holds(band: tuple[int, int], tone: Tone) -> bool:
    return band[0] - 0.5 <= tone.place <= band[1] + 0.5


def _sharp(tone: Tone, unexpected: list[Tone]) -> bool:
    """Return whether a tone is a sharp line and not part of a hump: many unexpected tones of similar height."""
    near = sum(abs(t.amplitude) ** 2 for t in unexpected if abs(t.place - tone.place) <= NEAR)
    return tone.explained >= SHARP and abs(tone.amplitude) ** 2 >= ALONE * near


def _row(
    expected: float,
    tone: Tone | None,
    found: bool,
    power: float,
    limit: float,
    transform: Transform,
    channel: Channel,
) -> LineRow:
    """Return the row of the best tone in the channel's units; without numbers where it is no line, or there is none."""
    energy = transform.n * squared_window(transform.cosines)[0]
    density = 2.0 * power / (channel.sampling * energy)
    prominence = 0.0
    if tone is not None and power > 0.0:
        prominence = abs(tone.amplitude) * transform.n * transform.cosines[0] / math.sqrt(power)
    if tone is None or not found:
        remark = f"no line above {limit:.3g} {channel.unit}".rstrip()
        if tone is not None:
            remark = "content that stands out, but no single sharp line: a hump, a wandering tone, or close unexpected lines"
        no = math.nan
        return LineRow(expected, False, no, no, no, no, no, no, prominence, limit, density, remark)
    resolution = channel.sampling / transform.n
    modulus, spread = abs(tone.amplitude), tone.covariance
    real, imaginary = tone.amplitude.real / modulus, tone.amplitude.imag / modulus
    along = np.array([0.0, 2.0 * real, 2.0 * imaginary])
    # The phase is fitted at the middle of the record; half a record back it turns by pi a line.
    turn = np.array([-math.pi, -imaginary / modulus, real / modulus])
    phase = np.angle(tone.amplitude * np.exp(-1j * math.pi * tone.place))
    return LineRow(
        expected, True, tone.place * resolution, math.sqrt(spread[0, 0]) * resolution, 2.0 * modulus,
        math.sqrt(max(along @ spread @ along, 0.0)), float(phase), math.sqrt(max(turn @ spread @ turn, 0.0)), prominence,
        limit, density,
    )  # fmt: skip
