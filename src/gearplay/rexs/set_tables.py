"""Tables of a planetary set: the set, sun, planets, ring, carrier."""

from typing import Any, Final

from gearplay.parts.planetary.members import Member, Planets, Toothed
from gearplay.parts.planetary.schema import Planetary
from gearplay.parts.support.schema import Support
from gearplay.rexs.bodies import Body
from gearplay.rexs.holding import Holding, holding_of
from gearplay.rexs.mechanism import material_of
from gearplay.rexs.sets import PlanetSet, planet_angles, planet_bearings
from gearplay.rexs.tables import MESH_DAMPING, Tables
from gearplay.rexs.text import number, quantity
from gearplay.rexs.writing import Table

PIN: Final = 2e9
"""Stiffness of a planet's pin where its bearing is rigid or has none in the file [N/m]; a case has no rigid pins."""


def set_tables(tables: Tables, found: PlanetSet, every: dict[int, Body]) -> list[Table]:
    """Return the tables of a planetary set."""
    assert found.sun is not None
    pair, outer = found.sun_pairs[0], found.ring_pairs[0]
    table = Table(f"[planetary.{found.name}]", Planetary, [f"{found.component}."])
    table.add("module", quantity(found.sun.module, "mm"))
    table.add("pressure_angle", quantity(found.sun.pressure_angle, "deg"))
    table.add("center_distance", quantity(pair.distance, "mm"))
    tables.pair_fields(table, pair)
    bare = not any("allowance" in each.fields for each in found.planets)
    tables.allow([pair])
    given = [each.fields["allowance"] for each in found.planets if "allowance" in each.fields]
    for each in found.planets if bare and given else ():
        each.fields["allowance"] = given[0]
    tables.allow([*found.sun_pairs, *found.ring_pairs])
    widths = [tables.stiffness(each) for each in (pair, outer)]
    if widths[0] == widths[1]:
        table.add("stiffness", widths[0])
    else:
        table.add("sun_planet", widths[0])
        table.add("planet_ring", widths[1])
    table.add("damping", {"ratio": MESH_DAMPING}, "assumed")
    planet = found.planets[0]
    links = planet_bearings(tables.bodies, found, planet)
    holding = holding_of(tables.box, links, tables.notes)
    weight = every[tables.bodies.find(planet.component.id)].weight
    pins = Holding(False, holding.stiffness or (PIN, PIN), holding.said)
    if holding.stiffness is None:
        tables.notes.assume(
            f"pins of {found.component} are rigid in the file: {PIN:g} N/m, since planets of a case sit on elastic pins"
        )
    support = {
        "stiffness": [quantity(each, "N/m") for each in pins.stiffness or ()],
        "damping": [quantity(each, "N s/m") for each in pins.damping(weight.mass)],
    }
    table.add("support", support)
    table.comments += [f"Pins: {'; '.join(holding.said)}."] if holding.said else []
    return [
        table,
        _member(tables, found, "sun", Toothed),
        _planets(tables, found, every),
        _member(tables, found, "ring", Toothed),
        _member(tables, found, "carrier", Member),
    ]


def _member(tables: Tables, found: PlanetSet, member: str, model: Any) -> Table:
    """Return the table of a sun, a ring or a carrier."""
    rotor = next(each for each in tables.rotors if each.member == (found, member))
    table = Table(f"[planetary.{found.name}.{member}]", model)
    gear = {"sun": found.sun, "ring": found.ring}.get(member)
    if gear is not None:
        table.comments.append(f"{gear.component}.")
        table.add("teeth", gear.teeth)
    tables.common(table, rotor)
    if gear is not None:
        tables.toothing(table, gear)
    if rotor.root in tables.fixed:
        table.add("fixed", True, "coupled to the casing")
        return table
    holding = tables.held_by(rotor)
    inner = Table("", Support)
    tables.support(inner, holding, rotor)
    if inner.entries:
        table.add("support", {each.key: each.value for each in inner.entries})
        table.comments += [f"Its bearings: {'; '.join(holding.said)}."] if holding.said else []
    if not holding.held and holding.stiffness is None:
        table.add("floating", True, "no bearing in the file")
    elif holding.held:
        table.comments.append(f"Its centre is held: {'; '.join(holding.said)}.")
    return table


def _planets(tables: Tables, found: PlanetSet, every: dict[int, Body]) -> Table:
    angles = planet_angles(tables.box, found, tables.plane, tables.notes)
    order = sorted(range(len(angles)), key=lambda k: angles[k])
    planet = found.planets[order[0]]
    body = every[tables.bodies.find(planet.component.id)]
    table = Table(f"[planetary.{found.name}.planets]", Planets)
    table.comments = [f"{', '.join(str(found.planets[k].component) for k in order)}.", *body.said]
    table.add("count", len(angles))
    table.add("teeth", planet.teeth)
    table.add("angles", [f"{number(angles[k])} deg" for k in order])
    table.add("mass", quantity(float(f"{body.weight.mass:.9g}"), "kg"))
    table.add("inertia", quantity(float(f"{body.weight.inertia:.9g}"), "kg m^2"))
    table.add("material", material_of(tables.box, body.main))
    tables.toothing(table, planet)
    for other in found.planets:
        if any(
            getattr(other, key) != getattr(planet, key)
            for key in ("teeth", "shift", "helix", "fields", "facewidth")
        ):
            tables.notes.leave_out(
                f"differs from {planet.component}: planets of a set are alike", other.component
            )
    return table
