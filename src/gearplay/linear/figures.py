"""Figures of linear analysis: mode shapes, Campbell diagram, frequency response."""

from __future__ import annotations

import json
import math
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gearplay.model.reading import load_case
from gearplay.pictures.canvas import (
    PALETTE,
    SMALL,
    legend_mark,
    make_figure,
    set_color_scale,
    set_legend,
    set_title,
)
from gearplay.pictures.planes import apart
from gearplay.pictures.style import CLEARANCE, COUPLED, UNCOUPLED
from gearplay.pictures.words import plain, short
from gearplay.results.mechanism import placed
from gearplay.results.titles import words_of

if TYPE_CHECKING:
    import xarray as xr

    from gearplay.model.case import Case

Floats = NDArray[np.float64]
ROTOR = 0.15
"""Radius of a rotor without gears, of the mechanism's size."""
SWING = 0.16
"""Largest displacement of a drawn shape, of the mechanism's size."""
COLUMNS = 4
OUTPUTS = 6
"""Most outputs of a family of responses that are drawn."""
NAMES_APART = 0.035
"""Least distance of names of orders at the right end, of the axis' height."""
CROSSING = "#222222"
KINDS = ("rotational", "translational", "planet", "mixed", "torsional", "lateral", "coupled")


class _Disc(NamedTuple):
    rotor: str
    x: float
    y: float
    radius: float
    ring: bool


def _discs(case: Case) -> tuple[list[_Disc], list[list[float]]]:
    """Return circles for all rotors, and lines between those of one shaft or coupling that lie apart, x, y, x, y [m].

    They are pitch circles of gears, circles of carriers through their pins; no circle lies over another plane.
    """
    mechanism = placed(case)
    own = {gear["rotor"]: gear for gear in mechanism["gears"]}
    arms = {
        each["on"]: math.dist(*((own[each[key]]["x"], own[each[key]]["y"]) for key in ("rotor", "on")))
        for each in mechanism["carried"]
    }
    pitch = {
        gear["name"]: 0.5 * gear["module"] * gear["teeth"] for gear in mechanism["gears"] if gear["module"]
    }
    plain_disc = ROTOR * max([*pitch.values(), *arms.values()], default=1.0)
    drawn = apart(mechanism, gap=SWING, disc=plain_disc)
    discs = [
        _Disc(
            gear["rotor"],
            gear["x"],
            gear["y"],
            pitch.get(gear["name"]) or arms.get(gear["rotor"]) or plain_disc,
            gear["internal"],
        )
        for gear in drawn["gears"]
    ]
    return discs, drawn["axes"]


def shapes_drawing(ds: xr.Dataset, *, most: int = 12) -> Any:
    """Return the figure of the first mode shapes on the mechanism: nominal positions thin, displaced ones in colour.

    A spoke shows how far a rotor turns; scale of each shape its own.
    """
    case = load_case(json.loads(ds.attrs["case"]))
    discs, axes_apart = _discs(case)
    moving = [m for m, f in enumerate(ds["frequency"].values) if f > 0.0][:most] or [0]
    columns = min(COLUMNS, len(moving))
    rows = -(-len(moving) // columns)
    figure, axes = make_figure(rows, columns, 0.9 + 2.4 * rows)
    extent = max(math.hypot(d.x - discs[0].x, d.y - discs[0].y) + d.radius for d in discs)
    places = {str(name): k for k, name in enumerate(ds["coordinate"].values)}
    for ax in axes.flat[len(moving) :]:
        ax.set_visible(False)
    for ax, m in zip(axes.flat, moving, strict=False):
        shape = ds["shape"].values[m]
        moves = {
            d.rotor: [
                shape[places[f"{d.rotor}.{a}"]] if f"{d.rotor}.{a}" in places else 0.0
                for a in ("x", "y", "theta")
            ]
            for d in discs
        }
        largest = max(
            max(float(np.hypot(v[0], v[1])), abs(v[2]) * d.radius) for d in discs for v in [moves[d.rotor]]
        )
        factor = SWING * extent / largest if largest > 0.0 else 0.0
        for x, y, to_x, to_y in axes_apart:
            ax.plot([x, to_x], [y, to_y], color=CLEARANCE, linewidth=0.6, linestyle="-.")
        for d in discs:
            dx, dy, turn = (factor * v for v in moves[d.rotor])
            still = abs(dx) + abs(dy) + abs(turn) * d.radius < 0.01 * SWING * extent
            _circle(ax, d.x, d.y, d.radius, 0.0, CLEARANCE, 0.6)
            if not still:
                _circle(ax, d.x + dx, d.y + dy, d.radius, turn, UNCOUPLED if d.ring else COUPLED, 1.3)
        ax.set_aspect("equal")
        ax.set_axis_off()
        text = f"{ds['frequency'].values[m]:.5g} Hz\n{ds['kind'].values[m]}"
        ax.set_title(plain(text), fontsize=SMALL)
    handles = {
        "nominal place": legend_mark(CLEARANCE, line="-"),
        "mode shape, gears and shafts": legend_mark(COUPLED, line="-"),
    }
    if any(d.ring for d in discs):
        handles["mode shape, rings"] = legend_mark(UNCOUPLED, line="-")
    set_legend(figure, handles)
    set_title(figure, f"{words_of(ds, 'Modes')}: shapes of the first {len(moving)} modes")
    return figure


def _circle(ax: Any, x: float, y: float, radius: float, turn: float, color: str, width: float) -> None:
    angle = np.linspace(0.0, 2.0 * np.pi, 181)
    ax.plot(x + radius * np.cos(angle), y + radius * np.sin(angle), color=color, linewidth=width)
    ax.plot([x, x + radius * np.cos(turn)], [y, y + radius * np.sin(turn)], color=color, linewidth=width)


def campbell_drawing(ds: xr.Dataset) -> Any:
    """Return the figure of a Campbell diagram: modes over speed, orders as rays, crossings marked."""
    figure, axes = make_figure(1, 1, 5.0)
    ax = axes[0, 0]
    rpm = 30.0 / np.pi * ds["speed"].values
    frequency = ds["frequency"].values
    moving = [m for m in range(frequency.shape[1]) if frequency[:, m].max() > 0.0]
    present = {str(ds["kind"].values[m]) for m in moving}
    colors = {kind: color for kind, color in zip(KINDS, PALETTE, strict=False) if kind in present}
    for m in moving:
        ax.plot(rpm, frequency[:, m], color=colors[str(ds["kind"].values[m])], linewidth=1.4)
    top = 1.1 * float(frequency.max(initial=1.0))
    _draw_orders(ax, ds, rpm, top)
    ax.plot(
        30.0 / np.pi * ds["crossing_speed"].values, ds["crossing_frequency"].values, "o",
        markersize=4, markerfacecolor="white", color=CROSSING, linestyle="none",
    )  # fmt: skip
    ax.set_ylim(0.0, top)
    ax.set_xlim(rpm[0], rpm[-1])
    ax.set_xlabel(plain(f"speed of {ds.attrs['lead']} [rpm]"), fontsize=SMALL)
    ax.set_ylabel("frequency [Hz]", fontsize=SMALL)
    handles = {f"{kind} modes": legend_mark(color, line="-") for kind, color in colors.items()}
    handles |= {
        "orders of excitation": legend_mark(CLEARANCE, line="--"),
        "crossings": legend_mark(CROSSING, marker="o", hollow=True),
    }
    set_legend(figure, handles)
    seen = ", seen from the turning carrier" if int(ds.attrs["turning"]) else ""
    set_title(figure, f"{words_of(ds, 'Campbell diagram')}: natural frequencies over speed{seen}")
    return figure


def _draw_orders(ax: Any, ds: xr.Dataset, rpm: Floats, top: float) -> None:
    """Draw orders of excitation as rays, with their names to the right of their ends, one above the other, or at the top."""
    free = 0.0
    words = {"fontsize": SMALL - 1, "color": "#555a66", "annotation_clip": False}
    for k in np.argsort(ds["order_frequency"].values[-1], kind="stable"):
        line = ds["order_frequency"].values[:, k]
        ax.plot(rpm, line, color=CLEARANCE, linewidth=0.8, linestyle="--")
        inside = np.flatnonzero(line <= top)
        if not inside.size:
            continue
        name, at = plain(short(str(ds["order"].values[k]), 28)), inside[-1]
        if at < len(rpm) - 1:
            ax.annotate(name, (rpm[at], line[at]), ha="right", va="bottom", **words)
            continue
        free = max(float(line[at]), free)
        beside = ax.get_yaxis_transform()  # a share of the width, a frequency
        ax.plot(
            [1.0, 1.035], [line[at], free], transform=beside, color=CLEARANCE, linewidth=0.5, clip_on=False
        )
        ax.annotate(name, (1.04, free), xycoords=beside, ha="left", va="center", **words)
        free += NAMES_APART * top


def family_drawing(ds: xr.Dataset) -> Any:
    """Return the figure of frequency responses over a parameter: amplitudes of each output on decades, coloured by its value."""
    amplitude = ds["amplitude"]
    parameter, frequency = ds[amplitude.dims[0]], ds["frequency"].values
    values, count = parameter.values, min(ds.sizes["at"], OUTPUTS)
    figure, axes = make_figure(count, 1, 2.0 + 2.2 * count)
    units = str(parameter.attrs["units"])
    label = str(parameter.attrs["long_name"]) + (f" [{units}]" if units not in ("", "1") else "")
    colors = set_color_scale(figure, axes[:, 0].tolist(), values.tolist(), label)
    unit = amplitude.attrs["units"].removeprefix("1/")
    for k, ax in enumerate(axes[:, 0]):
        for row, color in zip(amplitude.values[:, k], colors, strict=True):
            ax.semilogy(frequency, row, color=color, linewidth=1.0)
        name, own = str(ds["at"].values[k]), str(ds["unit"].values[k])
        ax.set_ylabel(plain(f"{short(name)} [{own} per {unit.strip('()')}]"), fontsize=SMALL)
        ax.set_xlim(frequency[0], frequency[-1] if frequency[-1] > frequency[0] else frequency[0] + 1.0)
    axes[-1, 0].set_xlabel("frequency [Hz]", fontsize=SMALL)
    set_title(figure, f"{words_of(ds, 'Response')}: response to {ds.attrs['force']}")
    return figure


def response_drawing(ds: xr.Dataset) -> Any:
    """Return the figure of a frequency response: amplitudes on decades, phases below."""
    figure, axes = make_figure(2, 1, 6.0)
    frequency, force = ds["frequency"].values, ds.attrs["force"]
    unit = ds["amplitude"].attrs["units"].removeprefix("1/")
    own = [str(each) for each in ds["unit"].values]
    handles = {}
    for k, name in enumerate(ds["at"].values):
        color = PALETTE[k % len(PALETTE)]
        axes[0, 0].semilogy(frequency, ds["amplitude"].values[k], color=color, linewidth=1.2)
        axes[1, 0].plot(frequency, np.degrees(ds["phase"].values[k]), color=color, linewidth=1.2)
        handles[f"{name} [{own[k]}/{unit}]"] = legend_mark(color, line="-")
    for natural in np.atleast_1d(ds.attrs["natural_frequencies"]):
        if frequency[0] <= natural <= frequency[-1]:
            for ax in axes[:, 0]:
                ax.axvline(natural, color=CLEARANCE, linewidth=0.6, linestyle=":")
    handles["natural frequencies"] = legend_mark(CLEARANCE, line=":")
    axes[0, 0].set_ylabel(
        plain(f"amplitude [{' or '.join(sorted(set(own)))} per {unit.strip('()')}]"), fontsize=SMALL
    )
    axes[1, 0].set_ylabel("phase [deg]", fontsize=SMALL)
    axes[1, 0].set_yticks(range(-180, 181, 90))
    axes[1, 0].set_xlabel("frequency [Hz]", fontsize=SMALL)
    for ax in axes[:, 0]:
        ax.set_xlim(frequency[0], frequency[-1] if frequency[-1] > frequency[0] else frequency[0] + 1.0)
    set_legend(figure, handles)
    set_title(figure, f"{words_of(ds, 'Response')}: response to {force}")
    return figure
