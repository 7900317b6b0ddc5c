"""Natural size of each state: the scale of error tolerances, orbits and exponents."""

import numpy as np
from numpy.typing import NDArray

from gearplay.kernels.layout import System
from gearplay.parts.assembly import ANGLE_SCALE, LENGTH_SCALE
from gearplay.parts.mesh import law as mesh

Floats = NDArray[np.float64]


SPEED_SCALE = 0.1  # m/s, natural size of a speed behind the error tolerances


def _arms(system: System) -> list[float]:
    """Return the radius [m] that turns each rotor's rotation into a length: its largest toothing, or 0.1 m."""
    arms, meshes = np.zeros(system.rotors.size), system.records[mesh.KIND]
    np.maximum.at(arms, meshes["a"], np.abs(meshes["rho_a"]))
    np.maximum.at(arms, meshes["b"], np.abs(meshes["rho_b"]))
    return [float(arm) or 0.1 for arm in arms]


def natural_sizes(system: System, states: int) -> Floats:
    """Return the natural size of each state of a packed mechanism [m, rad, m/s, rad/s], shape [state]."""
    arms = _arms(system)
    positions = [x for r in arms for x in (LENGTH_SCALE, LENGTH_SCALE, LENGTH_SCALE / r)]
    speeds = [x for r in arms for x in (SPEED_SCALE, SPEED_SCALE, SPEED_SCALE / r)]
    return np.array(positions + speeds + [ANGLE_SCALE] * states)
