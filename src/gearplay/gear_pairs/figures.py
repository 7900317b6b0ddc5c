"""Figure of a gear pair: teeth in mesh, stiffness, load sharing, contact ratio over the centres."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from gearplay.pictures.canvas import PALETTE, SMALL, make_figure, set_title
from gearplay.pictures.style import CLEARANCE

if TYPE_CHECKING:
    from gearplay.gear_pairs.teeth import Teeth

DRIVER, DRIVEN, CONTACT = PALETTE[0], PALETTE[1], PALETTE[2]
"""Colours of the first and the second gear and of the path of contact."""


def teeth_drawing(found: Teeth) -> Any:
    """Return the figure of a gear pair."""
    figure, axes = make_figure(2, 2, 7.6)
    ds = found.ds
    _outlines(axes[0, 0], found)
    _stiffness(axes[0, 1], found)
    _sharing(axes[1, 0], found)
    _distances(axes[1, 1], found)
    set_title(figure, f"{ds.attrs.get('title') or 'Teeth'}: {ds.attrs['mesh']}")
    return figure


def _outlines(ax: Any, found: Teeth) -> None:
    ds, values = found.ds, found.values
    names = [str(name) for name in ds["gear"].values]
    for name, color, label in (("first", DRIVER, names[0]), ("second", DRIVEN, names[1])):
        x, y = 1e3 * ds[f"outline_{name}"].values.T
        ax.plot(x, y, color=color, linewidth=1.2, label=label)
    radius = 0.5e3 * next(iter(found.gears.values()))["base_diameter"]
    angle = values["working_pressure_angle"]
    foot = radius * np.array([np.cos(angle), np.sin(angle)])
    way = np.array([np.sin(angle), -np.cos(angle)])
    ends = [foot + 1e3 * values[name] * way for name in ("path_start", "path_end")]
    ax.plot(*np.transpose([foot, ends[0]]), color=CLEARANCE, linewidth=0.8, linestyle="--")
    ax.plot(*np.transpose(ends), color=CONTACT, linewidth=2.0, label="path of contact")
    pitch = foot + 1e3 * values["pitch_point"] * way
    ax.plot(*pitch, "o", color=CONTACT, markersize=4)
    half = 1e3 * max(1.3 * (values["path_end"] - values["path_start"]), 4.0 * values["module"])
    ax.set_xlim(pitch[0] - half, pitch[0] + half)
    ax.set_ylim(pitch[1] - half, pitch[1] + half)
    ax.set_aspect("equal")
    ax.set_xlabel("x [mm]", fontsize=SMALL)
    ax.set_ylabel("y [mm]", fontsize=SMALL)
    ax.legend(fontsize=SMALL, framealpha=0.9, loc="upper right")


def _stiffness(ax: Any, found: Teeth) -> None:
    ds = found.ds
    phase = ds["phase"].values
    ax.plot(phase, 1e-6 * ds["mesh_stiffness"].values, color=PALETTE[0], linewidth=1.4, label="mesh")
    ax.axhline(
        1e-6 * found.values["mean_stiffness"], color=CLEARANCE, linewidth=0.9, linestyle="--", label="mean"
    )
    if "pair_stiffness" in ds:
        for k, pair in enumerate(ds["pair"].values):
            curve = 1e-6 * ds["pair_stiffness"].values[:, k]
            if np.any(curve > 0.0):
                shown = np.where(curve > 0.0, curve, np.nan)
                ax.plot(
                    phase, shown, color=PALETTE[(k + 1) % len(PALETTE)], linewidth=1.0, label=f"pair {pair}"
                )
    ax.set_ylim(0.0, None)
    ax.set_xlabel("phase [base pitches], 0 at the pitch point", fontsize=SMALL)
    ax.set_ylabel("stiffness [N/µm]", fontsize=SMALL)
    ax.legend(fontsize=SMALL, frameon=False)


def _sharing(ax: Any, found: Teeth) -> None:
    ds = found.ds
    if "load_sharing_ratio" in ds:
        for k, pair in enumerate(ds["pair"].values):
            share = ds["load_sharing_ratio"].values[:, k]
            if np.any(share > 0.0):
                ax.plot(
                    ds["phase"].values,
                    share,
                    color=PALETTE[(k + 1) % len(PALETTE)],
                    linewidth=1.2,
                    label=f"pair {pair}",
                )
        ax.set_ylim(0.0, 1.05)
        ax.set_xlabel("phase [base pitches], 0 at the pitch point", fontsize=SMALL)
        ax.set_ylabel("share in the force at rest [1]", fontsize=SMALL)
        ax.legend(fontsize=SMALL, frameon=False)
        return
    ax.plot(1e3 * ds["place"].values, ds["sliding_speed"].values * 1e3, color=PALETTE[0], linewidth=1.4)
    for name in ("path_start", "pitch_point", "path_end"):
        ax.axvline(1e3 * found.values[name], color=CLEARANCE, linewidth=0.9, linestyle="--")
    ax.set_xlabel("place on the path of contact [mm]", fontsize=SMALL)
    ax.set_ylabel("sliding speed [mm/s per rad/s]", fontsize=SMALL)


def _distances(ax: Any, found: Teeth) -> None:
    ds, values = found.ds, found.values
    off = 1e6 * (ds["center_distance"].values - values["center_distance"])
    ax.plot(off, ds["contact_ratio"].values, color=PALETTE[0], linewidth=1.4)
    ax.plot(0.0, values["contact_ratio"], "o", color=PALETTE[0], markersize=5)
    circle = ds["contact_ratio_on_circle"].values
    if np.ptp(circle) > 0.0:
        ax.axhspan(circle.min(), circle.max(), color=CLEARANCE, alpha=0.15)
    ax.set_xlabel("centre distance [µm from the nominal centres]", fontsize=SMALL)
    ax.set_ylabel("contact ratio [1]", fontsize=SMALL)
    other = ax.twinx()
    other.tick_params(labelsize=SMALL)
    other.plot(off, 1e6 * ds["backlash"].values, color=PALETTE[1], linewidth=1.2, linestyle="--")
    other.set_ylabel("normal backlash [µm], dashed", fontsize=SMALL)
