"""Static tooth loads under the constant torques of a case."""

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from gearplay.parts.mesh.train import geometry, rolling
from gearplay.parts.mesh.train.linear_conditions import solved_by_rank

if TYPE_CHECKING:
    from gearplay.parts.mesh.train.train import Train

Floats = NDArray[np.float64]


def _torques(case: "Train") -> Floats:
    """Return the constant torque [N m] on every rotor at its nominal speed, shape [rotor]; terms and tables left out."""
    speeds = rolling.nominal_speeds(case)
    senses = np.sign(rolling.moving_speeds(case, speeds))
    torques = np.zeros(len(case.rotors))
    for i, rotor in enumerate(case.rotors.values()):
        load = rotor.load
        torques[i] = -senses[i] * (load.torque + load.friction) - load.drag * speeds[i]
        if rotor.drive is not None:
            torques[i] += rotor.drive.constant_torque()
    return torques


def tooth_loads(case: "Train") -> Floats:
    """Return the steady force [N] along the line of action of every mesh, shape [mesh]; 0 without a load.

    The train rolls rigidly under its constant torques: with the conditions A alpha = 0 of rolling the accelerations minimise
    Gauss's |sqrt(J) (alpha - T / J)|^2, and the multipliers are the forces. Rotations that a speed, servo or position drive
    prescribes do not accelerate. Torques on rotors without inertia balance exactly. Meshes in parallel share alike, as planets
    do.
    """
    rotors = list(case.rotors.values())
    free = np.array([rotor.drive is None or rotor.drive.nominal_speed() is None for rotor in rotors])
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
        lever = max(abs(r_a), abs(r_b)) * math.cos(geometry.transverse_angle(case, mesh))
        forces[j] = abs(multipliers[j]) / lever
    forces[forces < 1e-9 * np.max(forces, initial=0.0)] = 0.0  # rounding
    return forces
