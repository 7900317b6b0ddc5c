"""Contacts at zero gap and zero load, treated as bilateral in linear analysis."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gearplay.integrate.slopes import Slopes
from gearplay.kernels.layout import OUT_SIZE, System
from gearplay.parts.mesh.flank import RAMP_CONSTANT
from gearplay.parts.mesh.geometry import P_B, P_D, gaps_at
from gearplay.parts.mesh.law.record import BACK, DRIVE
from gearplay.parts.mesh.law.slopes import F_P, F_R, FLANK, FLANK_SLOPES, F
from gearplay.parts.registry import MESH, SLEEVE
from gearplay.parts.sleeve.law import DELTA, INV_L, N_D, N, sleeve_geometry

Floats = NDArray[np.float64]

NO_GAP = 1e-12
"""Gap or penetration [m] that is none."""
LEAST = 1e-300
"""Force [N] of a flank that acts without a load."""


def bilateral_meshes(system: System, state: Floats, memory: Floats) -> tuple[int, ...]:
    """Return the meshes of which both flanks touch at a state and neither is pressed."""
    found, out = [], np.zeros(OUT_SIZE)
    for n in range(system.records[MESH].size):
        if system.records[MESH][n].pairs > 0:
            continue  # pairs of teeth keep the sides of their flanks
        if gaps_at(system, n, 0.0, state, memory, out) == 0 and max(abs(out[P_D]), abs(out[P_B])) <= NO_GAP:
            found.append(n)
    return tuple(found)


def linear_bushes(system: System) -> tuple[int, ...]:
    """Return the bushes without clearance whose law is linear."""
    sleeves = system.records[SLEEVE]
    linear = (sleeves["clearance"] == 0.0) & (sleeves["exponent"] == 1.0) & (sleeves["bed"] == 0)
    return tuple(np.flatnonzero(linear).tolist())


def act_on_both_sides(
    system: System, slopes: Slopes, state: Floats, meshes: tuple[int, ...], bushes: tuple[int, ...]
) -> bool:
    """Replace the slopes of meshes, linearised at ``state``, by those of one bilateral flank; return whether any changed.

    Slopes of ``bushes`` (`linear_bushes`) with the journal in their centre become those of a spring in all directions.
    """
    for n in meshes:
        mesh = system.records[MESH][n]
        row = slopes.elements[mesh.element]
        drive, back = FLANK + FLANK_SLOPES * DRIVE, FLANK + FLANK_SLOPES * BACK
        row[back + F] = row[back + F_P] = row[back + F_R] = 0.0
        row[drive + F] = row[drive + F] or LEAST
        row[drive + F_P] = mesh.k_m
        row[drive + F_R] = mesh.C_m if mesh.ramp == RAMP_CONSTANT else 0.0
    changed, sleeves = bool(meshes), system.records[SLEEVE]
    for n in bushes:
        sleeve, out = sleeves[n], np.zeros(OUT_SIZE)
        sleeve_geometry(system, n, 0.0, state, out)
        if out[DELTA] <= NO_GAP:
            row = slopes.elements[sleeve["element"]]
            row[N], row[N_D], row[INV_L] = sleeve["stiffness"] * NO_GAP, sleeve["stiffness"], 1.0 / NO_GAP
            changed = True
    return changed
