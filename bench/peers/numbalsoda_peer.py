"""numbalsoda: LSODA in C++ and DOP853 in Fortran, with a compiled right-hand side and no Python in between.

There are not wheels for every Python, and building one needs a Fortran compiler. Without it, unpack the
source distribution and name its folder in GEARPLAY_BENCH_NUMBALSODA: LSODA alone is built from C++.
"""

import ctypes
import os
import subprocess
import tempfile
import time
from functools import lru_cache
from pathlib import Path

import numpy as np
from numba import carray, cfunc, types

from bench.peers._flat import EVALUATION_LIMIT, SMALLEST_RELATIVE, flat

NAME = ["lsoda", "dop853"]
SOURCES = os.environ.get("GEARPLAY_BENCH_NUMBALSODA", "")
SIGNATURE = types.void(types.double, *3 * [types.CPointer(types.double)])  # as numbalsoda.lsoda_sig
WRAPPER_TYPES = [
    ctypes.c_void_p, ctypes.c_int, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_int, ctypes.c_void_p,
    ctypes.c_void_p, ctypes.c_double, ctypes.c_double, ctypes.c_int, ctypes.c_void_p,
]  # fmt: skip


@lru_cache
def wrappers():
    """Return numbalsoda's compiled entry points by method."""
    try:
        from numbalsoda.driver import lsoda_wrapper
        from numbalsoda.driver_dop853 import dop853_wrapper

        return {"lsoda": lsoda_wrapper, "dop853": dop853_wrapper}
    except (ImportError, OSError):
        if not SOURCES:
            return {}
    files = [str(Path(SOURCES) / "src" / name) for name in ("LSODA.cpp", "wrapper.cpp")]
    with tempfile.TemporaryDirectory() as folder:  # a loaded library outlives its file
        output = f"{folder}/liblsoda.so"
        flags = ["-O3", "-march=native", "-shared", "-fPIC"]
        subprocess.run(["g++", *flags, "-o", output, *files], check=True)
        wrapper = ctypes.CDLL(output).lsoda_wrapper
    wrapper.argtypes, wrapper.restype = WRAPPER_TYPES, None
    return {"lsoda": wrapper}


def missing():
    """Return what to install, None if nothing."""
    try:
        have = wrappers()
    except (OSError, subprocess.CalledProcessError) as error:
        return f"LSODA of numbalsoda could not be built: {error}"
    hint = "pip install numbalsoda (needs gfortran), or set GEARPLAY_BENCH_NUMBALSODA to its sources"
    return None if have else hint


def offered():
    """Return the methods that work here."""
    return [name for name in NAME if name in wrappers()]


@lru_cache
def compiled(problem):
    """Return the right-hand side in units of the natural sizes: numbalsoda has one tolerance for all."""
    rhs = flat(problem)
    natural = problem.packed.natural.copy()
    states = natural.size

    @cfunc(SIGNATURE)
    def function(t, scaled_at, rate_at, data_at):
        scaled, rate = carray(scaled_at, (states,)), carray(rate_at, (states,))
        data = carray(data_at, (1 + states,))  # evaluations, then room for the state
        y = data[1:]
        for i in range(states):
            y[i] = scaled[i] * natural[i]
        data[0] += 1.0
        if data[0] > EVALUATION_LIMIT:
            rate[:] = np.nan
            return
        rhs(t, y, rate)
        for i in range(states):
            rate[i] /= natural[i]

    return function


def solve(problem, member, method, tolerance):
    """Return the final state, the seconds the call took and the evaluations; NaN where the solver gave up."""
    wrapper, address = wrappers().get(method), compiled(problem).address
    begin, states = problem.begin, problem.packed.state_size
    failed = np.full(states, np.nan)
    if wrapper is None:
        return failed, float("nan"), None
    natural = problem.packed.natural
    start = problem.start(member) / natural

    def call(span):
        data, times = np.zeros(1 + states), np.array([begin, begin + span])
        ends = np.zeros((2, states))
        success = np.array(999, dtype=np.int32)
        began = time.perf_counter()
        wrapper(
            address, states, start.ctypes.data, data.ctypes.data, 2, times.ctypes.data, ends.ctypes.data,
            SMALLEST_RELATIVE, tolerance, 2_000_000, success.ctypes.data,
        )  # fmt: skip
        return ends[1], time.perf_counter() - began, int(data[0]), int(success)

    call(1e-6)
    end, seconds, count, success = call(problem.span)
    return (end * natural if success == 1 and np.all(np.isfinite(end)) else failed), seconds, count
