"""Coulomb friction of the teeth, against the actual sliding of the flanks in contact (docs/theory, T19).

One pair of teeth stands for all: it passes the pitch point where psi + pitch_phase = 2 pi n and hands over half a base pitch
later. Its contact lies at the way x from the pitch point along the line of action. With nu the gradient of the penetration by
the displacement of b and t = nu turned by 90 degrees, the flank of b slides on that of a at

    s = t . (v_b - v_a) - (omega_b q_b - omega_a q_a)

with v the velocities of the toothing centres and q the lever arms of t about them. b feels -mu F h(s / friction_speed) t at the
contact, h the regularised sign, a its opposite: the power of friction, -mu F h s, is never positive.
"""

import math
from typing import Any

from gearplay.kernels.arrays import Floats, Ints, Rows
from gearplay.kernels.compiled import compiled_inline
from gearplay.kernels.compiled_once import compiled_once
from gearplay.kernels.layout import FORCE, OPEN, Loads, System, spin_of, vx_of, vy_of
from gearplay.kernels.smooth_sign import smooth_sign
from gearplay.parts.mesh.geometry import (
    ARM_A_X,
    ARM_A_Y,
    ARM_B_X,
    ARM_B_Y,
    DISTANCE,
    E_X,
    E_Y,
    N_D_X,
    N_D_Y,
    PSI,
)
from gearplay.parts.mesh.law.record import DRIVE, KIND
from gearplay.parts.mesh.pairs.friction import SLIDING
from gearplay.parts.mesh.pairs.record import PAIR, SENSE


@compiled_inline
def next_pair(mesh: Any, pair: int) -> float:
    """Return the mesh phase psi [rad] at which pair number ``pair`` takes over."""
    return math.pi * (2 * pair - 1) - mesh.pitch_phase


@compiled_inline
def pair_of(mesh: Any, psi: float) -> int:
    """Return the number of the pair in contact at mesh phase psi [rad]."""
    return math.floor((psi + mesh.pitch_phase) / (2.0 * math.pi) + 0.5)


@compiled_inline
def way_of(mesh: Any, flank: int, psi: float, pair: int) -> float:
    """Return the way x [m] of a pair's contact from the pitch point along the line of action of a flank."""
    return (1.0 - 2.0 * flank) * mesh.way * (psi + mesh.pitch_phase - 2.0 * math.pi * pair)


@compiled_inline
def lever_arms(mesh: Any, flank: int, pair: int, out: Floats) -> tuple[float, float]:
    """Return the lever arms [m] of t at the contact about the toothing centres of a and of b."""
    x = way_of(mesh, flank, out[PSI], pair)
    nu_x, nu_y = out[N_D_X + 2 * flank], out[N_D_Y + 2 * flank]
    lever = out[DISTANCE] * (nu_x * out[E_X] + nu_y * out[E_Y]) / (mesh.rho_a + mesh.rho_b)
    return x - lever * mesh.rho_a, x + lever * mesh.rho_b


@compiled_once
def fill_sliding(system: System, n: int, y: Floats, modes: Ints, loads: Loads) -> None:
    """Fill the sliding speeds of mesh n's flanks in the contact table; the scratch holds its geometry."""
    mesh, out = system.records[KIND][n], loads.out
    a, b = mesh.a, mesh.b
    spin_a, spin_b = spin_of(system, a, y), spin_of(system, b, y)
    v_x = y[vx_of(system, b)] - spin_b * out[ARM_B_Y] - (y[vx_of(system, a)] - spin_a * out[ARM_A_Y])
    v_y = y[vy_of(system, b)] + spin_b * out[ARM_B_X] - (y[vy_of(system, a)] + spin_a * out[ARM_A_X])
    for flank in range(2):
        q_a, q_b = lever_arms(mesh, flank, modes[mesh.mode + PAIR], out)
        across = v_y * out[N_D_X + 2 * flank] - v_x * out[N_D_Y + 2 * flank]
        loads.contacts[mesh.contact + flank, SLIDING] = across - (spin_b * q_b - spin_a * q_a)


@compiled_once
def add_friction(system: System, n: int, modes: Ints, loads: Loads) -> None:
    """Add the friction of mesh n's flanks to the sums on its rotors, its rows of the contact table and the scratch filled."""
    out, force = loads.out, loads.rotors
    mesh = system.records[KIND][n]
    a, b = mesh.a, mesh.b
    for flank in range(2):
        row = loads.contacts[mesh.contact + flank]
        if row[FORCE] == 0.0:
            continue
        g = -mesh.friction * row[FORCE] * smooth_sign(row[SLIDING] / mesh.friction_speed)
        q_a, q_b = lever_arms(mesh, flank, modes[mesh.mode + PAIR], out)
        f_x, f_y = -g * out[N_D_Y + 2 * flank], g * out[N_D_X + 2 * flank]
        force[b, 0] += f_x
        force[b, 1] += f_y
        force[b, 2] += out[ARM_B_X] * f_y - out[ARM_B_Y] * f_x - g * q_b
        force[a, 0] -= f_x
        force[a, 1] -= f_y
        force[a, 2] -= out[ARM_A_X] * f_y - out[ARM_A_Y] * f_x - g * q_a


@compiled_inline
def friction_loss(mesh: Any, loads: Loads) -> float:
    """Return the power [W] that friction of a mesh's flanks takes, its rows of the contact table filled."""
    lost = 0.0
    for flank in range(2):
        row = loads.contacts[mesh.contact + flank]
        sliding = row[SLIDING]
        force = max(row[FORCE], 0.0)  # just before a located release it may be below 0 by rounding
        lost += mesh.friction * force * smooth_sign(sliding / mesh.friction_speed) * sliding
    return lost


@compiled_inline
def sense_of(mesh: Any, sliding: float) -> int:
    """Return the sense of a sliding speed [m/s], 0 where friction is not full."""
    if abs(sliding) < mesh.friction_speed:
        return 0
    return 1 if sliding > 0.0 else -1


@compiled_inline
def sense_switch(mesh: Any, c: int, modes: Ints, contacts: Rows) -> float:
    """Return how far [m/s] the sliding speed of contact c is beyond the edge of its sense; negative where it is open."""
    if modes[mesh.contact + c] == OPEN:
        return -1.0
    sliding, sense = contacts[mesh.contact + c, SLIDING], modes[mesh.mode + SENSE + c]
    return abs(sliding) - mesh.friction_speed if sense == 0 else mesh.friction_speed - sense * sliding


@compiled_inline
def switch_sense(mesh: Any, c: int, modes: Ints, contacts: Rows) -> None:
    """Pass the edge of the sense of contact c."""
    slot = mesh.mode + SENSE + c
    if modes[slot] != 0:
        modes[slot] = 0
    else:
        modes[slot] = 1 if contacts[mesh.contact + c, SLIDING] > 0.0 else -1


@compiled_once
def change_pair(system: System, n: int, pair: int, y: Floats, modes: Ints, contacts: Rows) -> None:
    """Let a pair of teeth be the one in contact: sliding speeds in the contact table and senses follow."""
    mesh = system.records[KIND][n]
    slot = mesh.mode + PAIR
    # x changes by whole base pitches, and s by -(omega_b - omega_a) x.
    further = 2.0 * math.pi * mesh.way * (pair - modes[slot])
    further *= spin_of(system, mesh.b, y) - spin_of(system, mesh.a, y)
    modes[slot] = pair
    for flank in range(2):
        row = mesh.contact + flank
        contacts[row, SLIDING] += further if flank == DRIVE else -further
        modes[mesh.mode + SENSE + flank] = sense_of(mesh, contacts[row, SLIDING])
