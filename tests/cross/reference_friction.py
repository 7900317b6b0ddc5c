"""Friction of the teeth of a mesh, for the reference: `cross.reference` calls it.  SI units.

One pair of teeth stands for all: it passes the pitch point where the mesh phase ``psi`` and ``friction_phase``
make whole turns, moves along the line of action by one base pitch a tooth, and gives way to the next one half
a pitch behind the pitch point.  The force follows Coulomb's law, smoothed within ``friction_speed``; its sense
is that of the sliding of two gears that roll on fixed centres.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from cross.reference_laws import TWO_PI, Pair, Wrench, number


@dataclass(frozen=True, slots=True)
class ToothFriction:
    """Friction of one mesh; ``half`` is +1 in the half-waves that begin at a pitch point, -1 in the others."""

    coefficient: float
    phase: float  # rad
    speed: float  # m/s, smoothed within
    way: float  # m/rad of the mesh phase: how the contact of the drive flank goes on along its normal on b

    def wave(self, psi: float) -> float:
        """Return a function that has the sign of the half-wave and is zero at its ends."""
        return math.sin(psi + self.phase)

    def wrapped(self, psi: float, half: float) -> float:
        """Return the phase since the nearest pitch point [rad]: 0 to pi in a half-wave +1, -pi to 0 in -1.

        The half-wave is given, so that the formula goes on smoothly where a step passes its end.
        """
        y = psi + self.phase
        return y - TWO_PI * round((y - 0.5 * math.pi * half) / TWO_PI)

    def slip(self, omega_a: float, omega_b: float) -> float:
        """Return the mean sliding speed of gears that turn so, over `speed` and with the sign of b against a."""
        return (omega_b - omega_a) * 0.5 * math.pi * abs(self.way) / self.speed

    def acting(
        self, flank: float, half: float, psi: float, smooth: float, normal: float, gradient: Pair, pitch: Pair
    ) -> tuple[Pair, Pair]:
        """Return where friction acts [m] and the force on b [N]; a feels its opposite there.

        ``flank`` is +1 for the drive flank, -1 for the back flank, ``normal`` its normal force [N], ``gradient``
        that of its penetration by the place of b; ``smooth`` is the smoothed sign of `slip`.
        """
        nx, ny = gradient
        x = flank * self.way * self.wrapped(psi, half)
        sense = half * flank * math.copysign(1.0, self.way) * smooth
        size = -self.coefficient * normal * sense
        return (pitch[0] - x * nx, pitch[1] - x * ny), (size * ny, -size * nx)


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


def pitch_point(a: Pair, b: Pair, rho_a: float, rho_b: float) -> Pair:
    """Return the point on the line of the toothings' centres where gears of these base radii roll [m]."""
    share = rho_a / (rho_a + rho_b)
    return a[0] + (b[0] - a[0]) * share, a[1] + (b[1] - a[1]) * share


def about(centre: Pair, point: Pair, force: Pair) -> Wrench:
    """Return a force at a point as force and torque about a centre."""
    rx, ry = point[0] - centre[0], point[1] - centre[1]
    return force[0], force[1], rx * force[1] - ry * force[0]
