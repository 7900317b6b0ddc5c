"""Changes of a case that bring hypotheses about: faults of three severities, worn flanks, worn bushes."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

from gearplay.diagnosis.bearing_combs import PARTS
from gearplay.diagnosis.evidence import Hypothesis
from gearplay.diagnosis.machine import Machine
from gearplay.model.case import Case
from gearplay.model.reading import replace
from gearplay.parts.bearing.faults import touching
from gearplay.parts.mesh.faults import SINGLE_TEETH, CrackFault
from gearplay.parts.mesh.train.geometry import full_name, gear_of, pair_of, working_backlash
from gearplay.parts.planetary.members import PinError
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

    ``hypotheses`` has the names of those that it stands for, none of wear; ``quantity`` and ``sizes`` [m] measure the severity.
    ``beside`` is another cause, of one severity, that all levels have.
    """

    name: str
    kind: str
    hypotheses: tuple[str, ...]
    quantity: str
    sizes: tuple[float, ...]
    levels: tuple[Mapping[str, Any], ...]
    beside: Suspect | None = None


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
        return Suspect(name, h.kind, (h.name,), quantity, tuple(sizes), tuple(levels))

    if h.kind == "planets":
        yield from _uneven(case, machine.sets[h.place].name, h)
    elif h.kind in ("tooth", "eccentric"):
        own, at = machine.set_of(h.place), machine.gears[h.place].name
        if own is not None and h.place == own.gears[1]:
            at += "1"  # all planets have the same lines
        meshes = [m for m in case.meshes if at in (full_name(case, m.driver), full_name(case, m.driven))]
        if not meshes:
            return
        module = meshes[0].module
        if h.kind == "eccentric":
            sizes = [share * module for share in ECCENTRICITIES]
            yield made(h.name, "eccentricity", "amount", "eccentricity", sizes, at=at)
        elif any(map(CrackFault.fits_contact, meshes)):
            if not gear_of(case, at).internal:
                sizes = [share * module for share in CRACKS]
                yield made(
                    f"crack of a tooth of {machine.gears[h.place].name}",
                    "crack",
                    "depth",
                    "depth",
                    sizes,
                    at=at,
                )
            sizes = [share * module for share in SPALLS]
            yield made(
                f"spall on a tooth of {machine.gears[h.place].name}",
                "spall",
                "depth",
                "depth",
                sizes,
                at=at,
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


def _uneven(case: Case, name: str, h: Hypothesis) -> Iterator[Suspect]:
    """Yield the causes of uneven planets: a pin off its place, an eccentric carrier, whose pins are all off as it is."""
    table = case.planetary[name]
    sizes = tuple(share * table.module for share in ECCENTRICITIES)
    alone = [(0.0, 1.0), *[(0.0, 0.0)] * (table.planets.count - 1)]
    together = [(math.cos(angle), -math.sin(angle)) for angle in table.planets.directions]
    before = {each.planet: each for each in table.pin_errors}

    def off(amount: float, directions: Sequence[tuple[float, float]]) -> list[dict[str, Any]]:
        errors = []
        for planet, (along, across) in enumerate(directions, 1):
            own = before.get(planet, PinError(planet=planet))
            moved = {"radial": own.radial + amount * along, "tangential": own.tangential + amount * across}
            errors.append(own.model_dump() | moved)
        return errors

    for words, directions in (
        (f"pin of a planet of {name} off its place", alone),
        (f"eccentric {name}.carrier", together),
    ):
        levels = tuple({f"planetary.{name}.pin_errors": off(size, directions)} for size in sizes)
        yield Suspect(
            words, h.kind, (h.name,), "offset" if directions is alone else "eccentricity", sizes, levels
        )


def _reason(case: Case, machine: Machine, h: Hypothesis) -> str:
    if h.kind in PARTS:
        return f"the case has no [bearings] table of {machine.bearings[h.place].name}"
    if machine.gears[h.place].shaft is None and machine.set_of(h.place) is None:
        return "its gear is in a planetary set of which neither sun nor ring stands"
    return SINGLE_TEETH


def _wear(case: Case) -> Iterator[Suspect]:
    """Yield the causes of more clearance: flanks of each mesh, bushes."""
    for j, mesh in enumerate(case.meshes):
        now = working_backlash(case, j) * math.cos(pair_of(case, j).first.base_helix)
        if now > 0.0 and ".planet" not in mesh.label:
            name = f"worn flanks of {mesh.label}" if len(case.meshes) > 1 else "worn flanks"
            yield _worn(name, "backlash", now, f"meshes.{j}.backlash")
    for name, table in case.planetary.items():
        j = next(j for j, mesh in enumerate(case.meshes) if mesh.label.startswith(f"{name}."))
        now = working_backlash(case, j) * math.cos(pair_of(case, j).first.base_helix)
        if now > 0.0:
            yield _worn(f"worn flanks of {name}", "backlash", now, f"planetary.{name}.backlash")
        if table.pin is not None and table.pin.radial_clearance > 0.0:
            at = f"planetary.{name}.pin.radial_clearance"
            yield _worn(f"worn pins of {name}", "radial clearance", table.pin.radial_clearance, at)
    bushes = [
        (name, each.radial_clearance)
        for name, each in case.sleeves.items()
        if each.radial_clearance > 0.0 and "." not in name
    ]
    for name, now in bushes[:MOST_BUSHES]:
        yield _worn(f"worn bush of {name}", "radial clearance", now, f"sleeves.{name}.radial_clearance")


def _worn(name: str, quantity: str, now: float, path: str) -> Suspect:
    """Return the cause of more clearance, the one at a path of the case [m]."""
    sizes = tuple(factor * now for factor in WORN)
    return Suspect(name, "rattle", (), quantity, sizes, tuple({path: size} for size in sizes))
