"""Signals of a result at one instant, from the state alone: for sections and maps, where nothing is sampled."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gearplay.kernels.layout import OUT_SIZE, System
from gearplay.kernels.mesh import mesh_gaps
from gearplay.kernels.sleeve import sleeve_geometry
from gearplay.model.pack import Packed
from gearplay.solver.trajectory import Column, choose_columns
from gearplay.vocabulary.errors import Fault, InputError

Floats = NDArray[np.float64]
ROTOR = ("x", "y", "theta", "vx", "vy", "omega")
MESH = {
    "drive_penetration": 0,
    "back_penetration": 1,
    "center_distance": 8,
    "backlash": 10,
    "transmission_error_dynamic": 11,
}
SLEEVE = {"sleeve_penetration": 0}


def state_names(packed: Packed) -> tuple[str, ...]:
    """Return the names of a state's entries in their order, ``rotor.signal``; integrals of servos, the last ones, have none."""
    return tuple(
        f"{rotor}.{name}" for part in (ROTOR[:3], ROTOR[3:]) for rotor in packed.rotor_names for name in part
    )


class Observables:
    """Chosen signals as functions of time and state.

    Names are those of a result, ``element.signal`` or a signal of all its elements; those that need forces are not among them.
    Rotations and speeds count from the nominal ones.

    Raises `InputError` for a name that is no such signal.
    """

    def __init__(self, packed: Packed, names: Sequence[str]) -> None:
        self.columns, _ = choose_columns(packed, list(names))
        places = {name: at for at, name in enumerate(state_names(packed))}
        known = {"rotor": dict.fromkeys(ROTOR, 0), "mesh": MESH, "sleeve": SLEEVE}
        for column in self.columns:
            if column.signal not in known[column.dimension]:
                rule = "must follow from the state alone"
                every = ", ".join(name for names_ in known.values() for name in names_)
                raise InputError(Fault("signals", column.signal, rule, f"Choose from: {every}"))
        elements = {"rotor": packed.rotor_names, "mesh": packed.mesh_names, "sleeve": packed.sleeve_names}
        self.places = [
            (
                c.dimension,
                elements[c.dimension].index(c.label),
                places[_name(c)] if c.dimension == "rotor" else known[c.dimension][c.signal],
            )
            for c in self.columns
        ]
        self.out = np.zeros(OUT_SIZE)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the signals, ``element.signal``."""
        return tuple(_name(column) for column in self.columns)

    def __call__(self, system: System, t: float, y: Floats) -> Floats:
        """Return the signals at time t [s] and state y, shape [signal]; NaN for a mesh whose gears cannot mesh there."""
        found = np.empty(len(self.places))
        for at, (dimension, element, slot) in enumerate(self.places):
            if dimension == "rotor":
                found[at] = y[slot]
                continue
            if dimension == "mesh":
                if mesh_gaps(system, element, t, y, self.out) != 0:
                    found[at] = np.nan
                    continue
            else:
                sleeves: Any = system.sleeves
                sleeve_geometry(sleeves[element], system, t, y, self.out)
            found[at] = self.out[slot]
        return found


def _name(column: Column) -> str:
    return f"{column.label}.{column.signal}"
