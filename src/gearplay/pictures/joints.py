"""Symbols of elastic supports and couplings in drawings of a mechanism, as on the page (``mechanism.js``)."""

import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gearplay.pictures.style import TEST

Floats = NDArray[np.float64]
SOFT = "#565d66"
COILS = 5
CIRCLE = np.linspace(0.0, 2.0 * np.pi, 73)


class Joints:
    """Symbols of the elastic joints of a mechanism in one view; made once and moved from frame to frame."""

    def __init__(self, ax: Any, mechanism: Mapping[str, Any]) -> None:
        shafts = {gear["rotor"]: gear for gear in reversed(mechanism["gears"])}
        self.springs: list[tuple[Any, Mapping[str, Any], int]] = []
        self.rings: list[tuple[Any, Mapping[str, Any], float, float]] = []
        for support in mechanism["supports"]:
            for axis, stiffness in enumerate(support["stiffness"]):
                if stiffness > 0.0:
                    (line,) = ax.plot([], [], color=SOFT, linewidth=0.8, zorder=4.2)
                    self.springs.append((line, shafts[support["name"]], axis))
        for coupling in mechanism["couplings"]:
            one, other = (shafts[name] for name in coupling["between"])
            if math.hypot(one["x"] - other["x"], one["y"] - other["y"]) > 1e-6:
                continue  # two axes joined by an ideal drive
            radius = 1.7 * max(one["shaft"], other["shaft"])
            for gear, style, inner in ((one, "-", 0.7), (other, "--", 1.3)):
                (line,) = ax.plot([], [], color=TEST, linewidth=1.1, linestyle=style, zorder=4.4)
                self.rings.append((line, gear, radius, inner))

    def place(
        self,
        centre: Callable[[Mapping[str, Any]], Floats],
        turn: Callable[[Mapping[str, Any]], float],
        shown: Callable[[Mapping[str, Any], Floats], Floats],
    ) -> None:
        """Update the symbols for centres [m] and rotations [rad] of shafts; ``shown`` maps points [m] to those of the view."""
        for line, gear, axis in self.springs:
            line.set_data(*shown(gear, spring(gear, centre(gear), axis)).T)
        for line, gear, radius, inner in self.rings:
            angle = turn(gear)
            mark = np.outer([1.0, inner], [math.cos(angle), math.sin(angle)])
            around = np.column_stack([np.cos(CIRCLE + angle), np.sin(CIRCLE + angle)])
            line.set_data(*shown(gear, centre(gear) + radius * np.vstack([around, mark])).T)


def spring(gear: Mapping[str, Any], centre: Floats, axis: int) -> Floats:
    """Return a spring from the ground, left of a shaft or below it, to the shaft at its centre [m], shape [point, 2]."""
    shaft, home = gear["shaft"], np.array([gear["x"], gear["y"]])
    start, end = -3.2 * shaft, centre[axis] - home[axis] - shaft
    along = [start, start, start, *np.linspace(start, end, 2 * COILS + 1)[1:-1], end]
    coils = [0.35 * shaft * (1.0 if k % 2 else -1.0) for k in range(1, 2 * COILS)]
    across = [-0.8 * shaft, 0.8 * shaft, 0.0, *coils, 0.0]
    points = np.empty((len(along), 2))
    points[:, axis] = home[axis] + np.array(along)
    points[:, 1 - axis] = centre[1 - axis] + np.array(across)
    return points
