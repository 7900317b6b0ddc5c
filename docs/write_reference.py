"""Write docs/reference.md: every public name with its signature and what its docstring says."""

import inspect
import re
from pathlib import Path
from typing import Any

import gearplay as gp

OUT = Path(__file__).with_name("reference.md")
HEAD = """# Reference

Every public name of `gearplay`, then those of `gearplay.signals`; the examples run with the tests. Everything else may move.
"""


def signature_of(name: str, it: Any) -> str:
    """Return a call with its arguments and their defaults, without types."""
    if isinstance(it, type) and issubclass(it, Exception):
        return name
    words, keyword = [], False
    for parameter in inspect.signature(it).parameters.values():
        if (
            parameter.kind == parameter.KEYWORD_ONLY
            and not keyword
            and not any(w.startswith("*") for w in words)
        ):
            words.append("*")
            keyword = True
        if parameter.kind == parameter.VAR_KEYWORD:
            words.append(f"**{parameter.name}")
        elif parameter.default is parameter.empty or "factory" in repr(parameter.default):
            words.append(parameter.name)
        else:
            words.append(f"{parameter.name}={parameter.default!r}")
    text = f"{name}({', '.join(words)})"
    return re.sub(r"mappingproxy\(\{\}\)", "{}", text)


def entry(room: str, name: str, it: Any) -> str:
    """Return the part of the page on one name."""
    return f"## {room}.{name}\n\n```text\n{signature_of(name, it)}\n\n{inspect.getdoc(it)}\n```\n"


def page() -> str:
    """Return the whole page."""
    parts = [HEAD]
    for room, names in (("gp", gp), ("gp.signals", gp.signals)):
        for name in dir(names):
            it = getattr(names, name)
            if not name.startswith("_") and not inspect.ismodule(it):
                parts.append(entry(room, name, it))
    return "\n".join(parts)


if __name__ == "__main__":
    OUT.write_text(page(), encoding="utf-8")
