"""What is sampled: one row of signals computed from the state and its modes."""

import math

import numpy as np
from numpy.typing import NDArray

from gearplay.kernels.compiled import compiled
from gearplay.kernels.layout import FORCE, FORCE_X, FORCE_Y, OPEN, PENETRATION, System
from gearplay.kernels.mesh import mesh_geometry
from gearplay.kernels.motion import right_hand_side

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

PER_ROTOR, PER_SLEEVE, PER_MESH = 8, 3, 9
ROTOR_STATES = 6  # of the 8: the accelerations need the forces


@compiled
def signal_count(system: System) -> int:
    """Return the length of a full row: 8 signals a rotor, 3 a sleeve, 9 a mesh (names in `layout`)."""
    return int(
        PER_ROTOR * system.rotors.size + PER_SLEEVE * system.sleeves.size + PER_MESH * system.meshes.size
    )


@compiled
def observe_rotors(system: System, t: float, y: Floats, row: Floats) -> None:
    """Fill the part of ``row`` that the state alone gives: each rotor's x, y, theta, vx, vy, omega."""
    n = system.rotors.size
    for i in range(n):
        at = PER_ROTOR * i
        omega = system.rotors[i].nominal_speed
        row[at], row[at + 1], row[at + 2] = y[3 * i], y[3 * i + 1], omega * t + y[3 * i + 2]
        row[at + 3], row[at + 4] = y[3 * (n + i)], y[3 * (n + i) + 1]
        row[at + 5] = omega + y[3 * (n + i) + 2]


def needs_only_the_state(columns: Ints, rotors: int) -> bool:
    """Return whether the kept columns are all states, so that sampling need not evaluate forces."""
    return bool(np.all((columns < PER_ROTOR * rotors) & (columns % PER_ROTOR < ROTOR_STATES)))


@compiled
def observe(
    system: System,
    t: float,
    y: Floats,
    modes: Ints,
    latch: Floats,
    dy: Floats,
    contacts: Floats,
    force: Floats,
    out: Floats,
    row: Floats,
) -> int:
    """Fill ``row`` with every signal at (t, y); return 0, or 1 where a pair cannot mesh.

    Order: rotors by `ROTOR_SIGNALS`, then sleeves by `SLEEVE_SIGNALS`, then meshes by `MESH_SIGNALS`. A flank
    force never pulls: the last ulp before a located release is cut at zero. contact_state counts 1 for a
    touching drive flank and 2 for a touching back flank.
    """
    if right_hand_side(system, t, y, modes, latch, dy, contacts, force, out) != 0:
        return 1
    n, n_s = system.rotors.size, system.sleeves.size
    observe_rotors(system, t, y, row)
    for i in range(n):
        row[PER_ROTOR * i + 6], row[PER_ROTOR * i + 7] = dy[3 * (n + i)], dy[3 * (n + i) + 1]
    at = PER_ROTOR * n
    for k in range(n_s):
        row[at] = contacts[k, PENETRATION]
        row[at + 1], row[at + 2] = contacts[k, FORCE_X], contacts[k, FORCE_Y]
        at += PER_SLEEVE
    for j in range(system.meshes.size):
        mesh_geometry(system, j, t, y, out)
        drive, back = n_s + 2 * j, n_s + 2 * j + 1
        row[at], row[at + 1] = contacts[drive, PENETRATION], contacts[back, PENETRATION]
        row[at + 2], row[at + 3] = contacts[drive, FORCE], contacts[back, FORCE]
        if row[at + 2] < 0.0 and row[at] < 1e-15:
            row[at + 2] = 0.0
        if row[at + 3] < 0.0 and row[at + 1] < 1e-15:
            row[at + 3] = 0.0
        row[at + 4], row[at + 5] = out[10], math.asin(out[9])
        row[at + 6], row[at + 7] = out[8], out[11]
        row[at + 8] = (1.0 if modes[drive] != OPEN else 0.0) + (2.0 if modes[back] != OPEN else 0.0)
        at += PER_MESH
    return 0
