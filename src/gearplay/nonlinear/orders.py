"""Period of a section in excitation periods, from exact orbits to noisy records."""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def repeating_orders(
    samples: Floats, most: int, apart: float, *, least: int = 1, first: int | None = None
) -> Iterator[int]:
    """Yield the orders, from ``least`` to ``most``, with which samples repeat to within ``apart``, the smallest first.

    ``samples`` has shape [period, signal]; with order k no sample differs from that k periods later by more than ``apart`` in
    any signal. Of long records only the ``first`` samples are compared.

    >>> list(repeating_orders(np.tile([[0.0], [5.0], [0.0], [8.0]], (4, 1)), 8, 0.1))
    [4, 8]
    """
    for order in range(least, most + 1):
        count = len(samples) - order
        some = count if first is None else min(first, count)
        if float(np.max(np.abs(samples[order : order + some] - samples[:some]))) <= apart:
            yield order
