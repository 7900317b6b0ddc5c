"""Signals of the housing's motion: an element without forces or contacts (`kernels.housing_motion` applies the motion)."""

import numpy as np

from gearplay.kernels.arrays import Floats, Rows
from gearplay.kernels.compiled_once import compiled_once
from gearplay.kernels.housing_motion import COSINE, SINE, base_acceleration
from gearplay.kernels.layout import PLACES, Branch, Loads, Signal, System

KIND = 6
RECORD = np.dtype([*PLACES], align=True)
SIGNALS = (
    Signal("base_ax", "ax", "m/s^2", "m/s^2", 1.0, "acceleration of the housing along x", True),
    Signal("base_ay", "ay", "m/s^2", "m/s^2", 1.0, "acceleration of the housing along y", True),
)
MEMORY: tuple[float, ...] = ()
MODES = 0
PER_CONTACT = 0
SLOPES = 0


@compiled_once
def apply_forces(
    system: System, n: int, t: float, y: Floats, branch: Branch, loads: Loads, dy: Floats
) -> int:
    """Return 0: the right-hand side itself lets the housing's motion act."""
    return 0


@compiled_once
def linearise(system: System, n: int, t: float, y: Floats, branch: Branch, loads: Loads, row: Floats) -> int:
    """Return 0: nothing depends on the state."""
    return 0


@compiled_once
def add_change(
    system: System, n: int, row: Floats, z: Floats, branch: Branch, force: Rows, dz: Floats
) -> None:
    """Add nothing: nothing depends on the state."""


@compiled_once
def observe(
    system: System, n: int, t: float, y: Floats, branch: Branch, loads: Loads, acting: bool, row: Floats
) -> None:
    """Fill the housing's signals of a full ``row`` at t."""
    at, a = system.records[KIND][n].signal, base_acceleration(system, t)
    row[at], row[at + 1] = a * system.base[COSINE], a * system.base[SINE]
