"""Figure of wear over life."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from gearplay.pictures.canvas import PALETTE, SMALL, make_figure, set_color_scale, set_title
from gearplay.pictures.words import plain

if TYPE_CHECKING:
    import xarray as xr

MOST_PANELS = 8
LEAST = 0.02
"""Share of the deepest wear below which a flank has no panel."""
STAGES = 5
"""Most curves of a panel: so many colours of the scale can be told apart by all eyes."""


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
    turns = ds["turns"].values
    each = list(axes.flat)
    stages = ds.isel(turns=np.unique(np.linspace(0, len(turns) - 1, STAGES).astype(int)))
    label = f"turns of {ds.attrs['rotor']} [{_unit(ds)}]"
    colors = set_color_scale(figure, each, list(stages["turns"].values / _counted(turns)), label)
    for ax, (kind, k) in zip(each, panels, strict=False):
        _depths(ax, stages, k, colors) if kind == "flank" else _bush(ax, stages, k, colors)
    _play(each[len(panels)], ds)
    for ax in each[len(panels) + 1 :]:
        ax.set_visible(False)
    set_title(
        figure, f"{ds.attrs.get('title') or 'Case'}: wear over {turns[-1]:.3g} turns of {ds.attrs['rotor']}"
    )
    return figure


def _counted(turns: Any) -> float:
    """Return the power of a thousand in which turns are counted in the figure."""
    return float(10.0 ** (3 * max(int(np.log10(max(float(turns[-1]), 1.0)) // 3), 0)))


def _unit(ds: xr.Dataset) -> str:
    counted = _counted(ds["turns"].values)
    return "1" if counted == 1.0 else f"{counted:.0e}".replace("e+0", "e")


def _depths(ax: Any, ds: xr.Dataset, k: int, colors: list[Any]) -> None:
    for step, color in enumerate(colors):
        ax.plot(ds["height"].values, 1e6 * ds["depth"].values[step, k], color=color, linewidth=1.2)
    ax.set_xlabel("place on the flank, 0 root end, 1 tip [1]", fontsize=SMALL)
    ax.set_ylabel(plain(f"worn off {ds['flank'].values[k]} [µm]"), fontsize=SMALL)


def _bush(ax: Any, ds: xr.Dataset, k: int, colors: list[Any]) -> None:
    angle = np.degrees(ds["direction"].values)
    for step, color in enumerate(colors):
        ax.plot(angle, 1e6 * ds["bush_depth"].values[step, k], color=color, linewidth=1.2)
        ax.plot(angle, 1e6 * ds["journal_depth"].values[step, k], color=color, linewidth=1.0, linestyle="--")
    ax.set_xticks(range(0, 361, 90))
    ax.set_xlabel("direction [deg]", fontsize=SMALL)
    ax.set_ylabel(plain(f"worn off {ds['sleeve'].values[k]}: bush, dashed journal [µm]"), fontsize=SMALL)


def _play(ax: Any, ds: xr.Dataset) -> None:
    turns, number = ds["turns"].values / _counted(ds["turns"].values), 0
    for variable, dim, words in (
        ("backlash", "mesh", "backlash"),
        ("radial_clearance", "sleeve", "radial clearance"),
    ):
        if variable not in ds:
            continue
        for k, name in enumerate(ds[dim].values):
            color = PALETTE[number % len(PALETTE)]
            label = plain(f"{words}, {name}")
            ax.plot(
                turns, 1e6 * ds[variable].values[:, k], color=color, marker=".", linewidth=1.2, label=label
            )
            number += 1
    ax.set_xlabel(plain(f"turns of {ds.attrs['rotor']} [{_unit(ds)}]"), fontsize=SMALL)
    ax.set_ylabel("play [µm]", fontsize=SMALL)
    ax.locator_params(axis="x", nbins=4)
    ax.legend(fontsize=SMALL, frameon=False)
