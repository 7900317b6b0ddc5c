"""Jam limit of a mesh in a map: 2 sin(alpha0) (sum of both radial clearances) = b0, all at temperature.

Radial clearances are those of sleeves and half the internal ones of rolling bearings, as in `geometry.jam_ratio`.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import lru_cache, partial
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import BarycentricInterpolator
from scipy.optimize import brentq

from gearplay.model.reading import replace
from gearplay.parts.mesh.train import geometry
from gearplay.parts.rotor.gear import Toothing
from gearplay.sweeps.running.evaluate import Sweep
from gearplay.vocabulary.errors import InputError

Floats = NDArray[np.float64]
Ends = tuple[str, float, float]
"""A varied quantity and the lowest and highest value drawn [SI or factors]; without a name there is no such axis."""
POINTS = 400
SEARCHED = ("radial_clearance", "internal_clearance", "backlash", "pressure_angle")
"""Fields of planetary sets and rolling bearings on which a line depends: it is found by search."""
THERMAL_POINTS, NODES = 25, 9
"""Points of a line at temperature, and cases along the other axis from which each is interpolated."""


@dataclass(frozen=True)
class JamLine:
    """The line of one mesh over two varied quantities [SI or factors], shape [point].

    On one side of it `jam_ratio` is above 1: to the right (1), to the left (-1) or neither (0), and above, below or neither.
    """

    mesh: str
    across: Floats
    up: Floats
    sides: tuple[int, int]


def jam_lines(sweep: Sweep, across: Ends, up: Ends, fixed: Mapping[str, float]) -> list[JamLine]:
    """Return the line of every mesh whose backlash or clearances vary along one of two axes.

    ``fixed`` are the values along other axes [SI or factors]. There is no line where a drawn parameter has a part in it: it
    would be another for every point.
    """
    base, found = sweep.template.base, []
    excess: Callable[[Sweep, int, Mapping[str, Any]], Any] = jam_excess
    make = _closed_line
    if base.environment is not None or _is_drawn(sweep) or _is_of_sets(sweep):
        drawn = sweep.template.plan.design
        if drawn is not None and drawn.parameters:
            return []
        excess, make = excess_at, _thermal_line
    for j, mesh in enumerate(base.meshes):
        line = make(sweep, j, across, up, fixed)
        if line is None:
            continue
        x, y = line
        values = {**fixed, across[0]: float(x[x.size // 2]), up[0]: float(y[y.size // 2])}
        sides = [0, 0]
        for k, (name, bottom, top) in enumerate((across, up)):
            step = 1e-3 * (top - bottom)
            ahead, behind = (excess(sweep, j, {**values, name: values[name] + s}) for s in (step, -step))
            sides[k] = int(np.sign(ahead - behind)) if abs(ahead - behind) > 1e-18 else 0
        found.append(JamLine(mesh.label, x, y, (sides[0], sides[1])))
    return found


def _is_drawn(sweep: Sweep) -> bool:
    """Return whether gears have, or get along an axis, drawings from which backlash and working angle follow."""
    base = sweep.template.base
    fields = {path.rpartition(".")[2] for path, _, _ in sweep.template.fields}
    return (
        bool(fields & {*Toothing.model_fields, "center_distance"})
        or any(mesh.center_distance is not None for mesh in base.meshes)
        or any(gear.drawn for rotor in base.rotors.values() for gear in (rotor, *rotor.gears.values()))
    )


def _is_of_sets(sweep: Sweep) -> bool:
    """Return whether a clearance or a backlash of planetary sets, or a clearance of rolling bearings, varies."""
    paths = [path.split(".") for path, _, _ in sweep.template.fields]
    return any(path[0] in ("planetary", "bearings") and path[-1] in SEARCHED for path in paths)


def jam_excess(sweep: Sweep, j: int, values: Mapping[str, Any]) -> Any:
    """Return 2 sin(alpha0) (sum of both radial clearances) - b0 [m] of mesh j at varied values by name, numbers or arrays.

    What is not varied is the base case's. Above 0 where `geometry.jam_ratio` is above 1.
    """
    base = sweep.template.base
    mesh = base.meshes[j]
    fields = fields_at(sweep, values)
    play: Any = 0.0
    for name in mesh.rotors:
        own = geometry.clearance_of(base, name) or 0.0
        play = play + (fields.get(f"sleeves.{name}.radial_clearance", own) if name in base.sleeves else own)
    angle = fields.get(f"meshes.{j}.pressure_angle", mesh.pressure_angle)
    return 2.0 * np.sin(angle) * play - fields.get(f"meshes.{j}.backlash", geometry.working_backlash(base, j))


def _closed_line(
    sweep: Sweep, j: int, across: Ends, up: Ends, fixed: Mapping[str, float]
) -> tuple[Floats, Floats] | None:
    """Return the points (across, up) at which `jam_excess` vanishes, solved for a quantity in which it is linear."""
    base = sweep.template.base
    mesh, angle = base.meshes[j], f"meshes.{j}.pressure_angle"
    linear = {f"sleeves.{n}.radial_clearance" for n in mesh.rotors if n in base.sleeves}
    linear.add(f"meshes.{j}.backlash")
    by_name: dict[str, set[str]] = {}
    for path, name, _ in sweep.template.fields:
        if path in linear or path == angle:
            by_name.setdefault(name, set()).add(path)
    solvable = [axis[0] for axis in (up, across) if axis[0] in by_name and angle not in by_name[axis[0]]]
    if not solvable or by_name.keys() - {across[0], up[0]} - fixed.keys():
        return None
    wanted, (other, low, high) = solvable[0], across if solvable[0] == up[0] else up
    grid = (np.geomspace if low > 0.0 and high > 10.0 * low else np.linspace)(low, high, POINTS)
    known = dict(fixed) | {other: grid}
    at_zero = jam_excess(sweep, j, known | {wanted: 0.0}) + np.zeros(POINTS)
    slope = jam_excess(sweep, j, known | {wanted: 1.0}) - at_zero
    if np.any(np.abs(slope) < 1e-300):  # the varied quantities cancel, or the base value is 0
        return None
    solved = -at_zero / slope
    return (grid, solved) if wanted == up[0] else (solved, grid)


def fields_at(sweep: Sweep, values: Mapping[str, Any]) -> dict[str, Any]:
    """Return the varied fields of a case by path, from the varied values given by name; others are left out."""
    return {
        path: values[name] if scaled is None else scaled * values[name]
        for path, name, scaled in sweep.template.fields
        if name in values
    }


def excess_at(sweep: Sweep, j: int, values: Mapping[str, float]) -> float:
    """Return 2 sin(alpha0) (sum of radial clearances) less the backlash [m] of mesh j at temperature, NaN out of mesh."""
    return _excesses(sweep, tuple(sorted(values.items())))[j]


@lru_cache(maxsize=4096)
def _excesses(sweep: Sweep, values: tuple[tuple[str, float], ...]) -> tuple[float, ...]:
    """Return `excess_at` of all meshes, cached: lines of many meshes, in many pictures, use the same cases."""
    base = sweep.template.base
    try:
        case = replace(base, fields_at(sweep, dict(values))).operating
    except InputError:
        return (math.nan,) * len(base.meshes)
    plays = [sum(geometry.clearance_of(case, name) or 0.0 for name in mesh.rotors) for mesh in case.meshes]
    return tuple(
        2.0 * math.sin(geometry.pair_of(case, j).working_angle) * play - geometry.installed_backlash(case, j)
        for j, play in enumerate(plays)
    )


def _thermal_line(
    sweep: Sweep, j: int, across: Ends, up: Ends, fixed: Mapping[str, float]
) -> tuple[Floats, Floats] | None:
    """Return the points (across, up) at which `excess_at` vanishes, found by search; None without a zero."""
    for along, other, swapped in ((up, across, False), (across, up, True)):
        if not along[0]:
            continue
        points = []
        for place in np.linspace(other[1], other[2], THERMAL_POINTS if other[0] else 2):
            held = dict(fixed) | ({other[0]: float(place)} if other[0] else {})
            root = _root(partial(_excess, sweep, j, held, along[0]), *along[1:])
            if root is not None:
                points.append((float(place), root))
        if len(points) > 1:
            first, second = np.array(points).T
            return (second, first) if swapped else (first, second)
    return None


def _excess(sweep: Sweep, j: int, held: Mapping[str, float], name: str, value: float) -> float:
    return excess_at(sweep, j, {**held, name: value})


def _root(function: Callable[[float], float], low: float, high: float) -> float | None:
    """Return where a smooth function changes its sign between two ends, if it does: by its interpolant of Chebyshev nodes."""
    nodes = 0.5 * (low + high) - 0.5 * (high - low) * np.cos(np.pi * np.arange(NODES) / (NODES - 1))
    values = np.array([function(float(place)) for place in nodes])
    known = np.isfinite(values)
    nodes, values = nodes[known], values[known]
    changes = np.flatnonzero(values[:-1] * values[1:] < 0.0)
    if not changes.size:
        return None
    at = int(changes[0])
    return float(
        brentq(BarycentricInterpolator(nodes, values), nodes[at], nodes[at + 1], xtol=1e-12 * (high - low))
    )
