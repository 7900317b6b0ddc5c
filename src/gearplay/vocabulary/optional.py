"""Libraries that only some commands need: asked for by name, with the command that installs them."""

from importlib import import_module
from types import ModuleType

from gearplay.vocabulary.errors import NO_VALUE, Fault, InputError


def load_optional(module: str, extra: str) -> ModuleType:
    """Import an optional library; `InputError` with the command that installs it where it is missing.

    >>> load_optional("math", "none").__name__
    'math'
    """
    try:
        return import_module(module)
    except ModuleNotFoundError as error:
        if error.name != module.split(".")[0]:
            raise
        cure = f"Run: pip install 'gearplay[{extra}]'"
        raise InputError(Fault(module, NO_VALUE, "is needed for this and not installed", cure)) from None
