"""Shared settings of all figures: size, fonts, colours, legends, export to PNG."""

import io
import textwrap
import warnings
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, nullcontext
from typing import Any

import numpy as np

from gearplay.pictures.style import COUPLED, UNCOUPLED, blank_figure, tidy
from gearplay.pictures.words import plain, short

PALETTE = (COUPLED, UNCOUPLED, "#4a2d33", "#c3a0a8", "#8a3cf0", "#35b8f0", "#2a1486", "#7a2f00",
           "#a5695a", "#96c369", "#f0a500", "#696978", "#8787ff", "#0000ff", "#690f69", "#d269b4")  # fmt: skip
"""Each apart from all others for the colour-blind too: 17 of CIE Lab at least, the first eight 24."""
SMALL, TEXT = 7.5, 8.5  # points; a page 900 px wide shows figures of 9 inches
WIDTH = 9.0  # inches
DPI = 130
LETTERS = 11  # of a title, an inch
MOST_NAMES = 24  # entries of a legend


def make_figure(rows: int, columns: int, height: float, *, width: float = WIDTH) -> tuple[Any, Any]:
    """Return a figure [inches] and its axes, shape [rows, columns], without pyplot's state."""
    figure = blank_figure(width, height)
    axes = figure.subplots(rows, columns, squeeze=False)
    for ax in axes.flat:
        tidy(ax).tick_params(labelsize=SMALL)
    return figure, axes


def set_color_scale(figure: Any, axes: list[Any], values: Sequence[float], label: str) -> list[Any]:
    """Draw a colour bar next to the axes for curves of different values; return the colour of each curve."""
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize

    low, high = min(values), max(values)
    scale = ScalarMappable(Normalize(low, high if high > low else low + (abs(low) or 1.0)), "viridis")
    bar = figure.colorbar(scale, ax=axes, pad=0.015, aspect=30)
    bar.set_label(plain(label), fontsize=SMALL)
    bar.ax.tick_params(labelsize=SMALL)
    return list(scale.to_rgba(np.array(values)))


def pixels_of(ax: Any) -> tuple[int, int]:
    """Return how many rows and columns of cells axes can show, each at least a pixel, wherever the layout puts the axes."""
    width, height = ax.figure.get_size_inches()
    rows, columns = ax.get_gridspec().get_geometry() if ax.get_gridspec() is not None else (1, 1)
    share = 0.5  # least share of a figure's area for axes that the axes take, the rest being labels and the colour bar
    return int(share * DPI * height / rows), int(share * DPI * width / columns)


def to_png(figure: Any) -> bytes:
    """Return a figure as PNG."""
    return to_bytes(figure, "png")


def to_bytes(figure: Any, form: str) -> bytes:
    """Return a figure as ``png``, ``svg`` or ``pdf``."""
    buffer = io.BytesIO()
    metadata = {"Software": "gearplay"} if form == "png" else {"Creator": "gearplay"}
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="Glyph")  # a name in a script that the font lacks
        with _laid_out(figure) if form == "png" else nullcontext():
            figure.savefig(buffer, format=form, dpi=DPI, metadata=metadata)
    return buffer.getvalue()


@contextmanager
def _laid_out(figure: Any) -> Iterator[None]:
    """Find the layout of a figure at its resolution; without a layout engine `savefig` then draws once, not twice."""
    before, engine = figure.dpi, figure.get_layout_engine()
    if engine is None:
        yield
        return
    figure.set_dpi(DPI)
    try:
        engine.execute(figure)
        figure.set_layout_engine(None)
        yield
    finally:
        figure.set_layout_engine(engine)
        figure.set_dpi(before)


def set_title(figure: Any, text: str) -> None:
    """Set a figure's title, in lines that fit its width."""
    wide = int(LETTERS * figure.get_figwidth())
    text = text.replace(" um", " µm")
    figure.suptitle(plain("\n".join(textwrap.wrap(text, wide))), fontsize=9.5)


def set_legend(figure: Any, handles: Mapping[str, Any]) -> None:
    """Draw one legend under the figure, which grows with it; of many entries the first."""
    names = list(handles)[:MOST_NAMES]
    shown = [short(name) for name in names]
    columns = max(1, min(6, 130 // (max(map(len, shown)) + 8)))
    figure.set_figheight(figure.get_figheight() + 0.16 * (-(-len(names) // columns) - 1))
    labels = list(map(plain, shown))
    if len(handles) > len(names):
        labels[-1] += f" and {len(handles) - len(names)} more"
    figure.legend([handles[name] for name in names], labels, loc="outside lower center",
                  ncols=min(columns, len(names)), fontsize=SMALL, frameon=False)  # fmt: skip


def legend_mark(color: str, *, marker: str = "", line: Any = "none", hollow: bool = False) -> Any:
    """Return a line or marker for a legend, white inside where it is ``hollow``."""
    from matplotlib.lines import Line2D

    face = "white" if hollow else color
    return Line2D([], [], color=color, marker=marker, linestyle=line, markersize=5, markerfacecolor=face)
