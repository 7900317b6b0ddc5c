"""Places of the teeth of meshes with pairs of teeth: mesh phases from actual teeth, and numbers of the teeth that meet.

A tooth of the first driver of a train points along +x at rotation 0. Going from mesh to mesh each gear has teeth where its
partner has spaces, with drive flanks in touch, as the rotations of a mesh count from there: also where a gear is driven on one
side and drives on the other.
"""

import math
from typing import TYPE_CHECKING, NamedTuple

from gearplay.model import geometry
from gearplay.model.phases import directions, meshes_in_turn, starting_phases, within_half_a_turn

if TYPE_CHECKING:
    from gearplay.model.case import Case


class ToothPlaces(NamedTuple):
    """Mesh phases at rotation 0 [rad], shape [mesh], and numbers of driver's and driven tooth at the line of centres there."""

    phases: list[float]
    numbers: list[tuple[int, int]]


def tooth_places(case: "Case", centres: dict[str, tuple[float, float]], senses: list[float]) -> ToothPlaces:
    """Return the places of the teeth of all meshes; of meshes without pairs the phases of `starting_phases`.

    ``centres`` are the nominal ones [m], ``senses`` 1 or -1 for each mesh, the sense in which its drive flanks are (sigma).
    """
    phases = starting_phases(case, centres)
    numbers = [(0, 0)] * len(case.meshes)
    if all(mesh.contact == "mesh" for mesh in case.meshes):
        return ToothPlaces(phases, numbers)
    teeth: dict[str, float] = {}  # angle [rad] of tooth 0 of every gear that is reached
    for j, driver, driven in meshes_in_turn(case, teeth):
        mesh = case.meshes[j]
        z_1, z_2 = geometry.teeth_of(case, driver), geometry.teeth_of(case, driven)
        seen_1, seen_2 = directions(case, j, centres)
        external = geometry.ring_of(case, mesh) is None
        mirrored = -1.0 if external else 1.0
        base = geometry.base_radii(case, j)[1]
        towards = 1.0 if external or geometry.ring_of(case, mesh) == mesh.driver else -1.0
        closed = 0.5 * towards * senses[j] * geometry.working_backlash(case, j) / base
        half = math.pi / z_2 + closed
        if driver not in teeth and driven in teeth:
            psi = mirrored * z_2 * (teeth[driven] - seen_2 - half)
            teeth[driver] = seen_1 + psi / z_1
        teeth.setdefault(driver, 0.0)
        psi = z_1 * (teeth[driver] - seen_1)
        if mesh.contact == "pairs" and case.mesh_phases != "from_zero":
            phases[j] = within_half_a_turn(psi) + mesh.phase
        faced = seen_2 + mirrored * phases[j] / z_2 + half
        teeth.setdefault(driven, faced)
        one = round((seen_1 + phases[j] / z_1 - teeth[driver]) * z_1 / (2.0 * math.pi))
        other = round((faced - teeth[driven]) * z_2 / (2.0 * math.pi))
        numbers[j] = (one % z_1, other % z_2)
    return ToothPlaces(phases, numbers)
