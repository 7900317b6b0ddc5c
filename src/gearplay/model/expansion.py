"""Thermal expansion: centre distances, radii, clearances and backlash of a case at its temperatures.

With f = 1 + expansion (temperature - reference) of each part (docs/theory, section 4): a housing moves nominal centres by its f,
a carrier its pins by its own; a pair of gears meshes at |r_a f_a + r_b f_b| as it did at |r_a + r_b|; a bush and its journal
leave (R + c) f_bush - R f_journal.
"""

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, NamedTuple

from gearplay.parts.mesh.temperature import mesh_at_temperature, thermal_texts
from gearplay.parts.mesh.train import geometry
from gearplay.parts.planetary.paths import settable_paths
from gearplay.parts.protocol import Holder
from gearplay.parts.tables import HOLDERS
from gearplay.schema.fields import FrozenTable
from gearplay.schema.units import ICE
from gearplay.vocabulary.errors import NO_VALUE, Fault, InputError, join_path

if TYPE_CHECKING:
    from gearplay.model.case import Case
    from gearplay.parts.environment import Environment


class _Factors(NamedTuple):
    """Factors of all lengths, by rotor and of the housing."""

    rotors: Mapping[str, float]
    housing: float


def expanded(case: "Case") -> "Case":
    """Return the case with the lengths at the temperatures of its parts; the same object if none changes.

    Raises `InputError` where an expansion is needed that is not given, or a journal no longer fits its bush.
    """
    with settable_paths(case):
        return _expanded(case)


def _expanded(case: "Case") -> "Case":
    environment = case.environment
    if environment is None:
        return case
    factors, faults = _factors(case, environment)
    holders: dict[str, dict[str, Holder]] = {table: {} for table in HOLDERS}
    for table, name, part in case.every_holder():
        bush = factors.housing if part.on is None else factors.rotors[part.on]
        path = join_path([table, name])
        try:
            holders[table][name] = part.at_temperature(path, factors.rotors[name], bush)
        except InputError as error:
            faults += error.faults
    if faults:
        raise InputError(faults)
    if factors.housing == 1.0 and all(factor == 1.0 for factor in factors.rotors.values()):
        return case
    centres = _moved(case, factors)
    rotors = {
        name: rotor.at_temperature(factors.rotors[name], centres[name]) for name, rotor in case.rotors.items()
    }
    meshes = tuple(mesh_at_temperature(case, j, factors.rotors) for j in range(len(case.meshes)))
    update: dict[str, object] = {"environment": None, "rotors": FrozenTable(rotors), "meshes": meshes}
    return case.model_copy(update=update | {table: FrozenTable(parts) for table, parts in holders.items()})


def _factors(case: "Case", environment: "Environment") -> tuple[_Factors, list[Fault]]:
    """Return the factors of a case, and the faults of expansions that are needed and not given, whose factors are NaN."""
    reference, housing = environment.reference_temperature, environment.housing
    rotors, faults = {}, []
    for name, rotor in case.rotors.items():
        warmer = (rotor.temperature or environment.temperature) - reference
        if warmer == 0.0 or not _matters(case, name):
            rotors[name] = 1.0
        elif rotor.material is None:
            degrees = f"{warmer + reference - ICE:.6g} degC"
            rule = f"is required at {degrees}, {abs(warmer):.6g} K from the reference temperature"
            cure = 'Give it a material = { expansion = "11.5e-6 1/K" }'
            rotors[name] = math.nan
            faults.append(Fault(join_path(["rotors", name, "material"]), NO_VALUE, rule, cure))
        else:
            rotors[name] = 1.0 + rotor.material.expansion * warmer
    warmer = ((housing and housing.temperature) or environment.temperature) - reference
    if warmer == 0.0:
        return _Factors(rotors, 1.0), faults
    if housing is None:
        rule = "is required at a temperature other than the reference temperature"
        cure = 'Write for example housing = { expansion = "23.1e-6 1/K" }'
        faults.append(Fault("environment.housing", NO_VALUE, rule, cure))
        return _Factors(rotors, math.nan), faults
    return _Factors(rotors, 1.0 + housing.expansion * warmer), faults


def _matters(case: "Case", name: str) -> bool:
    """Return whether a length of the case belongs to a rotor: toothed in a mesh, in a sleeve, or a carrier."""
    return (
        geometry.clearance_of(case, name) is not None
        or any(name in mesh.rotors for mesh in case.meshes)
        or any(geometry.carrier_of(case, other) == name for other in case.rotors)
    )


def _moved(case: "Case", factors: _Factors) -> dict[str, tuple[float, float]]:
    """Return every rotor's nominal centre [m] in the expanded housing, on expanded carriers."""
    centres = geometry.centres(case)
    moved: dict[str, tuple[float, float]] = {}

    def place(name: str) -> tuple[float, float]:
        if name not in moved:
            carrier = geometry.carrier_of(case, name)
            x, y = centres[name]
            if carrier is None:
                moved[name] = (factors.housing * x, factors.housing * y)
            else:
                at, f = place(carrier), factors.rotors[carrier]
                x, y = x - centres[carrier][0], y - centres[carrier][1]
                moved[name] = (at[0] + f * x, at[1] + f * y)
        return moved[name]

    for name in case.rotors:
        place(name)
    return moved


def thermal_changes(case: "Case") -> dict[str, str]:
    """Return texts on the thermal changes of a case's lengths, by field; empty where nothing changes."""
    hot = case.operating
    if hot is case:
        return {}
    texts = thermal_texts(case, hot)
    for (table, name, cold_part), (_, _, hot_part) in zip(
        case.every_holder(), hot.every_holder(), strict=True
    ):
        if (change := cold_part.thermal_change(hot_part)) is not None:
            texts[join_path([table, name, change[0]])] = change[1]
    return texts
