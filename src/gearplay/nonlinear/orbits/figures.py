"""Branches of periodic orbits as lines: stable parts solid, unstable ones dotted, special points marked."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from gearplay.nonlinear.orbits.branches import DOUBLING, FOLD, GRAZING, TORUS, Branch, Special
from gearplay.pictures.canvas import legend_mark

MARKS = {FOLD: "s", DOUBLING: "^", TORUS: "o", GRAZING: "x"}
BRANCH, POINT = "#222222", "#b02a4c"


def draw_branch(ax: Any, branch: Branch, values: Any, *, factor: float = 1.0, offset: float = 0.0) -> None:
    """Draw a branch on an axis: stable parts solid, unstable ones dotted, special points marked.

    ``values`` are what is shown of each orbit, shape [orbit] or [orbit, order]; ``factor`` multiplies the parameter,
    ``offset`` is added to it.
    """
    size = 5.0 / branch.order**0.5
    for y in np.asarray(values).reshape(len(branch.orbits), -1).T:
        for x, level, whole in _lines_of(branch, y):
            ax.plot(
                factor * np.asarray(x) + offset, level, "-" if whole else ":", color=BRANCH, linewidth=1.2
            )
        for special in branch.special:
            level = _level(branch, special, y)
            ax.plot(
                factor * special.orbit.parameter + offset,
                level,
                MARKS[special.kind],
                color=POINT,
                markersize=size,
            )


def _lines_of(branch: Branch, y: Any) -> list[tuple[Any, Any, bool]]:
    """Return the stable and unstable parts of a branch as lines x, y, separated at the special points between orbits."""
    turns = {s.place: s for s in branch.special if s.kind != GRAZING}
    lines: list[tuple[list[float], list[float], bool]] = []
    x, stable = branch.parameters, branch.stable
    for at in range(len(x)):
        if not lines or lines[-1][2] != stable[at]:
            begins: tuple[list[float], list[float]] = ([], [])
            if lines and at - 1 in turns:
                turn = turns[at - 1]
                begins = ([turn.orbit.parameter], [_level(branch, turn, y)])
                lines[-1][0].extend(begins[0])
                lines[-1][1].extend(begins[1])
            elif lines:
                begins = ([float(x[at - 1])], [float(y[at - 1])])
            lines.append((list(begins[0]), list(begins[1]), bool(stable[at])))
        lines[-1][0].append(float(x[at]))
        lines[-1][1].append(float(y[at]))
    return [(np.array(xs), np.array(ys), whole) for xs, ys, whole in lines]


def _level(branch: Branch, special: Special, y: Any) -> float:
    """Return where a special point is drawn: on the line between its neighbours."""
    low, high = (branch.orbits[special.place + k].parameter for k in (0, 1))
    share = float(np.clip((special.orbit.parameter - low) / (high - low), 0.0, 1.0)) if high != low else 0.5
    return float((1.0 - share) * y[special.place] + share * y[special.place + 1])


def branch_marks(branches: Sequence[Branch]) -> dict[str, Any]:
    """Return the legend entries for the points of branches."""
    stable = {bool(whole) for branch in branches for whole in branch.stable}
    marks = {"stable orbits": legend_mark(BRANCH, line="-")} if True in stable else {}
    if False in stable:
        marks["unstable orbits"] = legend_mark(BRANCH, line=":")
    kinds = {special.kind for branch in branches for special in branch.special}
    return marks | {kind: legend_mark(POINT, marker=MARKS[kind]) for kind in MARKS if kind in kinds}
