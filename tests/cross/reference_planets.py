"""Gears on carriers and the phases of their teeth, for the reference: `cross.reference` calls it.  SI units.

Nominal speeds roll in the frame of the carrier (Willis), with signed radii:
``r_a (W_a - W_c) + r_b (W_b - W_c) = 0``.

Phases.  A gear of ``z`` teeth shows the gear that it meets in direction ``alpha`` the phase
``z (tau - alpha)``, which grows by ``z`` as the gear turns by one; its pattern begins at ``tau``.  Gears that
mesh show each other the same phase, with opposite signs where they turn against each other.  A gear that
is driven from ``alpha`` and drives towards the opposite side passes the phase on unchanged, so that a driven
pattern begins half a turn further.  The gear that drives the first mesh of a train begins at 0.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from cross.reference_laws import Pair

Condition = Mapping[str, float]
"""Factors of the speeds of rotors in a sum that is 0."""


class Teeth(NamedTuple):
    """A mesh as the phases see it: which gears, how many teeth, where the centres are [m]."""

    driver: str
    driven: str
    z_driver: int
    z_driven: int
    internal: str  # the ring of the pair, "" where there is none
    driver_at: Pair
    driven_at: Pair

    def seen(self) -> Pair:
        """Return in which direction driver and driven see the place where they mesh [rad]."""
        x, y = (self.driven_at[k] - self.driver_at[k] for k in range(2))
        if self.internal == self.driven:
            x, y = -x, -y
        line = math.atan2(y, x)
        return line, line if self.internal else line + math.pi

    def passed(self, phase: float) -> float:
        """Return the driven gear's phase for the driver's, or the other way round."""
        return phase if self.internal else -phase


def phases_by_position(meshes: Sequence[Teeth]) -> list[float]:
    """Return the phase of every mesh where nothing has turned yet [rad]."""
    begins: dict[str, float] = {}  # z tau of the gears known
    left = list(meshes)
    while left:
        near = [mesh for mesh in left if mesh.driver in begins or mesh.driven in begins]
        mesh = near[0] if near else left[0]
        left.remove(mesh)
        one, two = mesh.seen()
        if mesh.driver not in begins and mesh.driven in begins:
            own = begins[mesh.driven] - mesh.z_driven * (two + math.pi)
            begins[mesh.driver] = mesh.passed(own) + mesh.z_driver * one
        phase = begins.setdefault(mesh.driver, 0.0) - mesh.z_driver * one
        begins.setdefault(mesh.driven, mesh.passed(phase) + mesh.z_driven * (two + math.pi))
    return [begins[mesh.driver] - mesh.z_driver * mesh.seen()[0] for mesh in meshes]


def speeds_on_carriers(
    names: Sequence[str],
    conditions: Iterable[Condition],
    known: Mapping[str, float],
    carriers: Iterable[str],
) -> dict[str, float]:
    """Return the speeds that fulfil all conditions [rad/s]; carriers that nothing turns stand still."""
    place = {name: k for k, name in enumerate(names)}
    still = {name: 0.0 for name in carriers if name not in known}
    for given in ({**still, **known}, known):
        lines = [*conditions, *({name: 1.0} for name in given)]
        matrix = np.zeros((len(lines), len(names)))
        for row, line in zip(matrix, lines, strict=True):
            for name, factor in line.items():
                row[place[name]] += factor
        wanted = np.array([0.0] * (len(lines) - len(given)) + list(given.values()))
        speeds = np.linalg.pinv(matrix) @ wanted
        if np.max(np.abs(matrix @ speeds - wanted)) < 1e-9 * max(1.0, np.max(np.abs(wanted))):
            return {name: float(speeds[k]) for name, k in place.items()}
    raise ValueError("the nominal speeds do not roll on their carriers")
