"""Public names of a package, read from its type stub: the stub is their only list."""

import re
from pathlib import Path


def exports(package: str) -> dict[str, str]:
    """Return the module of each name that the stub of a package's ``__init__.py`` re-exports.

    >>> import gearplay
    >>> exports(gearplay.__file__)["simulate"]
    'gearplay.results.simulate'
    """
    stub = Path(package).with_suffix(".pyi").read_text(encoding="utf-8")
    imports = re.findall(r"^from (\S+) import (\([^)]*\)|.+)", stub, re.MULTILINE)
    return {name: module for module, names in imports for name in re.findall(r"\b(\w+) as \1\b", names)}
