"""Signal analysis of simulated, measured or given arrays: spectra, lines, orders, envelopes, averages.

Put samples into a `Channel` with their rate and unit; every function takes one and returns numbers with their settings.

>>> import gearplay as gp, numpy as np
>>> t = np.arange(4000) / 1000.0
>>> channel = gp.Channel("acc", 3.0 * np.sin(2.0 * np.pi * 50.0 * t), 1000.0, "m/s^2")
>>> row = gp.signals.line_table(channel, [50.0]).rows[0]
>>> round(row.frequency, 6), round(row.amplitude, 6)
(50.0, 3.0)
"""

from functools import cache
from importlib import import_module
from inspect import isfunction
from typing import Any

from gearplay.vocabulary.exports import exports

_HOMES = exports(__file__)
__all__ = sorted(_HOMES)


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'gearplay.signals' has no attribute {name!r}")
    return _public(name)


@cache
def _public(name: str) -> Any:
    from gearplay.signals.checks import checked_classes

    found = getattr(import_module(_HOMES[name]), name)
    return checked_classes(found) if isfunction(found) else found


def __dir__() -> list[str]:
    return __all__
