"""Figure of a bifurcation diagram, with branches of periodic orbits."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from gearplay.nonlinear.orbits.branches import Branch
from gearplay.nonlinear.orbits.figures import branch_marks, draw_branch
from gearplay.pictures.canvas import SMALL, legend_mark, make_figure, set_legend, set_title
from gearplay.pictures.style import COUPLED, UNCOUPLED
from gearplay.pictures.words import axis_label, offset_in, plain, shown_in
from gearplay.results.titles import words_of

if TYPE_CHECKING:
    import xarray as xr

WAYS = {"up": COUPLED, "down": UNCOUPLED}
FEW_POINTS = 3000
SMALLEST_DOT, LARGEST_DOT = 1.2, 3.0  # points
COLUMN_SHARE = 180.0  # width of a dot times the number of values [points]: a third of the panel


def bifurcation_drawing(
    diagram: "xr.Dataset",
    signals: Sequence[str],
    *,
    branches: Sequence[tuple[Branch, Any]] = (),
    title: str = "",
) -> Any:
    """Return the figure of a bifurcation diagram: every section of each signal over the parameter, both ways in their colours.

    ``diagram`` is that of `gearplay.bifurcation`; one panel a signal, below each other. ``branches`` of periodic orbits come with
    the same signals at their sections, shape [orbit, order, signal].
    """
    name = diagram[signals[0]].dims[1]
    axis = diagram[name]
    figure, axes = make_figure(len(signals), 1, 1.0 + 2.6 * len(signals))
    unit_x, factor_x = shown_in(axis.attrs["units"], float(np.abs(axis.values).max()))
    offset = offset_in(unit_x)
    ways = [str(way) for way in diagram["direction"].values]
    for column, (ax, signal) in enumerate(zip(axes[:, 0], signals, strict=True)):
        variable = diagram[signal]
        largest = float(np.nanmax(np.abs(variable.values))) if np.isfinite(variable.values).any() else 1.0
        unit_y, factor_y = shown_in(variable.attrs["units"], largest)
        for at, way in enumerate(ways):
            values = variable.values[at]
            x = np.repeat(axis.values, values.shape[1])
            few = x.size <= FEW_POINTS
            dot = min(LARGEST_DOT, max(SMALLEST_DOT, COLUMN_SHARE / len(axis)))
            ax.plot(
                factor_x * x + offset, factor_y * values.ravel(), ("^" if way == "up" else "v") if few else ".",
                markersize=LARGEST_DOT if few else dot, markerfacecolor="none" if few else WAYS[way], color=WAYS[way],
                markeredgewidth=1.0 if few else 0.0, linestyle="none", alpha=0.9, rasterized=True,
            )  # fmt: skip
        for branch, levels in branches:
            draw_branch(
                ax, branch, factor_y * np.asarray(levels)[:, :, column], factor=factor_x, offset=offset
            )
        edge = 0.01 * (axis.values[-1] - axis.values[0])
        ax.set_xlim(factor_x * (axis.values[0] - edge) + offset, factor_x * (axis.values[-1] + edge) + offset)
        ax.set_ylabel(_label(variable.attrs["long_name"], unit_y), fontsize=SMALL)
    axes[-1, 0].set_xlabel(_label(axis.attrs["long_name"], unit_x), fontsize=SMALL)
    arrows = {"up": "up →", "down": "← down"}
    handles = {arrows[way]: legend_mark(WAYS[way], marker="o") for way in ways}
    set_legend(figure, handles | branch_marks([branch for branch, _ in branches]))
    set_title(
        figure,
        title or f"{words_of(diagram, 'Bifurcation diagram')}: sections over {axis.attrs['long_name']}",
    )
    return figure


def _label(name: str, unit: str) -> str:
    """Return the label of an axis with its unit, [1] where there is none."""
    return axis_label(name, unit) if unit not in ("", "1") else f"{plain(name)} [1]"
