"""Maps of a sweep: one number over two axes, small multiples over others, and the jam limit."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gearplay.pictures.canvas import (
    SMALL,
    WIDTH,
    legend_mark,
    make_figure,
    pixels_of,
)
from gearplay.pictures.extremes import largest_of_cells
from gearplay.pictures.panels import finished, label_axis, round_ticks, title_panel
from gearplay.pictures.scales import edges_of, logarithmic_range, spread_places, stand_apart
from gearplay.pictures.words import plain, short, wrapped
from gearplay.sweeps.report.drawable import Along, Place, View
from gearplay.sweeps.report.jam import JamLine, jam_lines

Floats = NDArray[np.float64]
JAM, GREY, HATCH = "#e0263c", "#e9ebee", "#aab0b9"
MAP = "viridis"
JAM_WORDS = "jam line 2 sin α₀ (c₁ + c₂) = b₀"


@dataclass(frozen=True)
class Panel:
    """One of several small pictures: its position along the other axes, and its title."""

    place: dict[str, int]
    title: str


def panels_of(view: View, free: Sequence[str], most: int) -> tuple[list[list[Panel]], str]:
    """Return panels in rows and columns over the axes that are not ``free``, and a text of the values fixed in all of them.

    Rows are a category's values, columns those of a further numeric axis, ``most`` of each; without one of them, all in a row.
    """
    category = next((name for name in view.categories if name not in free), "")
    further = next((name for name in view.numeric if name not in free), "")
    if not further:
        further = next((name for name in view.categories if name not in (*free, category)), "")
    if category and not further:
        category, further = "", category
    held = view.held((*free, category, further))
    rows, columns = _places(view, category, most), _places(view, further, most)
    grid = [[Panel(held | row | column, view.where(row | column)) for column in columns] for row in rows]
    return grid, view.held_words(held)


def _places(view: View, name: str, most: int) -> list[dict[str, int]]:
    """Return some positions along an axis, spread evenly; without a name one selection of all axes."""
    return [{name: at} for at in spread_places(len(view.axes[name].values), most)] if name else [{}]


def title_of(view: View, words: str, held: str, numbers: str = "") -> str:
    """Return a picture's title: that of the plan, the subject, the fixed values, the meaning of a number."""
    own = short(view.sweep.plan.title or "Sweep", 70)
    return "; ".join(part for part in (f"{own}: {words}", f"at {held}" if held else "", numbers) if part)


def scale_axis(ax: Any, axis: Along, *, up: bool = False, label: bool = True) -> None:
    """Give one axis of a picture its label, scale, limits and, for categories, names."""
    own = ax.yaxis if up else ax.xaxis
    edges = np.array([-0.5, len(axis.labels) - 0.5]) if axis.labels else edges_of(axis.values, log=axis.log)
    if axis.log:
        (ax.set_yscale if up else ax.set_xscale)("log")
        round_ticks(own, edges[0], edges[-1])
    (ax.set_ylim if up else ax.set_xlim)(edges[0], edges[-1])
    if axis.labels:
        places = spread_places(len(axis.labels), 8)
        names = [plain(wrapped(axis.labels[place], max(7, 48 // len(places)))) for place in places]
        own.set_ticks(places, names, fontsize=SMALL)
    if label:
        label_axis(ax, axis.label, up=up, width=30)


def separate_cells(ax: Any, axis: Along, edges: Floats, *, up: bool = False) -> None:
    """Separate the cells along an axis of few values, with a tick at each: nothing was computed between them."""
    if axis.labels or not stand_apart(axis.values, log=axis.log):
        return
    from matplotlib.ticker import NullLocator

    own = ax.yaxis if up else ax.xaxis
    own.set_ticks(axis.values, [f"{value:.4g}" for value in axis.values])
    own.set_minor_locator(NullLocator())
    draw, place = (ax.hlines, ax.get_yaxis_transform()) if up else (ax.vlines, ax.get_xaxis_transform())
    draw(edges[1:-1], 0.0, 1.0, transform=place, colors="white", linewidth=3.0, zorder=3)


def norm_of(tables: Sequence[Floats]) -> tuple[Any, str] | None:
    """Return one scale of colour for several tables, and at which end it is open; None where there is no number."""
    from matplotlib.colors import LogNorm, Normalize

    every = np.concatenate([table.ravel() for table in tables])
    known = every[np.isfinite(every)]
    if not known.size:
        return None
    ends = logarithmic_range(known)
    if ends is not None:
        return LogNorm(*ends), "min" if known.min() < ends[0] * 0.999 else "neither"
    low, high = float(known.min()), float(known.max())
    return Normalize(low, high if high > low else low + (abs(low) or 1.0)), "neither"


def logarithmic(norm: Any) -> bool:
    """Return whether a scale of colour is logarithmic."""
    from matplotlib.colors import LogNorm

    return isinstance(norm, LogNorm)


def color_bar(figure: Any, axes: Any, picture: Any, label: str, extend: str = "neither") -> None:
    """Draw the colour bar of a common colour scale next to all panels."""
    bar = figure.colorbar(picture, ax=axes, pad=0.015, aspect=30, extend=extend)
    bar.set_label(plain(wrapped(label, 48)), fontsize=SMALL)
    if logarithmic(picture.norm):
        round_ticks(bar.ax.yaxis, picture.norm.vmin, picture.norm.vmax)
    bar.ax.tick_params(labelsize=SMALL)


def draw_cells(
    ax: Any, x: Floats, y: Floats, table: Floats, norm: Any, *, log: tuple[bool, bool] = (False, False)
) -> Any:
    """Draw a table between edges: cells without a number in grey, values below a logarithmic scale at its lower end.

    A pixel has the largest number of the cells within it. ``log`` is whether each of the axes, y and x, is logarithmic.
    """
    table, y, x = largest_of_cells(table, y, x, pixels_of(ax), log=log)
    shown = np.maximum(table, norm.vmin)
    ax.set_facecolor(GREY)
    ax.grid(False)
    if not np.isfinite(table).any():
        ax.text(0.5, 0.5, "no number", transform=ax.transAxes, ha="center", va="center", fontsize=SMALL)
    return ax.pcolormesh(x, y, np.ma.masked_invalid(shown), norm=norm, cmap=MAP, rasterized=True)


def draw_failed(ax: Any, x: Floats, y: Floats, failed: NDArray[np.bool_]) -> None:
    """Hatch the cells whose cases failed, those side by side as one."""
    for row, (low, high) in zip(failed, pairwise(y), strict=True):
        ends = np.flatnonzero(np.diff(np.concatenate([[0], row.astype(np.int8), [0]])))
        spans = [(x[a], x[b] - x[a]) for a, b in ends.reshape(-1, 2)]
        if spans:
            ax.broken_barh(
                spans, (low, high - low), facecolor=GREY, edgecolor=HATCH, hatch="////", linewidth=0
            )


def map_figure(view: View, name: str, across: str, up: str) -> bytes | None:
    """Draw a variable over two axes, panels over the others on one scale of colour; None where no case has a number.

    Hatched cells failed, grey ones have no number. Where backlash or radial clearance of a mesh is drawn, the line on which
    2 sin(alpha0) (sum of both radial clearances) = b0.
    """
    grid, held = panels_of(view, (across, up), 4)
    flat = [panel for row in grid for panel in row]
    tables = [view.table(name, (up, across), panel.place) for panel in flat]
    scale = norm_of(tables)
    if scale is None:
        return None
    rows, columns = len(grid), len(grid[0])
    height = 1.35 + rows * {1: 3.6, 2: 2.9, 3: 2.3}.get(columns, 2.0)
    figure, axes = make_figure(rows, columns, height, width=WIDTH if columns > 1 else 6.4)
    x_axis, y_axis = view.axes[across], view.axes[up]
    x, y = edges_of(x_axis.values, log=x_axis.log), edges_of(y_axis.values, log=y_axis.log)
    handles: dict[str, Any] = {}
    picture = None
    for number, (ax, panel, table) in enumerate(zip(axes.flat, flat, tables, strict=True)):
        picture = draw_cells(ax, x, y, table, scale[0], log=(y_axis.log, x_axis.log))
        failed = view.failed((up, across), panel.place)
        draw_failed(ax, x, y, failed)
        if failed.any():
            handles["failed"] = _patch()
        scale_axis(ax, x_axis, label=number >= len(flat) - columns)
        scale_axis(ax, y_axis, up=True, label=number % columns == 0)
        separate_cells(ax, x_axis, x)
        separate_cells(ax, y_axis, y, up=True)
        ax.tick_params(
            labelsize=SMALL, labelbottom=number >= len(flat) - columns, labelleft=number % columns == 0
        )
        title_panel(ax, panel.title, width=46 if columns < 3 else 26)
        for line in jam_lines_of(view, across, up, panel.place):
            if _draw_jam(ax, x_axis, y_axis, line):
                handles[JAM_WORDS] = legend_mark(JAM, line="-")
    color_bar(figure, axes, picture, view.label(name), scale[1])
    return finished(figure, title_of(view, name, held, view.mean_words), handles)


def _patch() -> Any:
    from matplotlib.patches import Patch

    return Patch(facecolor=GREY, edgecolor=HATCH, hatch="////", linewidth=0)


def jam_lines_of(view: View, across: str, up: str, place: Place) -> list[JamLine]:
    """Return the jam lines of a panel in SI; without an axis ``up`` they are upright."""
    ends: list[tuple[str, float, float]] = []
    for name in (across, up):
        if not name:
            ends.append((name, 0.0, 1.0))
            continue
        axis = view.axes[name]
        if axis.labels:
            return []
        edges = axis.raw(edges_of(axis.values, log=axis.log))
        ends.append((name, float(edges[0]), float(edges[-1])))
    fixed = {
        name: float(axis.raw(axis.values[place.get(name, 0)]))
        for name, axis in (view.axes | view.alone).items()
        if (name in place or name in view.alone) and not axis.labels
    }
    return _distinct(jam_lines(view.sweep, ends[0], ends[1], fixed))


def _distinct(lines: list[JamLine]) -> list[JamLine]:
    """Return lines that differ, each named after its first mesh and the number of others, as those of planets."""
    alike: list[list[JamLine]] = []
    for line in lines:
        for group in alike:
            one = group[0]
            if (
                one.sides == line.sides
                and one.across.shape == line.across.shape
                and all(
                    np.allclose(mine, its, rtol=1e-9, atol=0.0)
                    for mine, its in ((one.across, line.across), (one.up, line.up))
                )
            ):
                group.append(line)
                break
        else:
            alike.append([line])
    return [
        replace(group[0], mesh=f"{group[0].mesh} and {len(group) - 1} more") if len(group) > 1 else group[0]
        for group in alike
    ]


def _draw_jam(ax: Any, x_axis: Along, y_axis: Along, line: JamLine) -> bool:
    """Draw the line with a label on the side on which the mesh can jam; return whether any of it is inside the picture."""
    from matplotlib.patheffects import withStroke

    x, y = x_axis.shown(line.across), y_axis.shown(line.up)
    (left, right), (low, high) = ax.get_xlim(), ax.get_ylim()
    inside = np.flatnonzero((x >= left) & (x <= right) & (y >= low) & (y <= high))
    if inside.size < 2:
        return False
    halo = [withStroke(linewidth=3.2, foreground="white", alpha=0.85)]
    ax.plot(x, y, color=JAM, linewidth=1.6, path_effects=halo, zorder=4)
    ax.set(xlim=(left, right), ylim=(low, high))
    places = ax.transAxes.inverted().transform(ax.transData.transform(np.column_stack([x, y])[inside]))
    central = int(np.argmin(np.abs(places - 0.5).sum(axis=1)))
    at, place, (right_of, above) = inside[central], places[central], line.sides
    room = [
        1.0 - p if side > 0 else p if side < 0 else 1.0 for p, side in zip(place, line.sides, strict=True)
    ]
    if room[0] < 0.35 or room[1] < 0.18:
        return True
    ax.annotate(
        f"{line.mesh}\ncan jam", (x[at], y[at]), textcoords="offset points", xytext=(5 * right_of, 5 * above),
        ha=("right", "center", "left")[right_of + 1], va=("top", "center", "bottom")[above + 1], fontsize=7, color=JAM,
        path_effects=[withStroke(linewidth=2.5, foreground="white", alpha=0.9)], zorder=5,
    )  # fmt: skip
    return True
