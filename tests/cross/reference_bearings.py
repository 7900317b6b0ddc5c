"""Rolling bearings of the reference: every ball or roller as one-sided spring and damper between two rings.

The tables are those of a case file: ``rolling_elements``, ``element_diameter``, ``pitch_diameter``, ``contact_angle``,
``internal_clearance`` (diametral, a number), ``stiffness``, ``exponent``, ``damping`` {value}, ``cage_phase``,
``cage_torque``, ``waviness`` [{order, amplitude, phase, ring}], ``rotor_ring``, ``on``, ``offset``.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

from cross.reference_laws import Body, Pair, Wrench, number, turned

GROUND = Body(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


class Wave(NamedTuple):
    """Amplitude [m], order and phase of a term of waviness."""

    order: float
    amplitude: float
    phase: float

    def height(self, angle: float) -> float:
        """Return how far [m] the ring stands in at an angle on it."""
        return self.amplitude * math.cos(self.order * angle + self.phase)

    def slope(self, angle: float) -> float:
        """Return the derivative by the angle [m]."""
        return -self.order * self.amplitude * math.sin(self.order * angle + self.phase)


class Element(NamedTuple):
    """An element at an instant: its direction, how deep it is pressed [m], the rate [m/s], derivatives by the rings' turns."""

    direction: Pair
    depth: float
    rate: float
    by_inner: float
    by_outer: float


@dataclass(frozen=True, slots=True)
class Bearing:
    """Balls or rollers between a rotor and the ground (``carrier`` -1) or a carrier's ``pin``."""

    rotor: int
    carrier: int
    pin: Pair  # centre of the part on the carrier at its rotation 0, from the carrier's centre
    beside: Pair  # the same from the nominal centre of the rotor
    count: int
    ratio: float
    clearance: float  # half
    stiffness: float
    exponent: float
    chi: float
    cage_phase: float
    torque: bool
    inner_waves: tuple[Wave, ...]
    outer_waves: tuple[Wave, ...]
    outer_moves: bool  # the rotor has the outer ring
    damping: float  # N s/m, of a carried rotor beside its pin

    def relative(self, own: Body, base: Body) -> tuple[Pair, Pair, Pair]:
        """Return the arm of the part on the carrier, displacement and velocity of the rotor's centre from it."""
        if self.carrier < 0:
            return (0.0, 0.0), (own.x - self.beside[0], own.y - self.beside[1]), (own.vx, own.vy)
        arm = turned(base.theta, *self.pin)
        nominal = self.pin[0] - self.beside[0], self.pin[1] - self.beside[1]
        place = own.x + nominal[0] - base.x - arm[0], own.y + nominal[1] - base.y - arm[1]
        rate = own.vx - base.vx + base.omega * arm[1], own.vy - base.vy - base.omega * arm[0]
        return arm, place, rate

    def elements(self, own: Body, carrier: Body | None) -> list[Element]:
        """Return every element at the motion of rotor and carrier."""
        base = carrier or GROUND
        _, (x, y), (vx, vy) = self.relative(own, base)
        inner, outer, side = (base, own, -1.0) if self.outer_moves else (own, base, 1.0)
        share_inner, share_outer = (1.0 - self.ratio) / 2.0, (1.0 + self.ratio) / 2.0
        found = []
        for k in range(self.count):
            phi = self.cage_phase + 2.0 * math.pi * k / self.count
            phi += share_inner * inner.theta + share_outer * outer.theta
            c, s = math.cos(phi), math.sin(phi)
            depth = side * (x * c + y * s) - self.clearance
            depth += sum(wave.height(phi - inner.theta) for wave in self.inner_waves)
            depth += sum(wave.height(phi - outer.theta) for wave in self.outer_waves)
            of_inner = sum(wave.slope(phi - inner.theta) for wave in self.inner_waves)
            of_outer = sum(wave.slope(phi - outer.theta) for wave in self.outer_waves)
            by_phi = side * (-x * s + y * c) + of_inner + of_outer
            by_inner = by_phi * share_inner - of_inner
            by_outer = by_phi * share_outer - of_outer
            rate = side * (vx * c + vy * s) + by_inner * inner.omega + by_outer * outer.omega
            found.append(Element((side * c, side * s), depth, rate, by_inner, by_outer))
        return found

    def loads(self, own: Body, carrier: Body | None, pressed: list[bool]) -> tuple[Wrench, Wrench]:
        """Return what acts on the rotor and on the carrier about their centres; ``pressed`` are the elements that act."""
        base = carrier or GROUND
        arm, (x, y), (vx, vy) = self.relative(own, base)
        fx, fy, turn_own, turn_base = -self.damping * vx, -self.damping * vy, 0.0, 0.0
        for element, acts in zip(self.elements(own, carrier), pressed, strict=True):
            if not acts or element.depth <= 0.0:
                continue
            load = self.stiffness * element.depth**self.exponent * (1.0 + self.chi * element.rate)
            ux, uy = element.direction
            fx -= load * ux
            fy -= load * uy
            mine, other = element.by_inner, element.by_outer
            if self.outer_moves:
                mine, other = other, mine
            if self.torque:
                turn_own -= load * mine
                turn_base -= load * other
            else:
                turn_base += load * (x * uy - y * ux)
        reaction = turn_base - (arm[0] * fy - arm[1] * fx)
        return (fx, fy, turn_own), (-fx, -fy, reaction)


def bearing_of(
    table: Mapping[str, Any], rotor: int, carrier: int, arm: Pair, radial_damping: float
) -> Bearing:
    """Return a bearing of its table; ``arm`` is the rotor's nominal centre from the carrier's."""
    off = table.get("offset") or (0.0, 0.0)
    waves: dict[str, list[Wave]] = {"inner": [], "outer": []}
    for wave in table.get("waviness") or ():
        waves[wave["ring"]].append(
            Wave(float(wave["order"]), float(wave["amplitude"]), number(wave, "phase"))
        )
    return Bearing(
        rotor=rotor,
        carrier=carrier,
        pin=(arm[0] + off[0], arm[1] + off[1]),
        beside=(float(off[0]), float(off[1])),
        count=int(table["rolling_elements"]),
        ratio=table["element_diameter"] * math.cos(number(table, "contact_angle")) / table["pitch_diameter"],
        clearance=0.5 * number(table, "internal_clearance"),
        stiffness=float(table["stiffness"]),
        exponent=number(table, "exponent", 1.5),
        chi=number(table.get("damping") or {}, "value"),
        cage_phase=number(table, "cage_phase"),
        torque=bool(table.get("cage_torque", True)),
        inner_waves=tuple(waves["inner"]),
        outer_waves=tuple(waves["outer"]),
        outer_moves=table.get("rotor_ring") == "outer",
        damping=radial_damping if carrier >= 0 else 0.0,
    )
