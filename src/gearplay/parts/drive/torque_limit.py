"""Torque saturation shared by speed and position servos: unlimited (mode 0), or at a limit (mode +1, -1)."""

import math

from gearplay.kernels.compiled import compiled_inline


@compiled_inline
def limited(wanted: float, limit: float, mode: int) -> float:
    """Return the saturated torque [N m]."""
    return wanted if mode == 0 else mode * limit


@compiled_inline
def shown(wanted: float, limit: float) -> float:
    """Return the torque [N m] to show: at the instant at which a set-point jumps the mode is still that before it."""
    return min(max(wanted, -limit), limit)


@compiled_inline
def past_limit(wanted: float, limit: float, mode: int) -> float:
    """Return the switch function of the limit [N m]: demand beyond it, or short of it while saturated."""
    return abs(wanted) - limit if mode == 0 else limit - mode * wanted


@compiled_inline
def limit_of(wanted: float) -> int:
    """Return the mode of the limit that a torque reaches."""
    return int(math.copysign(1.0, wanted))


@compiled_inline
def may_pass(least: float, most: float, h: float, g_0: float, g_1: float) -> bool:
    """Return whether a torque whose rate [N m/s] lies between two bounds in a step of h [s] may pass its limit and come back.

    ``g_0`` and ``g_1`` are `past_limit` at its ends. Where the torque rises and falls it may do so by half of its fastest change.
    """
    if least >= 0.0 or most <= 0.0:
        return False
    return max(g_0, g_1) + 0.5 * h * max(most, -least) > 0.0
