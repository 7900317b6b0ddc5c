"""Static tooth loads under the constant torques of a case, and the deflections under them."""

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from gearplay.model import geometry, rolling
from gearplay.model.linear_conditions import solved_by_rank
from gearplay.model.mesh_stiffness import pack_stiffness

if TYPE_CHECKING:
    from gearplay.model.case import Case

Floats = NDArray[np.float64]

UNKNOWN_LOAD_DEPTH = 1e-6
"""Depth [m] of a damping ramp where neither a depth nor a load is given."""
LEAST_DEPTH = 1e-8
"""Least depth [m] of a damping ramp that follows the load: less than teeth are rough."""


def _torques(case: "Case") -> Floats:
    """Return the constant torque [N m] on every rotor at its nominal speed, shape [rotor]; terms and tables left out."""
    speeds = rolling.nominal_speeds(case)
    senses = np.sign(rolling.moving_speeds(case, speeds))
    torques = np.zeros(len(case.rotors))
    for i, rotor in enumerate(case.rotors.values()):
        load = rotor.load
        torques[i] = -senses[i] * (load.torque + load.friction) - load.drag * speeds[i]
        if rotor.drive is not None and rotor.drive.kind == "torque":
            torques[i] += rotor.drive.torque
    return torques


def tooth_loads(case: "Case") -> Floats:
    """Return the steady force [N] along the line of action of every mesh, shape [mesh]; 0 without a load.

    The train rolls rigidly under its constant torques: with the conditions A alpha = 0 of rolling the accelerations minimise
    Gauss's |sqrt(J) (alpha - T / J)|^2, and the multipliers are the forces. Rotations that a speed, servo or position drive
    prescribes do not accelerate. Torques on rotors without inertia balance exactly. Meshes in parallel share alike, as planets
    do.
    """
    rotors = list(case.rotors.values())
    free = np.array([rotor.drive is None or rotor.drive.kind == "torque" for rotor in rotors])
    light = free & np.array([rotor.inertia == 0.0 for rotor in rotors])
    mobility = np.zeros(len(rotors))
    mobility[free] = [
        1.0 / math.sqrt(r.inertia or 1.0) for r, moves in zip(rotors, free, strict=True) if moves
    ]
    conditions = rolling.rolling_conditions(case) * mobility
    sizes = np.linalg.norm(conditions, axis=1)
    sizes[sizes == 0.0] = np.inf  # between prescribed rotations: no torque determines the load there
    matrix, target = (conditions / sizes[:, None]).T, mobility * _torques(case)
    if light.any():
        levels = [(matrix[light], target[light]), (matrix[~light], target[~light])]
        multipliers = solved_by_rank(levels, len(sizes)) / sizes
    else:
        multipliers = np.linalg.lstsq(matrix, target, rcond=1e-9)[0] / sizes
    forces = np.zeros(len(case.meshes))
    for j, mesh in enumerate(case.meshes):
        _, _, r_a, r_b = geometry.signed_radii(case, j)
        forces[j] = abs(multipliers[j]) / (max(abs(r_a), abs(r_b)) * math.cos(mesh.pressure_angle))
    forces[forces < 1e-9 * np.max(forces, initial=0.0)] = 0.0  # rounding
    return forces


def tooth_deflections(case: "Case") -> Floats:
    """Return the deflection F / k_m [m] of every mesh under its steady load, shape [mesh]; 0 without a load."""
    stiffness = [pack_stiffness(case, j).average for j in range(len(case.meshes))]
    deflections: Floats = tooth_loads(case) / np.array(stiffness)
    return deflections


def damping_depths(case: "Case") -> Floats:
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
