"""Paths of fields that a user sets, of parts that a planetary set stands for: ``rotors.first.sun.inertia``."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any, Final

from gearplay.parts.raw import read, text
from gearplay.vocabulary.errors import InputError

_MEMBER: Final = re.compile(
    r'(rotors|sleeves|supports|bearings)\."?(\w+)\.(sun|ring|carrier|planet\d+)"?(?:\.(.+))?'
)
_MESH: Final = re.compile(r"meshes\.(\d{1,6})(?:\.(.+))?")
_SEATS: Final = {"sleeves": "pin", "supports": "support", "bearings": "bearing"}


def settable_path(case: Any, path: str) -> str:
    """Return the path of the field of a planetary set that stands for a field of one of its parts; other paths unchanged.

    Parameters
    ----------
    case
        A `Case`, or the raw table of one with the parts of its sets.
    path
        Path with the tables of parts: ``rotors.SET.sun.inertia``, ``sleeves.SET.planet1.shaft_radius``,
        ``meshes.0.stiffness.kind``. A field that the set has not becomes the nearest table that has it.

    Examples
    --------
    >>> case = {"planetary": {"first": {"sun_planet": {}}}, "meshes": [{"driver": "first.sun", "driven": "first.planet1"}]}
    >>> settable_path(case, "rotors.first.sun.inertia"), settable_path(case, "meshes.0.stiffness.kind")
    ('planetary.first.sun.inertia', 'planetary.first.sun_planet.kind')
    >>> settable_path(case, "sleeves.first.planet2.shaft_radius"), settable_path(case, "rotors.motor.inertia")
    ('planetary.first.pin.shaft_radius', 'rotors.motor.inertia')

    """
    sets = read(case, "planetary")
    if not isinstance(sets, Mapping) or not sets:
        return path
    if (found := _MESH.fullmatch(path)) is not None:
        return _of_mesh(case, sets, int(found[1]), found[2] or "") or path
    found = _MEMBER.fullmatch(path)
    if found is None or found[2] not in sets:
        return path
    table, name, member, field = found[1], found[2], found[3], found[4] or ""
    if table == "rotors":
        return _of_rotor(sets[name], name, member, field)
    if member.startswith("planet"):
        own = "" if field.partition(".")[0] in ("on", "offset") else field
        return _joined("planetary", name, _SEATS[table], own)
    if table == "bearings":  # of the case itself
        return path
    return _joined("planetary", name, member, table.removesuffix("s"), field)


@contextmanager
def settable_paths(case: Any) -> Iterator[None]:
    """Name the fields of planetary sets in the faults of an `InputError` that is raised within."""
    try:
        yield
    except InputError as error:
        faults = [fault._replace(path=settable_path(case, fault.path)) for fault in error.faults]
        raise type(error)({(each.path, each.rule, each.cure): each for each in faults}.values()) from None


def _joined(*parts: str) -> str:
    return ".".join(part for part in parts if part)


def _of_rotor(part: Any, name: str, member: str, field: str) -> str:
    from gearplay.parts.planetary.members import Member, Planets, Toothed

    first = field.partition(".")[0]
    if first == "position":
        return f"planetary.{name}.{'center_distance' if member.startswith('planet') else 'position'}"
    if member.startswith("planet"):
        own = [read(each, "planet") for each in read(part, "eccentricities") or ()]
        if first == "runout" and int(member.removeprefix("planet")) in own:
            place = own.index(int(member.removeprefix("planet")))
            return _joined("planetary", name, "eccentricities", str(place), field.partition(".")[2])
        return _joined("planetary", name, "planets", field if first in Planets.model_fields else "")
    if first == "drive" and read(read(part, member), "fixed") is True:
        return f"planetary.{name}.{member}.fixed"
    known = Member if member == "carrier" else Toothed
    return _joined("planetary", name, member, field if first in known.model_fields else "")


def _of_mesh(case: Any, sets: Mapping[str, Any], j: int, field: str) -> str:
    """Return the path of the set's field for one of mesh j; an empty text for a mesh of the case itself."""
    from gearplay.parts.planetary.schema import SHARED

    meshes = read(case, "meshes") or ()
    ends = [text(meshes[j], role) or "" for role in ("driver", "driven")] if j < len(meshes) else [""]
    names = {end.partition(".")[0] for end in ends if "." in end}
    if not all("." in end for end in ends) or not names or not names <= sets.keys():
        return ""
    name, (first, _, rest) = ends[0].partition(".")[0], field.partition(".")
    if first == "stiffness" and read(sets[name], "stiffness") is None:
        kind = "sun_planet" if any(end.endswith(".sun") for end in ends) else "planet_ring"
        return _joined("planetary", name, kind, rest)
    return _joined("planetary", name, field if first in (*SHARED, "stiffness") else "")
