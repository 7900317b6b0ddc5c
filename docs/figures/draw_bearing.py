"""Draw docs/figures/bearing.svg: the loaded balls of a bearing, and its displacement as balls pass the load."""

import math
from pathlib import Path

import numpy as np
from draw_conventions import INK, LINE, PINION, RING, SOFT, arrow, circle, save
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure

from gearplay.linear.balance import balance

OUT = Path(__file__).with_name("bearing.svg")
COUNT, STIFFNESS, LOAD = 8, 1.334e10, 100.0
UNIT = 1e-6


def depths(at, play, cage):
    """Return directions [element, 2] and depths [m] of the elements at a displacement ``at`` [m]."""
    angles = cage - 0.5 * math.pi + 2.0 * math.pi * np.arange(COUNT) / COUNT
    ways = np.column_stack([np.cos(angles), np.sin(angles)])
    return ways, np.maximum(ways @ at - play, 0.0)


def rest(play, cage):
    """Return the displacement [m] under the load along -y."""
    now = np.zeros(2)

    def force(z):
        now[:] = UNIT * z
        ways, depth = depths(now, play, cage)
        return UNIT * (-(STIFFNESS * depth**1.5) @ ways - [0.0, LOAD])

    def stiffness():
        ways, depth = depths(now, play, cage)
        return UNIT**2 * (ways.T * (1.5 * STIFFNESS * np.sqrt(depth))) @ ways

    return UNIT * balance(force, stiffness, np.array([0.0, -play / UNIT - 3.0]), UNIT * LOAD).at


def section(ax):
    """Draw rings, balls and the loads of the balls."""
    play, cage = 5e-6, 0.2
    at = rest(play, cage)
    ways, depth = depths(at, play, cage)
    circle(ax, (0.0, 0.0), 1.3, RING, width=2.2)
    shift = 0.1 * at / np.hypot(*at)
    circle(ax, tuple(shift), 0.7, PINION, width=1.8)
    load = STIFFNESS * depth**1.5
    for way, each in zip(ways, load, strict=True):
        circle(ax, tuple(1.0 * way + 0.5 * shift), 0.24, INK if each > 0.0 else SOFT, width=1.2)
        if each > 0.0:
            start = 0.66 - 0.45 * each / load.max()
            arrow(ax, tuple(0.66 * way), tuple(start * way), LINE)
            ax.text(*(1.5 * way), f"{each:.0f} N", color=LINE, fontsize=10, ha="center", va="center")
    arrow(ax, (0.0, 0.55), (0.0, 0.15), INK, "100 N", (0.26, 0.1))
    ax.text(
        0.0,
        -1.62,
        "outer ring, shaft with the inner ring, balls on the cage",
        fontsize=9,
        color=INK,
        ha="center",
    )
    ax.set_xlim(-1.75, 1.75)
    ax.set_ylim(-2.1, 1.45)
    ax.set_aspect("equal")
    ax.axis("off")


def compliance(ax):
    """Draw the displacement over one pitch of the balls."""
    angles = np.linspace(0.0, 2.0 * math.pi / COUNT, 121)
    for play, style in ((0.0, "-"), (5e-6, "--"), (10e-6, ":")):
        down = np.array([-1e6 * rest(play, angle)[1] for angle in angles])
        swing = f"clearance {2e6 * play:g} um: {np.ptp(down):.3g} um"
        ax.plot(np.degrees(angles), down - down.mean(), style, color=PINION, label=swing)
    ax.set_xlabel("angle of the cage [deg]")
    ax.set_ylabel("displacement less its mean [um]")
    ax.legend(frameon=False, fontsize=9)
    ax.spines[["top", "right"]].set_visible(False)


def main():
    """Draw both panels."""
    figure = Figure(figsize=(9.6, 4.2), layout="constrained")
    FigureCanvasSVG(figure)
    axes = figure.subplots(1, 2)
    section(axes[0])
    compliance(axes[1])
    save(figure, OUT)


if __name__ == "__main__":
    main()
