"""Import of optional libraries, with the command that installs them in the error."""

import sys
from importlib import import_module
from pathlib import Path
from types import ModuleType

from gearplay.vocabulary.errors import NO_VALUE, InputError


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
        raise InputError.of(
            module, NO_VALUE, "is needed for this and not installed", cure_for(extra)
        ) from None


def cure_for(extra: str) -> str:
    """Return the command that installs an optional part: make extras in a clone with its own environment, else pip."""
    environment = Path(sys.prefix)
    clone = environment.parent
    if environment.name == ".venv" and (clone / "Makefile").is_file() and (clone / "src/gearplay").is_dir():
        return "Run: make extras" if clone == Path.cwd() else f"Run: make -C {clone} extras"
    return f"Run: {sys.executable} -m pip install 'gearplay[{extra}]'"
