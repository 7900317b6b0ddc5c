"""Kinematics of a machine as a diagnosis needs it: shafts, gears, meshes and bearings by their orders."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Final

import numpy as np

from gearplay.diagnosis.planetary_set import LOUD, PlanetarySet
from gearplay.signals.bearing_lines import BearingOrders, bearing_orders
from gearplay.vocabulary.errors import NO_VALUE, InputError

if TYPE_CHECKING:
    from gearplay.model.case import Case

MOST: Final = 40
"""Most gears or bearings of a machine."""
EXAMPLE: Final = 'Write "23:61", of two stages "23:61, 19:47"'
BEARING: Final = (
    'Write elements, their diameter and the pitch diameter: "8, 7.9mm, 33.5mm", on the second shaft "... @2"'
)


@dataclass(frozen=True)
class Shaft:
    """A shaft that turns ``order`` times in one turn of the first one."""

    name: str
    order: float


@dataclass(frozen=True)
class Gear:
    """A gear: a defect of one tooth recurs ``order`` times per turn of the first shaft; ``shaft`` is None on a planetary set."""

    name: str
    teeth: int
    order: float
    shaft: int | None


@dataclass(frozen=True)
class Mesh:
    """A pair of gears: teeth in mesh per turn of the first shaft, and the indices of its gears."""

    name: str
    order: float
    gears: tuple[int, ...]


@dataclass(frozen=True)
class Bearing:
    """A rolling bearing whose rings turn ``order`` times against each other in one turn of the first shaft.

    ``turning`` is the ring that turns under the load, "inner" or "outer"; ``orders`` has the cage relative to the other one.
    ``carrier`` is the order with which a carrier moves it past the sensor, 0 on the ground; ``rotor`` its table in a case.
    """

    name: str
    order: float
    orders: BearingOrders
    rotor: str = ""
    turning: str = "inner"
    carrier: float = 0.0


@dataclass(frozen=True)
class Machine:
    """Shafts (the first is the reference), gears, meshes, bearings; ``others`` are further lines by name, as orders.

    ``speed`` is the nominal one of the first shaft [Hz], None where it is not known.
    """

    shafts: tuple[Shaft, ...]
    gears: tuple[Gear, ...] = ()
    meshes: tuple[Mesh, ...] = ()
    bearings: tuple[Bearing, ...] = ()
    sets: tuple[PlanetarySet, ...] = ()
    others: dict[str, float] = field(default_factory=dict)
    speed: float | None = None

    def with_bearings(self, texts: Sequence[str]) -> Machine:
        """Return the machine with further bearings, each as text; `InputError` for text that is none."""
        if len(texts) > MOST:
            raise InputError.of("bearings", len(texts), f"must be at most {MOST}", "Name fewer")
        found = [
            bearing_of(text, k, [shaft.order for shaft in self.shafts], alone=len(texts) == 1)
            for k, text in enumerate(texts, 1)
        ]
        return replace(self, bearings=(*self.bearings, *found))

    def mesh_lines(self, harmonics: int) -> list[float]:
        """Return the orders at which harmonics of the meshes have lines, of planetary sets those of passing planets too."""
        return [o for mesh in self.meshes for h in range(1, harmonics + 1) for o in self.lines_of(mesh, h)]

    def lines_of(self, mesh: Mesh, h: int) -> list[float]:
        """Return the orders at which harmonic h of a mesh has lines."""
        own = self.set_of(mesh.gears[0])
        if own is None or own.sum_at(h * own.teeth) >= LOUD:
            return [h * mesh.order] if own is None else own.alike(h)
        return [h * mesh.order, *own.alike(h)]  # the first where planets are not alike

    def set_of(self, gear: int) -> PlanetarySet | None:
        """Return the planetary set that a gear belongs to, None for one with a shaft of its own."""
        return next((each for each in self.sets if gear in each.gears), None)

    def hunting(self, mesh: Mesh) -> float:
        """Return the order at which the same two teeth of a mesh meet."""
        return mesh.order / math.lcm(*(self.gears[k].teeth for k in mesh.gears[:2]))


def machine_of_teeth(text: str) -> Machine:
    """Return the machine of a train given by its teeth, ``driver:driven`` of each stage, the first shaft driving.

    >>> machine = machine_of_teeth("20:40, 10:30")
    >>> [shaft.order for shaft in machine.shafts], [mesh.order for mesh in machine.meshes]
    ([1.0, 0.5, 0.16666666666666666], [20.0, 5.0])
    """
    stages = [re.fullmatch(r"\s*(\d{1,5})\s*[:/]\s*(\d{1,5})\s*", part) for part in text.split(",")]
    pairs = [(int(each[1]), int(each[2])) for each in stages if each is not None]
    if len(pairs) < len(stages) or not all(3 <= z <= 10_000 for pair in pairs for z in pair):
        rule = "must be numbers of teeth, 3 to 10000 each, driver and driven of every stage"
        raise InputError.of("teeth", text, rule, EXAMPLE)
    if 2 * len(pairs) > MOST:
        raise InputError.of(
            "teeth", text, f"must be at most {MOST // 2} stages", "Name those near the sensor"
        )
    shafts, gears, meshes = [Shaft("shaft 1", 1.0)], list[Gear](), list[Mesh]()
    for k, (driver, driven) in enumerate(pairs):
        order, place = shafts[-1].order, len(gears)
        shafts.append(Shaft(f"shaft {k + 2}", order * driver / driven))
        gears.append(Gear(f"gear {place + 1} ({driver} teeth)", driver, order, k))
        gears.append(Gear(f"gear {place + 2} ({driven} teeth)", driven, shafts[-1].order, k + 1))
        name = "mesh" if len(pairs) == 1 else f"mesh {k + 1}"
        meshes.append(Mesh(name, order * driver, (place, place + 1)))
    return Machine(tuple(shafts), tuple(gears), tuple(meshes))


def bearing_of(text: str, number: int, turns: Sequence[float], *, alone: bool = True) -> Bearing:
    """Return a bearing given as ``elements, diameter, pitch diameter[, contact angle][@shaft]``, or ``designation[@shaft]``.

    ``turns`` are orders of shafts; designations are those of `CATALOGUE`.

    >>> round(bearing_of("8, 7.9mm, 33.5mm", 1, [1.0]).orders.bpfi, 9)
    4.943283582
    >>> round(bearing_of("6205@2", 1, [1.0, 0.5]).orders.bpfo, 4)
    3.5848
    """
    from gearplay.parts.bearing.geometry import CATALOGUE
    from gearplay.schema.units import UnitError, parse_quantity
    from gearplay.vocabulary.quantities import ANGLE, LENGTH

    body, at, place = text.partition("@")
    parts = [part.strip() for part in body.split(",")]
    known = CATALOGUE.get(body.strip())
    if known is None and (not 3 <= len(parts) <= 4 or not re.fullmatch(r"[0-9]{1,4}", parts[0])):
        rule = f"must be a bearing's geometry, or one of {', '.join(CATALOGUE)}"
        raise InputError.of("bearings", text, rule, BEARING)
    shaft = place.strip() if at else "1"
    if not re.fullmatch(r"[0-9]{1,2}", shaft) or not 1 <= int(shaft) <= len(turns):
        rule = (
            f"must sit on a shaft that there is, 1 to {len(turns)}"
            if len(turns) > 1
            else "must sit on shaft 1, the only one"
        )
        raise InputError.of("bearings", text, rule, BEARING)
    try:
        sizes = (
            [known.element_diameter, known.pitch_diameter]
            if known
            else [parse_quantity(part, LENGTH) for part in parts[1:3]]
        )
        angle = parse_quantity(parts[3], ANGLE) if len(parts) == 4 else 0.0
    except UnitError as error:
        raise InputError.of("bearings", text, error.rule, BEARING) from None
    try:
        orders = bearing_orders(known.elements if known else int(parts[0]), *sizes, contact_angle=angle)
    except InputError as error:
        fault = error.faults[0]
        raise InputError.of("bearings", text, f"{fault.path} {fault.rule}", fault.cure) from None
    name = "bearing" if alone else f"bearing {number}"
    return Bearing(name, turns[int(shaft) - 1], orders)


def machine_of_case(case: Case) -> Machine:
    """Return the machine of a case at its nominal speeds; the first shaft is that of the first mesh's driver.

    Its rolling bearings are those whose outer ring stands, and one for the planets of each set.

    Raises `InputError` for a case without a mesh or a rolling bearing, or one whose shafts stand.
    """
    from gearplay.parts.mesh.frequencies import mesh_frequencies, rolling_frame
    from gearplay.parts.mesh.train import rolling
    from gearplay.parts.mesh.train.geometry import rotor_of
    from gearplay.parts.planetary.frequencies import set_frequencies

    if not case.meshes and not case.bearings:
        rule = "must have a mesh or a rolling bearing"
        raise InputError.of("case", case.title, rule, "Give a case with either, or the teeth")
    names = list(case.rotors)
    turns = np.abs(rolling.nominal_speeds(case)) / (2.0 * math.pi)
    fixed = [j for j in range(len(case.meshes)) if rolling_frame(case, j) is None]
    if case.meshes:
        first = rotor_of(case, case.meshes[fixed[0] if fixed else 0].driver)
    else:
        first = max(case.bearings, key=lambda name: turns[names.index(name)])
    speed = float(turns[names.index(first)])
    if speed == 0.0 or not np.any(turns > 0.0):
        rule = "must prescribe a speed, at which its shafts turn"
        raise InputError.of("case", case.title, rule, "Give a drive with a speed, or the teeth and the speed")
    turning = [
        first,
        *(n for n in names if n != first and ".planet" not in n and turns[names.index(n)] > 0.0),
    ]
    shafts = tuple(Shaft(n, float(turns[names.index(n)]) / speed) for n in turning)
    gears: dict[str, Gear] = {}
    meshes: list[Mesh] = []
    for j in fixed:
        found = mesh_frequencies(case, j)
        if found.mesh == 0.0 or any(".planet" in name for name in found.shafts):
            continue
        for name, f in found.rotations.items():
            rotor = rotor_of(case, name)
            place = turning.index(rotor) if rotor in turning else None
            gears.setdefault(name, Gear(name, round(found.mesh / f), f / speed, place))
        both = tuple(list(gears).index(name) for name in found.rotations)
        meshes.append(Mesh(f"mesh {case.meshes[j].label}", found.mesh / speed, both))
    others: dict[str, float] = {}
    sets: list[PlanetarySet] = []
    for name, table in case.planetary.items():
        found_set, count = set_frequencies(case, name), len(gears)
        if found_set.mesh == 0.0:
            continue
        members = {"sun": (table.sun.teeth, found_set.sun), "planet": (table.planets.teeth, found_set.planet),
                   "ring": (table.ring.teeth, found_set.ring)}  # fmt: skip
        for member, (teeth, f) in members.items():
            gears[f"{name}.{member}"] = Gear(f"{name}.{member}", teeth, f / speed, None)
        meshes.append(Mesh(f"mesh {name}", found_set.mesh / speed, (count, count + 1, count + 2)))
        periods = found_set.mesh / found_set.carrier if found_set.carrier > 0.0 else 0.0
        if periods > 0.0 and abs(periods - round(periods)) < 1e-6:
            forward = math.copysign(1.0, float(rolling.nominal_speeds(case)[names.index(f"{name}.carrier")]))
            sets.append(
                PlanetarySet(
                    name, tuple(forward * angle for angle in table.planets.directions), round(periods), found_set.carrier / speed,
                    found_set.mesh / table.sun.teeth / speed, found_set.planet / speed, (count, count + 1, count + 2),
                    turning.index(f"{name}.carrier"),
                )
            )  # fmt: skip
        others |= {f"{word} of {name}": f / speed for word, f in found_set.orders().items()
                   if word.startswith(("carrier", "mesh "))}  # fmt: skip
    bearings = [
        Bearing(
            f"bearing of {name}",
            shafts[turning.index(name)].order,
            BearingOrders(o.cage, o.outer, o.inner, o.spin),
            name,
        )
        for name, each in case.bearings.items()
        if name in turning and each.on is None and each.rotor_ring == "inner" and (o := each.orders)
    ]
    for each in sets:
        pin = case.bearings.get(f"{each.name}.planet1")
        if pin is not None:
            o, ring = pin.orders, pin.rotor_ring
            cage = o.cage if ring == "inner" else 1.0 - o.cage
            planet = gears[f"{each.name}.planet"].order
            bearings.append(
                Bearing(f"bearing of a planet of {each.name}", planet, BearingOrders(cage, o.outer, o.inner, o.spin),
                        f"{each.name}.planet1", ring, each.carrier)
            )  # fmt: skip
    return Machine(shafts, tuple(gears.values()), tuple(meshes), tuple(bearings), tuple(sets), others, speed)


def described(case: Case | None, teeth: str | None, bearings: str | Sequence[str]) -> Machine:
    """Return the machine of a case, of teeth or of bearings alone; `InputError` without any, or with teeth and a case."""
    if case is not None and teeth is not None:
        raise InputError.of("teeth", teeth, "must not be given with a case, which has them", "Leave one out")
    given = (bearings,) if isinstance(bearings, str) else tuple(bearings)
    if case is not None:
        machine = machine_of_case(case)
    elif teeth is not None:
        machine = machine_of_teeth(teeth)
    elif given:
        machine = Machine((Shaft("shaft 1", 1.0),))
    else:
        rule = "is required where neither a case nor a bearing is given"
        raise InputError.of("teeth", NO_VALUE, rule, 'Give teeth "23:61", or a bearing "8, 7.9mm, 33.5mm"')
    return machine.with_bearings(given)
