"""Classification of modes: by symmetry for planetary sets, else by the moving parts."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gearplay.linear.system import LinearSystem, Shapes
from gearplay.parts.mesh.train import geometry

Floats = NDArray[np.float64]

LITTLE = 1e-3
"""Share of kinetic energy that counts as none."""


def kinds_of(system: LinearSystem, shapes: Shapes) -> list[str]:
    """Return the kind of each mode.

    In a planetary set with equal spacing modes are rotational (sun, ring and carrier only turn), translational (they only move
    sideways; such modes come in pairs) or planet modes (only planets move): J. Lin, R. G. Parker, J. Vib. Acoust. 121 (1999) 319.
    Those of a set that lacks the symmetry, under gravity for example, are mixed. Without planets: torsional, lateral or coupled.
    """
    names, case = system.linear.smooth.packed.rotor_names, system.case
    planets = {name for name in names if geometry.carrier_of(case, name) is not None}
    energy = system.mass * np.abs(shapes) ** 2
    energy = energy / energy.sum(axis=1, keepdims=True)
    rotor = np.array([name.rpartition(".")[0] for name in system.coordinates])
    turns = np.array([name.endswith(".theta") for name in system.coordinates])
    carried = np.isin(rotor, sorted(planets))
    found = []
    for shares in energy:
        across = float(shares[~turns & ~carried].sum())
        around = float(shares[turns & ~carried].sum())
        if planets:
            kind = (
                "planet" if across + around < LITTLE else
                "rotational" if across < LITTLE else
                "translational" if around < LITTLE else "mixed"
            )  # fmt: skip
        else:
            kind = "torsional" if across < LITTLE else "lateral" if around < LITTLE else "coupled"
        found.append(kind)
    return found


def multiplicities(frequencies: Floats) -> NDArray[np.int64]:
    """Return how many modes share each frequency [Hz], to a part in a million of it, shape [mode]."""
    size = max(1e-9, float(np.max(frequencies, initial=0.0)))
    near = np.abs(frequencies[:, None] - frequencies[None, :])
    return np.asarray(np.sum(near <= 1e-6 * np.maximum(frequencies[:, None], 1e-3 * size), axis=1))
