"""Boost odeint: controlled Dormand-Prince 5(4) and Fehlberg 7(8), formulas in C++ (odeint_peer.cpp).

Fehlberg's 7(8) estimates its error from four stages, two at each end of the step, and so hardly sees a
contact that begins or ends inside: its step control does not help here at any tolerance. With steps held
below 2e-6 s it is right.
"""

import ctypes
import os
import shutil
import subprocess
import tempfile
import time
from functools import lru_cache
from pathlib import Path

import numpy as np

from bench.peers._flat import EVALUATION_LIMIT, OUTSIDE, largest_difference
from bench.peers._pair import involute_coefficients, numbers
from bench.problem import LIVELY, STATES

NAME = ["dopri5", "fehlberg78"]
FIRST_STEP = 1e-6  # s; odeint chooses none itself
SOURCE = Path(__file__).with_suffix(".cpp")
COMPILER = os.environ.get("CXX", "g++")
HEADER = "boost/numeric/odeint.hpp"


def boost_folder():
    """Return the folder of the Boost headers, None if there is none."""
    folders = [Path("/usr/include"), Path("/usr/local/include")]
    try:
        import boost_headers

        folders.insert(0, Path(boost_headers.get_include()))
    except ImportError:
        pass
    return next((folder for folder in folders if (folder / HEADER).exists()), None)


def missing():
    """Return what to install, None if nothing."""
    if boost_folder() is None or shutil.which(COMPILER) is None:
        return "Boost headers (pip install boost-headers) and a C++ compiler"
    return None


@lru_cache
def library():
    """Compile the C++ file into a temporary folder and load it."""
    fields = "".join(f"    double {name};\n" for name in numbers(LIVELY))
    flags = ["-O3", "-march=native", "-std=c++17", "-shared", "-fPIC"]
    with tempfile.TemporaryDirectory() as folder:  # a loaded library outlives its file
        Path(folder, "pair.hpp").write_text(f"struct Pair {{\n{fields}}};\n")
        output = f"{folder}/libpair.so"
        flags += [f"-I{folder}", "-isystem", str(boost_folder())]
        subprocess.run([COMPILER, *flags, "-o", output, str(SOURCE)], check=True)
        loaded = ctypes.CDLL(output)
    at, real, whole = ctypes.c_void_p, ctypes.c_double, ctypes.c_long
    loaded.pair_derivative.argtypes = [at, at, real, at, at]
    loaded.pair_solve.argtypes = [at, at, at, real, ctypes.c_int, real, real, real, whole, at, at]
    return loaded


@lru_cache
def packed(problem):
    """Return the problem's numbers, involute coefficients and natural sizes as arrays."""
    return (
        np.array(list(numbers(problem).values())),
        involute_coefficients(problem),
        problem.packed.natural.copy(),
    )


def check(problem):
    """Return the largest relative difference from the common right-hand side."""
    pair, series, _ = packed(problem)

    def rate(t, y):
        dy = np.empty(STATES)
        library().pair_derivative(pair.ctypes.data, series.ctypes.data, t, y.ctypes.data, dy.ctypes.data)
        return dy

    return largest_difference(problem, rate)


def solve(problem, member, method, tolerance):
    """Return the final state, the seconds the call took and the evaluations; NaN where the solver gave up."""
    pair, series, natural = packed(problem)
    function = library().pair_solve

    def call(span):
        y, count = problem.start(member), np.zeros(1, dtype=np.int64)
        began = time.perf_counter()
        failed = function(
            pair.ctypes.data, series.ctypes.data, natural.ctypes.data, OUTSIDE, NAME.index(method), tolerance,
            span, FIRST_STEP, EVALUATION_LIMIT, y.ctypes.data, count.ctypes.data,
        )  # fmt: skip
        return failed, y, time.perf_counter() - began, int(count[0])

    call(1e-6)
    failed, y, seconds, count = call(problem.span)
    return (y if not failed and np.all(np.isfinite(y)) else np.full(STATES, np.nan)), seconds, count
