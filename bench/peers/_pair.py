"""The numbers that a right-hand side of this one pair needs, for peers that write its formulas anew.

They may be short because the problems are: an internal pair with its ring at the origin (rotor 1) and the
pinion on the +x axis (rotor 0, the driver), one sleeve on the ring, restitution 1, one harmonic each of
stiffness and transmission error.
"""

import numpy as np

from gearplay.parts.mesh.geometry import MESH_COUPLED
from gearplay.parts.mesh.tooth_stiffness import STIFFNESS_FOURIER
from gearplay.parts.registry import SLEEVE

ROTOR = ("nominal_speed", "inv_mass", "inv_inertia", "torque", "drag")
MESH = (
    "rho_a",
    "rho_b",
    "c0",
    "A0",
    "A_min",
    "A_max",
    "backlash",
    "z_driver",
    "k_m",
    "C_m",
    "depth",
    "u_series",
)


def numbers(problem):
    """Return the numbers by name; a problem with more physics than the formulas know is refused."""
    system = problem.packed.system
    sleeves, meshes = system.records[SLEEVE], system.records[MESH]
    mesh, sleeve = meshes[0], sleeves[0]
    fits = (
        (system.rotors.size, sleeves.size, meshes.size, system.elements.size) == (2, 1, 1, 2)
        and (mesh.a, mesh.b, mesh.driver, mesh.s, mesh.sigma) == (1, 0, 0, 1.0, 1.0)
        and (mesh.kind, mesh.stiffness_kind) == (MESH_COUPLED, STIFFNESS_FOURIER)
        and (mesh.stiffness_count, mesh.error_count) == (1, 1)
        and np.all(system.terms[:, 0] == 1.0)
        and (sleeve.journal, sleeve.bush, sleeve.dissipation, sleeve.exponent, sleeve.bed)
        == (1, -1, 0.0, 1.5, 0)
        and not np.any(system.gravity)
    )
    if not fits:
        raise ValueError("the rewritten formulas of this peer do not cover the problem")
    values = {
        f"{gear}_{name}": system.rotors[i][name]
        for i, gear in enumerate(("pinion", "ring"))
        for name in ROTOR
    }
    values |= {name: mesh[name] for name in MESH}
    for gear, side in (("pinion", "b"), ("ring", "a")):
        values |= {
            f"{gear}_eccentricity": mesh[f"runout_{side}"],
            f"{gear}_eccentricity_phase": mesh[f"runout_phase_{side}"],
        }
    values |= {"clearance": sleeve.clearance, "sleeve_stiffness": sleeve.stiffness}
    k, e = system.terms[mesh.stiffness_start], system.terms[mesh.error_start]
    values |= {"k_cos": k[1], "k_sin": k[2], "e_cos": e[1], "e_sin": e[2]}
    return {name: float(value) for name, value in values.items()}


def involute_coefficients(problem):
    """Return the coefficients of (inv(alpha_w) - inv(alpha0)) / u in powers of u = (A / A0)^2 - 1."""
    return problem.packed.system.involutes[0].copy()
