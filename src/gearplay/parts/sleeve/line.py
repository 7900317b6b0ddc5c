"""A journal in a bush of some length: force laws of a line contact of nearly equal radii, and their slopes.

With w = F/L, 1/E* the sum of (1 - nu^2)/E of both sides and c the radial clearance,

    Johnson:  delta = w / (pi E*) (ln(4 pi E* c / w) - 1),
    Liu:      w = (pi/2) E* delta sqrt(delta / (2 (c + delta))).

K. L. Johnson, Contact Mechanics, 1985; C. Liu, K. Zhang, R. Yang, Mech. Mach. Theory 42 (2007) 183.
"""

import math
from typing import Any

from gearplay.kernels.compiled import compiled

LINE_NONE, LINE_JOHNSON, LINE_LIU = 0, 1, 2
DEEPEST = math.exp(-2.0)
"""Of delta / (4 c): where Johnson's law ends, at w = 4 pi E* c / e^2, with a vertical tangent."""
ITERATIONS = 40


@compiled
def johnson_logarithm(y: float) -> float:
    """Return u >= 1 of u exp(-u) = e y, y = delta / (4 c) in (0, e^-2]; then w = 4 pi E* c exp(-u - 1).

    Newton's method on u - ln u + ln y + 1, convex and rising beyond 1, from the right of its zero.

    >>> round(johnson_logarithm(3.0 * math.exp(-4.0)), 12)
    3.0
    """
    whole = -math.log(y) - 1.0
    u = 2.0 * whole + 1.0
    for _ in range(ITERATIONS):
        step = (u - math.log(u) - whole) / (1.0 - 1.0 / u) if u > 1.0 else 0.0
        u = max(u - step, 1.0)
        if step <= 1e-15 * u:
            break
    return u


@compiled
def line_force(sleeve: Any, delta: float) -> float:
    """Return the elastic force [N] at penetration delta [m]; odd in delta, constant beyond the end of Johnson's law."""
    size, c = abs(delta), sleeve.clearance
    if size == 0.0:
        return 0.0
    if sleeve.line == LINE_LIU:
        per_length = 0.5 * math.pi * sleeve.line_modulus * size * math.sqrt(size / (2.0 * (c + size)))
    else:
        y = min(size / (4.0 * c), DEEPEST)
        per_length = 4.0 * math.pi * sleeve.line_modulus * c * math.exp(-johnson_logarithm(y) - 1.0)
    return math.copysign(sleeve.line_length * per_length, delta)


@compiled
def line_slope(sleeve: Any, delta: float) -> float:
    """Return the derivative [N/m] of `line_force`."""
    size, c = abs(delta), sleeve.clearance
    if size == 0.0:
        return 0.0
    if sleeve.line == LINE_LIU:
        wide = 2.0 * (c + size)
        root = math.sqrt(size / wide)
        return float(sleeve.line_length * 0.5 * math.pi * sleeve.line_modulus * root * (1.5 - size / wide))
    y = size / (4.0 * c)
    if y >= DEEPEST:
        return 0.0
    u = johnson_logarithm(y)
    return float(sleeve.line_length * math.pi * sleeve.line_modulus / max(u - 1.0, 1e-12))


def contact_modulus(sides: tuple[tuple[float, float], tuple[float, float]]) -> float:
    """Return E* [Pa] of two sides, each modulus [Pa] and Poisson's ratio."""
    return 1.0 / sum((1.0 - nu * nu) / modulus for modulus, nu in sides)
