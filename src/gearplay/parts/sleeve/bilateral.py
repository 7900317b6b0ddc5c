"""Bushes without clearance, in linear analysis springs in all directions."""

from collections.abc import Iterable

import numpy as np

from gearplay.kernels.arrays import Floats
from gearplay.kernels.layout import OUT_SIZE, System
from gearplay.parts.sleeve.law import DELTA, INV_L, KIND, N_D, N, sleeve_geometry

NO_GAP = 1e-12
"""Displacement [m] that is none."""


def linear_bushes(system: System) -> tuple[int, ...]:
    """Return the bushes without clearance whose law is linear."""
    sleeves = system.records[KIND]
    linear = (sleeves["clearance"] == 0.0) & (sleeves["exponent"] == 1.0) & (sleeves["bed"] == 0)
    return tuple(np.flatnonzero(linear).tolist())


def centred_as_springs(system: System, elements: Floats, state: Floats, bushes: Iterable[int]) -> bool:
    """Give `linear_bushes` with the journal in their centre the slopes of springs; return whether any is new.

    ``elements`` are rows of slopes at ``state``.
    """
    changed, sleeves = False, system.records[KIND]
    for n in bushes:
        sleeve, out = sleeves[n], np.zeros(OUT_SIZE)
        sleeve_geometry(system, n, 0.0, state, out)
        if out[DELTA] <= NO_GAP:
            row = elements[sleeve["element"]]
            row[N], row[N_D], row[INV_L] = sleeve["stiffness"] * NO_GAP, sleeve["stiffness"], 1.0 / NO_GAP
            changed = True
    return changed
