"""A CUDA device as its driver knows it: memory, code, launches. Nothing imports this module before a device is asked for."""

import ctypes
from typing import Any

import numpy as np
from cuda.bindings import driver as cuda
from numpy.typing import NDArray

from gearplay.device.fleet import DeviceError
from gearplay.kernels.machine_code import Code

BLOCK = 32
"""Threads of a block: those that go in step, so that one that is done gives way to the next."""


def _checked(answer: Any) -> Any:
    """Return what a call of the driver returns; `DeviceError` where it failed."""
    error, *values = answer
    if error != cuda.CUresult.CUDA_SUCCESS:
        raise DeviceError(error.name.removeprefix("CUDA_ERROR_").replace("_", " ").lower())
    return values[0] if values else None


class Device:
    """The first CUDA device. `DeviceError` where there is none."""

    def __init__(self) -> None:
        try:
            _checked(cuda.cuInit(0))
        except RuntimeError:  # also what the bindings raise where there is no driver
            raise DeviceError("the driver of an NVIDIA device does not answer") from None
        device = _checked(cuda.cuDeviceGet(0))
        self._context = _checked(cuda.cuDevicePrimaryCtxRetain(device))
        self.use()
        self.name = _checked(cuda.cuDeviceGetName(128, device)).decode().rstrip("\0")
        attribute = cuda.CUdevice_attribute
        self.capability = (
            self._ask(attribute.CU_DEVICE_ATTRIBUTE_COMPUTE_CAPABILITY_MAJOR, device),
            self._ask(attribute.CU_DEVICE_ATTRIBUTE_COMPUTE_CAPABILITY_MINOR, device),
        )

    @staticmethod
    def _ask(attribute: Any, device: Any) -> int:
        return int(_checked(cuda.cuDeviceGetAttribute(attribute, device)))

    def use(self) -> None:
        """Speak to the device from this thread."""
        _checked(cuda.cuCtxSetCurrent(self._context))

    def free_memory(self) -> int:
        """Return how much memory is free [bytes]."""
        self.use()
        return int(_checked(cuda.cuMemGetInfo()))  # and the whole, which is not asked for

    def allocate(self, size: int) -> int:
        """Return the address of that many bytes, a multiple of 256."""
        return int(_checked(cuda.cuMemAlloc(max(size, 1))))

    def release(self, address: int) -> None:
        """Give memory back."""
        _checked(cuda.cuMemFree(address))

    def put(self, address: int, numbers: NDArray[Any]) -> None:
        """Copy an array, C-contiguous, to the device."""
        if numbers.nbytes:
            _checked(cuda.cuMemcpyHtoD(address, numbers.ctypes.data, numbers.nbytes))

    def get(self, address: int, numbers: NDArray[Any]) -> None:
        """Fill an array, C-contiguous, from the device."""
        if numbers.nbytes:
            _checked(cuda.cuMemcpyDtoH(numbers.ctypes.data, address, numbers.nbytes))

    def load(self, code: Code) -> Any:
        """Return a function that `launch` takes."""
        module = _checked(cuda.cuModuleLoadData(np.frombuffer(code.content, dtype=np.uint8).ctypes.data))
        return _checked(cuda.cuModuleGetFunction(module, code.symbol.encode()))

    def launch(self, function: Any, threads: int, *words: int) -> None:
        """Let that many threads run a function of words, and wait for them."""
        blocks = -(-threads // BLOCK)
        arguments = (words, (ctypes.c_int64,) * len(words))
        _checked(cuda.cuLaunchKernel(function, blocks, 1, 1, BLOCK, 1, 1, 0, 0, arguments, 0))
        _checked(cuda.cuCtxSynchronize())
