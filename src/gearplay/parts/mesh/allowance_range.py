"""Least and largest backlash of a mesh by the allowances of its tooth thicknesses and centre distance."""

import math
from typing import TYPE_CHECKING

from gearplay.parts.mesh.train import geometry
from gearplay.parts.rotor.allowance import Limits
from gearplay.toothing.allowances import distance_allowance
from gearplay.toothing.pair import GearPair

if TYPE_CHECKING:
    from gearplay.parts.mesh.train.train import Train


def distance_limits(case: "Train", j: int) -> tuple[float, float]:
    """Return lower and upper allowance [m] of the centre distance of mesh j."""
    mesh = case.meshes[j]
    allowance = mesh.center_distance_allowance
    if isinstance(allowance, Limits):
        return allowance.lower, allowance.upper
    if allowance is None or mesh.center_distance is None:
        return 0.0, 0.0
    half = distance_allowance(int(allowance[2:]), mesh.center_distance) or math.nan
    return -half, half


def backlash_range(case: "Train", j: int) -> tuple[float, float] | None:
    """Return least and largest normal backlash [m] of mesh j at its working distance; None without allowances.

    A backlash that the case gives stands for the middle: allowances of thickness are then none of its own.
    """
    lower, upper = distance_limits(case, j)
    thick, thin = geometry.gears_of(case, j, place=1.0), geometry.gears_of(case, j, place=0.0)
    if case.meshes[j].backlash is not None:
        thick = thin = geometry.gears_of(case, j)
    if thick == thin and lower == upper:
        return None
    pair = geometry.pair_of(case, j)
    more = geometry.working_backlash(case, j) - pair.backlash
    normal = math.cos(pair.first.base_helix)
    near, far = (upper, lower) if pair.internal else (lower, upper)
    found = [
        (GearPair(*gears, pair.distance + off).backlash + more) * normal
        for gears, off in ((thick, near), (thin, far))
    ]
    return found[0], found[1]
