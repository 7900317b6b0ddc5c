"""Involute geometry of a pair at a changed centre distance."""

import math

from gearplay.kernels.compiled import compiled, compiled_inline


@compiled_inline
def involute(alpha: float) -> float:
    """Return inv(alpha) = tan(alpha) - alpha [rad], alpha [rad].

    >>> round(involute(math.radians(20.0)), 9)
    0.014904384
    """
    return math.tan(alpha) - alpha


@compiled_inline
def involute_from_distance(A: float, c0: float) -> float:
    """Return inv(alpha_w) [rad] at centre distance A [m], cos(alpha_w) = c0 / A, eq. (5); NaN for A < c0.

    The square-root form needs neither arccos nor tan and keeps full precision near the nominal angle.

    >>> c0 = 0.08 * math.cos(math.radians(20.0))
    >>> round(involute_from_distance(0.08, c0), 9)
    0.014904384
    """
    tangent = math.sqrt(A * A - c0 * c0) / c0
    return tangent - math.atan(tangent)


@compiled
def dynamic_backlash(A: float, A0: float, alpha0: float, b0: float, s: float) -> float:
    """Return the total normal backlash b_t [m] at centre distance A [m]: b0 - 2 s c0 (inv alpha_w - inv alpha0).

    s = +1 internal, -1 external; alpha0 [rad]; b0 [m] at A0. Equation (6), whose printed sign is the external
    one whatever the pair: an internal pair loses backlash when its centres move apart.

    >>> round(1e6 * dynamic_backlash(0.0801, 0.08, math.radians(20.0), 100e-6, -1.0), 3)
    168.565
    """
    c0 = A0 * math.cos(alpha0)
    return b0 - 2.0 * s * c0 * (involute_from_distance(A, c0) - involute(alpha0))
