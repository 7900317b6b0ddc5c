"""Motion of gears carried by a rotating carrier."""

import math

from gearplay.kernels.compiled import compiled_inline


@compiled_inline
def carried(turn: float, x: float, y: float) -> tuple[float, float, float, float]:
    """Return how far [m] a place (x, y) on a carrier moves when it turns by an angle [rad], and cos - 1 and sin of that.

    By the half angle: displacements must not cancel against 1.

    >>> carried(math.pi, 0.1, 0.0)[0]
    -0.2
    """
    cosine, sine = math.cos(0.5 * turn), math.sin(0.5 * turn)
    cosine_1, whole = -2.0 * sine * sine, 2.0 * sine * cosine
    return cosine_1 * x - whole * y, whole * x + cosine_1 * y, cosine_1, whole
