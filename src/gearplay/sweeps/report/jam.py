"""Jam limit of a mesh in a map: 2 sin(alpha0) (sum of both radial clearances) = b0."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gearplay.model.case import Case
from gearplay.sweeps.report.thermal_jam import excess_at, fields_at, line_of
from gearplay.sweeps.running.evaluate import Sweep

Floats = NDArray[np.float64]
POINTS = 400


@dataclass(frozen=True)
class JamLine:
    """The line of one mesh over two varied quantities [SI or factors], shape [point].

    On one side of it `jam_ratio` is above 1: to the right (1), to the left (-1) or neither (0), and above, below or neither.
    """

    mesh: str
    across: Floats
    up: Floats
    sides: tuple[int, int]


def _paths(base: Case, j: int) -> tuple[set[str], str]:
    """Return the fields in which the excess of mesh j is linear, and that of its angle."""
    mesh = base.meshes[j]
    sleeves = {f"sleeves.{n}.radial_clearance" for n in mesh.rotors if n in base.sleeves}
    return {f"meshes.{j}.backlash"} | sleeves, f"meshes.{j}.pressure_angle"


def jam_excess(sweep: Sweep, j: int, values: Mapping[str, Any]) -> Any:
    """Return 2 sin(alpha0) (sum of both radial clearances) - b0 [m] of mesh j at varied values by name, numbers or arrays.

    What is not varied is the base case's. Above 0 where `geometry.jam_ratio` is above 1.
    """
    base = sweep.template.base
    mesh = base.meshes[j]
    fields = fields_at(sweep, values)
    play: Any = 0.0
    for name in mesh.rotors:
        if name in base.sleeves:
            path = f"sleeves.{name}.radial_clearance"
            play = play + fields.get(path, base.sleeves[name].radial_clearance)
    angle = fields.get(f"meshes.{j}.pressure_angle", mesh.pressure_angle)
    return 2.0 * np.sin(angle) * play - fields.get(f"meshes.{j}.backlash", mesh.backlash)


def jam_lines(
    sweep: Sweep,
    across: tuple[str, float, float],
    up: tuple[str, float, float],
    fixed: Mapping[str, float],
) -> list[JamLine]:
    """Return the line of every mesh whose backlash or clearances vary along one of two axes.

    ``across`` and ``up`` are names with the lowest and highest value drawn, ``fixed`` the values along other axes [SI or
    factors]. There is no line where a drawn parameter has a part in it: it would be another for every point.
    """
    base, found = sweep.template.base, []
    if base.environment is not None:
        return _thermal_lines(sweep, across, up, fixed)
    for j in range(len(base.meshes)):
        linear, angle = _paths(base, j)
        by_name: dict[str, set[str]] = {}
        for path, name, _ in sweep.template.fields:
            if path in linear or path == angle:
                by_name.setdefault(name, set()).add(path)
        solvable = [axis[0] for axis in (up, across) if axis[0] in by_name and angle not in by_name[axis[0]]]
        if not solvable or by_name.keys() - {across[0], up[0]} - fixed.keys():
            continue
        wanted, (other, low, high) = solvable[0], across if solvable[0] == up[0] else up
        grid = (np.geomspace if low > 0.0 and high > 10.0 * low else np.linspace)(low, high, POINTS)
        known = dict(fixed) | {other: grid}
        at_zero = jam_excess(sweep, j, known | {wanted: 0.0}) + np.zeros(POINTS)
        slope = jam_excess(sweep, j, known | {wanted: 1.0}) - at_zero
        if np.any(np.abs(slope) < 1e-300):  # what varies cancels itself, or its base value is 0
            continue
        solved = -at_zero / slope
        x, y = (grid, solved) if wanted == up[0] else (solved, grid)
        found.append(_line(sweep, j, jam_excess, (x, y), across, up, fixed))
    return found


def _thermal_lines(
    sweep: Sweep,
    across: tuple[str, float, float],
    up: tuple[str, float, float],
    fixed: Mapping[str, float],
) -> list[JamLine]:
    """Do what `jam_lines` does for a case with temperatures."""
    drawn = sweep.template.plan.design
    if drawn is not None and drawn.parameters:
        return []
    lines = [(j, line_of(sweep, j, across, up, fixed)) for j in range(len(sweep.template.base.meshes))]
    return [_line(sweep, j, excess_at, line, across, up, fixed) for j, line in lines if line is not None]


def _line(
    sweep: Sweep,
    j: int,
    excess: Callable[[Sweep, int, Mapping[str, Any]], Any],
    line: tuple[Floats, Floats],
    across: tuple[str, float, float],
    up: tuple[str, float, float],
    fixed: Mapping[str, float],
) -> JamLine:
    """Return the line through points at which the excess of mesh j vanishes, with the sides on which it is above 0."""
    x, y = line
    values = {**fixed, across[0]: float(x[x.size // 2]), up[0]: float(y[y.size // 2])}

    def side(name: str, bottom: float, top: float) -> int:
        step = 1e-3 * (top - bottom)
        ahead, behind = (excess(sweep, j, {**values, name: values[name] + s}) for s in (step, -step))
        return int(np.sign(ahead - behind)) if abs(ahead - behind) > 1e-18 else 0

    return JamLine(sweep.template.base.meshes[j].label, x, y, (side(*across), side(*up)))
