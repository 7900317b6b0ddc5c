"""Coulomb friction of the teeth: across the line of action, against the sliding of the flanks (docs/theory, section 2).

One pair of teeth stands for all: it passes the pitch point at psi + phase = 0 and hands over half a base pitch after it. With x
its way from there along the line of action, e = -nu the direction of that, t across it, the flanks slide at
(omega_b - omega_a) x, and b feels -mu F S t at x, S the sign of that. It changes at the pitch point and at the hand-over, where
mu F S x does not jump.
"""

import math
from typing import Any

from gearplay.kernels.arrays import Floats, Ints
from gearplay.kernels.compiled import compiled_inline
from gearplay.kernels.compiled_once import compiled_once
from gearplay.kernels.elements.mesh.record import HALF_WAVE, KIND
from gearplay.kernels.layout import FORCE, Loads, System, spin_of, vx_of, vy_of
from gearplay.kernels.mesh_geometry import (
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
from gearplay.kernels.smooth_sign import smooth_sign, smooth_sign_slope

# Columns of a flank's slopes: mu S, its slope by omega_b - omega_a, the way x [m].
GRIP, GRIP_SLOPE, WAY = range(3)
COLUMNS = 3


@compiled_inline
def half_wave_edge(mesh: Any, half_wave: int) -> float:
    """Return the mesh phase psi [rad] at which a half-wave begins: at a pitch point where it is even, else at a hand-over."""
    return math.pi * half_wave - mesh.pitch_phase


@compiled_inline
def half_wave_of(mesh: Any, psi: float) -> int:
    """Return the half-wave that holds the mesh phase psi [rad]."""
    return math.floor((psi + mesh.pitch_phase) / math.pi)


@compiled_inline
def way_of(mesh: Any, flank: int, psi: float, half_wave: int) -> float:
    """Return the way x [m] of the contact from the pitch point along the line of action of a flank, in a half-wave."""
    turned = psi + mesh.pitch_phase - 2.0 * math.pi * ((half_wave + 1) // 2)
    return (1.0 - 2.0 * flank) * mesh.way * turned


@compiled_inline
def grip_of(system: System, mesh: Any, flank: int, half_wave: int, y: Floats) -> tuple[float, float]:
    """Return mu S of a flank in a half-wave, and its slope by omega_b - omega_a [s/rad]."""
    sign = (1.0 - 2.0 * flank) * math.copysign(1.0, mesh.way)
    if half_wave % 2 == 1:
        sign = -sign
    # At half the largest way, so that friction is full where the flanks slide by more than its speed.
    scale = 0.5 * math.pi * abs(mesh.way) / mesh.friction_speed
    u = scale * (spin_of(system, mesh.b, y) - spin_of(system, mesh.a, y))
    return sign * mesh.friction * smooth_sign(u), sign * mesh.friction * scale * smooth_sign_slope(u)


@compiled_inline
def rub(
    system: System, mesh: Any, flank: int, half_wave: int, y: Floats, loads: Loads
) -> tuple[float, float, float]:
    """Return mu F S of a flank [N], and the lever arms [m] of t there about the toothings of a and of b."""
    out = loads.out
    grip, _ = grip_of(system, mesh, flank, half_wave, y)
    x = way_of(mesh, flank, out[PSI], half_wave)
    nu_x, nu_y = out[N_D_X + 2 * flank], out[N_D_Y + 2 * flank]
    lever = out[DISTANCE] * (nu_x * out[E_X] + nu_y * out[E_Y]) / (mesh.rho_a + mesh.rho_b)
    return grip * loads.contacts[mesh.contact + flank, FORCE], x - lever * mesh.rho_a, lever * mesh.rho_b + x


@compiled_once
def add_friction(system: System, n: int, y: Floats, modes: Ints, loads: Loads) -> None:
    """Add the friction of mesh n's flanks to the sums on its rotors, its rows of the contact table and the scratch filled."""
    out, force = loads.out, loads.rotors
    mesh = system.records[KIND][n]
    a, b, half_wave = mesh.a, mesh.b, modes[mesh.mode + HALF_WAVE]
    for flank in range(2):
        if loads.contacts[mesh.contact + flank, FORCE] == 0.0:
            continue
        g, arm_a, arm_b = rub(system, mesh, flank, half_wave, y, loads)
        f_x, f_y = -g * out[N_D_Y + 2 * flank], g * out[N_D_X + 2 * flank]
        force[b, 0] += f_x
        force[b, 1] += f_y
        force[b, 2] += out[ARM_B_X] * f_y - out[ARM_B_Y] * f_x - g * arm_b
        force[a, 0] -= f_x
        force[a, 1] -= f_y
        force[a, 2] -= out[ARM_A_X] * f_y - out[ARM_A_Y] * f_x - g * arm_a


@compiled_once
def friction_loss(system: System, n: int, y: Floats, modes: Ints, loads: Loads) -> float:
    """Return the power [W] that friction of mesh n's flanks takes, its rows of the contact table and the scratch filled."""
    out, mesh = loads.out, system.records[KIND][n]
    a, b, half_wave, lost = mesh.a, mesh.b, modes[mesh.mode + HALF_WAVE], 0.0
    spin_a, spin_b = spin_of(system, a, y), spin_of(system, b, y)
    v_x = y[vx_of(system, b)] - spin_b * out[ARM_B_Y] - (y[vx_of(system, a)] - spin_a * out[ARM_A_Y])
    v_y = y[vy_of(system, b)] + spin_b * out[ARM_B_X] - (y[vy_of(system, a)] + spin_a * out[ARM_A_X])
    for flank in range(2):
        if loads.contacts[mesh.contact + flank, FORCE] == 0.0:
            continue
        g, arm_a, arm_b = rub(system, mesh, flank, half_wave, y, loads)
        sliding = v_x * out[N_D_Y + 2 * flank] - v_y * out[N_D_X + 2 * flank]
        lost += g * (sliding + (spin_b * arm_b - spin_a * arm_a))
    return lost
