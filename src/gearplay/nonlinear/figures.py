"""Figures of bifurcation diagrams and of branches of periodic orbits."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from gearplay.nonlinear.orbits.branches import DOUBLING, FOLD, GRAZING, TORUS, Branch, Special
from gearplay.pictures.canvas import SMALL, legend_mark, make_figure, set_legend, set_title
from gearplay.pictures.style import COUPLED, UNCOUPLED
from gearplay.pictures.words import axis_label, offset_in, plain, shown_in
from gearplay.results.titles import words_of

if TYPE_CHECKING:
    import xarray as xr
WAYS = {"up": COUPLED, "down": UNCOUPLED}
FEW_POINTS = 3000
MARKS = {FOLD: "s", DOUBLING: "^", TORUS: "o", GRAZING: "x"}
BRANCH, POINT = "#222222", "#b02a4c"


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
            ax.plot(
                factor_x * x + offset, factor_y * values.ravel(), ("^" if way == "up" else "v") if few else ".",
                markersize=3.0 if few else 1.2, markerfacecolor="none" if few else WAYS[way], color=WAYS[way],
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
        figure, title or f"{words_of(diagram, 'Bifurcation diagram')}: {axis.attrs['long_name']} varied"
    )
    return figure


def _label(name: str, unit: str) -> str:
    """Return the label of an axis with its unit, [1] where there is none."""
    return axis_label(name, unit) if unit not in ("", "1") else f"{plain(name)} [1]"


def draw_branch(ax: Any, branch: Branch, values: Any, *, factor: float = 1.0, offset: float = 0.0) -> None:
    """Draw a branch on an axis: stable parts solid, unstable ones dotted, special points marked.

    ``values`` are what is shown of each orbit, shape [orbit] or [orbit, order]; ``factor`` multiplies the parameter,
    ``offset`` is added to it.
    """
    size = 5.0 / branch.order**0.5
    for y in np.asarray(values).reshape(len(branch.orbits), -1).T:
        for x, level, whole in _stretches(branch, y):
            ax.plot(
                factor * np.asarray(x) + offset, level, "-" if whole else ":", color=BRANCH, linewidth=1.2
            )
        for special in branch.special:
            level = _level(branch, special, y)
            ax.plot(
                factor * special.orbit.parameter + offset,
                level,
                MARKS[special.kind],
                color=POINT,
                markersize=size,
            )


def _stretches(branch: Branch, y: Any) -> list[tuple[Any, Any, bool]]:
    """Return the parts of a branch that are stable or not as lines x, y; they change at the special points between orbits."""
    turns = {s.place: s for s in branch.special if s.kind != GRAZING}
    lines: list[tuple[list[float], list[float], bool]] = []
    x, stable = branch.parameters, branch.stable
    for at in range(len(x)):
        if not lines or lines[-1][2] != stable[at]:
            begins: tuple[list[float], list[float]] = ([], [])
            if lines and at - 1 in turns:
                turn = turns[at - 1]
                begins = ([turn.orbit.parameter], [_level(branch, turn, y)])
                lines[-1][0].extend(begins[0])
                lines[-1][1].extend(begins[1])
            elif lines:
                begins = ([float(x[at - 1])], [float(y[at - 1])])
            lines.append((list(begins[0]), list(begins[1]), bool(stable[at])))
        lines[-1][0].append(float(x[at]))
        lines[-1][1].append(float(y[at]))
    return [(np.array(xs), np.array(ys), whole) for xs, ys, whole in lines]


def _level(branch: Branch, special: Special, y: Any) -> float:
    """Return where a special point is drawn: on the line between its neighbours."""
    low, high = (branch.orbits[special.place + k].parameter for k in (0, 1))
    share = float(np.clip((special.orbit.parameter - low) / (high - low), 0.0, 1.0)) if high != low else 0.5
    return float((1.0 - share) * y[special.place] + share * y[special.place + 1])


def branch_marks(branches: Sequence[Branch]) -> dict[str, Any]:
    """Return the legend entries for the points of branches."""
    stable = {bool(whole) for branch in branches for whole in branch.stable}
    marks = {"stable orbits": legend_mark(BRANCH, line="-")} if True in stable else {}
    if False in stable:
        marks["unstable orbits"] = legend_mark(BRANCH, line=":")
    kinds = {special.kind for branch in branches for special in branch.special}
    return marks | {kind: legend_mark(POINT, marker=MARKS[kind]) for kind in MARKS if kind in kinds}
