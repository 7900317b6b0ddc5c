"""Figure of wear over life."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from gearplay.pictures.canvas import PALETTE, SMALL, make_figure, set_color_scale, set_title
from gearplay.pictures.words import plain, shown_in, significant

if TYPE_CHECKING:
    import xarray as xr

MOST_PANELS = 8
LEAST = 0.02
"""Share of the deepest wear below which a flank has no panel."""
STAGES = 5
"""Largest number of curves of a panel: colours of the scale that readers with colour blindness can distinguish."""


def wear_drawing(ds: xr.Dataset) -> Any:
    """Return the figure: depth of each flank over height and of each bush over direction, then play over life."""
    panels: list[tuple[str, int]] = []
    if "depth" in ds:
        deepest = ds["depth"].isel(turns=-1).max("height").values
        panels += [
            ("flank", k) for k in range(len(deepest)) if deepest[k] > LEAST * max(np.max(deepest), 1e-12)
        ]
    if "sleeve" in ds.dims:
        panels += [("sleeve", k) for k in range(ds.sizes["sleeve"])]
    panels = panels[:MOST_PANELS]
    rows = -(-(len(panels) + 1) // 2)
    figure, axes = make_figure(rows, 2, 3.4 * rows)
    turns, each = ds["turns"].values, list(axes.flat)
    counted, unit = _counted(turns)
    stages = ds.isel(turns=np.unique(np.linspace(0, len(turns) - 1, STAGES).astype(int)))
    label = f"turns of {ds.attrs['rotor']} [{unit}]"
    colors = set_color_scale(figure, each, list(stages["turns"].values / counted), label)
    for ax, (kind, k) in zip(each, panels, strict=False):
        _depths(ax, stages, k, colors) if kind == "flank" else _bush(ax, stages, k, colors)
    _play(each[len(panels)], ds)
    for ax in each[len(panels) + 1 :]:
        ax.set_visible(False)
    life = f"{turns[-1] / counted:.3g}" + ("" if counted == 1.0 else f" x {unit}")
    set_title(figure, f"{ds.attrs.get('title') or 'Case'}: wear over {life} turns of {ds.attrs['rotor']}")
    return figure


def _counted(turns: Any) -> tuple[float, str]:
    """Return the power of 1000 that scales the axis of turns, and its name."""
    power = 3 * max(int(np.log10(max(float(turns[-1]), 1.0)) // 3), 0)
    return float(10.0**power), "1" if power == 0 else "10" + "".join("⁰¹²³⁴⁵⁶⁷⁸⁹"[int(c)] for c in str(power))


def _depths(ax: Any, ds: xr.Dataset, k: int, colors: list[Any]) -> None:
    depth = ds["depth"].values[:, k]
    unit, factor = shown_in("m", float(depth.max()))
    for step, color in enumerate(colors):
        ax.plot(ds["height"].values, factor * depth[step], color=color, linewidth=1.2)
    ax.set_xlabel("place on the flank, 0 root end, 1 tip [1]", fontsize=SMALL)
    ax.set_ylabel(plain(f"worn off {ds['flank'].values[k]} [{unit}]"), fontsize=SMALL)


def _bush(ax: Any, ds: xr.Dataset, k: int, colors: list[Any]) -> None:
    angle = np.degrees(ds["direction"].values)
    bush, journal = ds["bush_depth"].values[:, k], ds["journal_depth"].values[:, k]
    unit, factor = shown_in("m", float(max(bush.max(), journal.max())))
    for step, color in enumerate(colors):
        ax.plot(angle, factor * bush[step], color=color, linewidth=1.2)
        ax.plot(angle, factor * journal[step], color=color, linewidth=1.0, linestyle="--")
    ax.set_xticks(range(0, 361, 90))
    ax.set_xlabel("direction [deg]", fontsize=SMALL)
    ax.set_ylabel(plain(f"worn off {ds['sleeve'].values[k]}: bush, dashed journal [{unit}]"), fontsize=SMALL)


def _play(ax: Any, ds: xr.Dataset) -> None:
    """Draw the increase of play by wear, of each mesh and sleeve; the initial play is in the legend."""
    kinds = (("backlash", "mesh", "backlash"), ("radial_clearance", "sleeve", "radial clearance"))
    curves = [
        (f"{words} of {name}", ds[variable].values[:, k])
        for variable, dim, words in kinds
        if variable in ds
        for k, name in enumerate(ds[dim].values)
    ]
    unit, factor = shown_in("m", float(max(np.max(np.abs(play - play[0])) for _, play in curves)))
    counted, turns_unit = _counted(ds["turns"].values)
    turns = ds["turns"].values / counted
    for number, (words, play) in enumerate(curves):
        label = plain(f"{words}, at first {significant(1e6 * play[0], 4)} µm")
        color = PALETTE[number % len(PALETTE)]
        ax.plot(turns, factor * (play - play[0]), color=color, marker=".", linewidth=1.2, label=label)
    ax.set_xlabel(plain(f"turns of {ds.attrs['rotor']} [{turns_unit}]"), fontsize=SMALL)
    ax.set_ylabel(f"play added [{unit}]", fontsize=SMALL)
    ax.locator_params(axis="x", nbins=4)
    ax.legend(fontsize=SMALL, frameon=False)
