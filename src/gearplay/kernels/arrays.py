"""Array types of the kernels."""

from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Rows = Annotated[NDArray[np.float64], 2]
"""An array of two dimensions, where a kernel's signature must say so."""


def blank(dimensions: int, kind: type = float) -> NDArray[Any]:
    """Return an array without numbers, for an example of a group."""
    return np.zeros(dimensions * (0,), dtype=kind)
