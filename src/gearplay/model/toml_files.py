"""Reading and writing of TOML text, with a size limit before parsing.

A parser of nested keys can be made to work for seconds by a small file, so size and depth are checked on the
text first: one pass over its tokens, without recursion.
"""

from __future__ import annotations

import json
import os
import re
import stat
import tomllib
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, Final

from gearplay.vocabulary.errors import NO_VALUE, Fault, InputError, shorten

LARGEST_FILE: Final = 256 * 1024
"""Largest case file [bytes]."""

OTHERS: Final[Mapping[str, tuple[str, ...]]] = {
    "table": (".csv", ".tsv", ".asc", ".xls", ".xlsx"),
    "record": (".wav", ".wave", ".mat", ".uff", ".unv", ".tdms", ".mf4", ".mdf", ".npy", ".npz"),
}
"""Extensions of files that are given by mistake, by what they are."""

DEEPEST: Final = 16
"""Deepest nesting of tables and lists."""

MOST_VALUES: Final = 100_000
"""Most values in one case."""

# Strings and comments are skipped as a whole; an unterminated one runs on, so that no text is scanned twice.
_TOKEN: Final = re.compile(
    r'"""(?:[^\\]|\\.)*?(?:"""|\\?\Z)|'
    r"'''.*?(?:'''|\Z)|"
    r'"(?:[^"\\\n]|\\[^\n])*+"?|'
    r"'[^'\n]*+'?|#[^\n]*+|(?P<mark>[\[\]{}=,\n.])",
    re.DOTALL,
)


def read_text(path: Path, *, what: str = "case") -> str:
    """Return the text of a regular file in UTF-8, at most `LARGEST_FILE` bytes; ``what`` names its content in messages."""
    where = shorten(str(path))
    try:
        status = path.stat()
        if stat.S_ISDIR(status.st_mode):
            raise InputError.of(what, where, "must be a file, not a directory", "Name the file in it")
        if not stat.S_ISREG(status.st_mode):
            raise InputError.of(what, where, "must be a regular file", f"Save the {what} to a file first")
        with path.open("rb") as file:
            content = file.read(LARGEST_FILE + 1)
    except FileNotFoundError:
        raise InputError.of(what, where, "no such file", "Check the path and the current folder") from None
    except (OSError, ValueError) as error:  # ValueError: a NUL in the path
        reason = getattr(error, "strerror", None) or "not a valid path"
        raise InputError.of(what, where, f"cannot be read: {reason}", "Check the path") from None
    if content.startswith((b"\x89HDF", b"CDF")):
        rule = f"must be a {what}, not a stored result"
        raise InputError.of(what, where, rule, "Pass what gearplay.read_result returns, or its .case")
    if len(content) > LARGEST_FILE:
        raise InputError.of(
            what, where, f"must have at most {LARGEST_FILE // 1024} KiB", "Split or shorten it"
        )
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        rule = f"must be UTF-8 text, but byte {error.start} is not"
        raise InputError.of(what, where, rule, "Save the file as UTF-8") from None


def toml_text(path: Path, *, what: str = "case") -> str:
    """Return the text of a TOML file as `read_text` does; `InputError` for one that is a table or a record by its extension."""
    kind = next((kind for kind, suffixes in OTHERS.items() if path.suffix.lower() in suffixes), None)
    if kind is not None and os.path.isfile(path):
        rule = f"must be a {what} in TOML, but this is a {kind} by its extension"
        cure = f"Give the TOML file of the {what}; gearplay.read_measurement and gearplay analyze read records and tables"
        raise InputError.of(what, shorten(str(path)), rule, cure)
    return read_text(path, what=what)


def lines_of(at: str, path: Path) -> Iterator[tuple[int, list[str]]]:
    """Yield the number and the words of each line of a text file but comments; apart by commas, semicolons, tabs or blanks."""
    for number, line in enumerate(read_text(path, what=at).splitlines(), start=1):
        words = line.replace(",", " ").replace(";", " ").split()
        if words and not words[0].startswith("#"):
            yield number, words


def rows_of(at: str, path: Path, columns: int, what: str) -> list[list[float]]:
    """Return the rows of numbers of a text file, a line of heads left out; `InputError` for a line without ``what``, so many."""
    rows: list[list[float]] = []
    for number, words in lines_of(at, path):
        try:
            row = [float(word) for word in words]
        except ValueError:
            row = []
        if len(row) == columns:
            rows.append(row)
        elif row or rows or number > 2:
            rule = f"must have {what}, but line {number} has not"
            raise InputError.of(at, shorten(path.name), rule, "Use a point as decimal sign")
    return rows


def parse_toml(text: str, where: str) -> dict[str, Any]:
    """Parse TOML text after checking its depth; `where` names it in messages."""
    too_deep = Fault(
        where, NO_VALUE, f"must be nested at most {DEEPEST} deep", "Use shorter keys and fewer brackets"
    )
    if text_depth(text) > DEEPEST:
        raise InputError(too_deep)
    try:
        return tomllib.loads(text)
    except RecursionError:
        raise InputError(too_deep) from None
    except ValueError as error:  # TOMLDecodeError, or an integer too long to read
        reason = (
            shorten(str(error), 120) if isinstance(error, tomllib.TOMLDecodeError) else "a number is too long"
        )
        raise InputError.of(where, NO_VALUE, f"is not valid TOML: {reason}", "Correct that line") from None


def text_depth(text: str) -> int:
    """Return a bound on how deep brackets, and separately dotted keys, nest in TOML text.

    Examples
    --------
    >>> text_depth("a.b.c = [[1.5]]"), text_depth("s = '[[[['"), text_depth('"a.b" = 1')
    (3, 0, 0)

    """
    brackets = deepest = dots = longest = 0
    for match in _TOKEN.finditer(text):
        mark = match["mark"]
        if mark is None:
            continue
        if mark == ".":
            dots += 1
            longest = max(longest, dots + 1)
            continue
        dots = 0
        if mark in "[{":
            brackets += 1
            deepest = max(deepest, brackets)
        elif mark in "]}":
            brackets = max(0, brackets - 1)
    return max(deepest, longest)


def plain_copy(value: object) -> Any:
    """Copy nested mappings, sequences and NumPy values into plain Python ones, within bounds.

    Raises
    ------
    InputError
        If it nests deeper than `DEEPEST`, holds more than `MOST_VALUES` values, or a key is no text.

    """
    budget = [MOST_VALUES]

    def copy(item: object, depth: int) -> Any:
        budget[0] -= 1
        if budget[0] < 0:
            raise InputError.of("case", NO_VALUE, f"must hold at most {MOST_VALUES} values", "Shorten it")
        if depth > DEEPEST:
            raise InputError.of("case", NO_VALUE, f"must be nested at most {DEEPEST} deep", "Flatten it")
        if not isinstance(item, (str, bytes)) and hasattr(item, "tolist"):
            item = item.tolist()
        if isinstance(item, Mapping):
            for key in item:
                if not isinstance(key, str):
                    raise InputError.of("case", key, "keys must be text", "Put the key in quotes")
            return {key: copy(inner, depth + 1) for key, inner in item.items()}
        if isinstance(item, (list, tuple)):
            return [copy(inner, depth + 1) for inner in item]
        return item

    return copy(value, 0)


def write_toml(document: Mapping[str, Any]) -> str:
    """Write a dictionary of tables as TOML; entries that are None are left out."""
    lines: list[str] = []
    _write_table(document, (), lines)
    return "\n".join(lines).strip() + "\n"


def _write_table(table: Mapping[str, Any], path: tuple[str, ...], lines: list[str]) -> None:
    present = {key: value for key, value in table.items() if value is not None}
    tables = {key: value for key, value in present.items() if len(path) < 2 and _is_table(value, len(path))}
    for key, value in present.items():
        if key not in tables:
            lines.append(f"{_key(key)} = {inline_value(value)}")
    for key, value in tables.items():
        name = ".".join(_key(part) for part in (*path, key))
        for item in value if isinstance(value, list) else [value]:
            if isinstance(value, list):
                lines.extend(["", f"[[{name}]]"])
            elif not (item and not path and all(_is_table(inner, 1) for inner in item.values())):
                lines.extend(["", f"[{name}]"])
            _write_table(item, (*path, key), lines)


def _is_table(value: object, depth: int) -> bool:
    if isinstance(value, list):
        return depth == 0 and bool(value) and all(isinstance(item, Mapping) for item in value)
    return isinstance(value, Mapping) and (depth == 0 or "kind" not in value)


def _key(key: str) -> str:
    return key if re.fullmatch(r"[A-Za-z0-9_-]+", key) else json.dumps(key)


def inline_value(value: object) -> str:
    """Return a value on one line; a table inline."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, Mapping):
        inner = ", ".join(
            f"{_key(key)} = {inline_value(item)}" for key, item in value.items() if item is not None
        )
        return f"{{ {inner} }}" if inner else "{}"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(inline_value(item) for item in value) + "]"
    return repr(value)
