"""Kernels of a test, compiled in this process and linked to a library of their own."""

import ctypes
from pathlib import Path
from typing import Any

from gearplay.build.compiler import compile_kernel
from gearplay.build.linking import link
from gearplay.build.objects import forms_object, machine_code, write_object
from gearplay.build.targets import host
from gearplay.kernels.from_python import FromPython
from gearplay.kernels.library import library


def load_small(folder: Path, *kernels: Any) -> Path:
    """Build the library of some kernels and let Python call them there."""
    folder.mkdir(exist_ok=True)
    ctypes.CDLL(library()._name, mode=ctypes.RTLD_GLOBAL)  # other kernels are found by their symbols
    objects = [
        write_object(folder, kernel.symbol, machine_code(str(compile_kernel(kernel)), host()))
        for kernel in kernels
    ]
    file = link(host(), [*objects, forms_object(folder, host())], folder)
    made = ctypes.CDLL(str(file))
    for kernel in kernels:
        kernel.from_python = FromPython(kernel, made)
    return file
