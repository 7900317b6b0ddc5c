"""Curves of a sweep over one axis, with the spread of members and hysteresis."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gearplay.pictures.canvas import PALETTE, TEXT, legend_mark
from gearplay.pictures.panels import finished, label_axis, make_panels, scale_ordinate
from gearplay.pictures.scales import edges_of, spread_places
from gearplay.pictures.style import CLEARANCE, COUPLED, UNCOUPLED
from gearplay.pictures.words import plain
from gearplay.sweeps.report.drawable import DIRECTION, View
from gearplay.sweeps.report.maps import JAM, JAM_WORDS, jam_lines_of, scale_axis, title_of
from gearplay.sweeps.variance import member_means

Floats = NDArray[np.float64]
PER_PAGE = 6  # numbers on one picture
MOST_CURVES = 8
MOST_MARKED = 60  # points of a curve that each get a mark
LEAST_RANGE = 0.02  # of the greatest value, on an ordinate
CONFIDENCE = 0.95  # from which on a difference is marked


def line_figure(view: View, names: Sequence[str], along: str) -> bytes | None:
    """Draw variables over one axis, a panel each and a curve for each value of a second, short axis; bands are the spread.

    Crosses at the foot are cases that failed. None where no case has a number.
    """
    second, places, held = _curves(view, along)
    curves = [(place, PALETTE[at % len(PALETTE)]) for at, place in enumerate(places)]
    bands = {
        (name, at): view.bands(name, (along,), held | place)
        for name in names
        for at, (place, _) in enumerate(curves)
    }
    if not any(np.isfinite(band[0]).any() for band in bands.values()):
        return None
    figure, axes = make_panels(len(names), 2, 2.3, alone=(3.3, 7.5))
    limits, own = _jam_limits(view, along, held, curves)
    failed = np.any([view.failed((along,), held | place) for place, _ in curves], axis=0)
    for number, (ax, name) in enumerate(zip(axes.flat, names, strict=False)):
        for at, (_, color) in enumerate(curves):
            _curve(ax, view, along, bands[name, at], color, (at, len(curves)))
        _finish(ax, view, name, [x for at in range(len(curves)) for x in bands[name, at]])
        for x, color in limits:
            ax.axvline(x, color=color, linewidth=1.0, linestyle=(0, (5, 2)), zorder=1.5)
        _crosses(ax, view, along, failed)
        scale_axis(ax, view.axes[along], label=number >= len(names) - axes.shape[1])
    handles = {
        view.axes[second].text(place[second]): legend_mark(color, line="-")
        for place, color in curves
        if second
    }
    if limits:
        handles["jam line of each curve" if own else JAM_WORDS] = legend_mark(
            CLEARANCE if own else JAM, line="--"
        )
    if failed.any():
        handles["some case failed"] = legend_mark(CLEARANCE, marker="x")
    words = f"numbers over {view.axes[along].words}"
    return finished(figure, title_of(view, words, view.held_words(held), view.band_words), handles)


def _jam_limits(
    view: View, along: str, held: dict[str, int], curves: Sequence[tuple[dict[str, int], str]]
) -> tuple[list[tuple[float, str]], bool]:
    """Return the jam limits on an axis with their colours, and whether these are those of curves with limits of their own."""
    found = [
        {
            view.axes[along].shown(float(line.across[0]))
            for line in jam_lines_of(view, along, "", held | place)
        }
        for place, _ in curves
    ]
    own = any(each != found[0] for each in found)
    colors = [color for _, color in curves] if own else [JAM]
    pairs = [(x, color) for each, color in zip(found, colors, strict=False) for x in sorted(each)]
    return [(x, color) for x, color in pairs if _within(view, along, x)], own


def _within(view: View, along: str, x: float) -> bool:
    edges = edges_of(view.axes[along].values, log=view.axes[along].log)
    return bool(edges[0] < x < edges[-1])


def _curves(view: View, along: str) -> tuple[str, list[dict[str, int]], dict[str, int]]:
    """Return the axis of the curves, their places on it, and the places of the fixed axes."""
    category = next((name for name in view.categories if name != along), "")
    numeric = sorted((name for name in view.numeric if name != along), key=lambda n: len(view.axes[n].values))
    second = category or (numeric[0] if numeric else "")
    held = view.held((along, second))
    if not second:
        return "", [{}], held
    most = MOST_CURVES if second == category else 5
    return second, [{second: at} for at in spread_places(len(view.axes[second].values), most)], held


def _curve(
    ax: Any, view: View, along: str, band: tuple[Floats, Floats, Floats], color: str, rank: tuple[int, int]
) -> None:
    """Draw one curve and its spread; the first are wider, and categories side by side, so that equal ones stay visible."""
    axis, (at, count) = view.axes[along], rank
    (middle, low, high), width = band, 2.4 - 1.3 * at / max(1, count - 1)
    if axis.labels:
        x = axis.values + 0.1 * (at - 0.5 * (count - 1))
        known = np.isfinite(middle)
        ax.vlines(x[known], low[known], high[known], color=color, linewidth=1.2, alpha=0.6)
        ax.plot(x, middle, "o", color=color, markersize=4.5)
        return
    if low is not middle:
        ax.fill_between(axis.values, low, high, color=color, alpha=0.15, linewidth=0)
    marker = "." if len(middle) <= MOST_MARKED else ""
    ax.plot(axis.values, middle, color=color, linewidth=width, marker=marker, markersize=2.0 + 1.6 * width)


def _finish(ax: Any, view: View, name: str, values: Sequence[Floats]) -> None:
    """Scale and label the ordinate."""
    every = np.concatenate(list(values))
    known = every[np.isfinite(every)]
    if known.size and np.ptp(known) <= LEAST_RANGE * np.abs(known).max():  # no magnifying glass for rounding
        middle, half = float(known.mean()), 0.5 * LEAST_RANGE * float(np.abs(known).max())
        ax.set_ylim((middle - half, middle + half) if half > 0.0 else (-0.05, 1.0))
    scale_ordinate(ax, every)
    ax.set_title(plain(name), fontsize=TEXT, loc="left")
    label_axis(ax, view.label(name), up=True, size=7)


def _crosses(ax: Any, view: View, along: str, failed: NDArray[np.bool_]) -> None:
    """Mark at the foot where cases failed."""
    x = view.axes[along].values[failed]
    ax.plot(
        x, np.full(len(x), 0.02), "x", color=CLEARANCE, markersize=4.5, transform=ax.get_xaxis_transform()
    )


def carried_axis(view: View) -> str | None:
    """Return the axis along which cases go up and down, None without an axis ``direction`` or without any other axis.

    It is the plan's; of a dataset made otherwise the first speed, or the longest axis.
    """
    if DIRECTION not in view.axes or sorted(view.axes[DIRECTION].labels) != ["down", "up"]:
        return None
    carry = view.sweep.plan.carry
    return carry.axis if carry is not None and carry.axis in view.axes else next(iter(view.numeric), None)


def hysteresis_figure(view: View, names: Sequence[str], along: str, fixed: dict[str, int]) -> bytes | None:
    """Draw variables on the way up and down one axis; bands are one standard error of the members.

    Grey bars join what differs by more than its 95 % interval, of Student's t with the members' degrees of freedom.
    ``fixed`` are places along categories.
    """
    labels = view.axes[DIRECTION].labels
    held = {name: at for name, at in (view.held((along, DIRECTION)) | fixed).items() if name}
    ways = {
        (name, way): _mean_and_error(view, name, along, held | {DIRECTION: labels.index(way)})
        for name in names
        for way in ("up", "down")
    }
    if not any(np.isfinite(mean).any() for mean, _ in ways.values()):
        return None
    figure, axes = make_panels(len(names), 2, 2.3, alone=(3.3, 7.5))
    failed = np.asarray(view.failed((along, DIRECTION), held).any(axis=1))
    x, differs = view.axes[along].values, False
    for number, (ax, name) in enumerate(zip(axes.flat, names, strict=False)):
        (up, up_error), (down, down_error) = ways[name, "up"], ways[name, "down"]
        apart = _differ(ways[name, "up"], ways[name, "down"], view.members)
        differs |= bool(apart.any())
        ax.vlines(x[apart], up[apart], down[apart], color=CLEARANCE, alpha=0.45, linewidth=4.0)
        for mean, error, color, marker in ((up, up_error, COUPLED, ">"), (down, down_error, UNCOUPLED, "<")):
            ax.fill_between(x, mean - error, mean + error, color=color, alpha=0.18, linewidth=0)
            ax.plot(x, mean, color=color, linewidth=1.1, marker=marker, markersize=4)
        _finish(ax, view, name, [up, down])
        _crosses(ax, view, along, failed)
        scale_axis(ax, view.axes[along], label=number >= len(names) - axes.shape[1])
    handles = {
        "up →": legend_mark(COUPLED, marker=">", line="-"),
        "← down": legend_mark(UNCOUPLED, marker="<", line="-"),
    }
    if failed.any():
        handles["some case failed"] = legend_mark(CLEARANCE, marker="x")
    if differs:
        handles["differ (95 %)"] = legend_mark(CLEARANCE, line="-")
    numbers = view.mean_words or "one case each: no spread to compare with"
    words = f"up and down over {view.axes[along].words}"
    return finished(figure, title_of(view, words, view.held_words(held), numbers), handles)


def _differ(one: tuple[Floats, Floats], other: tuple[Floats, Floats], count: int) -> NDArray[np.bool_]:
    """Return where two means of ``count`` cases each, given with their standard errors, differ by Welch's test."""
    from scipy.stats import ttest_ind_from_stats

    (mean, error), (other_mean, other_error) = one, other
    scale = np.sqrt(count)
    with np.errstate(divide="ignore", invalid="ignore"):
        found = ttest_ind_from_stats(
            mean, scale * error, count, other_mean, scale * other_error, count, equal_var=False
        )
    return np.asarray(found.pvalue < 1.0 - CONFIDENCE)


def _mean_and_error(view: View, name: str, along: str, place: dict[str, int]) -> tuple[Floats, Floats]:
    """Return mean and standard error of members (and drawn points); without several the error is not known."""
    found = view.values(name, (along,), place).reshape(len(view.axes[along].values), -1)
    count, mean = np.isfinite(found).sum(axis=1), member_means(found)
    square = np.nansum((found - mean[:, None]) ** 2, axis=1)
    variance = np.divide(square, (count - 1) * count, out=np.full(len(count), np.nan), where=count > 1)
    return mean, np.sqrt(variance)
