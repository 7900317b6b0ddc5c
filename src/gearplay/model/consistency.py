"""Checks across the parts of a case: names that must exist, gears that must fit each other.

They also run on a case some of whose parts are at fault, so that one reading reports everything: a part that
is not valid is then the raw table of the file, of which only names are used.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any, Final

from gearplay.model.joint import Joint
from gearplay.model.mesh import Mesh
from gearplay.model.rotor import Rotor
from gearplay.model.sleeve import Sleeve
from gearplay.model.wording import did_you_mean
from gearplay.vocabulary.errors import NO_VALUE, Fault, join_path

Raw = Mapping[str, Any]

_SAME: Final = 1e-9
"""Relative difference within which modules and pressure angles count as the same."""


def cross_faults(
    rotors: Mapping[str, Rotor | Raw],
    sleeves: Mapping[str, Sleeve | Raw],
    meshes: Sequence[Mesh | Raw],
    joints: Mapping[str, Sequence[Joint | Raw]],
) -> list[Fault]:
    """Return every fault across the parts.

    Parameters
    ----------
    rotors, sleeves, meshes, joints
        Valid parts, or raw tables where a part is at fault on its own; joints by the name of their list.

    """
    names = set(rotors)
    return [
        *_sleeve_faults(rotors, sleeves, names),
        *_carrier_faults(sleeves),
        *_mesh_faults(rotors, meshes, names),
        *_label_faults(meshes),
        *_gear_faults(meshes),
        *_joint_faults(joints, names),
    ]


def _read(part: object, name: str) -> Any:
    return part.get(name) if isinstance(part, Mapping) else getattr(part, name, None)


def _text(part: object, name: str) -> str | None:
    value = _read(part, name)
    return value if isinstance(value, str) else None


def _unknown(path: str, name: str, names: Iterable[str]) -> Fault:
    return Fault(path, name, "must be the name of a rotor", did_you_mean(name, names, "Rotors"))


def _sleeve_faults(
    rotors: Mapping[str, Rotor | Raw], sleeves: Mapping[str, Sleeve | Raw], names: set[str]
) -> Iterator[Fault]:
    for name, sleeve in sleeves.items():
        if name not in names:
            path = join_path(["sleeves", name])
            yield Fault(path, NO_VALUE, "names no rotor", did_you_mean(name, names, "Rotors"))
        elif _read(rotors[name], "floating") is True:
            rule = "must be false for a rotor in a sleeve"
            yield Fault(
                join_path(["rotors", name, "floating"]), True, rule, f"Remove it, or remove sleeves.{name}"
            )
        carrier = _text(sleeve, "on")
        if carrier is None:
            continue
        path = join_path(["sleeves", name, "on"]) if carrier == name or carrier not in names else ""
        if carrier == name:
            yield Fault(path, carrier, "must be another rotor", "Name the rotor that carries the bush")
        elif carrier not in names:
            yield _unknown(path, carrier, names)


def _carrier_faults(sleeves: Mapping[str, Sleeve | Raw]) -> Iterator[Fault]:
    """Refuse bushes that carry each other in a circle."""
    carriers = {name: _text(sleeve, "on") for name, sleeve in sleeves.items()}
    settled: set[str] = set()
    for start in carriers:
        chain: list[str] = []
        name: str | None = start
        while name is not None and name in carriers and name not in settled and name not in chain:
            chain.append(name)
            name = carriers[name]
        if name is not None and name in chain and carriers[name] != name:
            path = join_path(["sleeves", name, "on"])
            circle = " on ".join([*chain[chain.index(name) :], name])
            yield Fault(path, carriers[name], f"closes a circle: {circle}", "Put one of them on the ground")
        settled.update(chain)


def _mesh_faults(
    rotors: Mapping[str, Rotor | Raw], meshes: Sequence[Mesh | Raw], names: set[str]
) -> Iterator[Fault]:
    toothless: set[str] = set()
    for index, mesh in enumerate(meshes):
        ends = [(role, _text(mesh, role)) for role in ("driver", "driven")]
        for role, name in ends:
            if name is not None and name not in names:
                yield _unknown(f"meshes.{index}.{role}", name, names)
            elif name is not None and _read(rotors[name], "teeth") is None and name not in toothless:
                toothless.add(name)
                rule = f"is required, since meshes.{index} names this rotor"
                yield Fault(join_path(["rotors", name, "teeth"]), NO_VALUE, rule, "Give the number of teeth")
        pair = [rotors[name] for _, name in ends if name is not None and name in names]
        if len(pair) == 2 and ends[0][1] != ends[1][1]:
            yield from _pair_faults(index, ends[0][1], ends[1][1], *pair)


def _pair_faults(
    index: int, driver: str | None, driven: str | None, one: object, two: object
) -> Iterator[Fault]:
    inside = [_read(one, "internal") is True, _read(two, "internal") is True]
    if all(inside):
        yield Fault(
            f"meshes.{index}",
            f"{driver}-{driven}",
            "must have at most one internal gear",
            "Make one external",
        )
        return
    if not any(inside):
        return
    ring, pinion = (one, two) if inside[0] else (two, one)
    ring_name, pinion_name = (driver, driven) if inside[0] else (driven, driver)
    z_ring, z_pinion = _read(ring, "teeth"), _read(pinion, "teeth")
    if not all(isinstance(part, Rotor) for part in (one, two)) or z_ring is None or z_pinion is None:
        return
    if z_ring <= z_pinion:
        rule = f"must be more than the {z_pinion} teeth of {pinion_name}, which runs inside it"
        yield Fault(join_path(["rotors", ring_name, "teeth"]), z_ring, rule, "Correct one of the two numbers")


def _label_faults(meshes: Sequence[Mesh | Raw]) -> Iterator[Fault]:
    seen: dict[frozenset[str], int] = {}
    for index, mesh in enumerate(meshes):
        driver, driven = _text(mesh, "driver"), _text(mesh, "driven")
        if driver is None or driven is None or driver == driven:
            continue
        first = seen.setdefault(frozenset((driver, driven)), index)
        if first != index:
            rule = f"joins the same two rotors as meshes.{first}"
            yield Fault(f"meshes.{index}", f"{driver}-{driven}", rule, "Remove one of the two")


def _gear_faults(meshes: Sequence[Mesh | Raw]) -> Iterator[Fault]:
    """Refuse meshes that give one gear two modules or two pressure angles."""
    first: dict[str, int] = {}
    for index, mesh in enumerate(meshes):
        if not isinstance(mesh, Mesh):
            continue
        for name in (mesh.driver, mesh.driven):
            other = meshes[first.setdefault(name, index)]
            if not isinstance(other, Mesh) or other is mesh:
                continue
            for field in ("module", "pressure_angle"):
                mine, theirs = getattr(mesh, field), getattr(other, field)
                if not math.isclose(mine, theirs, rel_tol=_SAME):
                    rule = f"must be that of meshes.{first[name]}, {theirs:.6g}, since {name} is in both"
                    yield Fault(f"meshes.{index}.{field}", mine, rule, "Give both meshes the same value")


def _joint_faults(joints: Mapping[str, Sequence[Joint | Raw]], names: set[str]) -> Iterator[Fault]:
    for kind, parts in joints.items():
        seen: dict[str, int] = {}
        for index, joint in enumerate(parts):
            if not isinstance(joint, Joint):
                continue
            for field, name in joint.named_rotors().items():
                if name not in names:
                    yield _unknown(f"{kind}.{index}.{field}", name, names)
            first = seen.setdefault(joint.label, index)
            if first != index:
                rule = f"joins the same two rotors as {kind}.{first}"
                yield Fault(
                    f"{kind}.{index}", joint.label, rule, "Remove one of the two, or add their stiffnesses"
                )
