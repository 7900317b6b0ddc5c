"""Motion of gears carried by a rotating carrier."""

import math

from gearplay.kernels.arrays import Floats
from gearplay.kernels.compiled import compiled_inline
from gearplay.kernels.layout import LAST_COSINE_1, LAST_SINE, LAST_TURN


@compiled_inline
def rotation(turn: float, out: Floats) -> tuple[float, float]:
    """Return cos - 1 and sin of an angle [rad]; the last one is kept in the scratch ``out``, as all planets of a set need it.

    By the half angle: displacements must not cancel against 1.

    >>> import numpy as np
    >>> from gearplay.kernels.layout import OUT_SIZE
    >>> float(rotation(math.pi, np.zeros(OUT_SIZE))[0])
    -2.0
    """
    if out[LAST_TURN] != turn:
        cosine, sine = math.cos(0.5 * turn), math.sin(0.5 * turn)
        out[LAST_TURN], out[LAST_COSINE_1], out[LAST_SINE] = turn, -2.0 * sine * sine, 2.0 * sine * cosine
    return out[LAST_COSINE_1], out[LAST_SINE]


@compiled_inline
def carried(turn: float, x: float, y: float, out: Floats) -> tuple[float, float, float, float]:
    """Return how far [m] a place (x, y) on a carrier moves when it turns by an angle [rad], and `rotation` of that.

    >>> import numpy as np
    >>> from gearplay.kernels.layout import OUT_SIZE
    >>> float(carried(math.pi, 0.1, 0.0, np.zeros(OUT_SIZE))[0])
    -0.2
    """
    cosine_1, sine = rotation(turn, out)
    return cosine_1 * x - sine * y, sine * x + cosine_1 * y, cosine_1, sine
