"""Lazily computed variables of a dataset."""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
from xarray.backends import BackendArray
from xarray.core import indexing

if TYPE_CHECKING:
    from numpy.typing import NDArray


class _Computed(BackendArray):
    """An array with a shape and a function that computes it."""

    def __init__(
        self, shape: tuple[int, ...], compute: Callable[[], "NDArray[Any]"], dtype: "np.dtype[Any]"
    ) -> None:
        self.shape, self.dtype, self._compute = shape, dtype, compute

    def __getitem__(self, key: indexing.ExplicitIndexer) -> Any:
        return indexing.explicit_indexing_adapter(
            key, self.shape, indexing.IndexingSupport.BASIC, lambda part: self._compute()[part]
        )


def lazy_array(shape: tuple[int, ...], compute: Callable[[], "NDArray[Any]"], dtype: Any = np.float64) -> Any:
    """Return data for a variable of ``shape`` that is computed as a whole on first access and then cached by xarray."""
    return indexing.MemoryCachedArray(indexing.LazilyIndexedArray(_Computed(shape, compute, np.dtype(dtype))))  # type: ignore[no-untyped-call]
