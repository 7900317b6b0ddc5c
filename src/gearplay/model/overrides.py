"""Changes by path: ``meshes.0.backlash = 200 um`` applied to a raw case before validation."""

from __future__ import annotations

import tomllib
from typing import Any, Final

from gearplay.model.case import Case
from gearplay.model.item_names import LISTS, item_names, numbered
from gearplay.model.toml_files import DEEPEST, plain_copy, text_depth
from gearplay.model.wording import known_fields
from gearplay.parts.planetary.expansion import TABLES, with_members
from gearplay.parts.planetary.paths import settable_path
from gearplay.parts.tables import HOLDERS
from gearplay.vocabulary.errors import NO_VALUE, Fault, InputError, join_path, shorten
from gearplay.vocabulary.suggestions import did_you_mean, listed

LONGEST: Final = 4096
"""Longest override [characters]."""

_NAMED: Final = {name: name.capitalize() for name in ("rotors", *HOLDERS)} | {"planetary": "Planetary sets"}
_LISTED: Final = ("faults", *LISTS)


def parse_override(text: str) -> tuple[str, Any]:
    """Split ``path=value``; the value is TOML where it reads as such, otherwise text.

    Examples
    --------
    >>> parse_override("meshes.0.backlash=200 um"), parse_override("run.seed = 3")
    (('meshes.0.backlash', '200 um'), ('run.seed', 3))

    """
    path, mark, value = text.partition("=")
    if not mark or not path.strip():
        raise InputError.of("change", text, "must be path=value", "Write for example meshes.0.backlash=200um")
    if len(text) > LONGEST:
        raise InputError.of("change", text, f"must have at most {LONGEST} characters", "Write a case file")
    return path.strip(), _literal(value.strip())


def _literal(text: str) -> Any:
    if "\n" in text or text_depth(text) > DEEPEST:
        return text
    try:
        document = tomllib.loads(f"value = {text}")
    except (ValueError, RecursionError):
        return text
    value = document.get("value") if len(document) == 1 else text
    return plain_copy(value)


def apply_change(document: dict[str, Any], path: str, value: Any) -> Fault | None:
    """Set the value at `path` in a raw case; return the fault where the path leads nowhere.

    Tables that a file may leave out are created on the way; whether the last name is a field is checked in validation,
    which also suggests the nearest one.
    """
    if (fault := _of_set(document, path)) is not None:
        return fault
    parts = [part.strip() for part in numbered(document, path).split(".")]
    if len(parts) > DEEPEST or not all(parts):
        return Fault(
            join_path(parts[:DEEPEST]), NO_VALUE, "is not a path of a field", "Write names with single dots"
        )
    place: Any = document
    for index, part in enumerate(parts):
        last = index == len(parts) - 1
        if isinstance(place, list):
            if not part.isdecimal() or len(part) > 6 or int(part) >= len(place):
                count = f"has {len(place)} {'item' if len(place) == 1 else 'items'}, counted from 0"
                rule = f"no such item: {join_path(parts[:index])} {count}"
                names = item_names(document, parts[0]) if index == 1 and parts[0] in LISTS else []
                cure = f"Write its number or its name: {listed(names, 8)}" if names else "Correct the number"
                return Fault(join_path(parts[: index + 1]), NO_VALUE, rule, cure)
            if last:
                place[int(part)] = value
            else:
                place = place[int(part)]
        elif isinstance(place, dict):
            fault = _unknown(document, place, parts, index, value)
            if fault is not None:
                return fault
            if last:
                place[part] = value
            else:
                if place.get(part) is None:
                    place[part] = [] if index == 0 and part in _LISTED else {}
                place = place[part]
        else:
            return Fault(
                join_path(parts[:index]),
                place,
                "has no parts to set",
                f"Set {join_path(parts[:index])} itself",
            )
    return None


def _of_set(document: dict[str, Any], path: str) -> Fault | None:
    """Return the fault of a path into a part that a planetary set of a raw case stands for, with the path of its field."""
    table = path.partition(".")[0].strip()
    if not document.get("planetary") or table not in (*TABLES, "meshes"):
        return None
    expanded = with_members(document)
    parts = [part.strip() for part in numbered(expanded, path).split(".")]
    field = settable_path(expanded, ".".join(parts))
    if field.split(".") == parts:
        return None
    rule = f"is of the planetary set {field.split('.')[1]}, which stands for all its rotors, pins and meshes"
    return Fault(path, NO_VALUE, rule, f"Change {field}")


def _unknown(
    document: dict[str, Any], place: dict[str, Any], parts: list[str], index: int, value: Any
) -> Fault | None:
    """Return a fault if a name along the path is neither present nor a field that may be added."""
    part, last = parts[index], index == len(parts) - 1
    if part in place:
        return None
    here = join_path(parts[: index + 1])
    if index == 1 and parts[0] in _NAMED:
        if last and isinstance(value, dict):
            return None
        return Fault(here, NO_VALUE, "no such entry", did_you_mean(part, place, _NAMED[parts[0]]))
    if last:
        return None
    path = tuple(int(p) if p.isdecimal() and len(p) < 7 else p for p in parts[:index])
    known = known_fields(Case, path, document)
    if part in known:
        return None
    return Fault(here, NO_VALUE, "unknown field", did_you_mean(shorten(part), known, "Fields"))
