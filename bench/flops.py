"""Floating-point operations of one right-hand side, counted: the kernels in plain Python on numbers that count.

Run with GEARPLAY_INTERPRETED=1. A square root, a sine or a cosine counts as one; constants among themselves count nothing.
"""

import importlib
import json
import math
import pkgutil
import sys
from collections import Counter
from types import SimpleNamespace

import numpy as np

import gearplay.integrate
import gearplay.kernels
import gearplay.parts

COUNTS = Counter()


class Counting(float):
    """A float whose arithmetic is counted."""


def _counted(name):
    operation = getattr(float, name)

    def method(self, *others):
        COUNTS[name.strip("_").removeprefix("r")] += 1
        return Counting(operation(self, *(float(o) for o in others)))

    return method


for _name in ("add", "radd", "sub", "rsub", "mul", "rmul", "truediv", "rtruediv"):
    setattr(Counting, f"__{_name}__", _counted(f"__{_name}__"))
Counting.__neg__ = lambda self: Counting(-float(self))


class CountingMath:
    """`math` for kernels that count."""

    def __getattr__(self, name):
        """Return a function of `math` that counts itself."""
        function = getattr(math, name)
        if not callable(function):
            return function

        def call(*values):
            COUNTS[name] += 1
            return Counting(function(*(float(v) for v in values)))

        return call


class Records(list):
    """Records as plain objects of Python numbers, which give way to counting ones in arithmetic."""

    def __init__(self, array):
        super().__init__(SimpleNamespace(**{n: row[n].item() for n in array.dtype.names}) for row in array)
        self.size = len(array)


def counting(part):
    """Return a part of a system whose numbers give way to counting ones: a table, several, or an array; others as they are."""
    if isinstance(part, tuple):
        return tuple(counting(each) for each in part)
    if not isinstance(part, np.ndarray):
        return part
    return plain(part) if part.dtype.names is None else Records(part)


def plain(array):
    """Return an array of Python numbers."""
    return np.array(array.tolist(), dtype=object).reshape(array.shape)


def main():
    """Print the counts of one evaluation with sleeve and drive flank in contact."""
    from bench.problem import LIVELY
    from gearplay.integrate import dispatch
    from gearplay.integrate.right_hand_side import right_hand_side
    from gearplay.kernels.layout import LOADED

    system, active_set, branch, loads = LIVELY.arguments()
    y = LIVELY.start(1)
    for e in range(system.elements.size):
        dispatch.start_step(system, e, 0.0, y, branch)
    system = SimpleNamespace(**{name: counting(part) for name, part in vars(system).items()})
    for package in (gearplay.kernels, gearplay.integrate, gearplay.parts):
        for module in pkgutil.walk_packages(package.__path__, f"{package.__name__}."):
            loaded = importlib.import_module(module.name)
            if hasattr(loaded, "math"):
                loaded.math = CountingMath()
    branch.modes[:2] = LOADED
    COUNTS.clear()
    states, speeds, rows = (
        np.array([Counting(v) for v in a.ravel()], dtype=object).reshape(a.shape)
        for a in (y, branch.impact_speeds, loads.contacts)
    )
    rates, forces, scratch = (np.zeros(a.shape, dtype=object) for a in (y, loads.rotors, loads.out))
    branch = SimpleNamespace(modes=branch.modes, impact_speeds=speeds, memory=plain(branch.memory))
    loads = SimpleNamespace(contacts=rows, rotors=forces, out=scratch)
    # the ring alone is integrated: the pinion is held and prescribed
    active_set.active[:2] = 1, 1
    right_hand_side(system, active_set, Counting(1e-5), states, branch, rates, loads)
    json.dump(COUNTS, sys.stdout)


if __name__ == "__main__":
    main()
