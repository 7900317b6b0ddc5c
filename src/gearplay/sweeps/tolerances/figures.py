"""Figures of a tolerance study: distribution, sensitivities, allowable clearances."""

import math
import textwrap
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gearplay.pictures.canvas import SMALL, TEXT, make_figure
from gearplay.pictures.panels import finished
from gearplay.pictures.style import CLEARANCE, COUPLED, TEST, UNCOUPLED
from gearplay.pictures.words import offset_in, plain, short, shown_in
from gearplay.sweeps.tolerances.allowable import Allowable
from gearplay.sweeps.tolerances.statistics import Distribution, Exceedance, interval_of
from gearplay.sweeps.variance import Indices, as_table

Floats = NDArray[np.float64]
LIMIT = "#b02a4c"
MOST_BARS = 20  # parameters in a picture of indices: those with the largest total
MOST_STEPS = 4000  # corners of a drawn distribution function
FAR = 2.0  # ranges of the values: a limit further off is not drawn
DECADES = 2.0  # from the least to the largest value: more are shown on a logarithmic scale


@dataclass(frozen=True)
class Scale:
    """A measure as engineers read it: its name, the unit shown, and how many of it are one SI unit."""

    name: str
    unit: str
    factor: float

    @classmethod
    def of(cls, name: str, unit: str, largest: float) -> "Scale":
        """Return the scale for values up to ``largest`` in the SI unit.

        >>> Scale.of("play", "m", 2e-4)
        Scale(name='play', unit='µm', factor=1000000.0)
        """
        shown, factor = shown_in(unit, largest)
        return cls(name, shown, factor)

    def words(self, value: float, digits: int = 3) -> str:
        """Return a value in the SI unit as text with the unit shown.

        >>> Scale.of("play", "m", 2e-4).words(1.234e-4)
        '123 µm'
        """
        return f"{self.factor * value + offset_in(self.unit):.{digits}g}" + (
            "" if self.unit == "1" else f" {self.unit}"
        )

    @property
    def label(self) -> str:
        """Text of an axis."""
        return plain("\n".join(textwrap.wrap(f"{self.name} [{self.unit}]", 110)))


def percent(value: float) -> str:
    """Return a probability as text, with more digits near its ends.

    >>> percent(0.123456), percent(0.00123), percent(0.99958), percent(0.95)
    ('12.3 %', '0.12 %', '99.958 %', '95 %')
    """
    edge = 100.0 * min(value, 1.0 - value)
    digits = min(6, max(1, 1 - math.floor(math.log10(edge)))) if edge > 0.0 else 1
    return f"{100.0 * value:.{digits}f}".rstrip("0").rstrip(".") + " %"


def distribution_figure(
    values: Floats, found: Distribution, over: Exceedance, scale: Scale, title: str, *, wanted: float
) -> bytes:
    """Draw a histogram of a measure over its empirical distribution function, with the limit.

    ``values`` has shape [sample] or [sample, member]; every point has the same weight. The band holds the distribution
    function at each value with the given confidence.
    """
    table = as_table(values)
    known = np.isfinite(table)
    limit = scale.factor * over.limit
    figure, axes = make_figure(2, 1, 5.4)
    top, bottom = axes[:, 0]
    top.sharex(bottom)
    top.tick_params(labelbottom=False)
    log = beyond = False
    if known.any():
        shares = known / np.maximum(known.sum(axis=1), 1)[:, None]
        pooled, weights = scale.factor * table[known], shares[known] / shares[known].sum()
        low, high = float(pooled.min()), float(pooled.max())
        log = low > 0.0 and high > 10.0**DECADES * low
        beyond = low < high and not low - FAR * (high - low) < limit < high + FAR * (high - low)
        _histogram(top, pooled, weights, limit, log=log)
        _steps(bottom, pooled, weights, found, over.confidence)
    if log:
        bottom.set_xscale("log")
    if not beyond:
        for ax in (top, bottom):
            ax.axvline(limit, color=LIMIT, linewidth=1.3)
    top.set_ylabel("share of the cases [%]", fontsize=TEXT)
    bottom.set_ylabel("share that stays below [%]", fontsize=TEXT)
    bottom.axhline(
        100.0 * wanted, color=TEST, linewidth=0.8, linestyle=":", label=f"wanted: {percent(wanted)}"
    )
    bottom.set_ylim(0.0, 102.0)
    bottom.set_xlabel(scale.label, fontsize=TEXT)
    words = f"limit {scale.words(over.limit, 4)}" + (", beyond this picture" if beyond else "")
    if math.isfinite(over.probability):
        words += (
            f"\nexceeded with probability {percent(over.probability)}"
            f"\n{percent(over.confidence)} interval {percent(over.low)} to {percent(over.high)}"
        )
    else:
        words += "\nno case finished"
    _annotate(top, limit, words)
    return _labelled(figure, bottom, title)


def _labelled(figure: Any, ax: Any, title: str) -> bytes:
    """Return a figure as PNG, with a title and the legend of one of its axes."""
    labels = ax.get_legend_handles_labels()
    figure.legend(*labels, loc="outside lower center", ncols=3, fontsize=SMALL, frameon=False)
    return finished(figure, title)


def _histogram(ax: Any, pooled: Floats, weights: Floats, limit: float, *, log: bool) -> None:
    """Draw bars of equal width, one of which ends at the limit; those above have the limit's colour."""
    x, end = (np.log(pooled), math.log(limit) if limit > 0.0 else -math.inf) if log else (pooled, limit)
    low, high = float(x.min()), float(x.max())
    width, start = (high - low) / min(60.0, max(10.0, 2.0 * len(x) ** (1.0 / 3.0))), low
    if not high - low > 1e-9 * max(abs(low), abs(high)):
        width = 0.02 * max(abs(high), abs(end)) or 1.0
        start -= 0.5 * width
    elif low < end < high:
        start = end
    first, last = math.floor((low - start) / width + 1e-9), math.ceil((high - start) / width - 1e-9)
    edges = start + width * np.arange(first, last + 1)
    inside = np.clip(x, edges[0], edges[-1])  # a bar includes its upper end: a value on the limit keeps to it
    heights = np.histogram(-inside, -edges[::-1], weights=100.0 * weights)[0][::-1]
    over = 0.5 * (edges[:-1] + edges[1:]) > end + 1e-9 * width
    shown = np.exp(edges) if log else edges
    for flags, color in ((~over, COUPLED), (over, LIMIT)):
        ax.bar(shown[:-1][flags], heights[flags], np.diff(shown)[flags], align="edge", color=color, alpha=0.8,
               edgecolor="white", linewidth=0.4)  # fmt: skip
    ax.set_ylim(0.0, 1.28 * float(heights.max()))  # room for labels


def _steps(ax: Any, pooled: Floats, weights: Floats, found: Distribution, confidence: float) -> None:
    order = np.argsort(pooled, kind="stable")
    x, reached = pooled[order], np.minimum(np.cumsum(weights[order]), 1.0)
    step = max(1, -(-len(x) // MOST_STEPS))
    x, reached = (
        np.concatenate([x[:1], x[:-1:step], x[-1:]]),
        np.concatenate([[0.0], reached[:-1:step], [1.0]]),
    )
    low, high = interval_of(reached, found.effective, confidence)
    ax.fill_between(x, 100.0 * low, 100.0 * high, step="post", color=COUPLED, alpha=0.18, linewidth=0,
                    label=f"{percent(confidence)} interval at each value")  # fmt: skip
    ax.step(
        x, 100.0 * reached, where="post", color=COUPLED, linewidth=1.3, label=f"share of {found.cases} cases"
    )


def _annotate(ax: Any, x: float, words: str) -> None:
    """Write a label at the top of a vertical line, on the side that has more room; at the edge for one beyond it."""
    low, high = ax.get_xlim()
    log = ax.get_xscale() == "log"
    place = math.log(x / low) / math.log(high / low) if log and x > 0.0 else (x - low) / (high - low)
    right, x = place < 0.6, min(max(x, low), high)
    ax.annotate(words, (x, 1.0), xycoords=("data", "axes fraction"), xytext=(5 if right else -5, -3),
                textcoords="offset points", ha="left" if right else "right", va="top", fontsize=SMALL, color=LIMIT,
                bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.75, "pad": 1.5})  # fmt: skip


def indices_figure(found: Indices, title: str) -> bytes:
    """Draw first-order and total indices of the parameters as bars with their intervals, the largest total first.

    The grey band is what scatter among members alone gives every total index of a saltelli design.
    """
    shown = found.ranking[:MOST_BARS]
    figure, axes = make_figure(1, 1, 1.6 + 0.42 * len(shown))
    ax = axes[0, 0]
    places = np.arange(len(shown))
    noise = found.noise if math.isfinite(found.noise) else 0.0
    if noise > 0.0 and found.source == "sobol":
        ax.axvspan(0.0, noise, color=CLEARANCE, alpha=0.25, linewidth=0, label="scatter among members")
    pairs = (
        (-0.18, found.first, found.first_error, COUPLED, "first order: by this parameter alone"),
        (0.18, found.total, found.total_error, UNCOUPLED, "total: also by acting with others"),
    )
    for shift, values, errors, color, label in pairs:
        x, half = np.array(values)[shown], np.array(errors)[shown]
        ax.barh(places + shift, x, 0.34, color=color, alpha=0.85, label=label)
        ax.errorbar(x, places + shift, xerr=half, fmt="none", ecolor=TEST, elinewidth=0.9, capsize=2.5)
    ax.axvline(0.0, color=TEST, linewidth=0.7)
    ax.set_yticks(places, [plain(short(found.names[at], 34)) for at in shown])
    ax.set_ylim(len(shown) - 0.4, -0.6)
    ax.grid(False, axis="y")
    ax.set_xlim(min(0.0, ax.get_xlim()[0]), max(1.0, ax.get_xlim()[1]))
    ax.set_xlabel(
        f"share of the variance [1]; whiskers: {percent(found.confidence)} intervals", fontsize=TEXT
    )
    return _labelled(figure, ax, title)


def search_figure(found: Allowable, title: str, grows: str = "what grows") -> bytes:
    """Draw the probability to keep to the limit against the factor, with the result, its span and the fresh sample.

    ``grows`` names what is multiplied. Where the span is bounded, a second panel shows its surroundings.
    """
    near = found.single and all(map(math.isfinite, found.span)) and found.span[0] < found.span[1]
    figure, both = make_figure(1, 2 if near else 1, 3.9)
    axes = both[0]
    for ax in axes:
        _search(ax, found)
        ax.set_xlabel(plain(short(f"factor of {grows}", 60)), fontsize=TEXT)
    axes[0].set_ylabel("share that keeps to the limit [%]", fontsize=TEXT)
    axes[0].set_ylim(max(-2.0, 100.0 * min(found.wanted, *(s.low for s in found.steps)) - 4.0), 102.0)
    if near:
        width = found.span[1] - found.span[0]
        axes[1].set_xlim(found.span[0] - 0.4 * width, found.span[1] + 0.4 * width)
        shown = [s for s in found.steps if found.span[0] <= s.factor <= found.span[1]]
        shown += [found.check] if found.check is not None else []
        low, high = 100.0 * min(s.low for s in shown), 100.0 * max(s.high for s in shown)
        axes[1].set_ylim(low - 0.1 * (high - low), high + 0.1 * (high - low))
        axes[1].set_title("around the answer", fontsize=TEXT, loc="left")
    return _labelled(figure, axes[0], title)


def _search(ax: Any, found: Allowable) -> None:
    x = np.array([s.factor for s in found.steps])
    meets, low, high = (
        100.0 * np.array([getattr(s, name) for s in found.steps]) for name in ("meets", "low", "high")
    )
    if found.single and math.isfinite(found.factor):
        ax.axvspan(*np.clip(found.span, x[0], x[-1]), color=CLEARANCE, alpha=0.22, linewidth=0,
                   label=f"{percent(found.confidence)} interval of the true limit")  # fmt: skip
    ax.plot(x, meets, color=COUPLED, linewidth=0.8, alpha=0.6)
    ax.errorbar(x, meets, yerr=[meets - low, high - meets], fmt="o", color=COUPLED, markersize=4.5, elinewidth=0.9,
                capsize=2.5, label="simulated, the same points for all")  # fmt: skip
    ax.axhline(
        100.0 * found.wanted,
        color=TEST,
        linewidth=0.9,
        linestyle=":",
        label=f"wanted: {percent(found.wanted)}",
    )
    if math.isfinite(found.factor):
        words = (
            f"safe with {percent(found.confidence)} confidence" if found.safe else "kept by the sample alone"
        )
        ax.axvline(found.advised, color=LIMIT, linewidth=1.2, label=f"{words}: × {found.advised:.3g}")
    c = found.check
    if c is not None:
        ax.errorbar([c.factor], [100.0 * c.meets], yerr=[[100.0 * (c.meets - c.low)], [100.0 * (c.high - c.meets)]],
                    fmt="D", color=UNCOUPLED, markersize=5.5, elinewidth=1.3, capsize=4, zorder=5,
                    label="fresh points")  # fmt: skip
