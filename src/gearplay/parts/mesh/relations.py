"""Relations of meshes to rotors and to each other: names, numbers of teeth, one module and pressure angle for a gear."""

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Final

from gearplay.parts.mesh.schema import Mesh
from gearplay.parts.raw import Raw, read, text, unknown_rotor
from gearplay.parts.rotor.gear import Gear, split_name
from gearplay.parts.rotor.schema import Rotor
from gearplay.vocabulary.errors import NO_VALUE, Fault, join_path
from gearplay.vocabulary.suggestions import did_you_mean

_SAME: Final = 1e-9
"""Relative difference within which modules and pressure angles count as the same."""


def mesh_relations(rotors: Mapping[str, Rotor | Raw], meshes: Sequence[Mesh | Raw]) -> Iterator[Fault]:
    """Yield the faults of meshes among rotors; parts that are not valid on their own are raw tables."""
    yield from _mesh_faults(rotors, meshes, set(rotors))
    yield from _label_faults(rotors, meshes)
    yield from _gear_faults(rotors, meshes)


def _mesh_faults(
    rotors: Mapping[str, Rotor | Raw], meshes: Sequence[Mesh | Raw], names: set[str]
) -> Iterator[Fault]:
    toothless: set[str] = set()
    for index, mesh in enumerate(meshes):
        ends = [(role, text(mesh, role)) for role in ("driver", "driven")]
        pair: list[tuple[str, object]] = []  # names in full and gears that are there
        for role, name in ends:
            if name is None:
                continue
            rotor, gear = split_name(name, names)
            if rotor not in names:
                yield unknown_rotor(f"meshes.{index}.{role}", rotor, names)
                continue
            gears = read(rotors[rotor], "gears")
            gears = gears if isinstance(gears, Mapping) else {}
            if (gear or len(gears) > 1) and gear not in gears:
                yield _unknown_gear(f"meshes.{index}.{role}", name, rotor, gears)
                continue
            called = gear or next(iter(gears), "")
            found = gears[called] if called else rotors[rotor]
            full = f"{rotor}.{called}" if called else rotor
            pair.append((full, found))
            if read(found, "teeth") is None and full not in toothless and not called:
                toothless.add(full)
                rule = f"is required, since meshes.{index} names this rotor"
                yield Fault(join_path(["rotors", rotor, "teeth"]), NO_VALUE, rule, "Give the number of teeth")
        if len(pair) == 2 and split_name(pair[0][0], names)[0] != split_name(pair[1][0], names)[0]:
            yield from _pair_faults(rotors, index, *pair)


def _unknown_gear(path: str, name: str, rotor: str, gears: Mapping[str, object]) -> Fault:
    if not gears:
        rule = f"names a gear, but {rotor} has no table of gears"
        return Fault(path, name, rule, f"Write {rotor}, or give it gears")
    called = [f"{rotor}.{gear}" for gear in gears]
    rule = f"must be a gear of {rotor}" if "." in name else f"must name a gear of {rotor}"
    return Fault(path, name, rule, did_you_mean(name, called, "Gears"))


def _pair_faults(
    rotors: Mapping[str, Rotor | Raw], index: int, driver: tuple[str, object], driven: tuple[str, object]
) -> Iterator[Fault]:
    inside = [read(gear, "internal") is True for _, gear in (driver, driven)]
    if all(inside):
        rule = "must have at most one internal gear"
        yield Fault(f"meshes.{index}", f"{driver[0]}-{driven[0]}", rule, "Make one external")
        return
    if not any(inside):
        return
    (ring_name, ring), (pinion_name, pinion) = (driver, driven) if inside[0] else (driven, driver)
    z_ring, z_pinion = read(ring, "teeth"), read(pinion, "teeth")
    if (
        not all(isinstance(gear, (Rotor, Gear)) for gear in (ring, pinion))
        or z_ring is None
        or z_pinion is None
    ):
        return
    if z_ring <= z_pinion:
        rule = f"must be more than the {z_pinion} teeth of {pinion_name}, which runs inside it"
        rotor, gear = split_name(ring_name, rotors)
        path = ["rotors", rotor, *(["gears", gear] if gear else []), "teeth"]
        yield Fault(join_path(path), z_ring, rule, "Correct one of the two numbers")


def _in_full(rotors: Mapping[str, Rotor | Raw], name: str | None) -> str | None:
    """Return the full name of a gear, with the default for a shaft's only gear."""
    gears = read(rotors[name], "gears") if name is not None and name in rotors else None
    return f"{name}.{next(iter(gears))}" if isinstance(gears, Mapping) and len(gears) == 1 else name


def _label_faults(rotors: Mapping[str, Rotor | Raw], meshes: Sequence[Mesh | Raw]) -> Iterator[Fault]:
    seen: dict[frozenset[str], int] = {}
    for index, mesh in enumerate(meshes):
        driver, driven = (_in_full(rotors, text(mesh, role)) for role in ("driver", "driven"))
        if driver is None or driven is None or driver == driven:
            continue
        first = seen.setdefault(frozenset((driver, driven)), index)
        if first != index:
            rule = f"joins the same two gears as meshes.{first}"
            yield Fault(f"meshes.{index}", f"{driver}-{driven}", rule, "Remove one of the two")


def _gear_faults(rotors: Mapping[str, Rotor | Raw], meshes: Sequence[Mesh | Raw]) -> Iterator[Fault]:
    """Refuse meshes that give one gear two modules or two pressure angles."""
    first: dict[str, int] = {}
    for index, mesh in enumerate(meshes):
        if not isinstance(mesh, Mesh):
            continue
        for name in (_in_full(rotors, mesh.driver) or "", _in_full(rotors, mesh.driven) or ""):
            other = meshes[first.setdefault(name, index)]
            if not isinstance(other, Mesh) or other is mesh:
                continue
            for field in ("module", "pressure_angle"):
                mine, theirs = getattr(mesh, field), getattr(other, field)
                if not math.isclose(mine, theirs, rel_tol=_SAME):
                    rule = f"must be that of meshes.{first[name]}, {theirs:.6g}, since {name} is in both"
                    yield Fault(f"meshes.{index}.{field}", mine, rule, "Give both meshes the same value")
