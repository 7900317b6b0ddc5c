"""Figures of report pages: panels in rows, logarithmic axes with plain ticks, one title and one legend."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gearplay.pictures.canvas import SMALL, TEXT, WIDTH, make_figure, set_legend, set_title, to_png
from gearplay.pictures.scales import logarithmic_range
from gearplay.pictures.words import plain, wrapped

Floats = NDArray[np.float64]


def make_panels(
    count: int, columns: int, height: float, *, alone: tuple[float, float]
) -> tuple[Any, NDArray[Any]]:
    """Return a figure and its axes, shape [row, column], for ``count`` panels of a height [inches]; the others are removed.

    Panels in a single column have the height and width ``alone``.
    """
    columns = min(columns, count)
    rows = -(-count // columns)
    height, width = alone if columns == 1 else (height, WIDTH)
    figure, axes = make_figure(rows, columns, 0.9 + height * rows, width=width)
    for ax in axes.flat[count:]:
        ax.remove()
    return figure, axes


def finished(figure: Any, title: str, handles: Mapping[str, Any] | None = None) -> bytes:
    """Return a figure as PNG, with a title and, where there are ``handles``, a legend under it."""
    set_title(figure, title)
    if handles:
        set_legend(figure, handles)
    return to_png(figure)


def label_axis(ax: Any, text: str, *, up: bool = False, width: int = 36, size: float = TEXT) -> None:
    """Set the label of an axis, wrapped."""
    (ax.set_ylabel if up else ax.set_xlabel)(plain(wrapped(text, width)), fontsize=size)


def title_panel(ax: Any, text: str, *, width: int = 46) -> None:
    """Set the title of a panel at its left, wrapped."""
    ax.set_title(plain(wrapped(text, width)), fontsize=SMALL, loc="left")


def scale_ordinate(ax: Any, values: Floats, *, below: float = 0.8, above: float = 1.25) -> None:
    """Make the ordinate logarithmic where ``values`` span decades; the factors are margins beyond them."""
    ends = logarithmic_range(values)
    if ends is not None:
        ax.set_yscale("log")
        ax.set_ylim(below * ends[0], above * ends[1])
        round_ticks(ax.yaxis, *ax.get_ylim())


def round_ticks(axis: Any, low: float, high: float, *, fine: bool = False) -> None:
    """Label a logarithmic axis with plain round numbers, with ``fine`` more of them within a decade."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    decades = np.log10(high / low)
    steps: tuple[float, ...] = (1.0, 2.0, 5.0) if decades < 2.5 else (1.0,)
    if fine and decades < 1.0:
        steps = (1.0, 1.5, 2.0, 3.0, 5.0, 7.0)
    axis.set_major_locator(LogLocator(subs=steps, numticks=12 if fine else 9))
    axis.set_major_formatter(FuncFormatter(lambda v, _: f"{v:g}"))
    axis.set_minor_formatter(NullFormatter())
