"""Draw docs/figures/conventions.svg: axes, signs and the two flanks, for an internal and an external pair."""

import math
from pathlib import Path

import numpy as np
from matplotlib import rc_context
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure

INK, RING, PINION, LINE, SOFT = "#1c2430", "#5b6573", "#0b5fa5", "#c8641b", "#b9c0c9"
ALPHA = math.radians(20.0)


def save(figure, target):
    """Write a drawing as SVG, the same bytes each time."""
    with rc_context({"svg.hashsalt": "gearplay"}):
        figure.savefig(target, format="svg", metadata={"Date": None})


def circle(ax, centre, radius, color, style="-", width=1.4):
    """Draw a circle."""
    t = np.linspace(0.0, 2.0 * math.pi, 361)
    ax.plot(
        centre[0] + radius * np.cos(t), centre[1] + radius * np.sin(t), style, color=color, linewidth=width
    )


def arrow(ax, start, end, color, words="", offset=(0.0, 0.0), size=11):
    """Draw an arrow with a label near its head."""
    ax.annotate(
        "",
        xy=end,
        xytext=start,
        arrowprops={"arrowstyle": "-|>", "color": color, "linewidth": 1.6, "shrinkA": 0, "shrinkB": 0},
    )
    if words:
        ax.text(
            end[0] + offset[0],
            end[1] + offset[1],
            words,
            color=color,
            fontsize=size,
            ha="center",
            va="center",
        )


def turn(ax, centre, radius, start, end, color, words, offset):
    """Draw a counter-clockwise arc with a head at its end."""
    t = np.radians(np.linspace(start, end, 60))
    x, y = centre[0] + radius * np.cos(t), centre[1] + radius * np.sin(t)
    ax.plot(x[:-2], y[:-2], color=color, linewidth=1.6)
    arrow(ax, (x[-6], y[-6]), (x[-1], y[-1]), color, words, offset)


def sleeve(ax, centre, clearance, journal, shift, words):
    """Draw bush and journal with an enlarged clearance; the journal is displaced by ``shift``."""
    circle(ax, centre, journal + clearance, SOFT, width=2.5)
    moved = (centre[0] + shift[0], centre[1] + shift[1])
    circle(ax, moved, journal, INK, width=1.0)
    ax.plot(*centre, "+", color=SOFT, markersize=7)
    ax.plot(*moved, "o", color=INK, markersize=3)
    ax.text(centre[0], centre[1] - journal - clearance - 0.5, words, fontsize=9, color=RING, ha="center")


def pair(ax, internal):
    """Draw one pair: foot of the vector of centres at the origin, its tip on +x."""
    r_a, r_b = (6.0, 2.0) if internal else (2.6, 1.9)
    distance = r_a - r_b if internal else r_a + r_b
    a, b = (0.0, 0.0), (distance, 0.0)
    names = ("ring (a)", "pinion (b)") if internal else ("driver (a)", "driven (b)")
    for centre, radius, color in ((a, r_a, RING), (b, r_b, PINION)):
        circle(ax, centre, radius, color)
        circle(ax, centre, radius * math.cos(ALPHA), color, "--", 0.8)
    sleeve(ax, a, 0.22, 0.42, (0.14, 0.12), "sleeve: clearance c\n(radius difference)")
    ax.plot(*b, "o", color=PINION, markersize=4)
    arrow(ax, (0.14, 0.12), b, INK, "")
    ax.text(
        (0.36 if internal else 0.33) * distance,
        0.28,
        "A",
        fontsize=12,
        color=INK,
        ha="center",
        style="italic",
    )
    arrow(ax, b, (b[0] + 1.0, 0.0), INK, "u", (0.2, 0.22))
    arrow(ax, b, (b[0], 1.0), INK, "n", (-0.22, 0.1))
    pitch = (r_a, 0.0)
    length = 1.9 if internal else 2.6
    for sign, words, style in ((1.0, "drive flank", "-"), (-1.0, "back flank", "--")):
        # the common tangents of the base circles pass through the pitch point, at 90 deg - alpha from the centre line
        direction = (math.sin(ALPHA), math.cos(ALPHA))
        end = (pitch[0] + length * direction[0], sign * length * direction[1])
        ax.plot([2 * pitch[0] - end[0], end[0]], [-end[1], end[1]], style, color=LINE, linewidth=1.2)
        ax.text(
            end[0] + 0.12,
            end[1] + 0.22 * sign,
            f"line of action,\n{words}",
            fontsize=8.5,
            color=LINE,
            va="center",
        )
    ax.plot(*pitch, "s", color=LINE, markersize=4)
    turn(ax, a, 0.62 * r_a if not internal else 2.2, 120, 205, RING, r"$\theta_a$", (-0.35, -0.15))
    turn(ax, b, 0.62 * r_b, 110, 220, PINION, r"$\theta_b$", (-0.1, -0.42))
    ax.text(a[0] - 0.72 * r_a, a[1] + 0.78 * r_a + 0.25, names[0], color=RING, fontsize=11, ha="center")
    ax.text(
        b[0], -r_b - 0.38 if not internal else -r_b - 0.34, names[1], color=PINION, fontsize=11, ha="center"
    )
    corner = (-r_a - 0.2, -r_a - 0.1)
    arrow(ax, corner, (corner[0] + 1.1, corner[1]), INK, "x", (0.22, 0.0))
    arrow(ax, corner, (corner[0], corner[1] + 1.1), INK, "y", (0.0, 0.24))
    law = (
        "b_t = b0 - 2 s D: closes as A grows (s = +1)"
        if internal
        else "b_t = b0 - 2 s D: opens as A grows (s = -1)"
    )
    ax.set_title(f"{'Internal' if internal else 'External'} pair\n{law}", fontsize=11, loc="left", color=INK)
    ax.set_aspect("equal")
    ax.axis("off")
    ax.set_xlim(-r_a - 0.6, max(r_a, distance + r_b) + (2.9 if internal else 0.9))
    ax.set_ylim(-r_a - 0.5, r_a + 0.6)


def main() -> None:
    """Draw both pairs side by side."""
    figure = Figure(figsize=(13.0, 6.4), layout="constrained")
    figure.get_layout_engine().set(h_pad=0.15, w_pad=0.1)
    FigureCanvasSVG(figure)
    left, right = figure.subplots(1, 2, width_ratios=(1.15, 1.0))
    pair(left, True)
    pair(right, False)
    figure.text(
        0.5, 0.005, "Rotations counter-clockwise positive. Dashed circles: base circles. Clearance drawn far too large.",
        ha="center", fontsize=9, color=RING,
    )  # fmt: skip
    target = Path(__file__).with_name("conventions.svg")
    save(figure, target)


if __name__ == "__main__":
    main()
