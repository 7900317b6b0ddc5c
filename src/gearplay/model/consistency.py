"""Relations between the parts of a case: references and carriers; those of meshes are in their room.

They also run on a case some of whose parts are at fault, so that one reading reports everything: a part that
is not valid is then the raw table of the file, of which only names are used.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from gearplay.parts.mesh.relations import mesh_relations
from gearplay.parts.part_fault import PartFault
from gearplay.parts.protocol import Holder, Joint
from gearplay.parts.raw import Raw, read, text, unknown_rotor
from gearplay.parts.rotor.schema import Rotor
from gearplay.parts.tables import HOLDERS, JOINTS
from gearplay.schema.fields import Part
from gearplay.vocabulary.errors import NO_VALUE, Fault, join_path
from gearplay.vocabulary.suggestions import did_you_mean


def cross_faults(parts: Mapping[str, Any]) -> list[Fault]:
    """Return every fault across the parts of a case.

    Parameters
    ----------
    parts
        Valid parts, or raw tables where a part is at fault on its own, by table or list of the case.

    """
    rotors = parts["rotors"]
    names, holders = set(rotors), {table: parts[table] for table in HOLDERS}
    return [
        *_floating_faults(rotors, holders),
        *(fault for table in HOLDERS for fault in _holder_faults(table, holders[table], names)),
        *_carrier_faults(holders),
        *mesh_relations(rotors, parts["meshes"]),
        *_joint_faults({name: parts[name] for name in JOINTS}, names),
        *_sensor_faults(rotors, names),
        *_faults_of_parts(parts),
    ]


def _floating_faults(
    rotors: Mapping[str, Rotor | Raw], holders: Mapping[str, Mapping[str, Holder | Raw]]
) -> Iterator[Fault]:
    """Refuse ``floating`` of rotors in a part with a clearance."""
    for table in (table for table, kind in HOLDERS.items() if kind.has_clearance):
        for name in holders[table]:
            if name in rotors and read(rotors[name], "floating") is True:
                path, rule = join_path(["rotors", name, "floating"]), "must be false for a rotor in a sleeve"
                yield Fault(path, True, rule, f"Remove it, or remove {table}.{name}")


def _holder_faults(table: str, holders: Mapping[str, Holder | Raw], names: set[str]) -> Iterator[Fault]:
    """Refuse parts that hold unknown rotors or are mounted on them."""
    for name, holder in holders.items():
        if name not in names:
            path = join_path([table, name])
            yield Fault(path, NO_VALUE, "names no rotor", did_you_mean(name, names, "Rotors"))
        carrier = text(holder, "on")
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
            yield unknown_rotor(path, carrier, names)


def _carrier_faults(parts: Mapping[str, Mapping[str, Holder | Raw]]) -> Iterator[Fault]:
    """Refuse rotors on two carriers, and carriers that carry each other in a circle."""
    carriers: dict[str, str | None] = {}
    tables: dict[str, str] = {}
    for table, holders in parts.items():
        for held, holder in holders.items():
            on = text(holder, "on")
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


def _sensor_faults(rotors: Mapping[str, Rotor | Raw], names: set[str]) -> Iterator[Fault]:
    for name, rotor in rotors.items():
        for field in ("sensor", "speed_sensor"):
            sensor = text(read(rotor, "drive"), field)
            if sensor is not None and sensor not in names:
                yield unknown_rotor(join_path(["rotors", name, "drive", field]), sensor, names)


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
                yield Fault(join_path([*path, *map(str, at)]), read(fault, str(at[0])), rule, cure)


def _joint_faults(joints: Mapping[str, Sequence[Joint | Raw]], names: set[str]) -> Iterator[Fault]:
    for kind, parts in joints.items():
        for index, joint in enumerate(parts):
            if not isinstance(joint, Joint):
                continue
            for field, name in joint.named_rotors().items():
                if name not in names:
                    yield unknown_rotor(f"{kind}.{index}.{field}", name, names)
