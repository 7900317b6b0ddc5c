"""Quantisation step of a record."""

from __future__ import annotations

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

WHOLE: Final = 1e-2
"""Largest distance of a difference of values from a multiple of the step, in steps: values may be scaled and rounded."""
MOST_STEPS: Final = 1 << 20
"""Most steps in the range of values: beyond these rounding of the values hides them."""
DITHER: Final = 2.0
"""Level of what repeats with no shaft, over that of quantisation, below which it may be quantisation.

Of Gaussian noise of half a step, which makes quantisation noise independent of the signal, it is 2 (Widrow and Kollar,
Quantization Noise, 2008).
"""


def quantisation_step(values: Floats) -> float:
    """Return the step of which all differences of values are multiples, 0.0 where there is none that they show.

    >>> float(round(quantisation_step(0.3 + 0.01 * np.round(100.0 * np.sin(np.arange(500)))), 12))
    0.01
    >>> quantisation_step(np.sin(np.arange(500.0)))
    0.0
    """
    levels = np.unique(np.asarray(values, dtype=np.float64))
    span = float(levels[-1] - levels[0])
    apart = np.diff(levels)
    apart = apart[apart > span / MOST_STEPS / 2.0]
    if apart.size == 0:
        return 0.0
    step = float(np.min(apart))
    off = np.abs(apart / step - np.round(apart / step))
    if span > MOST_STEPS * step or float(np.max(off)) > WHOLE:
        return 0.0
    return step


def is_quantisation(rms: float, step: float) -> bool:
    """Return whether an rms level may be that of quantisation, step / sqrt(12), with too little noise to be independent."""
    return rms < DITHER * step / math.sqrt(12.0)
