"""What is sampled: signals computed from the state and its modes, for the elements whose signals are kept."""

import math

import numpy as np
from numpy.typing import NDArray

from gearplay.kernels.compiled import compiled_inline
from gearplay.kernels.flight import flight_rates
from gearplay.kernels.layout import (
    ACTIVE,
    FLYING,
    FORCE,
    FORCE_X,
    FORCE_Y,
    OPEN,
    PENETRATION,
    TOUCHING,
    System,
)
from gearplay.kernels.mesh import mesh_gaps
from gearplay.kernels.ripple import follow_ripple
from gearplay.kernels.run_state import PER_MESH, PER_ROTOR, PER_SLEEVE, Motion
from gearplay.kernels.sleeve import sleeve_geometry

Floats = NDArray[np.float64]


@compiled_inline
def observe_rotor(system: System, motion: Motion, i: int, t: float) -> None:
    """Fill rotor i's signals in ``row`` from y_try, and from dy_try where it is integrated."""
    n, y, row = system.rotors.size, motion.y_try, motion.row
    at, p, v = PER_ROTOR * i, 3 * i, 3 * (n + i)
    omega = system.rotors[i].nominal_speed
    if system.rotors[i].ripple_count > 0:
        follow_ripple(system, i, t, y)  # the interpolant of a step is not exact
    row[at], row[at + 1], row[at + 2] = y[p], y[p + 1], omega * t + y[p + 2]
    row[at + 3], row[at + 4], row[at + 5] = y[v], y[v + 1], omega + y[v + 2]
    a_x, a_y = 0.0, 0.0
    if motion.roster.roles[i] == ACTIVE:
        a_x, a_y = motion.dy_try[v], motion.dy_try[v + 1]
    elif motion.roster.roles[i] == FLYING:
        a_x, a_y, _ = flight_rates(system, i, y[v], y[v + 1], y[v + 2])
    row[at + 6], row[at + 7] = a_x, a_y


@compiled_inline
def observe_sleeve(system: System, motion: Motion, k: int, t: float) -> None:
    """Fill sleeve k's signals in ``row``."""
    at = PER_ROTOR * system.rotors.size + PER_SLEEVE * k
    row, contacts, out = motion.row, motion.contacts_try, motion.out
    if motion.roster.doings[k] == TOUCHING:
        row[at] = contacts[k, PENETRATION]
        row[at + 1], row[at + 2] = contacts[k, FORCE_X], contacts[k, FORCE_Y]
        return
    sleeve_geometry(system.sleeves[k], system, t, motion.y_try, out)
    row[at], row[at + 1], row[at + 2] = out[0], 0.0, 0.0


@compiled_inline
def observe_mesh(system: System, motion: Motion, j: int, t: float) -> None:
    """Fill mesh j's signals in ``row``.

    A flank force never pulls: the last ulp before a located release is cut at zero. contact_state counts 1 for a
    touching drive flank and 2 for a touching back flank.
    """
    n_s = system.sleeves.size
    at = PER_ROTOR * system.rotors.size + PER_SLEEVE * n_s + PER_MESH * j
    row, modes, out = motion.row, motion.modes, motion.out
    mesh_gaps(system, j, t, motion.y_try, out)
    drive, back = n_s + 2 * j, n_s + 2 * j + 1
    row[at], row[at + 1], row[at + 2], row[at + 3] = out[0], out[1], 0.0, 0.0
    if motion.roster.doings[n_s + j] == TOUCHING:
        for flank in range(2):
            force = motion.contacts_try[drive + flank, FORCE]
            row[at + 2 + flank] = 0.0 if force < 0.0 and out[flank] < 1e-15 else force
    row[at + 4], row[at + 5] = out[10], math.asin(out[9])
    row[at + 6], row[at + 7] = out[8], out[11]
    row[at + 8] = (1.0 if modes[drive] != OPEN else 0.0) + (2.0 if modes[back] != OPEN else 0.0)
