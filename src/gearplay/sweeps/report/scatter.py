"""Scatter plots of drawn parameters, and parallel coordinates."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gearplay.pictures.canvas import (
    PALETTE,
    SMALL,
    legend_mark,
    make_figure,
)
from gearplay.pictures.panels import finished, label_axis, make_panels, round_ticks, scale_ordinate
from gearplay.pictures.style import CLEARANCE, COUPLED, UNCOUPLED
from gearplay.pictures.words import plain, short, wrapped
from gearplay.sweeps.report.drawable import SAMPLE, Along, View
from gearplay.sweeps.report.maps import MAP, color_bar, norm_of, title_of

Floats = NDArray[np.float64]
MOST_LINES, MOST_DOTS, FEW = 2000, 4000, 100
FROM_TENTHS, MOST_GREY, MOST_OF_TENTH = 60, 400, 150
MOST_PANELS, MOST_ACROSS, MOST_TICKS = 12, 14, 12
SEED = 20210623
JITTER = 0.012  # of an axis, so that lines through the same value do not coincide


def scatter_figure(view: View, name: str) -> bytes | None:
    """Draw a variable against each drawn parameter, colours for the values of a category, the rest held fixed.

    None where no case has a number.
    """
    category = next(iter(view.categories), "")
    held = view.held((category,) if category else ())
    groups = [{category: at} for at in range(min(8, len(view.axes[category].values)))] if category else [{}]
    found = [view.table(name, (SAMPLE,), held | group) for group in groups]
    every = np.concatenate(found)
    if not np.isfinite(every).any():
        return None
    drawn = list(view.drawn.values())
    drawn = [drawn[at] for at in strongest([axis.values for axis in drawn], found[0], MOST_PANELS)]
    figure, axes = make_panels(len(drawn), 2 if len(drawn) == 4 else 3, 2.3, alone=(3.3, 7.0))
    step = max(1, -(-view.samples // MOST_DOTS))
    for at, (ax, axis) in enumerate(zip(axes.flat, drawn, strict=False)):
        for values, color in zip(found, PALETTE, strict=False):
            ax.plot(
                axis.values[::step],
                values[::step],
                ".",
                color=color,
                markersize=4 if view.samples > FEW else 7,
                alpha=0.65,
                markeredgewidth=0,
            )
        if axis.log:
            ax.set_xscale("log")
            round_ticks(ax.xaxis, float(axis.values.min()), float(axis.values.max()))
        scale_ordinate(ax, every)
        label_axis(ax, axis.label, width=34)
        if at % axes.shape[1] == 0:
            label_axis(ax, view.label(name), up=True, size=7)
    numbers = f"{view.samples} drawn points{_left_out(len(drawn), len(view.drawn))}" + (
        f", mean of {view.members} members" if view.members > 1 else ""
    )
    title = title_of(view, f"{name} against each drawn parameter", view.held_words(held), numbers)
    marks = {view.where(g): legend_mark(c, marker=".") for g, c in zip(groups, PALETTE, strict=False)}
    return finished(figure, title, marks if category else None)


def strongest(columns: Sequence[Floats], values: Floats, most: int) -> list[int]:
    """Return the numbers of at most ``most`` columns, in order: those whose ranks go most with the values'.

    >>> strongest([np.arange(5.0), np.array([1.0, 0.0, 1.0, 0.0, 1.0]), -np.arange(5.0)], np.arange(5.0) ** 3, 2)
    [0, 2]
    """
    if len(columns) <= most:
        return list(range(len(columns)))
    known = np.isfinite(values)
    ranks = [
        np.argsort(np.argsort(column[known], kind="stable")).astype(float) for column in (*columns, values)
    ]
    own = ranks.pop()
    along = [abs(float(np.dot(rank - rank.mean(), own - own.mean()))) for rank in ranks]
    return sorted(sorted(range(len(columns)), key=lambda at: -along[at])[:most])


def _left_out(shown: int, count: int) -> str:
    return f", the {shown} of {count} parameters that it goes with most" if shown < count else ""


def chosen_cases(count: int) -> NDArray[np.int64]:
    """Return the numbers of at most `MOST_LINES` cases of ``count``, the same at every call."""
    if count <= MOST_LINES:
        return np.arange(count)
    return np.sort(np.random.default_rng(SEED).choice(count, MOST_LINES, replace=False))


def parallel_figure(view: View, name: str) -> bytes | None:
    """Draw cases as lines across all axes and drawn parameters: few coloured by a variable, of many the extreme tenths.

    None where no case has a number. Lines are spread a little around the values of an axis.
    """
    dims = [*view.axes, *((SAMPLE,) if view.samples > 1 else ())]
    sizes = [view.samples if dim == SAMPLE else len(view.axes[dim].values) for dim in dims]
    cases = chosen_cases(math.prod(sizes))
    places = dict(zip(dims, np.unravel_index(cases, sizes), strict=True))
    values = view.at_cases(name, places)
    known = np.isfinite(values)
    scale = norm_of([values])
    if scale is None:
        return None
    across = [*view.axes.values(), *view.drawn.values()]
    places_of = {axis.name: places[SAMPLE if axis.name in view.drawn else axis.name] for axis in across}
    columns = [axis.values[places_of[axis.name]] for axis in across]
    across = [across[at] for at in strongest(columns, values, MOST_ACROSS)]
    jitter = np.random.default_rng(SEED)
    heights = []
    for axis in across:
        at = places_of[axis.name]
        spread = 0.0 if axis.name in view.drawn else JITTER * jitter.uniform(-1.0, 1.0, len(at))
        heights.append(_unit(axis, axis.values[at]) + spread)
    lines = np.column_stack(heights)[known]
    order = np.argsort(values[known], kind="stable")
    figure, axes = make_figure(1, 1, 4.9)
    ax = axes[0, 0]
    many = len(lines) >= FROM_TENTHS
    draw = _draw_tenths if many else _draw_lines
    handles = draw(ax, lines[order], values[known][order], scale[0], view.unit(name))
    for at, axis in enumerate(across):
        _axis(ax, at, axis, listed=axis.name not in view.drawn and len(axis.values) <= MOST_TICKS)
    labels = [plain(wrapped(short(axis.label, 60), max(9, 84 // len(across)))) for axis in across]
    ax.set_xticks(range(len(across)), labels, fontsize=SMALL if len(across) < 9 else 6.5)
    ax.set_yticks([])
    ax.set_xlim(-0.25, len(across) - 0.6)
    ax.set_ylim(-0.04, 1.04)
    ax.spines[:].set_visible(False)
    ax.tick_params(length=0)
    ax.grid(False)
    if not many:
        color_bar(figure, axes, ax.collections[0], view.label(name), scale[1])
    left_out = _left_out(len(across), len(view.axes) + len(view.drawn))
    count = f"{int(known.sum())} of {math.prod(sizes)} cases{left_out}"
    numbers = ", ".join(words for words in (count, view.member_words) if words)
    title = title_of(view, f"{name} over all that varies", view.held_words({}), numbers)
    return finished(figure, title, handles)


def _draw_lines(ax: Any, lines: Floats, values: Floats, norm: Any, unit: str) -> dict[str, Any]:
    """Draw every line in the colour of its value."""
    _add(ax, lines, 1.2, 0.7, array=np.maximum(values, norm.vmin), norm=norm, cmap=MAP)
    return {}


def _draw_tenths(ax: Any, lines: Floats, values: Floats, norm: Any, unit: str) -> dict[str, Any]:
    """Draw the tenth of the highest values and that of the lowest over the rest; lines and values rise together."""
    tenth, shown_unit = max(1, len(lines) // 10), "" if unit == "1" else f" {unit}"
    shown = np.random.default_rng(SEED).permutation(np.arange(tenth, len(lines) - tenth))[:MOST_GREY]
    _add(ax, lines[shown], 0.5, 0.35, color=CLEARANCE)
    handles = {}
    for words, part, color in (
        ("lowest", slice(0, tenth), COUPLED),
        ("highest", slice(-tenth, None), UNCOUPLED),
    ):
        _add(ax, lines[part][-MOST_OF_TENTH:], 0.8, 0.6, color=color)
        ends = f"{values[part].min():.3g} to {values[part].max():.3g}{shown_unit}"
        handles[f"{words} tenth: {ends}"] = legend_mark(color, line="-")
    return handles | {"the rest": legend_mark(CLEARANCE, line="-")}


def _add(ax: Any, lines: Floats, width: float, alpha: float, **style: Any) -> None:
    from matplotlib.collections import LineCollection

    x = np.arange(lines.shape[1], dtype=np.float64)
    paths = [np.column_stack([x, line]) for line in lines]
    ax.add_collection(LineCollection(paths, linewidth=width, alpha=alpha, **style))


def _unit(axis: Along, values: Floats) -> Floats:
    """Return values between the least (0) and the greatest (1) of their axis, by logarithms where it is logarithmic."""
    low, high = float(axis.values.min()), float(axis.values.max())
    if axis.log:
        return np.asarray(np.log(values / low) / np.log(high / low))
    return (values - low) / (high - low)


def _axis(ax: Any, at: int, axis: Along, *, listed: bool) -> None:
    """Draw one of the parallel axes with its ticks; ``listed``: ticks at the values of the axis."""
    from matplotlib.ticker import LogLocator, MaxNLocator

    low, high = float(axis.values.min()), float(axis.values.max())
    if axis.labels:
        places = axis.values[:: max(1, -(-len(axis.values) // 12))]
        labels = [plain(wrapped(short(axis.labels[int(v)], 28), 14)) for v in places]
    else:
        locator = LogLocator(subs=(1.0, 2.0, 5.0), numticks=9) if axis.log else MaxNLocator(5)
        places = np.array([v for v in locator.tick_values(low, high) if low <= v <= high])
        if listed:
            places = axis.values
        elif len(places) < 2 or len(places) > MOST_TICKS:
            places = np.array([low, high])
        labels = [f"{v:.3g}" for v in places]
    ax.axvline(at, color="#555a66", linewidth=0.8, zorder=3)
    for place, label in zip(_unit(axis, places), labels, strict=True):
        ax.plot([at - 0.015, at + 0.015], [place, place], color="#555a66", linewidth=0.8, zorder=3)
        ax.text(at + 0.025, place, label, fontsize=6.5, va="center", zorder=4,
                bbox={"boxstyle": "round,pad=0.1", "facecolor": "white", "edgecolor": "none", "alpha": 0.75})  # fmt: skip
