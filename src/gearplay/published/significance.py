"""Multiple-testing correction of differences."""

import math
from collections.abc import Sequence


def holm(p_values: Sequence[float], level: float = 0.05) -> list[bool]:
    """Return which are significant after Holm's correction, Scand. J. Stat. 6 (1979) 65; NaN is no test and never is.

    >>> holm([0.04, 0.001, math.nan, 0.02])
    [True, True, False, True]
    >>> holm([0.04, 0.001, 0.03])
    [False, True, False]
    """
    order = sorted((i for i, p in enumerate(p_values) if not math.isnan(p)), key=lambda i: p_values[i])
    found = [False] * len(p_values)
    for rank, i in enumerate(order):
        if p_values[i] > level / (len(order) - rank):
            break
        found[i] = True
    return found
