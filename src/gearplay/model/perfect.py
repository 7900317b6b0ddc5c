"""A case with gears free of errors, from centred shafts: the reference that transmission error and wind-up count from."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from gearplay.parts.mesh.faults import GearFault
from gearplay.parts.rotor.gear import Runout
from gearplay.parts.rotor.schema import Initial, Rotor
from gearplay.schema.fields import FrozenTable

if TYPE_CHECKING:
    from gearplay.model.case import Case

ERRORS: dict[str, Any] = {"runout": Runout(), "tip_relief": None, "quality": None, "deviations": None}
"""Fields of a gear that are errors of its flanks or of its seat, at the values of a perfect gear."""


def perfect_rotor(rotor: Rotor) -> Rotor:
    """Return a rotor whose gears have no run-out, relief and deviations."""
    gears = FrozenTable({name: gear.model_copy(update=ERRORS) for name, gear in rotor.gears.items()})
    return rotor.model_copy(update={**ERRORS, "gears": gears})


def perfect_case(case: Case) -> Case:
    """Return a case without errors and faults of its gears, with centred shafts and no given rotations.

    It is the case itself where this changes nothing.
    """
    rotors = {
        name: perfect_rotor(rotor).model_copy(update={"initial": Initial()})
        for name, rotor in case.rotors.items()
    }
    meshes = tuple(mesh.model_copy(update={"transmission_error": ()}) for mesh in case.meshes)
    faults = tuple(fault for fault in case.faults if not isinstance(fault, GearFault))
    if (rotors, meshes, faults) == (dict(case.rotors), tuple(case.meshes), tuple(case.faults)):
        return case
    return case.model_copy(update={"rotors": FrozenTable(rotors), "meshes": meshes, "faults": faults})
