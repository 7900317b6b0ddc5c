"""Jam limit of a mesh in a map over temperature, found by search."""

import math
from collections.abc import Callable, Mapping
from functools import lru_cache, partial
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import BarycentricInterpolator
from scipy.optimize import brentq

from gearplay.model import geometry
from gearplay.model.reading import replace
from gearplay.sweeps.running.evaluate import Sweep
from gearplay.vocabulary.errors import InputError

Floats = NDArray[np.float64]
POINTS, NODES = 25, 9
"""Points of a line, and cases along the other axis from which each is interpolated."""


def fields_at(sweep: Sweep, values: Mapping[str, Any]) -> dict[str, Any]:
    """Return the varied fields of a case by path, at those varied values by name that are known."""
    return {
        path: values[name] if scaled is None else scaled * values[name]
        for path, name, scaled in sweep.template.fields
        if name in values
    }


def excess_at(sweep: Sweep, j: int, values: Mapping[str, float]) -> float:
    """Return 2 sin(alpha0) (sum of radial clearances) less the backlash [m] of mesh j at temperature; NaN where it cannot be."""
    return _excesses(sweep, tuple(sorted(values.items())))[j]


@lru_cache(maxsize=4096)
def _excesses(sweep: Sweep, values: tuple[tuple[str, float], ...]) -> tuple[float, ...]:
    """Return `excess_at` of all meshes, cached: lines of many meshes, in many pictures, use the same cases."""
    base = sweep.template.base
    try:
        case = replace(base, fields_at(sweep, dict(values))).operating
    except InputError:
        return (math.nan,) * len(base.meshes)
    plays = [
        sum(case.sleeves[name].radial_clearance for name in mesh.rotors if name in case.sleeves)
        for mesh in case.meshes
    ]
    return tuple(
        2.0 * math.sin(mesh.pressure_angle) * play - geometry.installed_backlash(case, j)
        for j, (mesh, play) in enumerate(zip(case.meshes, plays, strict=True))
    )


def line_of(
    sweep: Sweep,
    j: int,
    across: tuple[str, float, float],
    up: tuple[str, float, float],
    fixed: Mapping[str, float],
) -> tuple[Floats, Floats] | None:
    """Return the points (across, up) at which the excess of mesh j vanishes, shape [point]; None where it does nowhere."""
    for along, other, swapped in ((up, across, False), (across, up, True)):
        if not along[0]:
            continue
        points = []
        for place in np.linspace(other[1], other[2], POINTS if other[0] else 2):
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
