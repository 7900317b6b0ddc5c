"""Draw the pictures of docs/gallery/nonlinear.md beside this file: python docs/gallery/nonlinear.py;
--short --out FOLDER tries it.
"""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from sizes import draw, sized

import gearplay as gp
from gearplay.model.torsional_pair import BASE_RADIUS
from gearplay.nonlinear.figures import WAYS
from gearplay.nonlinear.orbits.branches import Branch, Settings, follow_branch
from gearplay.nonlinear.orbits.figures import BRANCH, draw_branch
from gearplay.nonlinear.orbits.period_map import StrobeMap
from gearplay.nonlinear.orbits.shooting import find_orbit
from gearplay.pictures.canvas import SMALL, legend_mark, make_figure, set_legend, set_title, to_png

RED = "#b02a4c"
LABEL = "wheel's rotation on its base circle at the section [µm]"
Family = Callable[[float], gp.Case]


def microns(theta: Any) -> Any:
    """Return rotations [rad] as arcs of the base circle [um]."""
    return 1e6 * BASE_RADIUS * theta


def branch_of(family: Family, start: float, settings: Settings, *, upwards: bool) -> Branch:
    """Return the branch through what the motion settles to at ``start``."""
    period_map = StrobeMap(family, start)
    orbit = find_orbit(period_map, period_map.settle(period_map.start(start), start, 200), start)
    return follow_branch(period_map, orbit, settings, upwards=upwards)


def finish(figure: Any, ax: Any, x: str, title: str, handles: dict[str, Any], name: str) -> None:
    """Label a figure and write it."""
    ax.set_xlabel(x, fontsize=SMALL)
    ax.set_ylabel(LABEL, fontsize=SMALL)
    set_title(figure, title)
    set_legend(figure, handles)
    (sized.out / name).write_bytes(to_png(figure))


def jump() -> None:
    """Primary resonance: branch through both folds, sweeps up and down."""

    def family(frequency: float) -> gp.Case:
        return gp.torsional_pair(frequency, mean_force=0.1, force=0.05)

    branch = branch_of(family, 1.3, Settings(low=0.4, high=1.35, size=0.1), upwards=False)
    values = np.linspace(0.42, 1.3, sized(120, 30))
    found = gp.bifurcation(family, "frequency", values, ["wheel.theta"], settle=sized(150, 100), keep=1)
    figure, axes = make_figure(1, 1, 4.2)
    ax = axes[0, 0]
    for way, name in enumerate(found.directions):
        marker = ">" if name == "up" else "<"
        ax.plot(
            values, microns(found.values[way, :, 0, 0]), marker, color=WAYS[name], markersize=3.5, alpha=0.8
        )
    draw_branch(ax, branch, [float(microns(orbit.states[0][0])) for orbit in branch.orbits])
    handles = {
        "sweep up": legend_mark(WAYS["up"], marker=">"),
        "sweep down": legend_mark(WAYS["down"], marker="<"),
        "stable orbit": legend_mark(BRANCH, line="-"),
        "unstable orbit": legend_mark(BRANCH, line=":"),
        "fold": legend_mark(RED, marker="s"),
        "grazing": legend_mark(RED, marker="x"),
    }
    title = "Torsional pair, F_m = 0.1, F_a = 0.05, zeta = 0.05: primary resonance"
    finish(
        figure,
        ax,
        "ratio of the mesh frequency to the natural frequency",
        title,
        handles,
        "nonlinear-jump.png",
    )


def route() -> None:
    """Period doublings into chaos, with the orbit that loses its stability."""

    def family(force: float) -> gp.Case:
        return gp.torsional_pair(0.6, mean_force=0.1, force=force, damping_ratio=0.1)

    branch = branch_of(family, 0.12, Settings(low=0.119, high=0.3, size=0.05, most=0.1), upwards=True)
    values = np.linspace(0.12, 0.3, sized(500, 30))
    found = gp.bifurcation(
        family, "force", values, ["wheel.theta"], settle=sized(300, 100), keep=80, directions=["up"]
    )
    figure, axes = make_figure(1, 1, 4.2)
    ax = axes[0, 0]
    ax.plot(
        np.repeat(values, found.values.shape[2]),
        microns(found.values[0, :, :, 0]).ravel(),
        ",",
        color=WAYS["up"],
    )
    draw_branch(ax, branch, [float(microns(orbit.states[0][0])) for orbit in branch.orbits])
    handles = {
        "80 sections after 300 periods": legend_mark(WAYS["up"], marker="o"),
        "stable orbit of order 1": legend_mark(BRANCH, line="-"),
        "unstable orbit of order 1": legend_mark(BRANCH, line=":"),
        "period doubling": legend_mark(RED, marker="^"),
    }
    title = "Torsional pair at 0.6 of its natural frequency, F_m = 0.1, zeta = 0.1: the way into chaos"
    finish(figure, ax, "amplitude of the force, F_a [1]", title, handles, "nonlinear-route.png")


def basins() -> None:
    """Which of two motions a start leads to."""
    case = gp.torsional_pair(0.6, mean_force=0.1, force=0.05)
    found = gp.basins(
        case,
        ("wheel.theta", -1.5e-3, 1.2e-3, sized(110, 12)),
        ("wheel.omega", -9.0, 9.0, sized(90, 10)),
        settle=100,
    )
    title = "Torsional pair at 0.6 of its natural frequency, F_m = 0.1, F_a = 0.05: where a start leads"
    figure = found.plot(title=title)
    labels = {
        "xlabel": "wheel's rotation [rad]",
        "ylabel": "speed of the wheel relative to the nominal one [rad/s]",
    }
    figure.axes[0].set(**labels)
    (sized.out / "nonlinear-basins.png").write_bytes(to_png(figure))


def main(words: Sequence[str] | None = None) -> None:
    """Draw all of it."""
    draw(words, jump, route, basins)


if __name__ == "__main__":
    main()
