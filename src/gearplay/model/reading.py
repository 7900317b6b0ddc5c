"""Reading of cases from files, bundled cases and dictionaries, and changed copies."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, Final

from pydantic import ValidationError

from gearplay.model.bundled import bundled, bundled_text
from gearplay.model.case import NO_ROTORS, Case
from gearplay.model.consistency import cross_faults
from gearplay.model.file_kinds import check_kind
from gearplay.model.item_names import numbered
from gearplay.model.overrides import apply_change, parse_override
from gearplay.model.tables import brings_file, with_tables, without_replaced
from gearplay.model.toml_files import parse_toml, plain_copy, toml_text, write_toml
from gearplay.model.torsional_pair import FIELD, PARTS, speed_fault
from gearplay.model.wording import translate
from gearplay.parts.mesh.schema import Mesh
from gearplay.parts.planetary.expansion import assumed_members, with_members
from gearplay.parts.rotor.schema import Rotor
from gearplay.parts.tables import HOLDERS, JOINTS
from gearplay.schema.fields import FrozenTable, Part
from gearplay.vocabulary.errors import Fault, InputError, shorten
from gearplay.vocabulary.suggestions import did_you_mean

_MOST_OVERRIDES: Final = 1000

Source = Case | str | os.PathLike[str] | Mapping[str, Any]
"""What every public function takes as a case: one, a bundled name, a path, or a table laid out as a file."""


def bundled_names() -> list[str]:
    """Return the names of the cases that come with the package.

    Examples
    --------
    >>> "han2021" in bundled_names()
    True

    """
    return bundled("gearplay.model", "cases")


def load_case(source: Source, overrides: Sequence[str] = ()) -> Case:
    """Read a case.

    Parameters
    ----------
    source
        Name of a bundled case, path of a TOML file, a dictionary laid out as such a file, or a `Case`.
    overrides
        Changes such as ``"meshes.0.backlash=200 um"``, applied before validation.

    Returns
    -------
    Case
        Validated, in SI.

    Raises
    ------
    InputError
        With every fault found.

    Examples
    --------
    >>> load_case("han2021", ["meshes.0.backlash = 200 um"]).meshes[0].backlash
    0.0002

    """
    if isinstance(source, Case) and not overrides:
        return source
    if len(overrides) > _MOST_OVERRIDES:
        raise InputError.of(
            "overrides", len(overrides), f"must be at most {_MOST_OVERRIDES}", "Write a case file"
        )
    changes = [parse_override(text) for text in overrides]
    if isinstance(source, Case):
        return replace(source, dict(changes))
    document, folder = _document(source)
    if document.get(FIELD) is not None and changes:
        return replace(_changed(document, (), folder), dict(changes))
    case = _changed(document, changes, folder)
    return case.with_changed(numbered(case, path) for path, _ in changes) if changes else case


def replace(case: Source, changes: Mapping[str, Any]) -> Case:
    """Return a copy of a case with changes, validated anew.

    Parameters
    ----------
    case
        A `Case`, a bundled name, a path or a mapping.
    changes
        New values by path (``meshes.pinion-ring.backlash`` or ``meshes.0.backlash``), as numbers in SI, text with a unit, or
        tables; None removes an optional value. A ``file`` of a table is a path from the current directory.

    Returns
    -------
    Case
        The changed copy.

    Raises
    ------
    InputError
        With every fault found.

    Examples
    --------
    >>> changed = replace(load_case("han2021"), {"meshes.0.backlash": "200 um", "run.seed": 3})
    >>> changed.meshes[0].backlash, changed.run.seed
    (0.0002, 3)

    """
    case = load_case(case)
    if case.torsional_pair is not None:
        case, changes = _other_pair(case, changes)
    wanted = [(str(path), plain_copy(value)) for path, value in changes.items()]
    paths = [path for path, _ in wanted]
    if any(brings_file(path, value) for path, value in wanted):
        made = _changed(case.resolved(), wanted)
        return made.with_changed([*case.changed, *(numbered(case, path) for path in paths)])
    opened = _opened(case, paths)
    if all(apply_change(opened, path, value) is None for path, value in wanted):
        with suppress(ValidationError):
            return Case.model_validate(opened).with_changed(
                [*case.changed, *(numbered(case, path) for path in paths)]
            )
    return _changed(case.resolved(), wanted)  # reports the fault


def _other_pair(case: Case, changes: Mapping[str, Any]) -> tuple[Case, dict[str, Any]]:
    """Apply the changes of a torsional pair's own numbers; return the pair and the remaining changes.

    Where these are of its parts, it is a pair of the literature no more; a speed alone is refused.
    """
    own = {path: value for path, value in changes.items() if str(path).partition(".")[0].strip() == FIELD}
    others = {str(path): value for path, value in changes.items() if path not in own}
    faults = [speed_fault(path, value) for path, value in others.items() if _is_speed(path)]
    if faults:
        raise InputError(faults)
    if own:
        document = case.resolved()
        case = _changed(document, [(str(path), plain_copy(value)) for path, value in own.items()])
        case = case.with_changed(map(str, own))
    if any(path.partition(".")[0].strip() in PARTS for path in others):
        document = {**case.resolved(), **case.model_dump(mode="json", include=set(PARTS))}
        case = _changed({name: part for name, part in document.items() if name != FIELD}, ())
    return case, others


def _is_speed(path: str) -> bool:
    return path.startswith("rotors.") and path.rpartition(".")[2].strip() in ("speed", "start_speed")


def to_toml(case: Case) -> str:
    """Write a case as TOML in SI, every default included; `load_case` reads it back to an equal case."""
    return write_toml(case.resolved())


def _opened(case: Case, paths: Iterable[str]) -> dict[str, Any]:
    """Return a case as a raw one that keeps its parts, except those along a path, which are read anew."""
    document = _fields(case)
    for path in paths:
        place: Any = document
        for part in map(str.strip, numbered(case, path).split(".")):
            at: Any = part
            if isinstance(place, list):
                at = int(part) if part in map(str, range(len(place))) else None
            if at is None or (isinstance(place, dict) and at not in place):
                break
            inner = place[at]
            if isinstance(inner, Part):
                place[at] = _fields(inner)
            elif isinstance(inner, FrozenTable):
                place[at] = dict(inner)
            elif isinstance(inner, tuple):
                place[at] = list(inner)
            elif not isinstance(inner, (dict, list)):
                break
            place = place[at]
    return document


def _fields(part: Part) -> dict[str, Any]:
    return {name: getattr(part, name) for name in type(part).model_fields}


def _changed(document: dict[str, Any], changes: Sequence[tuple[str, Any]], folder: Path = Path()) -> Case:
    """Return the case of a raw one with changes; its own files lie in ``folder``, those of changes in the current directory."""
    without_replaced(document, changes)
    document = with_tables(document, folder)
    faults = [fault for path, value in changes if (fault := apply_change(document, path, value)) is not None]
    try:
        case = _validated(with_tables(document, Path()))
    except InputError as error:
        raise InputError(faults + error.faults) from None
    if faults:
        raise InputError(faults)
    return case


def _document(source: str | os.PathLike[str] | Mapping[str, Any]) -> tuple[dict[str, Any], Path]:
    """Return the raw case behind a source, plain dictionaries, lists and values, and the folder of the files that it names."""
    if isinstance(source, Mapping):
        copied: dict[str, Any] = plain_copy(source)
        return copied, Path()
    if not isinstance(source, (str, os.PathLike)):
        rule = "must be a Case, a bundled name, a path or a table"
        raise InputError.of("case", source, rule, "Pass one of these")
    name = os.fspath(source)
    if not isinstance(name, str):
        raise InputError.of("case", name, "must be a path as text", "Decode it first")
    known = bundled_names()
    if name in known:
        text, folder = bundled_text("gearplay.model", "cases", name), Path()
        where = name
    else:
        path = Path(name)
        if _looks_like_a_name(name):
            rule = "must be a bundled case or the path of a file"
            close = did_you_mean(name, known, "Bundled cases")
            every = f"{close} Bundled cases: {', '.join(known)}" if close.endswith("?") else close
            raise InputError.of("case", name, rule, every)
        text, where, folder = toml_text(path), shorten(path.name), path.parent
    document: dict[str, Any] = plain_copy(parse_toml(text, where))
    check_kind(document, "case", "case", where)
    if "case" in document and not document.keys() & {"rotors", "planetary", FIELD}:
        rule = "must be a case, but this is a plan, which names its case"
        raise InputError.of("case", where, rule, "Run it with gearplay sweep or calibrate, or name its case")
    return document, folder


def _looks_like_a_name(name: str) -> bool:
    if any(mark in name for mark in "/\\\0") or name.endswith(".toml"):
        return False
    try:
        return not os.path.lexists(name)
    except (OSError, ValueError):
        return True


def _validated(document: dict[str, Any]) -> Case:
    try:
        return Case.model_validate(document)
    except ValidationError as error:
        faults = translate(error, document, Case)
    if document.get("rotors") == {} and not document.get("planetary") and not document.get(FIELD):
        faults.insert(0, NO_ROTORS)
    raise InputError(faults + _faults_between_parts(document, {fault.path for fault in faults}))


def _faults_between_parts(document: Mapping[str, Any], known: set[str]) -> list[Fault]:
    """Check names across parts although some part is at fault, so that one reading reports everything."""
    assumed = assumed_members(document)
    document = with_members(document)
    rotors = {name: _part(Rotor, raw) for name, raw in _table(document, "rotors").items()} | assumed
    if not rotors:
        return []
    parts: dict[str, Any] = {
        "rotors": rotors,
        "meshes": [_part(Mesh, raw) for raw in _listed(document, "meshes")],
    }
    for table, holder in HOLDERS.items():
        parts[table] = {name: _part(holder, raw) for name, raw in _table(document, table).items()}
    for listed, joint in JOINTS.items():
        parts[listed] = [_part(joint, raw) for raw in _listed(document, listed)]
    faults = cross_faults(parts)
    return [fault for fault in faults if fault.path not in known]


def _table(document: Mapping[str, Any], name: str) -> Mapping[str, Any]:
    found = document.get(name)
    return found if isinstance(found, Mapping) else {}


def _listed(document: Mapping[str, Any], name: str) -> list[Any]:
    found = document.get(name)
    return found if isinstance(found, list) else []


def _part(kind: type[Part], raw: object) -> Any:
    """Return the part if it is valid on its own, else its raw table."""
    try:
        return kind.model_validate(raw)
    except ValidationError:
        return raw if isinstance(raw, Mapping) else {}
