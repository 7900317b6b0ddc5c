"""Deflections of the teeth under the static loads of a case, and depths of damping ramps that follow them."""

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from gearplay.parts.mesh.mesh_stiffness import pack_stiffness
from gearplay.parts.mesh.tooth_loads import tooth_loads

if TYPE_CHECKING:
    from gearplay.parts.mesh.train.train import Train

Floats = NDArray[np.float64]

UNKNOWN_LOAD_DEPTH = 1e-6
"""Depth [m] of a damping ramp where neither a depth nor a load is given."""
LEAST_DEPTH = 1e-8
"""Least depth [m] of a damping ramp that follows the load: less than teeth are rough."""


def tooth_deflections(case: "Train") -> Floats:
    """Return the deflection F / k_m [m] of every mesh under its steady load, shape [mesh]; 0 without a load."""
    stiffness = [pack_stiffness(case, j).average for j in range(len(case.meshes))]
    deflections: Floats = tooth_loads(case) / np.array(stiffness)
    return deflections


def damping_depths(case: "Train") -> Floats:
    """Return the depth d [m] of the damping ramp of every mesh, shape [mesh].

    The given one, else half the deflection under the steady load, at least 0.01 um; 1 um where there is no load. So the load has
    all of the damping, and teeth that swing about it by up to half do not pass the end of the ramp twice a period.
    """
    given = [mesh.damping.depth for mesh in case.meshes]
    if all(depth is not None for depth in given):
        return np.array(given, dtype=np.float64)
    deflections = tooth_deflections(case)
    found = np.where(deflections > 0.0, np.maximum(0.5 * deflections, LEAST_DEPTH), UNKNOWN_LOAD_DEPTH)
    return np.array([d if g is None else g for g, d in zip(given, found.tolist(), strict=True)])
