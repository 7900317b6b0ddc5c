"""A pair of teeth as an element without forces of its own: the signals of one slot of a mesh with pairs.

Its forces are those of its mesh; this element is observed where its signals are wanted.
"""

import math

import numpy as np

from gearplay.kernels.arrays import Floats, Ints, Rows
from gearplay.kernels.compiled import compiled_inline
from gearplay.kernels.compiled_once import compiled_once
from gearplay.kernels.layout import LOADED, OPEN, PLACES, Branch, Loads, Signal, System
from gearplay.parts.mesh.geometry import MESH, mesh_geometry
from gearplay.parts.mesh.pairs.forces import first_pair, oblique_sums, pair_force
from gearplay.parts.mesh.pairs.oblique import oblique_force
from gearplay.parts.mesh.pairs.overlap import AWAY, overlap_rate, pair_overlap

KIND = 9
RECORD = np.dtype([*PLACES, ("mesh", "i8"), ("flank", "i8"), ("slot", "i8")], align=True)
SIGNALS = (
    Signal("pair_force", "F_j", "N", "N", 1.0, "force of a pair of teeth along the line of action"),
    Signal("pair_share", "F_j/F", "1", "1", 1.0, "share of a pair of teeth in the force of its flank"),
    Signal("pair_overlap", "p_j", "m", "um", 1e6, "overlap of a pair of teeth, negative for a gap", True),
    Signal("pair_place", "rho_j", "m", "mm", 1e3, "place of a pair of teeth on its path of contact", True),
)
MEMORY: tuple[float, ...] = ()
MODES = 0
PER_CONTACT = 0
SLOPES = 0


@compiled_inline
def apply_forces(
    system: System, n: int, t: float, y: Floats, branch: Branch, loads: Loads, dy: Floats
) -> int:
    """Return 0: the mesh adds the forces."""
    return 0


@compiled_inline
def linearise(system: System, n: int, t: float, y: Floats, branch: Branch, loads: Loads, row: Floats) -> int:
    """Return 0: the mesh has the slopes."""
    return 0


@compiled_inline
def add_change(
    system: System, n: int, row: Floats, z: Floats, branch: Branch, force: Rows, dz: Floats
) -> None:
    """Add nothing."""


@compiled_inline
def _force(system: System, number: int, flank: int, slot: int, modes: Ints, out: Floats) -> float:
    """Return the force [N] of the pair in a slot of a mesh, `mesh_geometry` in the scratch; never below 0."""
    mesh = system.records[MESH][number]
    pair = pair_overlap(mesh, system, out, flank, slot)
    if modes[first_pair(mesh, flank) + slot] != LOADED or pair.touching == AWAY:
        return 0.0
    rate, worn, rate_1, rate_2 = overlap_rate(mesh, out, flank, pair)
    if mesh.varies == 1:
        sums = oblique_sums(mesh, system, flank, pair, rate, worn, rate_1, rate_2)
        return max(oblique_force(mesh, pair.p, sums)[0], 0.0)
    return max(pair_force(mesh, system, flank, pair, rate)[0], 0.0)


@compiled_once
def observe(
    system: System, n: int, t: float, y: Floats, branch: Branch, loads: Loads, acting: bool, row: Floats
) -> None:
    """Fill the signals of a pair of teeth in a full ``row`` at (t, y)."""
    each = system.records[KIND][n]
    mesh, out, at = system.records[MESH][each.mesh], loads.out, each.signal
    if mesh_geometry(system, each.mesh, t, y, branch.memory, out) != 0:
        for k in range(4):
            row[at + k] = math.nan
        return
    pair = pair_overlap(mesh, system, out, each.flank, each.slot)
    force, total = 0.0, 0.0
    if branch.modes[mesh.contact + each.flank] != OPEN:
        for slot in range(mesh.pairs):
            one = _force(system, each.mesh, each.flank, slot, branch.modes, out)
            force = one if slot == each.slot else force
            total += one
    row[at], row[at + 1] = force, force / total if total > 0.0 else 0.0
    row[at + 2], row[at + 3] = pair.penetration, pair.place
