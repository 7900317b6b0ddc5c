"""Initial mesh phases, from the positions of the gears and their numbers of teeth.

A gear's pattern of teeth repeats z times a turn. Where its centre sees a mesh in the direction alpha [rad] it shows the phase
z (tau - alpha), tau the angle at which the pattern begins; two gears that mesh show each other the same phase, an external
pair with opposite signs. Going from mesh to mesh this gives every phase but that of the first, which is 0 where its gears lie
along +x. A gear that is driven on one side and drives on the opposite one passes its phase on as it is: that its two flanks
are half a pitch apart, and which tooth or gap faces which, is left to ``phase`` of the mesh (docs/conventions).

Planets: with the sun as driver -z_s psi_n at the sun and, up to half a turn, the same at the ring (R. G. Parker, J. Lin,
J. Vib. Acoust. 126 (2004) 68).
"""

import math
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

from gearplay.parts.mesh.train import geometry
from gearplay.parts.mesh.train.traversal import mesh_order

if TYPE_CHECKING:
    from gearplay.parts.mesh.train.train import Train

ROUNDING = 1e-9
"""Phase [rad] that is 0 but for rounding."""


def starting_phases(case: "Train", centres: Mapping[str, tuple[float, float]]) -> list[float]:
    """Return every mesh's phase psi [rad] where nothing has turned yet, within half a turn, shape [mesh].

    ``centres`` are the nominal ones [m], before anything expands.
    """
    if case.mesh_phases == "from_zero":
        return [mesh.phase for mesh in case.meshes]
    patterns: dict[str, float] = {}  # z tau of every gear that is reached
    phases = [0.0] * len(case.meshes)
    for j, driver, driven in meshes_in_turn(case, patterns):
        z_1, z_2 = geometry.teeth_of(case, driver), geometry.teeth_of(case, driven)
        seen_1, seen_2 = directions(case, j, centres)
        mirrored = -1.0 if geometry.ring_of(case, case.meshes[j]) is None else 1.0
        if driver not in patterns and driven not in patterns:
            patterns[driver] = 0.0
        if driver not in patterns:
            patterns[driver] = mirrored * (patterns[driven] - z_2 * (seen_2 + math.pi)) + z_1 * seen_1
        phases[j] = patterns[driver] - z_1 * seen_1
        patterns.setdefault(driven, mirrored * phases[j] + z_2 * (seen_2 + math.pi))
    return [within_half_a_turn(psi) + mesh.phase for psi, mesh in zip(phases, case.meshes, strict=True)]


def meshes_in_turn(case: "Train", reached: Mapping[str, float]) -> Iterator[tuple[int, str, str]]:
    """Yield every mesh with the full names of its driver and driven gear, those first of which a gear is among the ``reached``.

    The caller adds the gears of each mesh before it asks for the next.
    """
    left = list(mesh_order(case))
    while left:
        names = [
            (geometry.full_name(case, case.meshes[j].driver), geometry.full_name(case, case.meshes[j].driven))
            for j in left
        ]
        at = next((k for k, pair in enumerate(names) if reached.keys() & set(pair)), 0)
        yield left.pop(at), *names[at]


def directions(case: "Train", j: int, centres: Mapping[str, tuple[float, float]]) -> tuple[float, float]:
    """Return the direction of mesh j from driver and driven gear [rad]: of an internal pair both on the pinion's side."""
    mesh = case.meshes[j]
    a, b, _, _ = geometry.signed_radii(case, j)
    (x_a, y_a), (x_b, y_b) = (centres[geometry.rotor_of(case, name)] for name in (a, b))
    line = math.atan2(y_b - y_a, x_b - x_a)
    if geometry.ring_of(case, mesh) is not None:
        return line, line
    return line, line + math.pi


def within_half_a_turn(psi: float) -> float:
    """Return a phase [rad] less whole turns, 0 where that is rounding."""
    rest = math.remainder(psi, 2.0 * math.pi)
    return 0.0 if abs(rest) < ROUNDING else rest
