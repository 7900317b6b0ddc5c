"""Relations between the parts of a case: references, compatible gears.

They also run on a case some of whose parts are at fault, so that one reading reports everything: a part that
is not valid is then the raw table of the file, of which only names are used.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any, Final

from gearplay.model.wording import did_you_mean
from gearplay.parts.mesh.schema import Mesh
from gearplay.parts.part_fault import PartFault
from gearplay.parts.protocol import Holder, Joint
from gearplay.parts.rotor.gear import Gear, split_name
from gearplay.parts.rotor.schema import Rotor
from gearplay.parts.tables import HOLDERS, JOINTS
from gearplay.schema.fields import Part
from gearplay.vocabulary.errors import NO_VALUE, Fault, join_path

Raw = Mapping[str, Any]

_SAME: Final = 1e-9
"""Relative difference within which modules and pressure angles count as the same."""


def cross_faults(parts: Mapping[str, Any]) -> list[Fault]:
    """Return every fault across the parts of a case.

    Parameters
    ----------
    parts
        Valid parts, or raw tables where a part is at fault on its own, by table or list of the case.

    """
    rotors, meshes = parts["rotors"], parts["meshes"]
    names, holders = set(rotors), {table: parts[table] for table in HOLDERS}
    return [
        *_floating_faults(rotors, holders),
        *(fault for table in HOLDERS for fault in _holder_faults(table, holders[table], names)),
        *_carrier_faults(holders),
        *_mesh_faults(rotors, meshes, names),
        *_label_faults(rotors, meshes),
        *_gear_faults(rotors, meshes),
        *_joint_faults({name: parts[name] for name in JOINTS}, names),
        *_sensor_faults(rotors, names),
        *_faults_of_parts(parts),
    ]


def _read(part: object, name: str) -> Any:
    return part.get(name) if isinstance(part, Mapping) else getattr(part, name, None)


def _text(part: object, name: str) -> str | None:
    value = _read(part, name)
    return value if isinstance(value, str) else None


def _unknown(path: str, name: str, names: Iterable[str]) -> Fault:
    return Fault(path, name, "must be the name of a rotor", did_you_mean(name, names, "Rotors"))


def _floating_faults(
    rotors: Mapping[str, Rotor | Raw], holders: Mapping[str, Mapping[str, Holder | Raw]]
) -> Iterator[Fault]:
    """Refuse ``floating`` of rotors in a part with a clearance."""
    for table in (table for table, kind in HOLDERS.items() if kind.has_clearance):
        for name in holders[table]:
            if name in rotors and _read(rotors[name], "floating") is True:
                path, rule = join_path(["rotors", name, "floating"]), "must be false for a rotor in a sleeve"
                yield Fault(path, True, rule, f"Remove it, or remove {table}.{name}")


def _holder_faults(table: str, holders: Mapping[str, Holder | Raw], names: set[str]) -> Iterator[Fault]:
    """Refuse parts that hold unknown rotors or are mounted on them."""
    for name, holder in holders.items():
        if name not in names:
            path = join_path([table, name])
            yield Fault(path, NO_VALUE, "names no rotor", did_you_mean(name, names, "Rotors"))
        carrier = _text(holder, "on")
        if carrier is None:
            continue
        path = join_path([table, name, "on"]) if carrier == name or carrier not in names else ""
        if carrier == name:
            yield Fault(
                path,
                carrier,
                "must be another rotor",
                f"Name the rotor that carries the {HOLDERS[table].noun}",
            )
        elif carrier not in names:
            yield _unknown(path, carrier, names)


def _carrier_faults(parts: Mapping[str, Mapping[str, Holder | Raw]]) -> Iterator[Fault]:
    """Refuse rotors on two carriers, and carriers that carry each other in a circle."""
    carriers: dict[str, str | None] = {}
    tables: dict[str, str] = {}
    for table, holders in parts.items():
        for held, holder in holders.items():
            on = _text(holder, "on")
            if held in carriers and on != carriers[held]:
                other = carriers[held] or f"the ground, as {tables[held]} has it"
                rule = f"must be {other}, since a rotor rides on one carrier"
                path = join_path([table, held, "on"])
                yield Fault(path, NO_VALUE if on is None else on, rule, "Put both on the same one")
                continue
            carriers[held], tables[held] = on, table
    settled: set[str] = set()
    for start in carriers:
        chain: list[str] = []
        name: str | None = start
        while name is not None and name in carriers and name not in settled and name not in chain:
            chain.append(name)
            name = carriers[name]
        if name is not None and name in chain and carriers[name] != name:
            path = join_path([tables[name], name, "on"])
            circle = " on ".join([*chain[chain.index(name) :], name])
            yield Fault(path, carriers[name], f"closes a circle: {circle}", "Put one of them on the ground")
        settled.update(chain)


def _mesh_faults(
    rotors: Mapping[str, Rotor | Raw], meshes: Sequence[Mesh | Raw], names: set[str]
) -> Iterator[Fault]:
    toothless: set[str] = set()
    for index, mesh in enumerate(meshes):
        ends = [(role, _text(mesh, role)) for role in ("driver", "driven")]
        pair: list[tuple[str, object]] = []  # names in full and gears that are there
        for role, name in ends:
            if name is None:
                continue
            rotor, gear = split_name(name, names)
            if rotor not in names:
                yield _unknown(f"meshes.{index}.{role}", rotor, names)
                continue
            gears = _read(rotors[rotor], "gears")
            gears = gears if isinstance(gears, Mapping) else {}
            if (gear or len(gears) > 1) and gear not in gears:
                yield _unknown_gear(f"meshes.{index}.{role}", name, rotor, gears)
                continue
            called = gear or next(iter(gears), "")
            found = gears[called] if called else rotors[rotor]
            full = f"{rotor}.{called}" if called else rotor
            pair.append((full, found))
            if _read(found, "teeth") is None and full not in toothless and not called:
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
    inside = [_read(gear, "internal") is True for _, gear in (driver, driven)]
    if all(inside):
        rule = "must have at most one internal gear"
        yield Fault(f"meshes.{index}", f"{driver[0]}-{driven[0]}", rule, "Make one external")
        return
    if not any(inside):
        return
    (ring_name, ring), (pinion_name, pinion) = (driver, driven) if inside[0] else (driven, driver)
    z_ring, z_pinion = _read(ring, "teeth"), _read(pinion, "teeth")
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
    gears = _read(rotors[name], "gears") if name is not None and name in rotors else None
    return f"{name}.{next(iter(gears))}" if isinstance(gears, Mapping) and len(gears) == 1 else name


def _label_faults(rotors: Mapping[str, Rotor | Raw], meshes: Sequence[Mesh | Raw]) -> Iterator[Fault]:
    seen: dict[frozenset[str], int] = {}
    for index, mesh in enumerate(meshes):
        driver, driven = (_in_full(rotors, _text(mesh, role)) for role in ("driver", "driven"))
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


def _sensor_faults(rotors: Mapping[str, Rotor | Raw], names: set[str]) -> Iterator[Fault]:
    for name, rotor in rotors.items():
        for field in ("sensor", "speed_sensor"):
            sensor = _text(_read(rotor, "drive"), field)
            if sensor is not None and sensor not in names:
                yield _unknown(join_path(["rotors", name, "drive", field]), sensor, names)


def _faults_of_parts(parts: Mapping[str, Any]) -> Iterator[Fault]:
    """Refuse faults of unknown parts, and faults that do not fit their part."""
    for index, fault in enumerate(parts.get("faults", ())):
        if not isinstance(fault, PartFault):
            continue
        holders, path = parts[fault.table], ["faults", str(index)]
        part = fault.part(holders)
        if part is None:
            rule = f"must be a name in the table {fault.table}"
            yield Fault(
                join_path([*path, "at"]),
                fault.at,
                rule,
                did_you_mean(fault.at, holders, fault.table.capitalize()),
            )
        elif isinstance(part, Part):
            others = [
                other
                for other in parts["faults"]
                if isinstance(other, PartFault)
                and other is not fault
                and other.table == fault.table
                and other.at == fault.at
            ]
            for at, rule, cure in fault.misfits(part, others):
                yield Fault(join_path([*path, *map(str, at)]), _read(fault, str(at[0])), rule, cure)


def _joint_faults(joints: Mapping[str, Sequence[Joint | Raw]], names: set[str]) -> Iterator[Fault]:
    for kind, parts in joints.items():
        for index, joint in enumerate(parts):
            if not isinstance(joint, Joint):
                continue
            for field, name in joint.named_rotors().items():
                if name not in names:
                    yield _unknown(f"{kind}.{index}.{field}", name, names)
