"""Friction of the teeth of a mesh, for the reference: `cross.reference` calls it.  SI units.

One pair of teeth stands for all: it passes the pitch point where the mesh phase ``psi`` and ``friction_phase``
make whole turns, moves along the line of action by one base pitch a tooth, and gives way to the next one half
a pitch behind the pitch point.  The force opposes the velocity of the flank of b against that of a at the point
of contact, across the line of action, by Coulomb's law smoothed within ``friction_speed``.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from cross.reference_laws import TWO_PI, Pair, Wrench, number


@dataclass(frozen=True, slots=True)
class ToothFriction:
    """Friction of one mesh; pairs of teeth are counted, ``parity`` is +1 for those of even number, else -1."""

    coefficient: float
    phase: float  # rad
    speed: float  # m/s, smoothed within
    way: float  # m/rad of the mesh phase: how the contact of the drive flank goes on along its normal on b

    def wave(self, psi: float) -> float:
        """Return a function with the sign of the parity of the pair in contact, zero at its ends."""
        return math.cos(0.5 * (psi + self.phase))

    def wrapped(self, psi: float, parity: float) -> float:
        """Return the phase since the pitch point of the nearest pair of this parity [rad].

        The parity is given, so that the formula goes on smoothly where a step passes the hand-over.
        """
        y = psi + self.phase
        odd = 0.0 if parity > 0.0 else TWO_PI
        return y - odd - 2.0 * TWO_PI * round((y - odd) / (2.0 * TWO_PI))

    def point(self, flank: float, parity: float, psi: float, gradient: Pair, pitch: Pair) -> Pair:
        """Return where the flanks touch [m]; ``flank`` is +1 for the drive flank, -1 for the back flank.

        ``gradient`` is that of the flank's penetration by the place of b.
        """
        x = flank * self.way * self.wrapped(psi, parity)
        return pitch[0] - x * gradient[0], pitch[1] - x * gradient[1]

    def force(self, normal: float, smooth: float, gradient: Pair) -> Pair:
        """Return the force on b [N] under a normal force [N]; ``smooth`` is the smoothed sign of what slides across."""
        size = -self.coefficient * normal * smooth
        return -size * gradient[1], size * gradient[0]


def tooth_friction_of(
    table: Mapping[str, Any], rho_a: float, rho_b: float, sigma: float, driver_is_a: bool
) -> ToothFriction | None:
    """Return the friction of a mesh's table, None where there is none; base radii with their signs [m]."""
    coefficient = number(table, "friction_coefficient")
    if coefficient == 0.0:
        return None
    forwards = sigma * (math.copysign(1.0, rho_a) if driver_is_a else -math.copysign(1.0, rho_b))
    return ToothFriction(
        coefficient=coefficient,
        phase=number(table, "friction_phase"),
        speed=number(table, "friction_speed", 1e-3),
        way=0.5 * forwards * float(table["module"]) * math.cos(float(table["pressure_angle"])),
    )


def sliding(
    a: Pair, b: Pair, velocities: tuple[Pair, Pair], spins: Pair, point: Pair, gradient: Pair
) -> float:
    """Return the speed [m/s] of b's material against a's at a point, across the gradient turned by 90 degrees.

    ``a``, ``b`` are the bodies' centres, ``velocities`` theirs.
    """
    (va, vb), (wa, wb) = velocities, spins
    x = vb[0] - wb * (point[1] - b[1]) - va[0] + wa * (point[1] - a[1])
    y = vb[1] + wb * (point[0] - b[0]) - va[1] - wa * (point[0] - a[0])
    return y * gradient[0] - x * gradient[1]


def pitch_point(a: Pair, b: Pair, rho_a: float, rho_b: float) -> Pair:
    """Return the point on the line of the toothings' centres where gears of these base radii roll [m]."""
    share = rho_a / (rho_a + rho_b)
    return a[0] + (b[0] - a[0]) * share, a[1] + (b[1] - a[1]) * share


def about(centre: Pair, point: Pair, force: Pair) -> Wrench:
    """Return a force at a point as force and torque about a centre."""
    rx, ry = point[0] - centre[0], point[1] - centre[1]
    return force[0], force[1], rx * force[1] - ry * force[0]
