"""Places of the teeth of meshes with pairs of teeth: mesh phases from actual teeth, and numbers of the teeth that meet.

A tooth of the first driver of a train points along +x at rotation 0. Going from mesh to mesh each gear has teeth where its
partner has spaces, with drive flanks in touch, as the rotations of a mesh count from there: also where a gear is driven on one
side and drives on the other.
"""

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, NamedTuple

from gearplay.parts.mesh.drawn_gears import deviates
from gearplay.parts.mesh.phases import directions, meshes_in_turn, starting_phases, within_half_a_turn
from gearplay.parts.mesh.schema import PlanetMesh
from gearplay.parts.mesh.train import geometry

if TYPE_CHECKING:
    from gearplay.parts.mesh.train.train import Train


class ToothPlaces(NamedTuple):
    """Mesh phases at rotation 0 [rad] and those of the teeth in their places, shapes [mesh]; numbers of driver's and driven tooth
    at the line of centres there.
    """

    phases: list[float]
    teeth: list[float]
    numbers: list[tuple[int, int]]


def tooth_places(
    case: "Train", centres: Mapping[str, tuple[float, float]], senses: list[float]
) -> ToothPlaces:
    """Return the places of the teeth of all meshes; of meshes with one stiffness the phases are those of `starting_phases`.

    ``centres`` are the nominal ones [m], ``senses`` 1 or -1 for each mesh, the sense in which its drive flanks are (sigma).
    """
    phases = starting_phases(case, centres)
    numbers = [(0, 0)] * len(case.meshes)
    placed = list(phases)
    if not any(mesh.contact == "pairs" or deviates(case, j) for j, mesh in enumerate(case.meshes)):
        return ToothPlaces(phases, placed, numbers)
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
        if case.mesh_phases != "from_zero" and (mesh.contact == "pairs" or deviates(case, j)):
            # A set gives its meshes of one stiffness the half pitch between a planet's flanks, which teeth have by themselves.
            given = 0.0 if mesh.contact == "mesh" and isinstance(mesh, PlanetMesh) else mesh.phase
            placed[j] = within_half_a_turn(psi) + given
        if mesh.contact == "pairs":
            phases[j] = placed[j]
        faced = seen_2 + mirrored * placed[j] / z_2 + half
        teeth.setdefault(driven, faced)
        one = round((seen_1 + placed[j] / z_1 - teeth[driver]) * z_1 / (2.0 * math.pi))
        other = round((faced - teeth[driven]) * z_2 / (2.0 * math.pi))
        numbers[j] = (one % z_1, other % z_2)
    return ToothPlaces(phases, placed, numbers)
