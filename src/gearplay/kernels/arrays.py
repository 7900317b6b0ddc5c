"""Array types of the kernels."""

from typing import Annotated

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Rows = Annotated[NDArray[np.float64], 2]
IntRows = Annotated[NDArray[np.int64], 2]
ComplexRows = Annotated[NDArray[np.complex128], 2]
Cubes = Annotated[NDArray[np.float64], 3]
"""Arrays of more dimensions than one, where a kernel's signature or the field of a group must say so."""
