"""Array types of the kernels."""

from typing import Annotated

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Rows = Annotated[NDArray[np.float64], 2]
"""An array of two dimensions, where a kernel's signature must say so."""
