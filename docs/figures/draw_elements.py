"""Draw docs/figures/elements.svg: every element of a mechanism beside gears and sleeves, with its signs."""

import math
from pathlib import Path

import matplotlib as mpl
import numpy as np
from draw_conventions import INK, LINE, PINION, RING, SOFT, arrow, circle, turn
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure


def spring(ax, start, end, color=INK, coils=5, width=0.18):
    """Draw a spring between two points."""
    (x0, y0), (x1, y1) = start, end
    length = math.hypot(x1 - x0, y1 - y0)
    u = ((x1 - x0) / length, (y1 - y0) / length)
    along = np.concatenate([[0.0, 0.15], np.linspace(0.2, 0.8, 2 * coils), [0.85, 1.0]]) * length
    across = np.concatenate([[0.0, 0.0], width * (-1.0) ** np.arange(2 * coils), [0.0, 0.0]])
    ax.plot(x0 + u[0] * along - u[1] * across, y0 + u[1] * along + u[0] * across, color=color, linewidth=1.2)


def ground(ax, x, y, *, upright):
    """Draw a piece of ground."""
    if upright:
        ax.plot([x, x], [y - 0.5, y + 0.5], color=INK, linewidth=2.0)
    else:
        ax.plot([x - 0.5, x + 0.5], [y, y], color=INK, linewidth=2.0)


def shaft(ax):
    """Draw several gears on one rotor, seen from the side."""
    ax.add_patch(_box(-2.0, -0.15, 4.0, 0.3, SOFT))
    ax.add_patch(_box(-1.2, -1.6, 0.5, 3.2, RING))
    ax.add_patch(_box(0.8, -0.9, 0.5, 1.8, PINION))
    ax.text(-0.95, 1.85, "layshaft.wheel", ha="center", fontsize=9, color=RING)
    ax.text(1.05, 1.2, "layshaft.pinion", ha="center", fontsize=9, color=PINION)
    ax.text(0.0, -2.2, "one rotor: one x, y, theta", ha="center", fontsize=9, color=INK)


def coupling(ax):
    """Draw a coupling between two rotors on one axis, from the side."""
    for x, color, name in ((-1.6, RING, "1"), (1.1, PINION, "2")):
        ax.add_patch(_box(x, -1.0, 0.5, 2.0, color))
        ax.text(x + 0.25, 1.25, name, ha="center", fontsize=10, color=color)
    spring(ax, (-1.1, 0.35), (1.1, 0.35))
    ax.plot([-1.1, -0.35, -0.35], [-0.4, -0.4, -0.1], color=LINE, linewidth=1.6)
    ax.plot([1.1, 0.1, 0.1], [-0.4, -0.4, -0.1], color=LINE, linewidth=1.6)
    ax.text(-0.1, -0.75, "play", ha="center", fontsize=9, color=LINE)
    ax.text(0.0, -1.6, "phi = theta$_1$ - ratio theta$_2$", ha="center", fontsize=9, color=INK)
    ax.text(0.0, -2.2, "torque -T on 1, + ratio T on 2", ha="center", fontsize=9, color=INK)


def support(ax):
    """Draw a support: springs along two axes and against rotation, from the end."""
    circle(ax, (0.0, 0.0), 0.7, PINION)
    spring(ax, (-2.1, 0.0), (-0.7, 0.0))
    spring(ax, (0.0, -2.1), (0.0, -0.7))
    ground(ax, -2.1, 0.0, upright=True)
    ground(ax, 0.0, -2.1, upright=False)
    turn(ax, (0.0, 0.0), 1.1, 20.0, 110.0, LINE, "theta", (-0.75, 0.1))
    ax.text(-1.4, 0.45, "$k_x, c_x$", ha="center", fontsize=9, color=INK)
    ax.text(0.75, -1.5, "$k_y, c_y$", ha="center", fontsize=9, color=INK)
    ax.text(0.0, 1.85, "torque $-k$ theta $-c$ omega", ha="center", fontsize=9, color=INK)


def unbalance(ax):
    """Draw an unbalance: the centre of mass beside the axis, from the end."""
    circle(ax, (0.0, 0.0), 1.6, RING)
    ax.plot(0.0, 0.0, "+", color=INK, markersize=9)
    mass = (0.9 * math.cos(0.6), 0.9 * math.sin(0.6))
    ax.plot([0.0, mass[0]], [0.0, mass[1]], color=LINE, linewidth=1.6)
    ax.plot(*mass, "o", color=LINE, markersize=7)
    turn(ax, (0.0, 0.0), 1.2, 0.0, 33.0, INK, "", (0.0, 0.0))
    ax.text(1.9, 0.3, "theta + phase", ha="center", fontsize=9, color=INK)
    ax.text(-0.35, -0.35, "axis x, y", ha="center", fontsize=9, color=INK)
    ax.text(0.0, -2.2, "amount = mass x eccentricity", ha="center", fontsize=9, color=INK)


def base(ax):
    """Draw a housing that moves."""
    ax.add_patch(_box(-1.7, -1.4, 3.4, 2.6, "#e4e8ee"))
    circle(ax, (0.2, -0.1), 0.6, PINION)
    arrow(ax, (-2.2, -1.8), (-0.9, -1.05), LINE, "a", (0.25, 0.15))
    arrow(ax, (0.2, -0.1), (-0.9, -0.75), INK, "-m a", (-0.35, 0.3))
    ax.plot([-2.2, -0.6], [-1.8, -1.8], "--", color=SOFT, linewidth=1.0)
    turn(ax, (-2.2, -1.8), 1.1, 0.0, 28.0, RING, "", (0.0, 0.0))
    ax.text(0.25, -1.85, "direction", ha="center", fontsize=9, color=RING)
    ax.text(0.0, 1.5, "x, y, ax, ay relative to the housing", ha="center", fontsize=9, color=INK)


def friction(ax):
    """Draw friction of the teeth along the line of action."""
    ax.plot([-2.0, 2.0], [-1.0, 1.0], "--", color=SOFT, linewidth=1.2)
    ax.plot(0.0, 0.0, "o", color=INK, markersize=5)
    ax.text(0.1, -0.55, "pitch point", fontsize=9, color=INK)
    ax.plot(1.2, 0.6, "o", color=LINE, markersize=6)
    arrow(ax, (1.2, 0.6), (2.1, 1.05), PINION, "F", (0.2, 0.15))
    arrow(ax, (1.2, 0.6), (0.85, 1.3), LINE, "mu F S", (-0.1, 0.3))
    ax.text(0.75, 0.05, "x", fontsize=10, color=LINE)
    ax.text(0.0, -1.6, "S: sign of the sliding, changes at x = 0", ha="center", fontsize=9, color=INK)
    ax.text(0.0, -2.2, "x grows with psi + friction_phase", ha="center", fontsize=9, color=INK)


def _box(x, y, width, height, color):
    from matplotlib.patches import Rectangle

    return Rectangle((x, y), width, height, facecolor=color, edgecolor=INK, linewidth=1.0)


PANELS = {
    "several gears on a rotor": shaft,
    "coupling": coupling,
    "support": support,
    "unbalance": unbalance,
    "base": base,
    "friction of the teeth": friction,
}


def main() -> None:
    """Write the figure beside this file."""
    mpl.rcParams["svg.hashsalt"] = "gearplay"
    figure = Figure(figsize=(10.5, 7.0))
    FigureCanvasSVG(figure)
    for ax, (title, draw) in zip(figure.subplots(2, 3).ravel(), PANELS.items(), strict=True):
        draw(ax)
        ax.set_title(title, fontsize=11, color=INK)
        ax.set_xlim(-2.9, 2.9)
        ax.set_ylim(-2.6, 2.3)
        ax.set_aspect("equal")
        ax.axis("off")
    figure.tight_layout()
    figure.savefig(Path(__file__).with_name("elements.svg"), metadata={"Date": None})


if __name__ == "__main__":
    main()
