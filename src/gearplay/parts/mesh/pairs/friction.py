"""Coulomb friction of a pair of teeth against its own sliding (docs/theory, T19).

The pair touches at one point P. With n the gradient of its overlap by the displacement of the second gear and t = n turned by 90
degrees, the second flank slides on the first at

    s = t . (v_2 - v_1)(P) = s_A dA/dt + s_1 a_1' + s_2 a_2',

linear in the rates of the centre distance A and of both gears' angles against the line of centres: s_1, s_2 [m] are the lever
arms of t about the gears, s_A its share along the line of centres. Friction has the generalised forces
-mu F h(s / friction_speed) (s_A, s_1, s_2), h the regularised sign; its power -mu F h s is never positive.
"""

import math
from typing import Any

from gearplay.kernels.arrays import Floats
from gearplay.kernels.compiled import compiled_inline
from gearplay.kernels.layout import FORCE_X
from gearplay.kernels.smooth_sign import smooth_sign, smooth_sign_slope
from gearplay.parts.mesh.geometry import DISTANCE, DISTANCE_RATE, SIN_W
from gearplay.parts.mesh.pairs.overlap import ON_FLANK, TIP_OF_1, TIP_OF_2, Pair, turn_rates

SLIDING = FORCE_X
"""Column of a contact's row of the contact table: sliding speed s [m/s]."""


@compiled_inline
def sliding_arms(
    s: float, A: float, tip_1: float, tip_2: float, touching: int, by_a: float, p_1: float, p_2: float, rho_1: float
) -> tuple[float, float, float]:  # fmt: skip
    """Return s_A, s_1 [m] and s_2 [m] of a pair; ``by_a``, ``p_1``, ``p_2`` are the slopes of its overlap.

    Flank on flank s_1 = rho_1. A corner is as far from its own centre as its tip circle. Both gears touch at one point:
    s_1 + s_2 = -A dp/dA.
    """
    s_a = -s * math.sqrt(max(1.0 - by_a * by_a, 1e-12))
    if touching == TIP_OF_2:
        s_2 = -s * math.sqrt(max(tip_2 * tip_2 - p_2 * p_2, 1e-12 * tip_2 * tip_2))
        return s_a, -s_2 - A * by_a, s_2
    s_1 = rho_1
    if touching == TIP_OF_1:
        s_1 = math.sqrt(max(tip_1 * tip_1 - p_1 * p_1, 1e-12 * tip_1 * tip_1))
    return s_a, s_1, -s_1 - A * by_a


@compiled_inline
def arms_of(mesh: Any, out: Floats, pair: Pair) -> tuple[float, float, float]:
    """Return `sliding_arms` of a pair of teeth at a state, `mesh_geometry` in the scratch; of an envelope those of flanks."""
    if mesh.envelope == 1:
        by_a = mesh.s * out[SIN_W]
        return sliding_arms(
            mesh.s, out[DISTANCE], mesh.tip_1, mesh.tip_2, ON_FLANK, by_a, 0.0, 0.0, pair.rho_1
        )
    return sliding_arms(
        mesh.s, out[DISTANCE], mesh.tip_1, mesh.tip_2, pair.touching, pair.by_a, pair.p_1, pair.p_2, pair.rho_1
    )  # fmt: skip


@compiled_inline
def sliding_of(mesh: Any, out: Floats, flank: int, pair: Pair) -> float:
    """Return the sliding speed s [m/s] of a pair of teeth of a flank."""
    s_a, s_1, s_2 = arms_of(mesh, out, pair)
    turn_1, turn_2, _ = turn_rates(mesh, out, flank)
    return s_a * out[DISTANCE_RATE] + s_1 * turn_1 + s_2 * turn_2


@compiled_inline
def grip_of(mesh: Any, sliding: float) -> tuple[float, float]:
    """Return friction over normal force, mu h(s / friction_speed), and its slope by the sliding speed [s/m]."""
    u = sliding / mesh.friction_speed
    return mesh.friction * smooth_sign(u), mesh.friction * smooth_sign_slope(u) / mesh.friction_speed
