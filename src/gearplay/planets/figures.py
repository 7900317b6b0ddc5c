"""Figure of load sharing."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from gearplay.pictures.canvas import PALETTE, SMALL, legend_mark, make_figure, set_legend, set_title
from gearplay.pictures.extremes import thinned_path
from gearplay.pictures.style import CLEARANCE, MOST_POINTS, STILL
from gearplay.pictures.words import plain

if TYPE_CHECKING:
    import xarray as xr


LEAST_REACH = 0.1
"""Least half-width of a panel of displacements, of the distance of its middle from 0: closer ones are drawn as one place."""


def sharing_drawing(ds: xr.Dataset) -> Any:
    """Return the figure of a set's load sharing: factors, of a motion also over the carrier's turn; planets; floating members."""
    moving = "factor_history" in ds
    figure, axes = make_figure(2, 2, 7.0)
    names = [str(name) for name in ds["planet"].values]
    colors = [PALETTE[k % len(PALETTE)] for k in range(len(names))]
    _factors(axes[0, 0], ds, colors)
    _forces(axes[0, 1], ds, colors, moving=moving)
    _pins(axes[1, 0], ds, colors, moving=moving)
    _floats(axes[1, 1], ds, moving=moving)
    handles = {
        name: legend_mark(color, marker="o", line="-") for name, color in zip(names, colors, strict=True)
    }
    if ds.attrs["pin_clearance"] > 0.0:
        handles["clearance circle of a pin"] = legend_mark(CLEARANCE, line="-")
    set_legend(figure, handles)
    how = "along the motion" if moving else "at rest under the load"
    set_title(figure, f"{ds.attrs.get('title') or 'Load sharing'}: planets of {ds.attrs['set']}, {how}")
    return figure


def _factors(ax: Any, ds: xr.Dataset, colors: list[str]) -> None:
    factor = ds["load_sharing_factor"].values
    spread = ds["factor_spread"].values if "factor_spread" in ds else None
    ax.bar(range(len(factor)), factor, color=colors, width=0.6, yerr=spread, ecolor="#222222", capsize=3)
    ax.axhline(1.0, color=CLEARANCE, linewidth=1.0, linestyle="--")
    ax.set_xticks(range(len(factor)), [str(k + 1) for k in range(len(factor))])
    ax.set_xlabel("number of the planet", fontsize=SMALL)
    ax.set_ylabel(
        "load-sharing factor [1], with its spread" if spread is not None else "load-sharing factor [1]",
        fontsize=SMALL,
    )


def _forces(ax: Any, ds: xr.Dataset, colors: list[str], *, moving: bool) -> None:
    if moving:
        place, rows = np.degrees(ds["place"].values), 1e-3 * ds["force_over_turn"].values
        for row, color in zip(rows, colors, strict=True):
            ax.plot(place, row, color=color, linewidth=1.0, marker=".", markersize=4)
        reached = place[np.any(np.isfinite(rows), axis=0)]
        if len(reached) > 0.2 * len(place):
            ax.set_xlim(0.0, 360.0)
            ax.set_xticks(range(0, 361, 60))
        else:  # a small part of a turn
            ax.set_xlim(reached[0] - 2.0, reached[-1] + 2.0)
        ax.set_xlabel("rotation of the carrier [deg]", fontsize=SMALL)
    else:
        ax.bar(range(len(colors)), 1e-3 * ds["sun_force"].values, color=colors, width=0.6)
        ax.set_xticks(range(len(colors)), [str(k + 1) for k in range(len(colors))])
        ax.set_xlabel("number of the planet", fontsize=SMALL)
    low, high = ax.get_ylim()
    ax.set_ylim(min(0.0, low), 1.1 * high)
    ax.set_ylabel("force of the sun's mesh [kN]", fontsize=SMALL)


def _pins(ax: Any, ds: xr.Dataset, colors: list[str], *, moving: bool) -> None:
    clearance = 1e6 * float(ds.attrs["pin_clearance"])
    angle = np.linspace(0.0, 2.0 * np.pi, 361)
    if clearance > 0.0:
        ax.plot(clearance * np.cos(angle), clearance * np.sin(angle), color=CLEARANCE, linewidth=1.0)
    for k, color in enumerate(colors):
        if moving:
            x, y = (1e6 * ds["beside_pin_history"].values[k][axis] for axis in range(2))
            ax.plot(*thinned_path(x, y, MOST_POINTS), color=color, linewidth=0.6)
        ax.plot(*(1e6 * ds["beside_pin"].values[k]), "o", color=color, markersize=4)
    _frame(ax)
    ax.set_xlabel("planet in its pin, outwards [µm]", fontsize=SMALL)
    ax.set_ylabel("ahead [µm]", fontsize=SMALL)


def _floats(ax: Any, ds: xr.Dataset, *, moving: bool) -> None:
    members = [str(name) for name in ds["member"].values]
    for k, name in enumerate(members):
        color = PALETTE[(k + 8) % len(PALETTE)]
        if moving:
            x, y = (1e6 * ds["floating_history"].values[k][axis] for axis in range(2))
            ax.plot(*thinned_path(x, y, MOST_POINTS), color=color, linewidth=0.6, label=plain(name))
        else:
            ax.plot(*(1e6 * ds["floating"].values[k]), "o", color=color, markersize=5, label=plain(name))
    if members:
        ax.legend(fontsize=SMALL, frameon=False)
    else:
        ax.text(
            0.5, 0.5, "sun, ring and carrier are held", ha="center", transform=ax.transAxes, fontsize=SMALL
        )
    _frame(ax)
    ax.set_xlabel("floating members, x [µm]", fontsize=SMALL)
    ax.set_ylabel("y [µm]", fontsize=SMALL)


def _frame(ax: Any) -> None:
    """Set equal scales for displacements [µm], none on which rounding is drawn as a difference."""
    box = ax.dataLim
    ax.set_aspect("equal", adjustable="datalim")
    ax.locator_params(nbins=5)
    if not np.all(np.isfinite(box.get_points())):  # nothing is drawn
        return
    x, y = 0.5 * (box.x0 + box.x1), 0.5 * (box.y0 + box.y1)
    least = max(LEAST_REACH * float(np.hypot(x, y)), 1e6 * STILL["m"])
    if 0.5 * max(box.width, box.height) < least:
        ax.set_xlim(x - least, x + least)
        ax.set_ylim(y - least, y + least)
        ax.set_aspect("equal", adjustable="box")  # no fixed limits are widened
