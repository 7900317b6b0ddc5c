"""Functions of the benchmark that numba compiles with kernels in them, for calls from Python."""

import ctypes

from numba.extending import NativeValue, unbox

from gearplay.build.compiler import GroupType, group_type, jitted
from gearplay.kernels.library import library

__all__ = ["group_type", "jitted"]

ctypes.CDLL(library()._name, mode=ctypes.RTLD_GLOBAL)  # kernels that they call are found by their symbols


@unbox(GroupType)
def _unbox(kind, value, c):
    """Take a group of arrays from Python by the address of its table."""
    number = c.pyapi.object_getattr_string(value, "_address")
    address = c.pyapi.long_as_voidptr(number)
    c.pyapi.decref(number)
    return NativeValue(address)
