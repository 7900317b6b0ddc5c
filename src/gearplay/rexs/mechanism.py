"""Rotors of the case, from the bodies of the gearbox."""

import math
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any, Final

from gearplay.rexs.bodies import STIFF_MATERIAL, Bodies, Body, Weight, ring
from gearplay.rexs.loads import Motion
from gearplay.rexs.names import new_name, plain_name
from gearplay.rexs.notes import Notes
from gearplay.rexs.records import Component, Gearbox
from gearplay.rexs.sets import PlanetSet
from gearplay.rexs.teeth import Gear
from gearplay.rexs.text import quantity
from gearplay.vocabulary import quantities as q

STIFF_SHAFT: Final = 1e7
"""Torsional stiffness of a shaft without sections between two places on it [N m/rad]."""
RIM: Final = 3.5
"""Thickness of the rim of a ring gear whose shaft has no sections, in modules."""


@dataclass
class Rotor:
    """A rotor of the case: a body, or a part of one that is in several planetary sets."""

    name: str
    root: int
    body: Body
    gears: list[Gear]
    weight: Weight
    member: tuple[PlanetSet, str] | None = None
    parts: int = 1
    """Number of rotors that the body is made into."""
    called: dict[int, str] = field(default_factory=dict)
    """Names of gears by their components."""

    def gear_name(self, gear: Gear) -> str:
        """Return the name of a gear in meshes."""
        inner = self.called.get(gear.component.id)
        return f"{self.name}.{inner}" if inner else self.name


def add_gear_bodies(
    bodies: Bodies, every: Iterable[Body], gears: dict[int, Gear], notes: Notes, *, always: bool
) -> None:
    """Add solid gear bodies, from the shaft to the reference circle, where requested, or where a body has no other mass."""
    missing = []
    for body in every:
        solid = [_gear_body(bodies, body, gears[each.id]) for each in body.gears]
        extra = Weight()
        for each in solid:
            extra.add(each)
        if extra.mass == 0.0:
            continue
        if not always and body.weight.mass > 0.0:
            missing.append(
                f"{extra.mass:.4g} kg, {extra.inertia:.4g} kg m^2 to {body.weight.mass:.4g} kg of {body.main}"
            )
            continue
        if not always:
            notes.assume(
                f"{body.main} has no mass in the file: that of its gears, solid to the reference circle"
            )
        body.weight.add(extra)
        for gear, own in zip(body.gears, solid, strict=True):
            body.said.append(
                f"{gear}, solid to its reference circle: {own.mass:.7g} kg, {own.inertia:.7g} kg m^2"
            )
    if missing:
        notes.leave_out(
            "bodies of the gears, of which the file has no shape: rotors are too light; gear_bodies = solid adds, to the "
            f"reference circle, {'; '.join(missing)}"
        )


def _gear_body(bodies: Bodies, body: Body, gear: Gear) -> Weight:
    width = gear.facewidth or 0.0
    if width == 0.0:
        return Weight()
    shafts = [each for each in body.members if each.type == "shaft"]
    shaft = next((each for each in shafts if gear.component in bodies.box.parts(each.id)), None)
    own_material = bodies.box.referenced(gear.component.id, "material")
    density = bodies.density(gear.component if own_material or shaft is None else shaft)
    outer, inner = gear.reference_diameter, 0.0
    if shaft is not None:
        at = bodies.box.number(gear.component, q.LENGTH, "u_coordinate_on_shaft")
        outside, inside = _diameters(bodies, shaft, at)
        outer, inner = (inside, outer) if gear.internal else (outer, outside)
    if gear.internal and (shaft is None or outer == 0.0):
        outer, inner = gear.reference_diameter + 2.0 * RIM * gear.module, gear.reference_diameter
    if outer <= inner:
        return Weight()
    return ring(width, (outer, outer), (inner, inner), density)


def _diameters(bodies: Bodies, shaft: Component, at: float | None) -> tuple[float, float]:
    """Return outer and inner diameter of a shaft at a place along it, the largest ones where the place is not given."""
    outer = inner = 0.0
    for piece in bodies.box.parts(shaft.id, "shaft_section"):
        length, outside, inside = bodies.section(piece)
        start = bodies.box.number(piece, q.LENGTH, "u_coordinate_on_shaft")
        if at is None or start is None or start - 1e-9 <= at <= start + length + 1e-9:
            outer, inner = max(outer, *outside), max(inner, *inside)
    return outer, inner


def rotors_of(
    bodies: Bodies,
    every: dict[int, Body],
    gears: dict[int, Gear],
    sets: list[PlanetSet],
    motion: Motion,
    notes: Notes,
) -> list[Rotor]:
    """Return the rotors: of every body with gears, couplings or loads, one; of one that is in several sets, one for each."""
    planets = {bodies.find(gear.component.id) for found in sets for gear in found.planets}
    members: dict[int, list[tuple[PlanetSet, str]]] = {}
    for found in sets:
        for member, number in found.members.items():
            members.setdefault(bodies.find(number), []).append((found, member))
    linked = {bodies.find(side) for link in bodies.links for side in (link.inner, link.outer)}
    acting = linked | set(motion.loads) | set(motion.drives) | {motion.driver}
    taken = {found.name for found in sets}
    kept = [
        root
        for root in every
        if root not in planets and (every[root].gears or root in members or root in acting)
    ]
    kept = [
        root for root in kept if not bodies.stands(root) or root in members or _meshes(bodies, every[root])
    ]
    names = Counter(plain_name(every[root].main.name, every[root].main.type) for root in kept)
    repeated = {name for name, count in names.items() if count > 1}
    rotors: list[Rotor] = []
    for root in kept:
        body, roles = every[root], members.get(root, [])
        in_sets = {number for found, member in roles for number in (found.members[member],)}
        rest = [gears[each.id] for each in body.gears if each.id not in in_sets]
        parts: list[tuple[tuple[PlanetSet, str] | None, list[Gear]]] = [(role, []) for role in roles]
        if rest or not parts:
            parts.append((None, rest))
        share = Weight(body.weight.mass / len(parts), body.weight.inertia / len(parts))
        for role, own in parts:
            if role is None:
                name = new_name(body.main.name, body.main.type, body.key, repeated, taken)
            else:
                name = f"{role[0].name}.{role[1]}"
            rotors.append(Rotor(name, root, body, own, share, role, len(parts), _gear_names(own)))
        if len(parts) > 1:
            where = ", ".join(rotor.name for rotor in rotors[-len(parts) :])
            notes.assume(
                f"{body.main} is in several sets: rotors {where} with equal parts of its mass, coupled by its twist"
            )
    for root, body in every.items():
        if root not in kept and root not in planets and not bodies.stands(root):
            notes.skip("without gear, coupling or load: no rotor", body.main)
    return rotors


def _meshes(bodies: Bodies, body: Body) -> bool:
    """Return whether a gear of a body that stands still is in a stage."""
    return any(
        bodies.box.linked(("stage",), role, gear.id, "stage")
        for gear in body.gears
        for role in ("gear_1", "gear_2")
    )


def _gear_names(gears: list[Gear]) -> dict[int, str]:
    if len(gears) < 2:
        return {}
    names = Counter(plain_name(each.component.name, "gear") for each in gears)
    repeated, taken = {name for name, count in names.items() if count > 1}, set[str]()
    return {
        each.component.id: new_name(each.component.name, "gear", each.component.id, repeated, taken)
        for each in gears
    }


def shaft_twist(bodies: Bodies, body: Body) -> float:
    """Return the torsional stiffness of a body's main shaft from end to end [N m/rad]."""
    compliance = 0.0
    for piece in bodies.box.parts(body.key, "shaft_section"):
        length, outer, inner = bodies.section(piece)
        fourth = math.pi / 32.0 * (_mean(outer) ** 4 - _mean(inner) ** 4)
        if length > 0.0 and fourth > 0.0:
            compliance += length / (80e9 * fourth)
    return float(f"{1.0 / compliance:.4g}") if compliance > 0.0 else STIFF_SHAFT


def _mean(ends: tuple[float, float]) -> float:
    return 0.5 * (ends[0] + ends[1])


def drive_and_load(
    rotor: Rotor, others: Iterable[Rotor], motion: Motion, *, fixed: bool
) -> tuple[Any, Any, str]:
    """Return drive and load of a rotor and a comment; of a body of several rotors the last one has both."""
    of_body = [each for each in others if each.root == rotor.root]
    if fixed or rotor is not of_body[-1]:
        return None, None, ""
    speed, root = motion.speeds.get(rotor.root, 0.0), rotor.root
    drive = load = None
    if root == motion.driver and speed:
        drive = {"kind": "speed", "speed": quantity(speed, "rpm")}
    elif root in motion.drives:
        drive = {"kind": "torque", "torque": quantity(motion.drives[root], "N m")}
    if root in motion.loads:
        load = {"torque": quantity(motion.loads[root], "N m")}
    return drive, load, f"{speed * 30.0 / math.pi:.6g} rpm nominal" if speed and not drive else ""


def material_of(box: Gearbox, component: Component) -> dict[str, Any] | None:
    """Return the material of a component, None without a thermal expansion, the one property that acts on a case."""
    for material in box.referenced(component.id, "material"):
        expansion = box.number(
            material, q.EXPANSION, "thermal_expansion_coefficient_plus", "thermal_expansion_coefficient"
        )
        modulus = box.number(material, q.PRESSURE, "elastic_modulus")
        modulus = None if modulus is not None and modulus > STIFF_MATERIAL else modulus
        poisson = box.number(material, None, "poisson_ratio")
        density = box.number(material, q.MASS_DENSITY, "density")
        if expansion is not None:
            found = {
                "modulus": modulus and quantity(modulus, "GPa"),
                "poisson": poisson,
                "density": density and quantity(density, "kg/m^3"),
                "expansion": quantity(expansion, "1/K"),
            }
            return {key: value for key, value in found.items() if value}
    return None
