"""Rigid bodies: shafts, side plates and gears that rigid couplings join, with mass and inertia from their sections."""

import math
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Final

from gearplay.rexs.notes import Notes
from gearplay.rexs.placement import Plane
from gearplay.rexs.records import Component, Gearbox
from gearplay.vocabulary import quantities as q

GEARS: Final = ("cylindrical_gear", "ring_gear")
PLATES: Final = ("shaft", "side_plate")
COUPLINGS: Final = ("coupling", "switchable_coupling", "fixed_coupling")
FITS: Final = (
    "cylindrical_interference_fit", "tapered_interference_fit", "feather_key_connection", "involute_spline_connection",
)  # fmt: skip
"""Connections of shaft and hub, taken as rigid."""
SIDES: Final = ("side", "coupling", "connection")
GROUND: Final = -1
"""Number of the casing as a body."""
RIGID_TWIST: Final = 1e10
"""Torsional stiffness from which on a coupling is rigid [N m/rad]; programs write 1e17 and more."""
RIGID: Final = 1e13
"""Radial stiffness from which on a bearing is rigid [N/m]; programs write 1e20."""
STEEL: Final = 7850.0
STIFF_MATERIAL: Final = 2e12
"""Young's modulus above which a material is a device of the writing program [Pa]."""


@dataclass
class Weight:
    """Mass [kg] and inertia about the axis of the body [kg m^2]."""

    mass: float = 0.0
    inertia: float = 0.0

    def add(self, other: "Weight", offset: float = 0.0) -> None:
        """Add another, whose axis is ``offset`` [m] away."""
        self.mass += other.mass
        self.inertia += other.inertia + other.mass * offset**2


def ring(length: float, outer: tuple[float, float], inner: tuple[float, float], density: float) -> Weight:
    """Return the weight of a conical ring from its diameters [m] at both ends.

    >>> weight = ring(0.08, (0.05, 0.05), (0.0, 0.0), 7850.0)
    >>> round(weight.mass, 6), round(weight.inertia, 9)
    (1.233075, 0.000385336)
    """

    def powers(ends: tuple[float, float], order: int) -> float:
        a, b = (0.5 * each for each in ends)
        return sum(a**k * b ** (order - k) for k in range(order + 1)) / (order + 1)

    volume = math.pi * length * (powers(outer, 2) - powers(inner, 2))
    fourth = 0.5 * math.pi * length * (powers(outer, 4) - powers(inner, 4))
    return Weight(density * volume, density * fourth)


@dataclass
class Link:
    """A coupling or a bearing between two bodies, of which one may be the casing."""

    component: Component
    inner: int
    outer: int


@dataclass
class Body:
    """Components that turn together, on one axis."""

    members: list[Component]
    gears: list[Component] = field(default_factory=list)
    weight: Weight = field(default_factory=Weight)
    said: list[str] = field(default_factory=list)

    @property
    def main(self) -> Component:
        """The shaft with the most gears, or the first one."""
        return self.members[0]

    @property
    def key(self) -> int:
        """Number of the body: the id of its main component."""
        return self.main.id


class Bodies:
    """Bodies of a gearbox, and the elastic links between them."""

    def __init__(self, box: Gearbox, notes: Notes) -> None:
        self.box, self.notes = box, notes
        self.root: dict[int, int] = {GROUND: GROUND}
        self._grounded: set[int] = set()
        for each in box.of_type(*PLATES, *GEARS):
            self.root[each.id] = each.id
        for gear in box.of_type(*GEARS):
            for shaft in box.assemblies(gear.id, "shaft"):
                self._join(gear.id, shaft.id)
        self.links: list[Link] = []
        self.bearings: list[Link] = []
        self._connect()

    def find(self, number: int) -> int:
        """Return the representative of a component's body."""
        while self.root[number] != number:
            self.root[number] = self.root[self.root[number]]
            number = self.root[number]
        return number

    @property
    def fixed(self) -> set[int]:
        """Representatives of the bodies that are rigidly coupled to the casing."""
        return {self.find(number) for number in self._grounded}

    def stands(self, number: int) -> bool:
        """Return whether a component belongs to the casing, or to a body that is coupled to it."""
        root = self.find(number)
        return root == GROUND or root in self.fixed

    def _join(self, first: int, second: int) -> None:
        """Merge two bodies into one; a body joined to the casing is fixed and stays separate."""
        if GROUND in (first, second):
            self._grounded |= {first, second} - {GROUND}
            return
        a, b = self.find(first), self.find(second)
        self.root[max(a, b)] = min(a, b)

    def join(self, numbers: Iterable[int]) -> None:
        """Merge several components into one body."""
        numbers = list(numbers)
        for other in numbers[1:]:
            self._join(numbers[0], other)

    def side(self, component: Component) -> int:
        """Return the number of the body of one part of a link; the casing for a part without a body."""
        if component.id in self.root:
            return component.id
        inside = [part for part in self.box.parts(component.id) if part.id in self.root]
        if component.type == "planet_carrier" and inside:
            return inside[0].id
        return GROUND

    def _connect(self) -> None:
        box = self.box
        for relation in box.relations:
            if relation.type not in SIDES:
                continue
            inner, outer = relation.role("inner_part", "side_1"), relation.role("outer_part", "side_2")
            for number in relation.role("assembly", "coupling", "connection"):
                component = box.components[number]
                ends = [self.side(box.components[side[0]]) if side else GROUND for side in (inner, outer)]
                link = Link(component, ends[0], ends[1])
                if component.type in COUPLINGS:
                    self._couple(link)
                elif component.type in FITS:
                    self._join(*ends)
                    self.notes.leave_out(
                        f"elasticity and play of {component}: it is rigid; its twist adds to no stiffness"
                    )
                elif "bearing" in component.type:
                    self.bearings.append(link)
                else:
                    self.notes.skip(f"{component} between two parts: it neither joins nor holds them")

    def _couple(self, link: Link) -> None:
        component, box = link.component, self.box
        if component.type == "switchable_coupling" and box.flag(component, "is_engaged") is False:
            self.notes.leave_out(f"{component} is not engaged: its two sides turn on their own")
            return
        twist = box.number(component, q.ROTATIONAL_STIFFNESS, "rotational_stiffness")
        if twist is None and component.type != "fixed_coupling":
            self.notes.assume(f"{component} has no torsional stiffness in the file: it is rigid")
        if twist is None or twist >= RIGID_TWIST:
            self._join(link.inner, link.outer)
        elif twist == 0.0:
            self.bearings.append(link)
        else:
            self.links.append(link)

    def every(self, plane: Plane, offsets: dict[int, float]) -> dict[int, Body]:
        """Return all bodies, by their representatives, with their weights.

        ``offsets`` [m] are distances of components from the axis of their body where the file has no positions.
        """
        groups: dict[int, list[Component]] = {}
        for number in sorted(self.root):
            if number != GROUND:
                groups.setdefault(self.find(number), []).append(self.box.components[number])
        found = {}
        for root, members in groups.items():
            gears = [each for each in members if each.type in GEARS]
            own = [each for each in members if each.type not in GEARS]
            count = {each.id: len(self.box.parts(each.id, *GEARS)) for each in own}
            own.sort(key=lambda each: (-count[each.id], each.type != "shaft", each.id))
            body = Body(own or gears, gears)
            found[root] = body
            for each in own:
                self._weigh(body, each, plane, offsets)
        return found

    def density(self, component: Component) -> float:
        """Return the density of a component's material [kg/m^3]."""
        for material in self.box.referenced(component.id, "material"):
            density = self.box.number(material, q.MASS_DENSITY, "density")
            if density is not None:
                return density
            if (self.box.number(material, q.PRESSURE, "elastic_modulus") or 0.0) > STIFF_MATERIAL:
                self.notes.assume(
                    "no mass: its material is stiffened artificially and has no density", component
                )
                return 0.0
        self.notes.assume(f"no density in the file: steel, {STEEL:g} kg/m^3", component)
        return STEEL

    def _weigh(self, body: Body, component: Component, plane: Plane, offsets: dict[int, float]) -> None:
        own = Weight()
        pieces = self.box.parts(component.id, "shaft_section") if component.type == "shaft" else [component]
        density = self.density(component) if pieces else 0.0
        for piece in pieces:
            length, outer, inner = self.section(piece)
            if length > 0.0 and outer[0] + outer[1] > 0.0:
                own.add(ring(length, outer, inner, density))
        for extra in self.box.parts(component.id, "additional_mass"):
            mass = self.box.number(extra, q.MASS, "mass_of_component") or 0.0
            own.add(Weight(mass))
            self.notes.leave_out(f"inertia of {extra}: {mass:g} kg act in the axis of {component}")
        placed = plane.distance(body.key, component.id)
        offset = offsets.get(component.id, 0.0) if placed is None else placed
        offset = round(offset, 9)
        if own.mass > 0.0:
            away = f", {1e3 * offset:.6g} mm off the axis" if offset > 1e-9 else ""
            body.said.append(f"{component}: {own.mass:.7g} kg, {own.inertia:.7g} kg m^2{away}")
        body.weight.add(own, offset)

    def section(self, piece: Component) -> tuple[float, tuple[float, float], tuple[float, float]]:
        """Return length, outer and inner diameters at both ends of a section or a plate [m]."""
        box = self.box

        def ends(kind: str) -> tuple[float, float]:
            begin = box.number(piece, q.LENGTH, f"{kind}_diameter_begin", f"{kind}_diameter")
            end = box.number(piece, q.LENGTH, f"{kind}_diameter_end", f"{kind}_diameter")
            first = begin if begin is not None else end or 0.0
            return first, end if end is not None else first

        return box.number(piece, q.LENGTH, "length", "width") or 0.0, ends("outer"), ends("inner")
