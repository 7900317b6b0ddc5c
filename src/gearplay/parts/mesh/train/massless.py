"""Free coordinates without mass: linear analysis condenses them statically, a simulation over time needs an inertia."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from gearplay.parts.mesh.train import geometry
from gearplay.vocabulary.errors import Fault, InputError

if TYPE_CHECKING:
    from gearplay.parts.mesh.train.train import Train

UNITS = {"mass": "kg", "inertia": "kg m^2"}


def massless(case: Train) -> Iterator[tuple[str, str]]:
    """Yield rotors with free coordinates of no mass, and the field that is 0: ``mass`` of a centre, ``inertia`` of a rotation."""
    for name, rotor in case.rotors.items():
        if rotor.mass == 0.0 and not geometry.is_held(case, name):
            yield name, "mass"
        if rotor.inertia == 0.0 and not rotor.is_prescribed:
            yield name, "inertia"


def refuse_massless(case: Train) -> None:
    """Raise `InputError` where a case has free coordinates without mass, which have no acceleration to integrate."""
    cure = "Give it a positive one; modes, campbell, frequency_response and load_sharing take 0"
    paths = {case.field_path(name, field): field for name, field in massless(case)}
    if paths:
        rule = "must be greater than 0 {} for a simulation over time"
        raise InputError([Fault(path, 0.0, rule.format(UNITS[field]), cure) for path, field in paths.items()])
