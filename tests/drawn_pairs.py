"""Pairs of drawn gears for tests, lengths in one unit, angles in degrees."""

import math
from typing import Any

from gearplay.toothing.gear import DrawnGear
from gearplay.toothing.pair import GearPair


def drawn(
    module: float, teeth: int, shift: float = 0.0, *, alpha: float = 20.0, beta: float = 0.0, **more: Any
) -> DrawnGear:
    """Return a gear; ``more`` are fields of `DrawnGear`."""
    return DrawnGear(
        teeth=teeth,
        module=module,
        pressure_angle=math.radians(alpha),
        helix_angle=math.radians(beta),
        profile_shift=shift,
        **more,
    )


def paired(first: DrawnGear, second: DrawnGear, distance: float | None = None) -> GearPair:
    """Return a pair at a distance, that of the shifts if None."""
    pair = GearPair(first, second, math.nan)
    return pair.at(pair.shifted_distance if distance is None else distance)


def standard(
    z_1: int, z_2: int, internal: bool, module: float, alpha: float = 20.0, distance: float | None = None
) -> GearPair:
    """Return a pair of full-depth gears without shift."""
    return paired(
        drawn(module, z_1, alpha=alpha), drawn(module, z_2, alpha=alpha, internal=internal), distance
    )
