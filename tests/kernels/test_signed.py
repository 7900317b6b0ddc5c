"""Arrays in a kernel's annotations, however NumPy names them."""

from typing import Annotated, Any, TypeVar

import numpy as np
import pytest
from numpy.typing import NDArray
from typing_extensions import TypeAliasType

from gearplay.kernels.signatures import array_of

Scalar = TypeVar("Scalar", bound=np.generic)
# As NumPy 2.5 has its NDArray on Python 3.12 and later.
Alias = TypeAliasType("Alias", np.ndarray[tuple[Any, ...], np.dtype[Scalar]], type_params=(Scalar,))


@pytest.mark.parametrize("array", [NDArray, Alias])
def test_an_array_is_known_by_its_numbers_and_dimensions(array: Any) -> None:
    assert array_of(array[np.float64]) == (np.dtype(np.float64), 1)
    assert array_of(Annotated[array[np.int64], 2]) == (np.dtype(np.int64), 2)


@pytest.mark.parametrize("other", [float, tuple[int, float], Annotated[int, 2]])
def test_what_is_no_array_is_none(other: Any) -> None:
    assert array_of(other) is None
