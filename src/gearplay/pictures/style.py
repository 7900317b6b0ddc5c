"""Style of all plots; functions that draw on a given ``ax`` and label it with units."""

from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gearplay.pictures.extremes import extremes, thinned_path
from gearplay.pictures.words import plain

if TYPE_CHECKING:
    from collections.abc import Mapping

    from matplotlib.axes import Axes

Floats = NDArray[np.float64]

COUPLED, UNCOUPLED, TEST, CLEARANCE = "#0b5fa5", "#c8641b", "#222222", "#8a8f98"
MOST_POINTS = 20_000
LONGEST_NUMBER = 8  # characters at an axis
APART = 0.035  # least distance of two names of lines, as a share of the width
DOT = 0.1  # of the clearance: a path that is smaller is drawn magnified too


STILL = {"m": 1e-9, "m/s": 1e-9, "m/s^2": 1e-6, "rad": 1e-9, "rad/s": 1e-9, "N": 1e-6, "N m": 1e-9}
"""Range [SI] up to which a signal is at rest, by its unit: below what is measured, above what rounding leaves."""


def is_still(values: Floats, unit: str) -> bool:
    """Return whether values [SI] change by no more than `STILL`.

    >>> is_still(np.array([1.0, 1.0 + 1e-12]), "m"), is_still(np.array([0.0, 1e-6]), "m")
    (True, False)
    """
    known = values[np.isfinite(values)]
    return unit in STILL and bool(known.size) and float(np.ptp(known)) <= STILL[unit]


def note_still(ax: "Axes", unit: str, what: str = "motion") -> None:
    """Note in axes that nothing above `STILL` is drawn."""
    ax.text(
        0.5, 0.56, plain(f"no {what} above {STILL[unit]:.0e} {unit}".replace("e-0", "e-").replace("^2", "²")),
        transform=ax.transAxes, ha="center", va="center", fontsize=8,
    )  # fmt: skip


def widen_still(ax: "Axes", values: Floats, least: float) -> None:
    """Scale the ordinate of a constant curve by its level, not by its rounding; a level below ``least`` counts as 0."""
    level = float(np.nanmean(values)) if np.isfinite(values).any() else 0.0
    reach = 0.5 * abs(level) if abs(level) > least else 1.0
    ax.set_ylim(level - reach, level + reach)


def new_axes(width: float = 7.0, height: float = 4.0) -> "Axes":
    """Return axes of a new figure [inches] in the common style, without touching matplotlib's global state."""
    ax: Axes = tidy(blank_figure(width, height).subplots())
    return ax


def blank_figure(width: float, height: float) -> Any:
    """Return an empty figure of a size [inches], on the canvas for PNG."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def tidy(ax: Any) -> Any:
    """Apply the common style to axes."""
    ax.spines[["top", "right"]].set_visible(False)
    ax.grid(True, color="#e4e6ea", linewidth=0.6)
    ax.set_axisbelow(True)
    ax.tick_params(labelsize=8)
    plain_numbers(ax)
    return ax


def plain_numbers(ax: Any) -> None:
    """Format the ticks of linear axes in full, without a common factor or offset such as ``1e6`` or ``+8e4`` at the axis."""
    for axis in (ax.xaxis, ax.yaxis):
        axis.set_major_formatter(_whole_numbers()())


@cache
def _whole_numbers() -> Any:
    """Return the class of these formatters; made on first use, since matplotlib loads slowly."""
    from matplotlib.ticker import ScalarFormatter

    class WholeNumbers(ScalarFormatter):
        def __init__(self) -> None:
            super().__init__(useOffset=False)
            self.set_scientific(False)

        def __call__(self, x: float, pos: int | None = None) -> str:
            text = super().__call__(x, pos)
            return text if len(text) <= LONGEST_NUMBER else f"{x:.4g}".replace("-", "\N{MINUS SIGN}")

    return WholeNumbers


def draw_circle(ax: "Axes", radius: float) -> None:
    """Draw a clearance circle, dashed and on top, so that both it and a path on it are visible."""
    angle = np.linspace(0.0, 2.0 * np.pi, 361)
    circle = radius * np.cos(angle), radius * np.sin(angle)
    ax.plot(*circle, color=CLEARANCE, linewidth=0.7, dashes=(4, 5), zorder=3)


def plot_orbit(ax: "Axes", x: Floats, y: Floats, clearance: float) -> "Axes":
    """Draw the path x, y [m] of a shaft's centre in its circle of radius ``clearance`` [m], in µm; a dot is magnified."""
    x, y = thinned_path(np.asarray(x), np.asarray(y), MOST_POINTS)
    still = is_still(x, "m") and is_still(y, "m")
    x, y, c = 1e6 * x, 1e6 * y, 1e6 * clearance
    if c > 0.0:
        draw_circle(ax, c)
    ax.plot(x, y, color=COUPLED, linewidth=0.8)
    if c > 0.0:  # both axes about the circle, whatever the path
        reach = 1.06 * max(c, float(np.max(np.abs([x, y]), initial=0.0)))
        if x.size and not still and max(np.ptp(x), np.ptp(y)) < DOT * reach:
            _magnify(ax, x, y, reach)
        ax.set_xlim(-reach, reach)
        ax.set_ylim(-reach, reach)
    if still:
        ax.plot(x[:1], y[:1], "o", color=COUPLED, markersize=4)
        note_still(ax, "m")
        if c <= 0.0:
            ax.set_xlim(x[0] - 1.0, x[0] + 1.0)
            ax.set_ylim(y[0] - 1.0, y[0] + 1.0)
    ax.set_aspect("equal", adjustable="box" if c > 0.0 or still else "datalim")  # no fixed limits are widened
    ax.locator_params(nbins=5)
    ax.set_xlabel("x [µm]", fontsize=8)
    ax.set_ylabel("y [µm]", fontsize=8)
    return ax


def _magnify(ax: "Axes", x: Floats, y: Floats, reach: float) -> None:
    """Draw a path [µm] that is a dot in axes up to ``reach`` again, magnified, where it leaves room."""
    middle = np.array([0.5 * (x.min() + x.max()), 0.5 * (y.min() + y.max())])
    away = float(np.hypot(*middle))
    shift = -0.38 * middle / away if away > 0.15 * reach else np.array([0.0, 0.6])
    size = 0.36
    left, low = (0.5 + 0.42 * float(each) - 0.5 * size for each in shift)
    close = ax.inset_axes((left, low, size, size))
    tidy(close).tick_params(labelsize=6)
    close.plot(x, y, color=COUPLED, linewidth=0.6)
    half = 0.6 * max(np.ptp(x), np.ptp(y), 1e-6 * reach)
    close.set_xlim(middle[0] - half, middle[0] + half)
    close.set_ylim(middle[1] - half, middle[1] + half)
    close.locator_params(nbins=2)
    close.spines[["top", "right"]].set_visible(True)
    for spine in close.spines.values():
        spine.set_color(CLEARANCE)
    close.set_title(f"{float(f'{size * reach / half:.2g}'):g} times larger [µm]", fontsize=6.5, pad=3)
    ax.plot(*middle, "o", color=COUPLED, markersize=4, markerfacecolor="none", markeredgewidth=0.8)


def plot_curve(
    ax: "Axes", time: Floats, values: Floats, words: str, *, color: str = COUPLED, label: str | None = None
) -> "Axes":
    """Draw values over time [s]; of many the minimum and maximum of each segment, so that no impact is lost."""
    t, v = extremes(np.asarray(time), np.asarray(values), MOST_POINTS // 2)
    ax.plot(t, v, color=color, linewidth=0.7, label=plain(label) if label else None)
    ax.set_xlabel("time [s]", fontsize=8)
    ax.set_ylabel(plain(words), fontsize=8)
    return ax


def mark_lines(ax: "Axes", marks: "Mapping[str, float]") -> None:
    """Mark frequencies with thin lines, named at the top where names do not overlap."""
    low, high = ax.get_xlim()
    taken: list[float] = []
    for name, at in marks.items():
        if not low < at < high:
            continue
        ax.axvline(at, color=CLEARANCE, linewidth=0.6, linestyle=":", zorder=0.8)
        share = (at - low) / (high - low)
        if name and share < 0.98 and all(abs(share - each) >= APART for each in taken):
            taken.append(share)
            ax.text(
                share + 0.004, 0.985, plain(name), transform=ax.transAxes, rotation=90, fontsize=6.5, color="#555a66",
                ha="left", va="top", bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.75, "pad": 0.6},
            )  # fmt: skip
