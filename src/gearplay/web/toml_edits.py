"""Changes of values in the text of a case file, with comments and units kept."""

import math
import re
from collections.abc import Mapping
from typing import Any

from gearplay.model.case import Case
from gearplay.model.reading import load_case, replace, to_toml
from gearplay.model.toml_files import parse_toml
from gearplay.schema.units import CELSIUS
from gearplay.vocabulary.errors import InputError
from gearplay.vocabulary.quantities import TEMPERATURE

_HEADER = re.compile(r"[ \t]*(\[\[?)[ \t]*([^\[\]\n]+?)[ \t]*\]\]?[ \t]*(?:#[^\n]*)?(?:\n|$)")
_KEY = re.compile(
    r"""[ \t]*((?:[A-Za-z0-9_-]+|"[^"\n]*"|'[^'\n]*')(?:[ \t]*\.[ \t]*(?:[A-Za-z0-9_-]+|"[^"\n]*"|'[^'\n]*'))*)[ \t]*=[ \t]*"""
)
_QUANTITY = re.compile(r"([+-]?[0-9][0-9_.]*(?:[eE][+-]?[0-9]+)?)(\s*)(.+)")
_SPACE = re.compile(r"(?:[ \t\r\n]|#[^\n]*)*")
Span = tuple[int, int]
Path = tuple[str, ...]


def edited(source: str, changes: Mapping[str, Any]) -> str:
    """Return the text of a case file with fields changed, SI; rewritten completely if the text cannot be edited.

    Raises `InputError` for an invalid text or value.

    >>> from gearplay.model.bundled import bundled_text
    >>> text = bundled_text("gearplay.model", "cases", "han2021")
    >>> print(edited(text, {"meshes.0.backlash": 1.5e-4}).splitlines()[38])
    backlash = "150 um"                     # article: 100 or 200 um
    """
    before = load_case(parse_toml(source, "upload"))
    text, done = source, before
    for path, value in changes.items():
        wanted = replace(done, {path: value})
        parts = tuple(path.split("."))
        if parts[-1].isdecimal() and _at(done, parts[:-1]) is None:  # a list that the file leaves out
            path, value = ".".join(parts[:-1]), _at(wanted, parts[:-1])
        kept = next(
            (each for each in _candidates(text, done, path, value) if _is_text_of(each, wanted)), None
        )
        if kept is None:
            return to_toml(replace(before, changes))
        text, done = kept, wanted
    return text


def _is_text_of(text: str, wanted: Case) -> bool:
    """Return whether a text is that of a case, apart from rounding."""
    try:
        return _close(load_case(parse_toml(text, "edited")).resolved(), wanted.resolved())
    except InputError:
        return False


def _close(one: Any, other: Any) -> bool:
    if isinstance(one, Mapping) and isinstance(other, Mapping):
        return one.keys() == other.keys() and all(_close(one[key], other[key]) for key in one)
    if isinstance(one, (list, tuple)) and isinstance(other, (list, tuple)):
        return len(one) == len(other) and all(map(_close, one, other))
    if isinstance(one, float) and isinstance(other, float):
        return math.isclose(one, other, rel_tol=1e-9)
    return bool(one == other)


def _candidates(text: str, case: Case, path: str, value: Any) -> list[str]:
    """Return candidate texts with a field's new value: in its old unit, as a plain number, among its neighbours."""
    parts = tuple(path.split("."))
    spans, tables = _places(text)
    found: list[str] = []
    if parts in spans:
        low, high = spans[parts]
        old = text[low:high]
        words = [_literal(value)]
        if isinstance(value, float) and (quoted := _in_unit(old, _at(case, parts), value)):
            words.insert(0, quoted)
        found += [text[:low] + each + text[high:] for each in words]
        return found
    if (inline := spans.get(parts[:-1])) and text[inline[0]] == "{":
        low, high = inline
        inside = text[low + 1 : high - 1].strip()
        found.append(
            f"{text[:low]}{{ {inside}{', ' if inside else ''}{parts[-1]} = {_literal(value)} }}{text[high:]}"
        )
    for depth in range(len(parts) - 1, 0, -1):
        if (at := tables.get(parts[:depth])) is not None:
            found.append(f"{text[:at].rstrip()}\n{'.'.join(parts[depth:])} = {_literal(value)}\n{text[at:]}")
    return found


def _at(case: Case, parts: Path) -> Any:
    place: Any = case.resolved()
    for part in parts:
        place = place[int(part)] if isinstance(place, (list, tuple)) else place.get(part)
        if place is None:
            return None
    return place


def _in_unit(old: str, before: Any, value: float) -> str | None:
    """Return a value [SI] as text in the unit of an old text; None where that has none, or is 0."""
    match = _QUANTITY.fullmatch(old[1:-1]) if old[:1] in "\"'" else None
    if match is None or not isinstance(before, float) or not before:
        return None
    if match[3] in CELSIUS:
        return f'"{value + TEMPERATURE.display_offset:.10g}{match[2]}{match[3]}"'
    number = float(match[1].replace("_", ""))
    return f'"{value * number / before:.10g}{match[2]}{match[3]}"' if number else None


def _literal(value: Any) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, float):
        return repr(value)
    if isinstance(value, (list, tuple)):
        return f"[{', '.join(map(_literal, value))}]"
    return (
        str(value)
        if isinstance(value, int)
        else '"' + str(value).replace("\\", "\\\\").replace('"', '\\"') + '"'
    )


def _places(text: str) -> tuple[dict[Path, Span], dict[Path, int]]:
    """Return the position of each value of a TOML text, by its path, and the end of each table."""
    spans: dict[Path, Span] = {}
    tables: dict[Path, int] = {(): 0}
    counts: dict[Path, int] = {}
    table: Path = ()
    at = 0
    while at < len(text):
        at = _SPACE.match(text, at).end()  # type: ignore[union-attr]
        if header := _HEADER.match(text, at):
            table = _under(_split(header[2]), counts)
            if header[1] == "[[":
                name = table
                counts[name] = counts.get(name, -1) + 1
                table = (*name, str(counts[name]))
            at = tables[table] = header.end()
        elif key := _KEY.match(text, at):
            path = (*table, *_split(key[1]))
            at = _value(text, key.end(), path, spans)
            newline = text.find("\n", at)
            tables[table] = len(text) if newline < 0 else newline + 1
        else:
            break
    return spans, tables


def _under(name: Path, counts: dict[Path, int]) -> Path:
    """Return a table's path, with the number of the array's table that it belongs to."""
    found: Path = ()
    for part in name[:-1]:
        found = (*found, part)
        found = (*found, str(counts[found])) if found in counts else found
    return (*found, name[-1])


def _split(dotted: str) -> Path:
    return tuple(part.strip().strip("\"'") for part in dotted.split("."))


def _value(text: str, at: int, path: Path, spans: dict[Path, Span]) -> int:
    """Note the position of a value and of those within it; return its end."""
    start = at
    if text[at : at + 1] in ("[", "{"):
        table, number = text[at] == "{", 0
        at = _SPACE.match(text, at + 1).end()  # type: ignore[union-attr]
        while at < len(text) and text[at] not in "]}":
            inner = (*path, str(number))
            if table:
                key = _KEY.match(text, at)
                if key is None:
                    return len(text)
                inner, at = (*path, *_split(key[1])), key.end()
            at = _SPACE.match(text, _value(text, at, inner, spans)).end()  # type: ignore[union-attr]
            if text[at : at + 1] == ",":
                at = _SPACE.match(text, at + 1).end()  # type: ignore[union-attr]
            number += 1
        at += 1
    elif text[at : at + 1] in ('"', "'"):
        quote = text[at]
        at += 1
        while at < len(text) and text[at] != quote:
            at += 2 if text[at] == "\\" and quote == '"' else 1
        at += 1
    else:
        at = re.compile(r"[^,\]}#\n]*").match(text, at).end()  # type: ignore[union-attr]
        at = start + len(text[start:at].rstrip())
    spans[path] = (start, min(at, len(text)))
    return max(at, start + 1)
