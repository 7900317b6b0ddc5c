"""Acceleration of the housing: states are relative to it, so it acts on every free centre like gravity turned round.

One of three kinds, along one direction: a sine, half a sine, a record as a cubic spline over equal steps (docs/theory,
section 4). `pull` is gravity and base motion together.
"""

import math

from gearplay.kernels.compiled import compiled_inline
from gearplay.kernels.layout import System

NONE, HARMONIC, HALF_SINE, RECORD = range(4)
# Slots of System.base: direction, amplitude (of a record what it cannot exceed) [m/s^2], angular frequency [rad/s] that steps
# must resolve, phase at t = 0, when it begins and ends [s], step of the record [s], its pieces, the first of `System.record`.
KIND, COSINE, SINE, AMPLITUDE, RATE, PHASE, START, END, STEP, COUNT = range(10)
SLOTS = 10


@compiled_inline
def recorded(system: System, first: int, count: int, start: float, step: float, t: float) -> float:
    """Return the value at t [s] of a record of ``count`` pieces of `System.record`, from ``start`` on; 0 outside it."""
    if t < start or t > start + step * count:
        return 0.0
    at = (t - start) / step
    piece = min(int(at), count - 1)
    u, c = at - piece, system.record[first + piece]
    return float(c[0] + u * (c[1] + u * (c[2] + u * c[3])))


@compiled_inline
def base_acceleration(system: System, t: float) -> float:
    """Return the acceleration [m/s^2] of the housing along its direction at t [s]."""
    base, kind = system.base, system.base[KIND]
    if kind == NONE or t < base[START] or t > base[END]:
        return 0.0
    if kind == RECORD:
        return recorded(system, 0, int(base[COUNT]), base[START], base[STEP], t)
    return float(base[AMPLITUDE] * math.sin(base[RATE] * (t - base[START]) + base[PHASE]))


@compiled_inline
def pull(system: System, t: float) -> tuple[float, float]:
    """Return gravity less the acceleration of the housing [m/s^2] along x and y at t [s]."""
    a = base_acceleration(system, t)
    return system.gravity[0] - a * system.base[COSINE], system.gravity[1] - a * system.base[SINE]


@compiled_inline
def shakes(system: System, t: float) -> bool:
    """Return whether the housing is accelerated now or later."""
    return bool(system.base[KIND] != NONE and t < system.base[END])
