"""gearplay: dynamics of gear mechanisms whose small clearances are coupled.

The names that ``__init__.pyi`` imports are the interface; everything else may move. Heavy parts load on first use.
"""

from importlib import import_module
from typing import Any

from gearplay.vocabulary.exports import exports
from gearplay.vocabulary.version import VERSION

__version__ = VERSION
_HOMES = exports(__file__)
__all__ = sorted({*_HOMES, "__version__", "signals"})


def __getattr__(name: str) -> Any:
    if name == "signals":
        return import_module("gearplay.signals")
    if name not in _HOMES:
        raise AttributeError(f"module 'gearplay' has no attribute {name!r}")
    from gearplay.public_functions import public

    return public(name, _HOMES[name])


def __dir__() -> list[str]:
    return __all__
