"""Draw docs/figures/clearances.svg: what the clearance of a sleeve, the backlash of a mesh and a runout measure."""

import math
from pathlib import Path

import numpy as np
from draw_conventions import INK, LINE, PINION, RING, SOFT, arrow, circle, save
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure

OUT = Path(__file__).with_name("clearances.svg")


def span(ax, one, other, words, at, ha="center"):
    """Draw a dimension between two points with its name."""
    style = {"arrowstyle": "<|-|>", "color": LINE, "linewidth": 1.3, "shrinkA": 0, "shrinkB": 0}
    ax.annotate("", xy=other, xytext=one, arrowprops=style)
    ax.text(*at, words, color=LINE, fontsize=10, ha=ha, va="center")


def sleeve(ax):
    """Draw bush and journal: centred, and pressed in."""
    bush, journal, clearance = 1.0, 0.7, 0.3
    circle(ax, (0.0, 0.0), bush, RING, width=2.2)
    circle(ax, (0.0, 0.0), journal, SOFT, "--")
    turned = math.radians(-50.0)
    out = clearance + 0.06
    centre = (out * math.cos(turned), out * math.sin(turned))
    circle(ax, centre, journal, PINION, width=1.8)
    ax.plot(0.0, 0.0, "+", color=RING, markersize=9)
    ax.plot(*centre, "o", color=PINION, markersize=4)
    span(ax, (0.0, journal), (0.0, bush), "radial_clearance", (0.0, 1.12))
    arrow(ax, (0.0, 0.0), centre, INK, "e", (-0.13, 0.05))
    ax.text(0.95, -0.95, "penetration\n|e| - clearance", fontsize=9, color=INK, ha="left", va="center")
    ax.text(0.0, -1.35, "radius of the bush minus radius of the journal", fontsize=9, color=INK, ha="center")
    ax.set_xlim(-1.5, 2.0)


def tooth(height, width, lean):
    """Return the outline of a tooth that points upwards, about x = 0."""
    half, top = 0.5 * width, 0.5 * width - lean
    return np.array([(-half, 0.0), (-top, height), (top, height), (half, 0.0)])


def mesh(ax):
    """Draw a tooth in the space of the other gear, and the gaps of both flanks along the line of action."""
    lean = math.tan(math.radians(20.0))
    space = tooth(1.0, 1.75, lean)
    body = np.array([(-1.6, 0.0), *space[:1], *space[1:3], *space[3:], (1.6, 0.0), (1.6, 1.35), (-1.6, 1.35)])
    ax.fill(body[:, 0], body[:, 1], facecolor="#e3e7ee", edgecolor=RING, linewidth=1.6)
    inner = tooth(0.85, 1.25, lean * 0.85) - (0.0, 0.05)
    lower = np.array([(-1.6, -0.05), *inner, (1.6, -0.05), (1.6, -0.6), (-1.6, -0.6)])
    ax.fill(lower[:, 0], lower[:, 1], facecolor="#d5e4f2", edgecolor=PINION, linewidth=1.6)
    normal = np.array([math.cos(math.radians(20.0)), math.sin(math.radians(20.0))])
    for way, words in ((1.0, "drive gap"), (-1.0, "back gap")):
        start = np.array([way * (0.625 - lean * 0.4), 0.35])
        gap = 0.25 * math.cos(math.radians(20.0)) - 0.02
        end = start + gap * normal * (way, 1.0)
        style = {"arrowstyle": "<|-|>", "color": LINE, "linewidth": 1.3, "shrinkA": 0, "shrinkB": 0}
        ax.annotate("", xy=end, xytext=start, arrowprops=style)
        ax.text(way * 1.22, 0.62, words, color=LINE, fontsize=9, ha="center", va="center")
    ax.text(0.0, -0.85, "backlash = drive gap + back gap: total, along the\nline of action, at the nominal centre distance",
            fontsize=9, color=INK, ha="center", va="center")  # fmt: skip
    ax.set_xlim(-1.8, 1.8)


def runout(ax):
    """Draw the centre of a toothing beside that of its shaft."""
    circle(ax, (0.25, 0.18), 0.95, PINION, width=1.8)
    circle(ax, (0.0, 0.0), 0.95, SOFT, "--")
    ax.plot(0.0, 0.0, "+", color=RING, markersize=9)
    ax.plot(0.25, 0.18, "o", color=PINION, markersize=4)
    ax.plot([0.0, 0.9], [0.0, 0.0], color=SOFT, linewidth=1.0)
    arrow(ax, (0.0, 0.0), (0.25, 0.18), LINE)
    ax.text(-0.05, 0.2, "amplitude", fontsize=10, color=LINE, ha="right", va="center")
    ax.text(0.3, -0.12, "theta + phase", fontsize=9, color=INK, ha="left", va="center")
    ax.text(-0.2, -0.12, "shaft", fontsize=9, color=RING, ha="center", va="center")
    ax.text(
        0.1, -1.35, "runout: eccentricity, half the indicator reading", fontsize=9, color=INK, ha="center"
    )
    ax.set_xlim(-1.4, 1.5)


def main():
    """Draw the three beside each other."""
    figure = Figure(figsize=(11.0, 3.9))
    FigureCanvasSVG(figure)
    parts = (("clearance of a sleeve", sleeve), ("backlash of a mesh", mesh), ("runout of a gear", runout))
    for at, (title, draw) in enumerate(parts):
        ax = figure.add_axes((0.01 + 0.33 * at, 0.02, 0.32, 0.86))
        ax.set_aspect("equal")
        ax.axis("off")
        draw(ax)
        ax.set_ylim(*((-1.1, 1.5) if draw is mesh else (-1.5, 1.2)))
        ax.set_title(title, fontsize=12, color=INK)
    save(figure, OUT)


if __name__ == "__main__":
    main()
