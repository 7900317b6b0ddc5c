"""Planetary stages: sun, ring, planets and carrier of each, found by their relations."""

import math
import re
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Final

from gearplay.rexs.bodies import GROUND, Bodies, Link
from gearplay.rexs.notes import Notes
from gearplay.rexs.placement import Plane
from gearplay.rexs.records import Component, Gearbox, refused
from gearplay.rexs.teeth import Gear, Pair
from gearplay.vocabulary import quantities as q

_AT: Final = re.compile(r"@\s*(-?\d+(?:[.,]\d+)?)\s*(?:°|deg)?\s*$")
"""Angle at the end of a planet's name."""


@dataclass
class PlanetSet:
    """One planetary stage."""

    component: Component
    stages: list[Component]
    carriers: list[int]
    planets: list[Gear] = field(default_factory=list)
    sun: Gear | None = None
    ring: Gear | None = None
    sun_pairs: list[Pair] = field(default_factory=list)
    ring_pairs: list[Pair] = field(default_factory=list)
    pins: list[int] = field(default_factory=list)
    name: str = "stage"

    @property
    def members(self) -> dict[str, int]:
        """Main component of the body of each member."""
        assert self.sun is not None
        assert self.ring is not None
        return {"sun": self.sun.component.id, "ring": self.ring.component.id, "carrier": self.carriers[0]}


def find_sets(box: Gearbox, bodies: Bodies, gears: dict[int, Gear], notes: Notes) -> list[PlanetSet]:
    """Return the planetary stages; the components of each carrier become one body.

    Raises `InputError` for a stage without planets, carrier, sun or ring, and for stepped planets and second suns or rings.
    """
    return [_find_set(box, bodies, gears, each, notes) for each in box.of_type("planetary_stage")]


def _find_set(
    box: Gearbox, bodies: Bodies, gears: dict[int, Gear], component: Component, notes: Notes
) -> PlanetSet:
    def shafts(kind: str) -> list[int]:
        found = box.linked((kind,), "planetary_stage", component.id, "shaft")
        return [each.id for each in found if each.id in bodies.root]

    on_planets = {bodies.find(number) for number in shafts("planet_shaft")}
    if not on_planets:
        raise refused(str(component), "must have planet shafts", "Export the stage with its planets")
    touching = [
        stage
        for stage in box.of_type("cylindrical_stage")
        if any(bodies.find(number) in on_planets for number in box.stage_gears(stage) if number in gears)
    ]
    found = PlanetSet(component, touching, _carrier(bodies, shafts, component, on_planets, notes))
    found.pins = shafts("planet_pin")
    for number, gear in sorted(gears.items()):
        if bodies.find(number) in on_planets:
            found.planets.append(gear)
    if len(found.planets) != len(on_planets):
        rule = f"must have one gear on each planet shaft; it has {len(found.planets)} on {len(on_planets)}"
        raise refused(
            str(component),
            rule,
            "Stepped planets cannot be imported: split the stage, or write the case by hand",
        )
    _centrals(box, bodies, gears, found, on_planets)
    return found


def _carrier(
    bodies: Bodies,
    shafts: Callable[[str], list[int]],
    component: Component,
    on_planets: set[int],
    notes: Notes,
) -> list[int]:
    """Return the components of the carrier, made one body: carrier shafts, pins, else what the planets' bearings sit on."""
    own, pins = shafts("planet_carrier_shaft"), shafts("planet_pin")
    numbers = [*own, *pins] or [
        side
        for link in bodies.bearings
        for side, other in ((link.inner, link.outer), (link.outer, link.inner))
        if side != GROUND
        and bodies.find(side) not in on_planets
        and other != GROUND
        and bodies.find(other) in on_planets
    ]
    if not numbers:
        raise refused(
            str(component),
            "must have a carrier: planet_carrier_shaft or planet_pin",
            "Export the stage with it",
        )
    if len({bodies.find(number) for number in numbers}) > 1:
        notes.assume(
            f"parts of the carrier of {component} are not joined in the file: they are one rigid body"
        )
    bodies.join(numbers)
    return numbers


def _centrals(
    box: Gearbox, bodies: Bodies, gears: dict[int, Gear], found: PlanetSet, on_planets: set[int]
) -> None:
    for stage in found.stages:
        for number in box.stage_gears(stage):
            gear = gears.get(number)
            if gear is None or bodies.find(number) in on_planets:
                continue
            member = "ring" if gear.internal else "sun"
            known = getattr(found, member)
            if known is not None and known is not gear:
                rule = f"must have one {member}: {known.component} and {gear.component} mesh with its planets"
                raise refused(str(found.component), rule, "Split the stage, or write the case by hand")
            setattr(found, member, gear)
    for member in ("sun", "ring"):
        if getattr(found, member) is None:
            raise refused(
                str(found.component),
                f"must have a {member} that meshes with its planets",
                "Write the case by hand",
            )


def planet_angles(box: Gearbox, found: PlanetSet, plane: Plane, notes: Notes) -> list[float]:
    """Return the direction [deg] of each planet from the centre, in the order of ``found.planets``.

    By positions, else by the rotating angles of the stages with the sun, else by the names' ends (``@ 240.0°``), else equally
    spaced. Both kinds of angle count from the w axis.
    """
    assert found.sun is not None
    angles: list[float] = []
    for gear in found.planets:
        direction = plane.direction(found.sun.component.id, gear.component.id)
        if direction is None:
            direction = _stage_direction(box, found, gear)
        if direction is None:
            named = _AT.search(gear.component.name)
            direction = math.radians(90.0 + float(named[1].replace(",", "."))) if named else None
        if direction is None:
            notes.assume(f"places of the planets of {found.component} are not in the file: equally spaced")
            return [round(360.0 * k / len(found.planets), 9) for k in range(len(found.planets))]
        angles.append(round(math.degrees(direction) % 360.0, 9) % 360.0)
    return angles


def _stage_direction(box: Gearbox, found: PlanetSet, planet: Gear) -> float | None:
    assert found.sun is not None
    for pair in found.sun_pairs:
        if planet in (pair.first, pair.second):
            turned = stage_direction(box, pair.stage)
            if turned is not None:
                return turned if pair.first is found.sun else turned + math.pi
    return None


def stage_direction(box: Gearbox, stage: Component) -> float | None:
    """Return the direction [rad] from the first gear of a stage to the second by its rotating angle, from w about -u."""
    turned = box.number(stage, q.ANGLE, "rotating_angle_around_neg_u_axis")
    return None if turned is None else 0.5 * math.pi - turned


def planet_bearings(bodies: Bodies, found: PlanetSet, planet: Gear) -> list[Link]:
    """Return the bearings between a planet and the carrier."""
    ends = {bodies.find(planet.component.id), bodies.find(found.carriers[0])}
    return [link for link in bodies.bearings if {bodies.find(link.inner), bodies.find(link.outer)} == ends]
