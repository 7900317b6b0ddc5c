"""Deviations of teeth in a mesh with one stiffness: the envelope over its pairs.

A flank touches where the pair of most material does, its lead: the deepest of the pairs within reach, corners of entering and
leaving tips included. Its force is K(psi) p + C(p) dp/dt with the lead's overlap p, along the line of action of the actual
centres: gaps of corners are deviations here, so that the force of an undamped flank is continuous where another pair takes the
lead. Such a change is a switch of the flank.
"""

import math
from typing import Any

from gearplay.kernels.arrays import Floats
from gearplay.kernels.compiled import compiled_inline
from gearplay.kernels.compiled_once import compiled_once
from gearplay.kernels.layout import (
    FORCE,
    FORCE_Y,
    LOADED,
    MARGIN,
    OPEN,
    PENETRATION,
    RATE,
    Branch,
    Loads,
    System,
)
from gearplay.parts.mesh.flank import flank_force
from gearplay.parts.mesh.geometry import (
    COS_PSI,
    ERROR_RATE,
    MESH,
    P_D_RATE,
    PAIRS_LOST,
    PAIRS_PUT_IN,
    PSI,
    PSI_RATE,
    PULL_1,
    PULL_2,
    PULL_A,
    SIN_PSI,
    SIN_W,
    fill_psi,
)
from gearplay.parts.mesh.pairs.friction import SLIDING, arms_of, grip_of, sliding_of
from gearplay.parts.mesh.pairs.overlap import (
    largest_overlap,
    line_of_flank,
    modulo,
    numbered_pair,
    overlap_rate,
    pair_overlap,
    penetration_rate,
    pitches_ahead,
    sense,
)
from gearplay.parts.mesh.pairs.record import FLANKS, LEAD, SEGMENT
from gearplay.parts.mesh.tooth_stiffness import mesh_stiffness, stiffness_slope

LAG = FORCE_Y
"""Column of a flank's row of the contact table: overlap of the deepest other pair less that of the lead [m], -1 while open."""


@compiled_inline
def deepest_slot(mesh: Any, system: System, out: Floats, flank: int, other: int) -> tuple[int, float]:
    """Return the slot of a flank's deepest pair but that in slot ``other``, -1 for all, and its penetration [m].

    From mid-path outwards; a pair is evaluated where its `largest_overlap` exceeds the penetration found so far.
    """
    line = line_of_flank(mesh, out, flank)
    half = 0.5 * mesh.pairs
    ahead = pitches_ahead(mesh, line)
    nearest = math.floor(0.5 - ahead)
    found, deepest = -1, -math.inf
    for step in range(mesh.pairs):
        number = nearest + ((step + 1) // 2 if step % 2 == 1 else -(step // 2))
        if ahead + number >= half:
            number -= mesh.pairs
        slot = modulo(number, float(mesh.pairs))
        if slot == other or largest_overlap(mesh, system, out, flank, line, number) <= deepest:
            continue
        penetration = numbered_pair(mesh, system, out, flank, line, number).penetration
        if penetration > deepest:
            found, deepest = slot, penetration
    return found, deepest


@compiled_inline
def lead_of(mesh: Any, system: System, out: Floats, flank: int, branch: Branch) -> int:
    """Return the slot of the pair that is a flank's lead: as its mode has it, the deepest one while it is open."""
    if branch.modes[mesh.contact + flank] == OPEN:
        return deepest_slot(mesh, system, out, flank, -1)[0]
    return int(branch.modes[mesh.mode + LEAD + flank])


@compiled_once
def press_envelope(system: System, n: int, branch: Branch, loads: Loads, whole: bool) -> None:
    """Fill mesh n's rows of the contact table and the sums over its flanks' leads, `mesh_geometry` in the scratch.

    Unless ``whole`` an open flank has its force alone, a closed one no `LAG`.
    """
    mesh, out, contacts, modes = system.records[MESH][n], loads.out, loads.contacts, branch.modes
    fill_psi(mesh, branch.memory, out)
    segment = modes[mesh.mode + SEGMENT]
    k_mesh = mesh_stiffness(mesh, system, out[PSI], out[COS_PSI], out[SIN_PSI], segment)
    k_slope = stiffness_slope(mesh, system, out[PSI], out[COS_PSI], out[SIN_PSI])
    pull_a, pull_1, pull_2, lost, put_in = 0.0, 0.0, 0.0, 0.0, 0.0
    for flank in range(FLANKS):
        k, m = mesh.contact + flank, sense(mesh, flank)
        if modes[k] == OPEN and not whole:
            contacts[k, FORCE] = 0.0
            continue
        error_rate = out[ERROR_RATE] if flank == 0 else -out[ERROR_RATE]
        lead = lead_of(mesh, system, out, flank, branch)
        pair = pair_overlap(mesh, system, out, flank, lead)
        rate, _, rate_1, _ = overlap_rate(mesh, out, flank, pair)
        p, moving = pair.penetration, penetration_rate(pair, rate, rate_1)
        contacts[k, PENETRATION], contacts[k, RATE] = p, moving
        contacts[k, LAG] = -1.0
        if modes[k] != OPEN and whole:
            contacts[k, LAG] = deepest_slot(mesh, system, out, flank, lead)[1] - p
        past = modes[mesh.mode + flank]
        force, contacts[k, MARGIN] = flank_force(mesh, k_mesh, p, moving, past, flank)
        contacts[k, FORCE] = force if modes[k] == LOADED else 0.0
        if mesh.friction > 0.0:
            contacts[k, SLIDING] = sliding_of(mesh, out, flank, pair)
        if modes[k] == OPEN:
            continue
        force = contacts[k, FORCE]
        lost += (force - k_mesh * p) * moving
        # All that the overlap has beyond the involutes' is a deviation.
        put_in += force * (moving - out[P_D_RATE + flank] + error_rate)
        put_in += 0.5 * k_slope * out[PSI_RATE] * p * p
        pull_a += force * mesh.s * out[SIN_W]
        pull_1 += m * force * mesh.base_1
        pull_2 -= m * force * mesh.s * mesh.base_2
        if mesh.friction > 0.0 and force > 0.0:
            s_a, s_1, s_2 = arms_of(mesh, out, pair)
            grip = force * grip_of(mesh, contacts[k, SLIDING])[0]
            pull_a += grip * s_a
            pull_1 += m * grip * s_1
            pull_2 += m * grip * s_2
            lost += grip * contacts[k, SLIDING]
    out[PULL_A], out[PULL_1], out[PULL_2] = pull_a, pull_1, pull_2
    out[PAIRS_LOST], out[PAIRS_PUT_IN] = lost, put_in
