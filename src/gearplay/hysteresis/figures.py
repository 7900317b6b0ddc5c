"""Figure of lost motion: the hysteresis curve, the parts of the clearances, the numbers over turn, members, temperatures."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from gearplay.hysteresis.cycle import ARCMIN, SMALL, drawn_branch
from gearplay.pictures.canvas import SMALL as FONT
from gearplay.pictures.canvas import legend_mark, make_figure, set_legend, set_title
from gearplay.pictures.style import CLEARANCE, COUPLED, TEST, UNCOUPLED
from gearplay.pictures.words import plain, short

if TYPE_CHECKING:
    import xarray as xr

MOST_BARS = 12
"""Most clearances that are drawn, the largest."""
MOST_SAMPLES = 4000
"""Most measured samples that are drawn."""
PANELS = (
    ("position", "angle of the output [deg]", 180.0 / np.pi, 0.0),
    ("temperature", "temperature [°C]", 1.0, -273.15),
)


def lost_motion_drawing(ds: xr.Dataset) -> Any:
    """Return the figure of a result's dataset."""
    over = [name for name in ("position", "member", "temperature") if name in ds.dims]
    has_parts = "clearance" in ds.dims
    columns = max(1 + has_parts, len(over))
    rows = 1 + bool(over)
    figure, axes = make_figure(rows, columns, 3.6 * rows)
    _curve(axes[0, 0], ds)
    if has_parts:
        _parts(axes[0, 1], ds)
    for k, name in enumerate(over):
        (_members if name == "member" else _over)(axes[1, k], ds, name)
    used = [1 + has_parts, len(over)]
    for row in range(rows):
        for ax in axes[row, used[row] :]:
            ax.set_visible(False)
    marks = {
        "torque falls": legend_mark(COUPLED, line="-"),
        "torque rises": legend_mark(UNCOUPLED, line="-"),
        "lost motion, between the middles of both": legend_mark(TEST, marker="o", line="--"),
    }
    if "measured_torque" in ds:
        marks["measured"] = legend_mark(CLEARANCE, marker=".")
    set_legend(figure, marks)
    lost, play = float(ds["lost_motion_arcmin"]), float(ds["backlash_arcmin"])
    where = f" at {ds.attrs['at']}" if ds.attrs.get("at") else ""
    title = ds.attrs.get("title") or "Train"
    set_title(figure, f"{title}: {lost:.4g} arcmin of lost motion{where}, {play:.4g} arcmin of backlash")
    return figure


def _curve(ax: Any, ds: xr.Dataset) -> None:
    torque, angle = ds["torque"].values, ARCMIN * ds["angle"].values
    if "measured_torque" in ds:
        step = max(1, ds.sizes["sample"] // MOST_SAMPLES)
        ax.plot(
            ds["measured_torque"].values[::step], ARCMIN * ds["measured_angle"].values[::step], ".", color=CLEARANCE,
            markersize=2,
        )  # fmt: skip
    for name, color, width in (("loading", UNCOUPLED, 2.6), ("unloading", COUPLED, 1.3)):
        ax.plot(*drawn_branch(ds, name), color=color, linewidth=width)
    small = SMALL * float(ds.attrs["rated_torque"])
    centre = 0.5 * (angle[0] + angle[1])
    ends = [float(np.interp(sign * small, torque, centre)) for sign in (-1.0, 1.0)]
    ax.plot([-small, small], ends, "o--", color=TEST, markersize=3.5, linewidth=0.8)
    for end in ds["stage_end"].values[:-1]:
        ax.axvline(end, color=CLEARANCE, linewidth=0.6, linestyle=":")
    ax.set_xlabel("torque on the output [N m]", fontsize=FONT)
    ax.set_ylabel("rotation [arcmin]", fontsize=FONT)


def _parts(ax: Any, ds: xr.Dataset) -> None:
    parts = ARCMIN * ds["lost_motion_part"].values
    order = np.argsort(-parts)[:MOST_BARS][::-1]
    names = [plain(short(str(ds["clearance"].values[k]))) for k in order]
    ax.barh(range(len(order)), parts[order], color=COUPLED, height=0.6)
    ax.set_yticks(range(len(order)), names, fontsize=FONT)
    few = f", {MOST_BARS} largest of {parts.size}" if parts.size > MOST_BARS else ""
    ax.set_xlabel(f"lost motion less without it [arcmin]{few}", fontsize=FONT)


def _over(ax: Any, ds: xr.Dataset, name: str) -> None:
    label, factor, shift = next(each[1:] for each in PANELS if each[0] == name)
    x, highest = factor * ds[name].values + shift, 0.0
    for field, color in (("lost_motion", TEST), ("backlash", COUPLED)):
        y = ds[f"{field}_arcmin_by_{name}"].values
        highest = max(highest, float(y.max()))
        ax.plot(x, y, "o-", color=color, markersize=3, linewidth=1.0, label=field.replace("_", " "))
    ax.set_ylim(0.0, 1.15 * highest or 1.0)
    ax.set_xlabel(label, fontsize=FONT)
    ax.set_ylabel("at the output [arcmin]", fontsize=FONT)
    ax.legend(fontsize=FONT, frameon=False)


def _members(ax: Any, ds: xr.Dataset, name: str) -> None:
    values = ds[f"lost_motion_arcmin_by_{name}"].values
    ax.hist(values, bins=max(4, min(30, int(np.sqrt(values.size)))), color=COUPLED)
    ax.axvline(float(ds["lost_motion_arcmin"]), color=TEST, linewidth=1.0, linestyle="--", label="nominal")
    ax.set_xlabel("lost motion of drawn members [arcmin]", fontsize=FONT)
    ax.set_ylabel("members", fontsize=FONT)
    ax.legend(fontsize=FONT, frameon=False)


def reduction_drawing(ds: xr.Dataset) -> Any:
    """Return the figure of a reduced joint: torque over rotation, and the half widths of drawn members."""
    scattered = "member" in ds.dims
    figure, axes = make_figure(1, 2 if scattered else 1, 3.4)
    rated = float(ds.attrs["rated_torque"])
    half, stiffness = float(ds["half_width"]), float(ds["stiffness"])
    torque = np.array([-rated, 0.0, 0.0, rated])
    angle = ARCMIN * np.array([-half - rated / stiffness, -half, half, half + rated / stiffness])
    axes[0, 0].plot(angle, torque, color=COUPLED, linewidth=1.4)
    axes[0, 0].set_xlabel("rotation of the joint [arcmin]", fontsize=FONT)
    axes[0, 0].set_ylabel("torque [N m]", fontsize=FONT)
    if scattered:
        values = ARCMIN * ds["half_width_by_member"].values
        axes[0, 1].hist(values, bins=max(4, min(30, int(np.sqrt(values.size)))), color=UNCOUPLED)
        axes[0, 1].axvline(ARCMIN * half, color=COUPLED, linewidth=1.4)
        axes[0, 1].set_xlabel("half width of drawn members [arcmin]", fontsize=FONT)
        axes[0, 1].set_ylabel("members", fontsize=FONT)
    marks = {"nominal": legend_mark(COUPLED, line="-")}
    if scattered:
        marks["drawn members"] = legend_mark(UNCOUPLED, marker="s")
    set_legend(figure, marks)
    set_title(figure, f"{ds.attrs.get('title') or 'Train'}: one joint at {ds.attrs['at']}")
    return figure


def describing_drawing(ds: xr.Dataset) -> Any:
    """Return the figure of a describing function: stiffness over amplitude, and growth rate with the predicted limit cycles."""
    has_loop = "growth_rate" in ds
    figure, axes = make_figure(1, 2 if has_loop else 1, 3.4)
    amplitude = ARCMIN * ds["amplitude"].values
    axes[0, 0].plot(amplitude, ds["stiffness"].values, color=COUPLED, linewidth=1.4)
    marks = {"stiffness, real part": legend_mark(COUPLED, line="-")}
    if float(ds["loss"].max()) > 0.0:
        axes[0, 0].plot(amplitude, ds["loss"].values, color=UNCOUPLED, linewidth=1.2)
        marks["loss, imaginary part"] = legend_mark(UNCOUPLED, line="-")
    axes[0, 0].set_xlabel("amplitude of the twist [arcmin]", fontsize=FONT)
    axes[0, 0].set_ylabel("first harmonic [N m/rad]", fontsize=FONT)
    if has_loop:
        ax = axes[0, 1]
        ax.plot(amplitude, ds["growth_rate"].values, color=COUPLED, linewidth=1.4)
        ax.axhline(0.0, color=CLEARANCE, linewidth=0.6)
        for twist, stable in zip(ds["cycle_twist"].values, ds["cycle_stable"].values, strict=True):
            ax.plot(
                ARCMIN * twist, 0.0, "o", color=TEST, markersize=5, markerfacecolor=TEST if stable else "none"
            )
        marks["predicted limit cycle, filled: stable"] = legend_mark(TEST, marker="o")
        ax.set_xlabel("amplitude of the twist [arcmin]", fontsize=FONT)
        ax.set_ylabel("growth rate of the loop [1/s]", fontsize=FONT)
    set_legend(figure, marks)
    set_title(figure, f"{ds.attrs.get('title') or 'Train'}: describing function at {ds.attrs['at']}")
    return figure
