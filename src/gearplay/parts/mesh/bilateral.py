"""Meshes at zero gap and zero load, in linear analysis one flank that acts on both sides."""

from collections.abc import Iterable

import numpy as np

from gearplay.kernels.arrays import Floats
from gearplay.kernels.layout import OUT_SIZE, System
from gearplay.parts.mesh.flank import RAMP_CONSTANT
from gearplay.parts.mesh.geometry import P_B, P_D, gaps_at
from gearplay.parts.mesh.law import KIND
from gearplay.parts.mesh.law.record import BACK, DRIVE
from gearplay.parts.mesh.law.slopes import F_P, F_R, FLANK, FLANK_SLOPES, F

NO_GAP = 1e-12
"""Gap or penetration [m] that is none."""
LEAST = 1e-300
"""Force [N] of a flank that acts without a load."""


def bilateral_meshes(system: System, state: Floats, memory: Floats) -> tuple[int, ...]:
    """Return the meshes of which both flanks touch at a state and neither is pressed."""
    found, out = [], np.zeros(OUT_SIZE)
    for n in range(system.records[KIND].size):
        if system.records[KIND][n].pairs > 0:
            continue  # pairs of teeth keep the sides of their flanks
        if gaps_at(system, n, 0.0, state, memory, out) == 0 and max(abs(out[P_D]), abs(out[P_B])) <= NO_GAP:
            found.append(n)
    return tuple(found)


def join_flanks(system: System, elements: Floats, meshes: Iterable[int]) -> None:
    """Give the slopes of meshes, rows of ``elements``, one flank that acts on both sides."""
    for n in meshes:
        mesh = system.records[KIND][n]
        row = elements[mesh.element]
        drive, back = FLANK + FLANK_SLOPES * DRIVE, FLANK + FLANK_SLOPES * BACK
        row[back + F] = row[back + F_P] = row[back + F_R] = 0.0
        row[drive + F] = row[drive + F] or LEAST
        row[drive + F_P] = mesh.k_m
        row[drive + F_R] = mesh.C_m if mesh.ramp == RAMP_CONSTANT else 0.0
