"""Free coordinates without mass: linear analysis condenses them statically, a simulation over time needs an inertia."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from gearplay.model import geometry
from gearplay.vocabulary.errors import Fault, InputError, join_path

if TYPE_CHECKING:
    from gearplay.model.case import Case

UNITS = {"mass": "kg", "inertia": "kg m^2"}


def field_path(case: Case, name: str, *fields: str) -> str:
    """Return the path of a field of a rotor, which may be a member of a planetary set."""
    part, _, member = name.partition(".")
    if part not in case.planetary:
        return join_path(["rotors", name, *fields])
    return join_path(["planetary", part, "planets" if member.startswith("planet") else member, *fields])


def massless(case: Case) -> Iterator[tuple[str, str]]:
    """Yield rotors with free coordinates of no mass, and the field that is 0: ``mass`` of a centre, ``inertia`` of a rotation."""
    for name, rotor in case.rotors.items():
        if rotor.mass == 0.0 and not geometry.is_held(case, name):
            yield name, "mass"
        if rotor.inertia == 0.0 and (rotor.drive is None or rotor.drive.kind != "speed"):
            yield name, "inertia"


def refuse_massless(case: Case) -> None:
    """Raise `InputError` where a case has free coordinates without mass, which have no acceleration to integrate."""
    cure = "Give it a positive one; modes, campbell, frequency_response and load_sharing take 0"
    paths = {field_path(case, name, field): field for name, field in massless(case)}
    if paths:
        rule = "must be greater than 0 {} for a simulation over time"
        raise InputError([Fault(path, 0.0, rule.format(UNITS[field]), cure) for path, field in paths.items()])
