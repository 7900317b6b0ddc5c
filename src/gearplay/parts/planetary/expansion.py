"""Expansion of planetary sets into their members, and their names in the set."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from typing import TYPE_CHECKING, Any, Final

from pydantic import ValidationError

from gearplay.parts.planetary.names import MEMBERS, MOST_PLANETS
from gearplay.schema.fields import NAME
from gearplay.vocabulary.errors import NO_VALUE, Fault, join_path

if TYPE_CHECKING:
    from gearplay.parts.planetary.schema import Planetary

TABLES: Final = ("rotors", "sleeves", "supports", "bearings")


def with_members(given: Mapping[str, Any]) -> dict[str, Any]:
    """Return the fields of a case with the parts of its planetary sets, replacing the parts of the sets as they were before.

    An invalid set is not expanded: its own validation reports the fault.
    """
    sets = given.get("planetary")
    if not isinstance(sets, Mapping) or not sets:
        return dict(given)
    named = {name: raw for name, raw in sets.items() if isinstance(name, str) and re.fullmatch(NAME, name)}
    case = without_members(given, named)
    valid = {name: part for name, raw in named.items() if (part := _valid(raw)) is not None}
    case["planetary"] = {**sets, **valid}  # need not be validated again
    parts = [part.parts(name) for name, part in valid.items()]
    for k, table in enumerate(TABLES):
        if not isinstance(case.get(table, {}), Mapping):
            return case  # at fault
        if table == "bearings" and not any(each[k] for each in parts):
            continue
        made = {name: part for each in parts for name, part in each[k].items()}  # type: ignore[union-attr]
        case[table] = {**case.get(table, {}), **made}
    meshes = case.get("meshes", ())
    if isinstance(meshes, (list, tuple)):
        case["meshes"] = [*meshes, *(mesh for each in parts for mesh in each[-1])]
    return case


def without_members(given: Mapping[str, Any], sets: Iterable[str]) -> dict[str, Any]:
    """Return the fields of a case without the expanded parts of its planetary sets."""
    case, sets = dict(given), set(sets)
    if not sets:
        return case
    for table in TABLES:
        if isinstance(case.get(table), Mapping) and case[table]:
            case[table] = {k: part for k, part in case[table].items() if not _is_made(table, k, sets)}
    if isinstance(case.get("meshes"), (list, tuple)):
        case["meshes"] = [mesh for mesh in case["meshes"] if not _is_within(mesh, sets)]
    return case


def assumed_members(given: Mapping[str, Any]) -> dict[str, Any]:
    """Return raw rotors of invalid sets, so that references to them are not reported as faults too."""
    sets = given.get("planetary")
    found: dict[str, Any] = {}
    for name, raw in sets.items() if isinstance(sets, Mapping) else ():
        if not isinstance(name, str) or _valid(raw) is not None:
            continue
        raw = raw if isinstance(raw, Mapping) else {}
        planets = _table(raw, "planets")
        count = planets.get("count")
        number = count if isinstance(count, int) and 1 <= count <= MOST_PLANETS else MOST_PLANETS
        parts = {**{member: _table(raw, member) for member in MEMBERS}}
        parts |= {f"planet{k}": planets for k in range(1, number + 1)}
        found |= {f"{name}.{member}": {"teeth": 0, **part} for member, part in parts.items()}
    return found


def _table(raw: Mapping[str, Any], name: str) -> Mapping[str, Any]:
    part = raw.get(name)
    return part if isinstance(part, Mapping) else {}


def _valid(raw: Any) -> Planetary | None:
    from gearplay.parts.planetary.schema import Planetary

    if isinstance(raw, Planetary):
        return raw
    try:
        return Planetary.model_validate(raw)
    except ValidationError:
        return None


def _is_member(name: object, sets: Iterable[str]) -> bool:
    return isinstance(name, str) and "." in name and name.partition(".")[0] in sets


def _is_made(table: str, name: object, sets: Iterable[str]) -> bool:
    """Return whether a planetary set generates a part: any part of a member, in ``bearings`` only those of planets."""
    planets = table != "bearings" or ".planet" in str(name)
    return planets and _is_member(name, sets)


def _is_within(mesh: Any, sets: Iterable[str]) -> bool:
    """Return whether a mesh joins two members of planetary sets."""
    ends = [
        mesh.get(role) if isinstance(mesh, Mapping) else getattr(mesh, role, None)
        for role in ("driver", "driven")
    ]
    return all(_is_member(name, sets) for name in ends)


def set_faults(sets: Mapping[str, Planetary], rotors: Mapping[str, Any]) -> Iterator[Fault]:
    """Yield faults between planetary sets and the rotors of a case."""
    for name in sets:
        if name in rotors:
            rule = "must not be the name of a rotor too"
            yield Fault(join_path(["planetary", name]), NO_VALUE, rule, "Call one of the two otherwise")
    for name in rotors:
        if "." in name and name.partition(".")[0] not in sets:
            rule = "is no rotor: a dot is for members of planetary sets, which [planetary.NAME] stands for"
            yield Fault(join_path(["rotors", name]), NO_VALUE, rule, "Call it without a dot")
