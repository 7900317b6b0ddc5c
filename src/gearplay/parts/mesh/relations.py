"""Relations of meshes to rotors and to each other: names, numbers of teeth, one module and pressure angle for a gear."""

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Final

from gearplay.parts.mesh.schema import Mesh
from gearplay.parts.raw import Raw, read, text, unknown_rotor
from gearplay.parts.rotor.gear import Gear, split_name
from gearplay.parts.rotor.schema import Rotor
from gearplay.vocabulary.errors import NO_VALUE, Fault, join_path
from gearplay.vocabulary.suggestions import did_you_mean

if TYPE_CHECKING:
    from gearplay.parts.mesh.train.train import Train

ENDS: Final = ("driver", "driven")
_SAME: Final = 1e-9
"""Relative difference within which modules and pressure angles count as the same."""


def mesh_relations(rotors: Mapping[str, Rotor | Raw], meshes: Sequence[Mesh | Raw]) -> Iterator[Fault]:
    """Yield the faults of meshes among rotors; parts that are not valid on their own are raw tables."""
    toothless: set[str] = set()
    for index, mesh in enumerate(meshes):
        pair: list[tuple[str, str, object]] = []  # rotors, gears and their fields that are there
        for role in ENDS:
            if (name := text(mesh, role)) is None:
                continue
            rotor, gear = split_name(name, rotors)
            if rotor not in rotors:
                yield unknown_rotor(f"meshes.{index}.{role}", rotor, rotors)
                continue
            gears = read(rotors[rotor], "gears")
            gears = gears if isinstance(gears, Mapping) else {}
            if (gear or len(gears) > 1) and gear not in gears:
                yield _unknown_gear(f"meshes.{index}.{role}", name, rotor, gears)
                continue
            gear = gear or next(iter(gears), "")
            pair.append((rotor, gear, gears[gear] if gear else rotors[rotor]))
            if not gear and read(rotors[rotor], "teeth") is None and rotor not in toothless:
                toothless.add(rotor)
                rule = f"is required, since meshes.{index} names this rotor"
                yield Fault(join_path(["rotors", rotor, "teeth"]), NO_VALUE, rule, "Give the number of teeth")
        if len(pair) == 2 and pair[0][0] != pair[1][0]:
            yield from _pair_faults(index, *pair)
    names = [[_in_full(rotors, text(mesh, role)) for role in ENDS] for mesh in meshes]
    yield from _label_faults(names)
    yield from _gear_faults(meshes, names)


def printed_faults(case: "Train") -> list[Fault]:
    """Return the faults of friction of teeth in the equations as published."""
    rule = "must be 0 as published, where teeth have no friction"
    return [
        Fault(f"meshes.{j}.friction_coefficient", mesh.friction_coefficient, rule, "Remove it")
        for j, mesh in enumerate(case.meshes)
        if mesh.friction_coefficient > 0.0 and case.formulation == "as_published"
    ]


def _unknown_gear(path: str, name: str, rotor: str, gears: Mapping[str, object]) -> Fault:
    if not gears:
        rule = f"names a gear, but {rotor} has no table of gears"
        return Fault(path, name, rule, f"Write {rotor}, or give it gears")
    called = [f"{rotor}.{gear}" for gear in gears]
    rule = f"must be a gear of {rotor}" if "." in name else f"must name a gear of {rotor}"
    return Fault(path, name, rule, did_you_mean(name, called, "Gears"))


def _pair_faults(
    index: int, driver: tuple[str, str, object], driven: tuple[str, str, object]
) -> Iterator[Fault]:
    inside = [read(gear, "internal") is True for *_, gear in (driver, driven)]
    if all(inside):
        rule = "must have at most one internal gear"
        names = "-".join(_joined(*each[:2]) for each in (driver, driven))
        yield Fault(f"meshes.{index}", names, rule, "Make one external")
        return
    (rotor, name, ring), (*pinion_name, pinion) = (driver, driven) if inside[0] else (driven, driver)
    if not any(inside) or not (isinstance(ring, (Rotor, Gear)) and isinstance(pinion, (Rotor, Gear))):
        return
    if ring.teeth is not None and pinion.teeth is not None and ring.teeth <= pinion.teeth:
        rule = f"must be more than the {pinion.teeth} teeth of {_joined(*pinion_name)}, which runs inside it"
        path = ["rotors", rotor, *(["gears", name] if name else []), "teeth"]
        yield Fault(join_path(path), ring.teeth, rule, "Correct one of the two numbers")


def _joined(rotor: str, gear: str) -> str:
    return f"{rotor}.{gear}" if gear else rotor


def _in_full(rotors: Mapping[str, Rotor | Raw], name: str | None) -> str | None:
    """Return the full name of a gear, with the default for a shaft's only gear."""
    gears = read(rotors[name], "gears") if name is not None and name in rotors else None
    return f"{name}.{next(iter(gears))}" if isinstance(gears, Mapping) and len(gears) == 1 else name


def _label_faults(names: Sequence[Sequence[str | None]]) -> Iterator[Fault]:
    """Refuse meshes of the same two gears."""
    seen: dict[frozenset[str | None], int] = {}
    for index, (driver, driven) in enumerate(names):
        if driver is None or driven is None or driver == driven:
            continue
        first = seen.setdefault(frozenset((driver, driven)), index)
        if first != index:
            rule = f"joins the same two gears as meshes.{first}"
            yield Fault(f"meshes.{index}", f"{driver}-{driven}", rule, "Remove one of the two")


def _gear_faults(meshes: Sequence[Mesh | Raw], names: Sequence[Sequence[str | None]]) -> Iterator[Fault]:
    """Refuse meshes that give one gear two modules or two pressure angles."""
    first: dict[str | None, int] = {}
    valid = [(index, mesh) for index, mesh in enumerate(meshes) if isinstance(mesh, Mesh)]
    for index, mesh in valid:
        for name in names[index]:
            other = meshes[first.setdefault(name, index)]
            for field in ("module", "pressure_angle"):
                mine, theirs = getattr(mesh, field), getattr(other, field)
                if not math.isclose(mine, theirs, rel_tol=_SAME):
                    rule = f"must be that of meshes.{first[name]}, {theirs:.6g}, since {name} is in both"
                    yield Fault(f"meshes.{index}.{field}", mine, rule, "Give both meshes the same value")
