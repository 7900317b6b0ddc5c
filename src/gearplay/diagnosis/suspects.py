"""Changes of a case that bring hypotheses about: faults of three severities, worn flanks, worn bushes."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

from gearplay.diagnosis.hypotheses import Hypothesis
from gearplay.diagnosis.machine import Machine
from gearplay.diagnosis.measures import PARTS
from gearplay.model.case import Case
from gearplay.model.reading import replace
from gearplay.parts.bearing.faults import touching
from gearplay.parts.mesh.faults import SINGLE_TEETH, SpallFault
from gearplay.parts.mesh.train.geometry import full_name, gear_of, pair_of, working_backlash
from gearplay.vocabulary.errors import InputError

AS_IT_IS: Final = "the case as it is"
CRACKS: Final = (0.2, 0.4, 0.6)
"""Depths of a crack, of the module."""
SPALLS: Final = (0.002, 0.01, 0.05)
"""Depths of a spall, of the module."""
ECCENTRICITIES: Final = (0.005, 0.02, 0.06)
"""Eccentricities, of the module."""
DENTS: Final = (2e-6, 6e-6, 18e-6)
"""Depths of a dent in a bearing [m]."""
POCKETS: Final = (0.1, 0.3, 0.9)
"""Distances of an element from its even place in a broken cage, of the free one to its neighbour."""
WORN: Final = (1.5, 2.0, 3.0)
"""Clearances of a worn machine, of those of the case."""
MOST_BUSHES: Final = 3
"""Most bushes that are worn in turn."""


@dataclass(frozen=True)
class Suspect:
    """A cause that can be simulated: ``levels`` of rising severity, each in words with its changes of the case.

    ``hypothesis`` is the name of the one that it stands for, empty for wear; ``quantity`` and ``sizes`` [m] measure the severity.
    """

    name: str
    kind: str
    hypothesis: str
    quantity: str
    sizes: tuple[float, ...]
    levels: tuple[Mapping[str, Any], ...]


def suspects_of(
    case: Case, machine: Machine, every: Sequence[Hypothesis], loads: Mapping[str, float]
) -> tuple[list[Suspect], list[str]]:
    """Return the causes to simulate for the hypotheses, wear of flanks and bushes among them, and what cannot be simulated.

    ``loads`` has the direction [rad] in which the force of the rotor presses each bearing's ring, where a dent of the outer ring
    is passed under load.
    """
    found, said = list[Suspect](), list[str]()
    for h in every:
        made = list(_faults(case, machine, h, loads))
        if not made and h.kind != "rattle":
            said.append(f"{h.name} cannot be simulated: {_reason(case, machine, h)}.")
        found += made
    found += _wear(case)
    kept = []
    for each in found:
        try:
            for changes in each.levels:
                replace(case, changes)
        except InputError as error:
            said.append(f"{each.name} cannot be simulated: {error.faults[0].path} {error.faults[0].rule}.")
        else:
            kept.append(each)
    return kept, said


def _faults(case: Case, machine: Machine, h: Hypothesis, loads: Mapping[str, float]) -> Iterator[Suspect]:
    """Yield the faults that a hypothesis may be."""
    before = [fault.model_dump(mode="json") for fault in case.faults]

    def made(
        name: str, kind: str, field: str, quantity: str, sizes: Sequence[float], **fixed: Any
    ) -> Suspect:
        levels = [{"faults": [*before, {"kind": kind, **fixed, field: size}]} for size in sizes]
        return Suspect(name, h.kind, h.name, quantity, tuple(sizes), tuple(levels))

    if h.kind in ("tooth", "eccentric"):
        gear = machine.gears[h.place]
        meshes = [
            m for m in case.meshes if gear.name in (full_name(case, m.driver), full_name(case, m.driven))
        ]
        if not meshes:
            return
        module = meshes[0].module
        if h.kind == "eccentric":
            sizes = [share * module for share in ECCENTRICITIES]
            yield made(h.name, "eccentricity", "amount", "eccentricity", sizes, at=gear.name)
        elif any(map(SpallFault.fits_contact, meshes)):
            if not gear_of(case, gear.name).internal:
                sizes = [share * module for share in CRACKS]
                yield made(f"crack of a tooth of {gear.name}", "crack", "depth", "depth", sizes, at=gear.name)
            sizes = [share * module for share in SPALLS]
            yield made(
                f"spall on a tooth of {gear.name}",
                "spall",
                "depth",
                "depth",
                sizes,
                at=gear.name,
                flank="both",
            )
    elif h.kind in PARTS:
        rotor = machine.bearings[h.place].rotor
        if rotor in case.bearings and h.kind == "cage":
            bearing = case.bearings[rotor]
            room = 2.0 * math.pi / bearing.elements - touching(bearing)
            angles = [share * room for share in POCKETS]
            suspect = made(h.name, "cage", "angle", "offset of an element", angles, at=rotor)
            yield dataclasses.replace(
                suspect, sizes=tuple(0.5 * bearing.pitch_size * angle for angle in angles)
            )
        elif rotor in case.bearings:
            wide = 12.0 if h.kind == "element" else min(3.0, 0.4 * 360.0 / case.bearings[rotor].elements)
            angle = {"angle": loads.get(rotor, 0.0)} if h.kind == "outer" else {}
            yield made(h.name, h.kind, "depth", "depth", DENTS, at=rotor, arc=math.radians(wide), **angle)


def _reason(case: Case, machine: Machine, h: Hypothesis) -> str:
    if h.kind in PARTS:
        return f"the case has no [bearings] table of {machine.bearings[h.place].name}"
    if machine.gears[h.place].shaft is None:
        return "its gear is in a planetary set"
    return SINGLE_TEETH


def _wear(case: Case) -> Iterator[Suspect]:
    """Yield the causes of more clearance: flanks of each mesh, bushes."""
    for j, mesh in enumerate(case.meshes):
        now = working_backlash(case, j) * math.cos(pair_of(case, j).first.base_helix)
        if now > 0.0 and ".planet" not in mesh.label:
            sizes = tuple(factor * now for factor in WORN)
            name = f"worn flanks of {mesh.label}" if len(case.meshes) > 1 else "worn flanks"
            levels = tuple({f"meshes.{j}.backlash": size} for size in sizes)
            yield Suspect(name, "rattle", "", "backlash", sizes, levels)
    bushes = [
        (name, each.radial_clearance)
        for name, each in case.sleeves.items()
        if each.radial_clearance > 0.0 and "." not in name
    ]
    for name, now in bushes[:MOST_BUSHES]:
        sizes = tuple(factor * now for factor in WORN)
        levels = tuple({f"sleeves.{name}.radial_clearance": size} for size in sizes)
        yield Suspect(f"worn bush of {name}", "rattle", "", "radial clearance", sizes, levels)
