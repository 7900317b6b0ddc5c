"""Wear of flanks: loads over places of the path in a simulated block, depth per turn, worn profiles as faults of the case.

Depth per contact k w |v1 - v2| / v, w the line load and v the rolling speed of the flank along the contact: A. Flodin and
S. Andersson, Simulation of mild wear in spur gears, Wear 207 (1997) 16-23, with b p_m = w: independent of the contact's width.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gearplay.model.pack import pack
from gearplay.parts.mesh.drawn_gears import gear_path, mesh_path, tooth_faults
from gearplay.parts.mesh.faults import DEEPEST, WearFault
from gearplay.parts.mesh.pairs.tooth_rows import profile_pieces
from gearplay.parts.mesh.teeth_stiffness import stiffness_over_path
from gearplay.parts.mesh.train import geometry
from gearplay.parts.registry import MESH
from gearplay.vocabulary.errors import NO_VALUE, InputError

if TYPE_CHECKING:
    from gearplay.model.case import Case
    from gearplay.results.result import Result

Floats = NDArray[np.float64]
HEIGHTS: Floats = np.linspace(0.0, 1.0, 41)
"""Places of a flank at which wear is computed, 0 at the root end of its path of contact, 1 at the tip."""
SIDES = ("drive", "back")
CLEAR = 0.05
"""Least distance of the path of contact from a base tangent point, in base pitches; there a flank does not roll."""
SAME = 1e-6
"""Difference of two paths of a flank that is rounding, in base pitches."""


@dataclass(frozen=True)
class Contact:
    """A flank of a gear in one of its meshes: place of the mesh in the case, 0 for the first gear of the pair, side."""

    mesh: int
    which: int
    side: str

    def coefficient(self, case: Case) -> float:
        """Return k [m^2/N] of the gear in this mesh."""
        mesh = case.meshes[self.mesh]
        assert mesh.wear is not None
        drives = geometry.gears_of_pair(case, self.mesh)[self.which] == mesh.driver
        return mesh.wear.coefficients[0 if drives else 1]


Flanks = dict[tuple[str, str], list[Contact]]
"""Contacts of each flank that wears, by full name of the gear and ``left`` or ``right``; heights are on the path of the first."""


def wearing_flanks(case: Case) -> Flanks:
    """Return the flanks that wear, in the order of the meshes; `InputError` where their wear cannot be computed."""
    found: Flanks = {}
    if not any(mesh.wear is not None for mesh in case.meshes):
        return found
    senses = [float(record.sigma) for record in pack(case, moves=False).system.records[MESH]]
    for j, mesh in enumerate(case.meshes):
        for side, sign in zip(SIDES, (1.0, -1.0), strict=True):
            flank = "left" if senses[j] * sign > 0.0 else "right"
            for which, name in enumerate(geometry.gears_of_pair(case, j)):
                key = geometry.full_name(case, name), flank
                found.setdefault(key, []).append(Contact(j, which, side))
        if mesh.wear is not None:
            _check_mesh(case, j)
    worn = {
        key: sorted(contacts, key=lambda contact: contact.side != "drive")
        for key, contacts in found.items()
        if any(case.meshes[contact.mesh].wear is not None for contact in contacts)
    }
    for (gear, _), contacts in worn.items():
        _check_gear(case, gear, contacts)
    return worn


def _check_mesh(case: Case, j: int) -> None:
    mesh, at = case.meshes[j], mesh_path(case, j, "wear")
    if mesh.contact != "pairs":
        rule = 'must be given with contact = "pairs", which has the load at each place of a flank'
        raise InputError.of(at, NO_VALUE, rule, 'Write contact = "pairs" in the mesh')
    names = geometry.gears_of_pair(case, j)
    pair = geometry.installed_pair(case, j)
    if pair.overlap > 0.0:
        raise InputError.of(at, NO_VALUE, "must be given for spur gears", "Remove it")
    ends = pair.path.start, pair.path.tangent_of_second - pair.path.end
    for name, apart in zip(names, ends, strict=True):
        if apart < CLEAR * pair.first.base_pitch:
            rule = (
                f"must leave the path of contact {1e3 * CLEAR * pair.first.base_pitch:.3g} mm from the base tangent point of "
                f"{name}, where its flank does not roll and wear has no bound"
            )
            other = names[1] if name == names[0] else names[0]
            shown = f"{1e3 * max(apart, 0.0):.3g} mm"
            raise InputError.of(gear_path(case, other, "tip_diameter"), shown, rule, "Shorten its teeth")


def _ends(case: Case, contact: Contact) -> tuple[float, float, float]:
    """Return root end and tip end [m] of a gear's path of contact from its base tangent point, and the base pitch."""
    pair = geometry.installed_pair(case, contact.mesh)
    start, end = pair.path.start, pair.path.end
    if contact.which == 1:
        line, sign = pair.base_tangent, pair.second.sign
        start, end = line - sign * end, line - sign * start
    return start, end, pair.first.base_pitch


def _radii(case: Case, contact: Contact) -> Floats:
    """Return the places of `HEIGHTS` on a gear's path of contact, from its base tangent point [m]."""
    start, end, _ = _ends(case, contact)
    return start + HEIGHTS * (end - start)


def _check_gear(case: Case, gear: str, contacts: list[Contact]) -> None:
    first = _ends(case, contacts[0])
    for contact in contacts:
        at = mesh_path(case, contact.mesh, "wear")
        if case.meshes[contact.mesh].wear is None:
            raise InputError.of(
                at, NO_VALUE, f"is required, since a flank of {gear} wears elsewhere", "Add it"
            )
        if contact.side != contacts[0].side:
            continue  # as the back flank of an idler
        if np.max(np.abs(np.subtract(_ends(case, contact), first))) > SAME * first[2]:
            rule = f"must be given where all meshes of a flank have the same path of contact, which those of {gear} have not"
            raise InputError.of(at, NO_VALUE, rule, "Make its partners alike, or remove it")


def places_of(case: Case, j: int) -> Floats:
    """Return the places [m] on the first gear's path of mesh j, at `HEIGHTS` of its flank."""
    path = geometry.installed_pair(case, j).path
    return path.start + HEIGHTS * path.length


def line_load(result: Result, j: int, side: str) -> Floats:
    """Return the mean line load [N/m] of a pair of teeth of a side of mesh j at `places_of`, shape [height].

    Mean over the record and its members, at each place over the samples that a pair of teeth is near it, in contact or not,
    weighted by a hat function.
    """
    case, label = result.case, result.case.meshes[j].label
    places, pair = places_of(case, j), geometry.installed_pair(case, j)
    total, weights = np.zeros(len(places)), np.zeros(len(places))
    slots = [name for name in map(str, result.ds["pair"].values) if name.startswith(f"{label}:{side}-")]
    for member in range(len(result.runs)):
        for slot in slots:
            at = (result.signal("pair_place", slot, member) - places[0]) / (places[1] - places[0])
            force = result.signal("pair_force", slot, member)
            inside = (at >= 0.0) & (at <= len(places) - 1)
            at, force = at[inside], force[inside]
            lower = np.minimum(at.astype(np.int64), len(places) - 2)
            upper = at - lower
            for node, weight in ((lower, 1.0 - upper), (lower + 1, upper)):
                total += np.bincount(node, weight * force, len(places))
                weights += np.bincount(node, weight, len(places))
    if np.any(weights == 0.0):
        rule = "must be so long that teeth pass every place of the path of contact"
        raise InputError.of("run.duration", f"{case.run.duration:g} s", rule, "Raise it, or run.sampling")
    assert pair.facewidth is not None, "validated: the stiffness of pairs needs it"
    return total / weights / pair.facewidth


def passes(result: Result, contact: Contact) -> float:
    """Return how often a second each tooth of a gear meets one of its partner [1/s], turns of the block counted either way."""
    case = result.case
    gear = geometry.rotor_of(case, geometry.gears_of_pair(case, contact.mesh)[contact.which])
    frame = geometry.mesh_frame(case, contact.mesh)
    rates = []
    for member in range(len(result.runs)):
        omega = result.signal("omega", gear, member)
        carried = result.signal("omega", frame, member) if frame is not None else 0.0
        rates.append(np.mean(np.abs(omega - carried)))
    return float(np.mean(rates)) / (2.0 * math.pi)


def flank_rates(
    result: Result, flanks: Flanks
) -> tuple[dict[tuple[str, str], Floats], dict[tuple[int, str], Floats]]:
    """Return how fast flanks wear over a block [m/s] by flank, and the line loads [N/m] by mesh and side, shapes [height]."""
    case = result.case
    loads = {
        (contact.mesh, contact.side): line_load(result, contact.mesh, contact.side)
        for contacts in flanks.values()
        for contact in contacts
        if contact.which == 0
    }
    rates = {}
    for key, contacts in flanks.items():
        rates[key], radii = np.zeros(len(HEIGHTS)), _radii(case, contacts[0])
        for contact in contacts:
            pair = geometry.installed_pair(case, contact.mesh)
            sliding = pair.specific_sliding(places_of(case, contact.mesh))[contact.which]
            depth = contact.coefficient(case) * loads[contact.mesh, contact.side] * sliding
            depth = passes(result, contact) * (depth if contact.which == 0 else depth[::-1])
            own = _radii(case, contact)
            order = np.argsort(own)
            same = contact.side == contacts[0].side
            rates[key] += depth if same else np.interp(radii, own[order], depth[order], left=0.0, right=0.0)
    return rates, loads


def deflections(case: Case, loads: dict[tuple[int, str], Floats]) -> dict[tuple[int, str], float]:
    """Return the largest deflection [m] of a pair of teeth under mean line loads, by mesh and side."""
    found = {}
    for (j, side), load in loads.items():
        stiffness = stiffness_over_path(case, j)
        found[j, side] = float(np.max(load * stiffness.width / stiffness.held(places_of(case, j))))
    return found


def starting_depths(case: Case, flanks: Flanks) -> dict[tuple[str, str], Floats]:
    """Return the depths [m] of the profiles that flanks have in the case, shape [height]."""
    found = {key: np.zeros(len(HEIGHTS)) for key in flanks}
    for gear, flank in flanks:
        for _, fault in tooth_faults(case, gear):
            if isinstance(fault, WearFault) and fault.profile and fault.flank in (flank, "both"):
                found[gear, flank] += _profile_at(fault.profile, HEIGHTS)
    return found


def _profile_at(profile: tuple[tuple[float, float], ...], heights: Floats) -> Floats:
    pieces = profile_pieces(profile)
    x = np.clip(heights, pieces[0, 0], pieces[-1, 0])
    row = np.clip(np.searchsorted(pieces[:, 0], x, side="right") - 1, 0, len(pieces) - 2)
    x = x - pieces[row, 0]
    c = pieces[row, 1:].T
    return np.asarray(c[0] + x * (c[1] + x * (c[2] + x * c[3])))


def worn_faults(case: Case, depths: dict[tuple[str, str], Floats]) -> list[dict[str, Any]]:
    """Return the faults of the case with worn profiles of flanks in place of the previous ones."""
    kept: list[dict[str, Any]] = []
    for fault in case.faults:
        document = fault.model_dump(mode="json", exclude_none=True)
        if isinstance(fault, WearFault) and fault.profile:
            name = geometry.full_name(case, fault.at)
            sides = ("left", "right") if fault.flank == "both" else (fault.flank,)
            kept += [{**document, "flank": side} for side in sides if (name, side) not in depths]
        else:
            kept.append(document)
    for (gear, flank), depth in depths.items():
        if np.any(depth > 0.0):
            profile = [[float(x), float(d)] for x, d in zip(HEIGHTS, depth, strict=True)]
            kept.append({"kind": "wear", "at": gear, "flank": flank, "profile": profile})
    return kept


def thickest_wear(case: Case, flank: list[Contact]) -> float:
    """Return the greatest depth of wear [m] of a flank that is computed: half of a tooth, at most that of a fault."""
    return min(0.25 * _ends(case, flank[0])[2], DEEPEST)


def worn_volume(case: Case, flank: list[Contact], depth: Floats) -> float:
    """Return the volume [m^3] that all teeth of a gear have lost on a flank: z b times the integral of depth over its length."""
    rho = _radii(case, flank[0])
    pair = geometry.installed_pair(case, flank[0].mesh)
    gear = (pair.first, pair.second)[flank[0].which]
    assert pair.facewidth is not None
    length = np.abs(np.diff(rho)) / gear.base_radius
    mean = 0.5 * (depth[1:] * rho[1:] + depth[:-1] * rho[:-1])
    return float(gear.teeth * pair.facewidth * np.sum(mean * length))


def added_backlash(case: Case, j: int, depths: dict[tuple[str, str], Floats], flanks: Flanks) -> float:
    """Return by how much wear has opened the normal backlash of mesh j [m], mean over a mesh period, without load.

    Of each side the pair of teeth in contact that lacks least material touches.
    """
    pair, opened = geometry.installed_pair(case, j), 0.0
    pitch, path = pair.first.base_pitch, pair.path
    phases = np.arange(256) / 256.0
    for side in SIDES:
        missing = np.zeros(len(HEIGHTS))
        for key, contacts in flanks.items():
            for contact in contacts:
                if (contact.mesh, contact.side) == (j, side):
                    missing += depths[key] if contact.which == 0 else depths[key][::-1]
        numbers = np.arange(math.ceil(path.length / pitch) + 1)
        ahead = (phases[:, None] + numbers) * pitch / path.length
        each = np.where(ahead <= 1.0, np.interp(ahead, HEIGHTS, missing), np.inf)
        opened += float(np.mean(np.min(each, axis=1)))
    return opened
