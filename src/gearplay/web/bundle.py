"""Modules of the page's script as one file, since a browser takes longer for twenty requests than for their text."""

import re
from functools import cache
from importlib import resources

IMPORT = re.compile(r'^import (\{[^}]*\}) from "\./(\w+)\.js";\n', re.MULTILINE)
EXPORT = re.compile(r"^export (?=(?:const|class|function|async function) ([\w$]+))", re.MULTILINE)


@cache
def script_of(name: str) -> str:
    """Return a module of the page with all modules that it imports, each of them a function that returns its exports.

    >>> "import " in script_of("player"), script_of("player").count("modules.gears = ")
    (False, 1)
    """
    texts: dict[str, str] = {}

    def add(module: str) -> None:
        text = static_text(f"{module}.js")
        for _, imported in IMPORT.findall(text):
            if imported not in texts:
                add(imported)
        texts[module] = text

    add(name)
    main = _linked(texts.pop(name))
    return "\n".join(["const modules = {};", *(_module(*each) for each in texts.items()), main])


def _module(name: str, text: str) -> str:
    """Return the assignment of a module's exports."""
    exported = ", ".join(EXPORT.findall(text))
    return f"modules.{name} = (() => {{\n{_linked(text)}return {{ {exported} }};\n}})();"


def _linked(text: str) -> str:
    """Return the text of a module with its imports from the modules before it."""
    return EXPORT.sub("", IMPORT.sub(r"const \1 = modules.\2;\n", text))


def static_text(name: str) -> str:
    """Return the text of a static file."""
    return (resources.files("gearplay.web") / "static" / name).read_text(encoding="utf-8")
