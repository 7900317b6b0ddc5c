"""Spectra and histories of a sweep: waterfalls, order maps, overlaid curves."""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gearplay.model.reading import replace
from gearplay.parts.mesh.train import rolling
from gearplay.pictures.canvas import PALETTE, SMALL, TEXT, WIDTH, legend_mark, make_figure
from gearplay.pictures.extremes import extremes
from gearplay.pictures.panels import finished, label_axis, scale_ordinate, title_panel
from gearplay.pictures.scales import edges_of, spread_places
from gearplay.pictures.style import MOST_POINTS
from gearplay.sweeps.report.drawable import View
from gearplay.sweeps.report.maps import (
    Panel,
    color_bar,
    draw_cells,
    draw_failed,
    panels_of,
    scale_axis,
    separate_cells,
    title_of,
)
from gearplay.vocabulary.errors import GearplayError

Floats = NDArray[np.float64]
MOST_ROWS, MOST_COLUMNS = 400, 1200  # of a map; a picture has no more dots
SHOWN = 3.0  # decades of colour
ORDERS = (1, 2, 3)
HIGHEST_ORDER = 10.0
LINE = "#ffffff"
DASHED: dict[str, Any] = {"color": LINE, "linewidth": 0.8, "linestyle": (0, (4, 3)), "alpha": 0.8}


def own_axis(view: View, name: str) -> str:
    """Return the dimension that belongs to a spectrum or history alone."""
    points = set(view.dataset["status"].dims)
    return next(str(d) for d in view.dataset[name].dims if d not in points)


def waterfall_figure(view: View, name: str, up: str) -> bytes | None:
    """Draw a spectrum as colour over frequency and one axis, orders 1 to 3 of the mesh as dashed lines.

    None where no case has a spectrum above 0.
    """
    grid, _ = panels_of(view, (up,), 2)
    flat = [panel for row in grid for panel in row]
    meshes = [mesh_frequencies(view, up, panel.place) for panel in flat]
    edges, y = edges_of(_frequencies(view, name), log=False), view.axes[up].values

    def mark(ax: Any, at: int) -> None:
        if np.isfinite(meshes[at]).any():
            for order in ORDERS:
                ax.plot(order * meshes[at], y, **DASHED)
                _name_order(ax, order * meshes[at], y, order, float(edges[-1]))
            ax.set_xlim(edges[0], edges[-1])

    marked = any(np.isfinite(mesh).any() for mesh in meshes)
    words = f"{name} over {view.axes[up].words}" + ("; orders of the mesh dashed" if marked else "")
    tables = [_rows(view, name, up, panel) for panel in flat]
    return _color_figure(view, name, up, (edges, tables), ("frequency [Hz]", words), mark)


def order_figure(view: View, name: str, up: str) -> bytes | None:
    """Draw a spectrum as colour over its order, frequency by the mesh frequency of the first mesh, and one axis.

    None where the mesh frequency does not vary along that axis: there the waterfall shows the same.
    """
    edges = edges_of(_frequencies(view, name), log=False)
    grid, _ = panels_of(view, (up,), 2)
    flat = [panel for row in grid for panel in row]
    meshes = [mesh_frequencies(view, up, panel.place) for panel in flat]
    known = np.concatenate([mesh[np.isfinite(mesh)] for mesh in meshes])
    if not known.size or np.ptp(known) < 1e-6 * known.max():
        return None
    top = min(HIGHEST_ORDER, max(ORDERS[-1] + 0.5, float(edges[-1] / np.median(known))))
    cells = int(min(MOST_COLUMNS, max(200.0, 2.0 * top * known.max() / np.diff(edges).min())))
    orders = np.linspace(0.0, top, cells + 1)
    tables = [
        _over_orders(_rows(view, name, up, panel), mesh, edges, orders)
        for panel, mesh in zip(flat, meshes, strict=True)
    ]

    def mark(ax: Any, _: int) -> None:
        for order in ORDERS:
            ax.axvline(order, **DASHED)

    words = f"{name} by order over {view.axes[up].words}"
    return _color_figure(view, name, up, (orders, tables), ("order of the mesh frequency [1]", words), mark)


def _frequencies(view: View, name: str) -> Floats:
    return np.asarray(view.dataset[own_axis(view, name)].values, dtype=np.float64)


def _color_figure(
    view: View,
    name: str,
    up: str,
    cells: tuple[Floats, list[Floats]],
    texts: tuple[str, str],
    mark: Callable[[Any, int], None],
) -> bytes | None:
    """Draw tables between the edges ``cells`` as colour, a panel each, and what ``mark(ax, number)`` adds.

    ``texts`` are the label of the abscissa and the title. None where no number is above 0.
    """
    (x, tables), (label, words) = cells, texts
    grid, held = panels_of(view, (up,), 2)
    scale = _norm(tables)
    if scale is None:
        return None
    rows, columns = len(grid), len(grid[0])
    figure, axes = make_figure(rows, columns, 0.9 + 3.6 * rows, width=WIDTH if columns > 1 else 7.5)
    axis, picture = view.axes[up], None
    y = edges_of(axis.values, log=axis.log)
    for number, ax in enumerate(axes.flat):
        panel = grid[number // columns][number % columns]
        picture = draw_cells(ax, x, y, tables[number], scale[0], log=(axis.log, False))
        draw_failed(ax, x[[0, -1]], y, view.failed((up,), panel.place)[:, None])  # over the whole width
        scale_axis(ax, axis, up=True, label=number % columns == 0)
        separate_cells(ax, axis, y, up=True)
        ax.set_xlim(x[0], x[-1])
        if number >= (rows - 1) * columns:
            ax.set_xlabel(label, fontsize=TEXT)
        title_panel(ax, panel.title)
        mark(ax, number)
    color_bar(figure, axes, picture, view.label(name), scale[1])
    return finished(figure, title_of(view, words, held, view.mean_words))


def _over_orders(table: Floats, mesh: Floats, edges: Floats, orders: Floats) -> Floats:
    """Return each row's largest value of the bands that share a cell of orders, NaN where none does.

    ``edges`` are those of the bands [Hz], ``orders`` those of the cells, multiples of the ``mesh`` frequency [Hz].
    """
    found = np.full((len(table), len(orders) - 1), np.nan)
    for row, (values, frequency) in enumerate(zip(table, mesh, strict=True)):
        if np.isfinite(frequency):
            first = np.searchsorted(edges, orders[:-1] * frequency, side="right") - 1
            last = np.searchsorted(edges, orders[1:] * frequency, side="left")
            for cell in np.flatnonzero((last > 0) & (first < len(values)) & (last > first)):
                found[row, cell] = np.fmax.reduce(values[max(first[cell], 0) : last[cell]])
    return found


def mesh_frequencies(view: View, along: str, place: dict[str, int]) -> Floats:
    """Return the nominal frequency [Hz] of the first mesh along an axis, shape [value]; NaN where it is 0 or refused."""
    template, axis = view.sweep.template, view.axes[along]
    found = np.full(len(axis.values), np.nan)
    if not template.base.meshes or axis.labels:
        return found
    fixed = {name: view.raw(name, at) for name, at in place.items() if not view.axes[name].labels}
    tried = spread_places(len(found), MOST_ROWS)
    for at in tried:
        values = fixed | {along: view.raw(along, at)}
        changes = {
            path: values[name] if base is None else base * values[name]
            for path, name, base in template.fields
            if name in values
        }
        try:
            frequency = rolling.mesh_frequency(replace(template.base, changes))
        except GearplayError:
            continue
        found[at] = frequency if frequency > 0.0 else np.nan
    return found if len(tried) == len(found) else np.interp(np.arange(len(found)), tried, found[tried])


def _rows(view: View, name: str, up: str, panel: Panel) -> Floats:
    return view.table(name, (up, own_axis(view, name)), panel.place)


def _norm(tables: list[Floats]) -> tuple[Any, str] | None:
    """Return one logarithmic scale of colour for all panels and whether it is open below; None where nothing is above 0."""
    from matplotlib.colors import LogNorm

    every = np.concatenate([table.ravel() for table in tables])
    above = every[every > 0.0]
    if not above.size:
        return None
    top = float(above.max())
    low = max(float(above.min()), top * 10.0**-SHOWN)
    return LogNorm(min(low, 0.5 * top), top), "min" if np.nanmin(every) < low else "neither"


def _name_order(ax: Any, x: Floats, y: Floats, order: int, right: float) -> None:
    """Write the number of an order where its line leaves the picture."""
    inside = np.flatnonzero(np.isfinite(x) & (x <= 0.97 * right))
    if inside.size > 1:
        ax.annotate(f"{order}", (x[inside[-1]], y[inside[-1]]), textcoords="offset points", xytext=(-3, -1), ha="right",
                    va="top", fontsize=7, color=LINE)  # fmt: skip


def curves_figure(view: View, name: str) -> bytes | None:
    """Draw some spectra or histories as curves, cases spread evenly over the sweep; None where none was finished."""
    own = own_axis(view, name)
    x = view.dataset[own].values.astype(np.float64)
    sizes = [len(axis.values) for axis in view.axes.values()]
    places = [dict(zip(view.axes, map(int, np.unravel_index(at, sizes)), strict=True)) if sizes else {}
              for at in spread_places(int(np.prod(sizes)) if sizes else 1, 6)]  # fmt: skip
    history = name in view.histories
    found = [(view.brief(place) or name, _of_case(view, name, own, place, first=history)) for place in places]
    found = [(words, values) for words, values in found if np.isfinite(values).any()]
    if not found:
        return None
    figure, axes = make_figure(1, 1, 3.9, width=7.5)
    ax, handles = axes[0, 0], {}
    for at, (words, values) in enumerate(found):
        ax.plot(*extremes(x, values, MOST_POINTS // 2), color=PALETTE[at], linewidth=0.8)
        handles[words] = legend_mark(PALETTE[at], line="-")
    if not history:
        scale_ordinate(ax, np.concatenate([values for _, values in found]), below=0.7, above=1.5)
    ax.set_xlim(x[0], x[-1])
    ax.set_xlabel("time [s]" if history else "frequency [Hz]", fontsize=TEXT)
    label_axis(ax, view.label(name), up=True, width=50, size=SMALL)
    numbers = view.mean_words if not history else "one member each" if view.mean_words else ""
    title = title_of(view, name, view.held_words({}), numbers)
    return finished(figure, title, handles if len(found) > 1 else None)


def _of_case(view: View, name: str, own: str, place: dict[str, int], *, first: bool) -> Floats:
    """Return the mean of the members at a place, or the ``first`` alone: a mean of histories is no history."""
    if not first:
        return view.table(name, (own,), place)
    found = view.values(name, (own,), place)
    return found.reshape(len(found), -1)[:, 0]
