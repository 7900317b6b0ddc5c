"""Figures of signals; each draws on a given ``ax``, with units and settings."""

import math
import textwrap
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gearplay.files.atomic import check_new, write_bytes
from gearplay.files.record import Channel
from gearplay.pictures.canvas import pixels_of, to_png
from gearplay.pictures.extremes import extremes, largest_of_cells
from gearplay.pictures.scales import edges_of
from gearplay.pictures.style import CLEARANCE, COUPLED, MOST_POINTS, TEST, UNCOUPLED, new_axes
from gearplay.pictures.words import plain, shown_unit
from gearplay.signals.angle import ShaftAngle
from gearplay.signals.averaging import AveragedSpectrum, averaged_spectrum, power_density
from gearplay.signals.checks import TWO_PI, check_channel
from gearplay.signals.envelopes import EnvelopeSpectrum, envelope_spectrum, most_impulsive_band
from gearplay.signals.line_tables import LineTable, line_table
from gearplay.signals.orders import OrderMap, OrderSpectrum, order_map, order_spectrum
from gearplay.signals.spectrograms import Spectrogram, spectrogram
from gearplay.signals.statistics import signal_statistics
from gearplay.signals.synchronous import SynchronousAverage, synchronous_average

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Floats = NDArray[np.float64]

PICTURES = (
    "history", "spectrum", "density", "spectrogram", "envelope_spectrum",
    "order_spectrum", "order_map", "synchronous_average",
)  # fmt: skip
"""Names of the pictures of `draw_record`; the last three where a speed is given."""
DECADES = 5.0  # shown below the highest value; rounding would else fill the picture


def _finish(ax: "Axes", horizontal: str, vertical: str, caption: str, name: str) -> "Axes":
    """Label the axes, name the channel above and print the settings below."""
    ax.set_xlabel(horizontal, fontsize=8)
    ax.set_ylabel(vertical, fontsize=8)
    if name:
        ax.set_title(plain(_folded(name, 80)), fontsize=9, loc="left")
    width = 17.0 * float(ax.figure.bbox.width / ax.figure.dpi)  # letters on one line
    ax.text(
        0.0, -0.17, plain(_folded(caption, int(width))), transform=ax.transAxes, fontsize=6.5, color=CLEARANCE, va="top",
    )  # fmt: skip
    return ax


def _folded(text: str, width: int) -> str:
    return "\n".join("\n".join(textwrap.wrap(line, width)) for line in text.splitlines())


def _decades(ax: "Axes", x: Floats, y: Floats) -> None:
    """Draw on a logarithmic ordinate of at most `DECADES`; a signal at rest has none."""
    x, y = extremes(x, y, MOST_POINTS // 2)
    top = float(np.max(y, initial=0.0))
    if top > 0.0:
        low = max(top * 10.0**-DECADES, 0.5 * float(np.min(y[y > 0.0])))
        ax.semilogy(x, np.maximum(y, low), color=COUPLED, linewidth=0.7)
        ax.set_ylim(0.7 * low, 2.0 * top)
    else:
        ax.plot(x, y, color=COUPLED, linewidth=0.7)
    ax.set_xlim(0.0, float(x[-1]))


def _unit(unit: str) -> str:
    """Return the unit of an axis, also of a channel whose unit nobody gave."""
    return shown_unit(unit) if unit else "unit not given"


def plot_channel(ax: "Axes", channel: Channel) -> "Axes":
    """Draw a channel over time [s], with its statistics in the caption."""
    values = check_channel(channel)
    ax.plot(*extremes(channel.time, values, MOST_POINTS // 2), color=COUPLED, linewidth=0.5)
    s = signal_statistics(channel, remove_mean=True)
    unit = f" {channel.unit}" if channel.unit else ""
    caption = (
        f"{s.samples} samples at {channel.sampling:g} Hz; mean {s.mean:.4g}{unit}; about it rms {s.rms:.4g}{unit}, "
        f"peak {s.peak:.4g}{unit}, crest factor {s.crest_factor:.3g}, kurtosis {s.kurtosis:.3g} (normal 3), "
        f"skewness {s.skewness:.2g}"
    )
    ax.set_xlim(float(channel.time[0]), float(channel.time[-1]))
    return _finish(ax, "time [s]", f"signal [{_unit(channel.unit)}]", caption, channel.name)


def plot_averaged_spectrum(
    ax: "Axes", spectrum: AveragedSpectrum, *, lines: LineTable | None = None
) -> "Axes":
    """Draw an amplitude spectrum or density on a logarithmic ordinate; ``lines`` marks those of a table (amplitude only)."""
    # The mean is off: what remains at zero is rounding.
    _decades(ax, spectrum.frequency[1:], spectrum.values[1:])
    if lines is not None:
        _mark(ax, lines)
    word = "amplitude" if spectrum.kind == "amplitude" else "power spectral density"
    vertical = f"{word} [{_unit(spectrum.unit)}]"
    return _finish(ax, "frequency [Hz]", vertical, spectrum.caption, spectrum.name)


def _mark(ax: "Axes", table: LineTable) -> None:
    """Mark the lines found with their frequencies, and expected ones that were not found."""
    found = [row for row in table.rows if row.found]
    ax.plot([r.frequency for r in found], [r.amplitude for r in found], "o", markersize=4.5, markerfacecolor="none",
            color=UNCOUPLED, label="line fitted" if found else None)  # fmt: skip
    for row in found if len(found) <= 12 else ():
        ax.annotate(f"{row.frequency:.5g}", (row.frequency, row.amplitude), textcoords="offset points", xytext=(3, 5),
                    fontsize=6.5, color=TEST)  # fmt: skip
    absent = [row for row in table.rows if not row.found]
    floor = ax.get_ylim()[0]
    ax.plot([r.expected for r in absent], [floor * 1.6] * len(absent), "x", markersize=5, color=CLEARANCE,
            label="no line here" if absent else None)  # fmt: skip
    ax.legend(fontsize=7, framealpha=0.9, loc="upper right")


def plot_envelope_spectrum(ax: "Axes", result: EnvelopeSpectrum, *, highest: float | None = None) -> "Axes":
    """Draw an envelope spectrum up to ``highest`` [Hz]."""
    s = result.spectrum
    kept = s.frequency <= (highest if highest is not None else math.inf)
    f, a = s.frequency[kept], s.values[kept]
    ax.plot(*extremes(f[1:], a[1:], MOST_POINTS // 2), color=COUPLED, linewidth=0.7)
    ax.set_ylim(bottom=0.0)
    if not np.any(a[1:] > 0.0):
        ax.text(0.5, 0.5, "0 throughout", transform=ax.transAxes, ha="center", va="center", fontsize=9)
    ax.set_xlim(0.0, float(f[-1]))
    return _finish(ax, "frequency [Hz]", f"envelope amplitude [{_unit(s.unit)}]", result.caption, s.name)


def _mesh(ax: "Axes", x: Floats, y: Floats, values: Floats, label: str) -> None:
    """Draw a map in four decades of colour below its highest value, the colour bar in the unit.

    A pixel has the highest value of the cells within it, so that a line narrower than a pixel is seen.
    """
    from matplotlib.colors import LogNorm

    across, up = (
        # the only cell of an axis lies about the middle of the record
        edges_of(each, log=False) if each.size > 1 else np.array([0.0, 2.0 * float(each[0]) or 1.0])
        for each in (x, y)
    )
    table, up, across = largest_of_cells(values, up, across, pixels_of(ax))
    top = float(table.max())
    norm, shown = LogNorm(top * 1e-4, top) if top > 0.0 else None, np.maximum(table, top * 1e-4)
    picture = ax.pcolormesh(across, up, shown, norm=norm, cmap="viridis", rasterized=True)
    ax.grid(False)
    bar: Any = ax.figure.colorbar(picture, ax=ax, pad=0.02)
    bar.set_label(label, fontsize=8)
    bar.ax.tick_params(labelsize=7)


def plot_spectrogram(ax: "Axes", result: Spectrogram) -> "Axes":
    """Draw a spectrogram over time and frequency, four decades of colour."""
    word = "amplitude" if result.kind == "amplitude" else "density"
    _mesh(ax, result.time, result.frequency, result.values, f"{word} [{_unit(result.unit)}]")
    return _finish(ax, "time [s]", "frequency [Hz]", result.caption, result.name)


def plot_order_map(ax: "Axes", result: OrderMap) -> "Axes":
    """Draw an order map over order and revolution, four decades of colour."""
    _mesh(ax, result.revolution, result.order, result.amplitude, f"amplitude [{_unit(result.unit)}]")
    speeds = 60.0 / TWO_PI * result.speed
    caption = f"{speeds.min():.4g} to {speeds.max():.4g} rpm; {result.caption}"
    return _finish(ax, "revolution of the shaft [1]", "order [1]", caption, result.name)


def plot_order_spectrum(ax: "Axes", result: OrderSpectrum) -> "Axes":
    """Draw an order spectrum on a logarithmic ordinate."""
    _decades(ax, result.order[1:], result.amplitude[1:])
    return _finish(ax, "order [1]", f"amplitude [{_unit(result.unit)}]", result.caption, result.name)


def plot_synchronous_average(ax: "Axes", result: SynchronousAverage) -> "Axes":
    """Draw a synchronous average over the shaft's angle [deg] with twice its standard error."""
    angle = np.degrees(result.angle)
    low, high = result.average - 2.0 * result.error, result.average + 2.0 * result.error
    ax.fill_between(angle, low, high, color=COUPLED, alpha=0.2, linewidth=0, label="± 2 standard errors")
    ax.plot(angle, result.average, color=COUPLED, linewidth=0.7, label="average")
    ax.set_xlim(0.0, 360.0 * result.period)
    ax.set_xticks(np.linspace(0.0, 360.0 * result.period, 9))
    ax.legend(fontsize=7, loc="upper right", framealpha=0.9)
    vertical = f"synchronous average [{_unit(result.unit)}]"
    return _finish(ax, "angle of the shaft [deg]", vertical, result.caption, result.name)


def check_pictures(folder: Path, *, overwrite: bool) -> None:
    """Refuse a folder that cannot be written, or that has pictures of `draw_record` which may not be replaced."""
    for name in PICTURES:
        check_new(folder / f"{name}.png", overwrite=overwrite)


def draw_record(
    channel: Channel,
    folder: Path | str,
    *,
    speed: float | Channel | ShaftAngle | None = None,
    expected: Sequence[float] = (),
    band: tuple[float, float] | None = None,
    highest: float | None = None,
    overwrite: bool = False,
) -> list[Path]:
    """Write a page of PNGs of one signal into ``folder`` and return their paths.

    History, amplitude spectrum with the lines near ``expected`` [Hz] marked, density, spectrogram, envelope spectrum of
    ``band`` [Hz] (the most impulsive one unless given); with a shaft's ``speed`` (see `shaft_angle`) order spectrum, order map
    and synchronous average up to the order ``highest``. Nothing is written where an analysis is refused.
    Pictures of an earlier record in the folder are refused, or with ``overwrite`` replaced, those without a successor removed.

    Parameters
    ----------
    channel
        Signal, shape [time].
    folder
        Where the pictures go.
    speed
        Of the shaft: a constant [rad/s], a speed channel, or a `ShaftAngle`. With it orders are drawn too.
    expected
        Frequencies of lines [Hz].
    band
        Band of the envelope [Hz]; the most impulsive one if not given.
    highest
        Highest order; as far as the sampling allows if not given.
    overwrite
        Whether to replace the pictures of an earlier record.

    Returns
    -------
    list of pathlib.Path
        The pictures.

    Raises
    ------
    InputError
        As the analyses do, and where the folder cannot be written or has such pictures already.

    Examples
    --------
    >>> import tempfile
    >>> made = draw_record(Channel("acc", np.sin(np.arange(2048.0)), 1000.0), tempfile.mkdtemp())
    >>> [path.name for path in made][:2]
    ['history.png', 'spectrum.png']

    """
    folder = Path(folder)
    check_pictures(folder, overwrite=overwrite)
    values = check_channel(channel, 256)
    low, high = band if band is not None else most_impulsive_band(channel)
    whole = averaged_spectrum(channel, segment=values.size)
    table = line_table(channel, expected) if len(expected) else None
    envelope = envelope_spectrum(channel, low, high)
    pages = {
        "history": plot_channel(new_axes(), channel),
        "spectrum": plot_averaged_spectrum(new_axes(), whole, lines=table),
        "density": plot_averaged_spectrum(new_axes(), power_density(channel)),
        "spectrogram": plot_spectrogram(new_axes(), spectrogram(channel)),
        "envelope_spectrum": plot_envelope_spectrum(new_axes(), envelope, highest=0.5 * (high - low)),
    }
    if speed is not None:
        spectrum = order_spectrum(channel, speed, highest=highest)
        pages["order_spectrum"] = plot_order_spectrum(new_axes(), spectrum)
        pages["order_map"] = plot_order_map(new_axes(), order_map(channel, speed, highest=highest))
        average = synchronous_average(channel, speed, highest=highest)
        pages["synchronous_average"] = plot_synchronous_average(new_axes(), average)
    paths = []
    for name, ax in pages.items():
        paths.append(folder / f"{name}.png")
        write_bytes(paths[-1], to_png(ax.figure), overwrite=overwrite)
    for name in PICTURES:
        if name not in pages:
            (folder / f"{name}.png").unlink(missing_ok=True)  # of the record that was replaced
    return paths
