"""Write docs/reference.md: every public name with its signature and what its docstring says."""

import inspect
import re
import textwrap
from pathlib import Path
from typing import Any

from wrap_prose import wrap_prose

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
    text = re.sub(r"mappingproxy\(\{\}\)", "{}", f"{name}({', '.join(words)})")
    return "\n".join(textwrap.wrap(text, 100, subsequent_indent="    ", break_long_words=False))


def sections_of(doc: str) -> list[tuple[str, str]]:
    r"""Return the parts of a docstring by their heading; the first has none.

    >>> sections_of("Add.\n\nParameters\n----------\na\n    One.")
    [('', 'Add.'), ('Parameters', 'a\n    One.')]
    """
    heading = re.compile(r"^([A-Z][A-Za-z ]+)\n-{3,}\n", re.MULTILINE)
    parts = heading.split(f"{doc}\n")
    return [
        ("", parts[0].strip()),
        *((title, text.strip("\n")) for title, text in zip(parts[1::2], parts[2::2], strict=True)),
    ]


def entries_of(text: str) -> list[tuple[str, str]]:
    r"""Return what a section lists: names, and what is said of them in the indented lines below.

    >>> entries_of("a, b\n    Two\n    lines.\nc\n    One.")
    [('a, b', 'Two lines.'), ('c', 'One.')]
    """
    found: list[tuple[str, str]] = []
    for line in text.splitlines():
        if line and not line.startswith(" "):
            found.append((line, ""))
        elif line.strip():
            name, said = found.pop()
            found.append((name, f"{said} {line.strip()}".strip()))
    return found


def marked(text: str) -> str:
    r"""Return a docstring's words as Markdown; code stays code, stars and angles are themselves.

    >>> marked("``a`` times b*c < d")
    '`a` times b\\*c &lt; d'
    """
    parts = re.split(r"(``.+?``|`[^`]+`)", text, flags=re.DOTALL)
    plain = [re.sub(r"(?<!\\)\*", r"\\*", part).replace("<", "&lt;") for part in parts[::2]]
    code = [part.replace("``", "`") for part in parts[1::2]]
    return "".join(a + b for a, b in zip(plain, [*code, ""], strict=True))


def cell(text: str) -> str:
    """Return words as a cell of a table takes them."""
    return marked(text).replace("|", "\\|")


def table_of(heading: str, entries: list[tuple[str, str]], defaults: dict[str, str]) -> str:
    """Return a table of a section; parameters with the default of each that has one."""
    if heading != "Parameters":
        return "\n".join(
            [
                f"| {heading.lower()} | |",
                "|---|---|",
                *(f"| `{name}` | {cell(said)} |" for name, said in entries),
            ]
        )
    rows = ["| parameter | default | meaning |", "|---|---|---|"]
    for names, said in entries:
        each = [name.strip().lstrip("*") for name in names.partition(" :")[0].split(",")]
        shown = ", ".join(f"`{defaults[name]}`" for name in each if name in defaults).replace("|", "\\|")
        rows.append(f"| {', '.join(f'`{name}`' for name in each)} | {shown} | {cell(said)} |")
    return "\n".join(rows)


def defaults_of(it: Any) -> dict[str, str]:
    """Return what each argument is where it is not given."""
    try:
        every = inspect.signature(it).parameters.values()
    except ValueError:
        return {}
    return {
        p.name: repr(p.default)
        for p in every
        if p.default is not p.empty
        and "factory" not in repr(p.default)
        and "mappingproxy" not in repr(p.default)
    }


def entry(room: str, name: str, it: Any) -> str:
    """Return the part of the page on one name."""
    parts = [f"## {room}.{name}", f"```text\n{signature_of(name, it)}\n```"]
    for heading, text in sections_of(inspect.getdoc(it) or ""):
        if not heading:
            parts.append(marked(text))
        elif heading == "Examples":
            parts.append(f"```pycon\n{text.strip()}\n```")
        elif text.startswith(" ") or not any(said for _, said in entries_of(text)):
            parts += [f"**{heading}.**", marked(text)]
        else:
            parts.append(table_of(heading, entries_of(text), defaults_of(it)))
    return "\n\n".join(parts) + "\n"


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
    OUT.write_text(wrap_prose(page()), encoding="utf-8")
