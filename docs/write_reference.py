"""Write docs/reference.md: every public name, for mkdocstrings to fill in its signature and docstring."""

import inspect
from pathlib import Path
from typing import Any

import gearplay as gp

OUT = Path(__file__).with_name("reference.md")
HEAD = """# Python reference

Every public name of `gearplay`, imported as `gp`, then those of `gearplay.signals`. The examples run with the tests. Everything
else may change between versions.
"""


def entries() -> list[tuple[str, Any]]:
    """Return the public functions and classes by the names under which users call them."""
    return [
        (f"{shown}.{name}", getattr(module, name))
        for shown, module in (("gp", gp), ("gp.signals", gp.signals))
        for name in dir(module)
        if not name.startswith("_") and not inspect.ismodule(getattr(module, name))
    ]


def entry(name: str, found: Any) -> str:
    """Return the directive of one name; of a class its public methods with it, inherited ones too."""
    options = {"heading": name, "toc_label": name.removeprefix("gp.")}
    lines = [f"::: {found.__module__}.{found.__qualname__}", "    options:"]
    lines += [f"      {key}: {value}" for key, value in options.items()]
    if inspect.isclass(found) and not issubclass(found, Exception):
        bases = [each for each in found.__mro__ if each.__module__.startswith("gearplay.")]
        own = {key: value for each in reversed(bases) for key, value in vars(each).items()}
        methods = [
            key
            for key, value in own.items()
            if not key.startswith("_")
            and value.__doc__
            and (callable(value) or isinstance(value, property | classmethod))
        ]
        if methods:
            lines += [f"      members: [{', '.join(methods)}]", "      inherited_members: true"]
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    OUT.write_text("\n".join([HEAD, *(entry(*each) for each in entries())]), encoding="utf-8")
