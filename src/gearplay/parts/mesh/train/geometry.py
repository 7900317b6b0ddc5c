"""Plane geometry and kinematics of a train: radii, centres, nominal speeds, contact and jam ratios."""

import math
from typing import TYPE_CHECKING

from gearplay.parts.mesh.involute import involute, involute_from_distance
from gearplay.parts.mesh.train.traversal import mesh_order
from gearplay.parts.rotor.allowance import allowance_middle
from gearplay.parts.rotor.gear import split_name
from gearplay.parts.rotor.schema import POSITION_TOLERANCE, place_words
from gearplay.toothing.gear import DrawnGear
from gearplay.toothing.pair import GearPair
from gearplay.vocabulary.errors import InputError

if TYPE_CHECKING:
    from gearplay.parts.mesh.schema import Mesh
    from gearplay.parts.mesh.train.train import Train
    from gearplay.parts.rotor.gear import Gear
    from gearplay.parts.rotor.schema import Rotor


def gear_of(case: "Train", name: str) -> "Gear | Rotor":
    """Return a gear given by its name in a mesh, ``rotor`` or ``rotor.gear``."""
    rotor, gear = split_name(name, case.rotors)
    return case.rotors[rotor].gear(gear)


def rotor_of(case: "Train", name: str) -> str:
    """Return the rotor of a gear given by its name in a mesh."""
    return split_name(name, case.rotors)[0]


def toothings(case: "Train", rotor: str) -> "dict[str, Gear | Rotor]":
    """Return the gears of a rotor by their full names: ``rotor.gear``, or ``rotor`` for one without a table of gears."""
    found = case.rotors[rotor]
    return {f"{rotor}.{name}": gear for name, gear in found.gears.items()} or {rotor: found}


def full_name(case: "Train", name: str) -> str:
    """Return the full name of a gear named by a mesh, with the default for a shaft's only gear."""
    return next(iter(toothings(case, name))) if name in case.rotors else name


def ring_of(case: "Train", mesh: "Mesh") -> str | None:
    """Return the name of the mesh's internal gear in the mesh, or None for an external pair."""
    for name in (mesh.driver, mesh.driven):
        if gear_of(case, name).internal:
            return name
    return None


def teeth_of(case: "Train", name: str) -> int:
    """Return the number of teeth of a gear given by its name in a mesh."""
    teeth = gear_of(case, name).teeth
    assert teeth is not None, "validated: gears in a mesh have teeth"
    return teeth


def pitch_radius(case: "Train", mesh: "Mesh", name: str) -> float:
    """Return the reference radius m_t z / 2 [m] of one gear of a mesh."""
    module, helix = mesh.module, gear_of(case, name).helix_angle
    return 0.5 * (module / math.cos(helix) if helix else module) * teeth_of(case, name)


def transverse_angle(case: "Train", mesh: "Mesh") -> float:
    """Return the transverse pressure angle alpha_t of a mesh at its reference circles [rad]."""
    helix = gear_of(case, mesh.driver).helix_angle
    return math.atan(math.tan(mesh.pressure_angle) / math.cos(helix)) if helix else mesh.pressure_angle


def base_radii(case: "Train", j: int) -> tuple[float, float]:
    """Return the base radii r_b = r cos(alpha_t) [m] of mesh j's driver and driven gear."""
    mesh = case.meshes[j]
    c = math.cos(transverse_angle(case, mesh))
    return pitch_radius(case, mesh, mesh.driver) * c, pitch_radius(case, mesh, mesh.driven) * c


def gears_of_pair(case: "Train", j: int) -> tuple[str, str]:
    """Return the names of mesh j's gears, first and second of its `GearPair`: of an internal pair pinion and ring."""
    mesh = case.meshes[j]
    return (mesh.driven, mesh.driver) if mesh.driver == ring_of(case, mesh) else (mesh.driver, mesh.driven)


def gears_of(case: "Train", j: int, place: float = 0.5) -> tuple[DrawnGear, DrawnGear]:
    """Return mesh j's gears as drawn, in the order of `gears_of_pair`.

    ``place`` of tooth thicknesses between their lower (0) and upper (1) limits.
    """
    mesh = case.meshes[j]
    first, second = (
        gear.drawing(
            mesh.module, mesh.pressure_angle, teeth_of(case, name), internal=gear.internal, place=place
        )
        for name in gears_of_pair(case, j)
        if (gear := gear_of(case, name))
    )
    return first, second


def pair_of(case: "Train", j: int) -> GearPair:
    """Return mesh j's gears as drawn at their working centre distance; see `working_distance`."""
    pair = GearPair(*gears_of(case, j), math.nan)
    return pair.at(_working_distance(case, j, pair))


def _working_distance(case: "Train", j: int, pair: GearPair) -> float:
    mesh = case.meshes[j]
    if mesh.center_distance is not None:
        return mesh.center_distance
    if pair.is_shifted:
        one, other = (case.rotors[name].position for name in mesh.rotors)
        return pair.shifted_distance if one is None or other is None else math.dist(one, other)
    return pair.reference_distance


def working_distance(case: "Train", j: int) -> float:
    """Return the working centre distance [m] of mesh j, at which its backlash counts.

    Given; else by the positions of gears with profile shift; else that at which the shifts leave no backlash, without them
    m_t (z_1 + z_2) / 2 of an external and m_t (z_2 - z_1) / 2 of an internal pair.
    """
    return pair_of(case, j).distance


def placed_distance(case: "Train", j: int) -> float:
    """Return the distance [m] at which `centres` places the gears of mesh j: the working one at the middle of its allowance."""
    return working_distance(case, j) + allowance_middle(case.meshes[j].center_distance_allowance)


def installed_distance(case: "Train", j: int) -> float:
    """Return the distance [m] of the nominal centres of mesh j."""
    at = centres(case)
    return math.dist(*(at[name] for name in case.meshes[j].rotors))


def installed_pair(case: "Train", j: int) -> GearPair:
    """Return mesh j's gears as drawn at the distance of their nominal centres."""
    pair, distance = pair_of(case, j), installed_distance(case, j)
    return pair if abs(distance - pair.distance) < 1e-12 * pair.distance else pair.at(distance)


def working_backlash(case: "Train", j: int) -> float:
    """Return the transverse backlash [m] of mesh j along the line of action at its working centre distance.

    Given: normal, as the angle of the driven gear or as an arc of the working pitch circle; else by thicknesses and allowances.
    """
    given, pair = case.meshes[j].backlash, pair_of(case, j)
    if given is None:
        return pair.backlash
    if isinstance(given, float):
        return given if pair.first.helix_angle == 0.0 else given / math.cos(pair.first.base_helix)
    if given.angle is not None:
        return given.angle * base_radii(case, j)[1]
    assert given.circumferential is not None, "validated"
    return given.circumferential * math.cos(pair.working_angle)


def jam_ratio(case: "Train", j: int) -> float:
    """Return 2 sin(alpha_w) (sum of both radial clearances) / b of mesh j: wedging is possible above 1.

    alpha_w is the working pressure angle, b the backlash at the distance of the nominal centres. Infinite where that is 0 or less
    and a clearance is left; 0 without clearances.
    """
    play = sum(clearance_of(case, name) or 0.0 for name in case.meshes[j].rotors)
    backlash = installed_backlash(case, j)
    if backlash > 0.0:
        return 2.0 * math.sin(pair_of(case, j).working_angle) * play / backlash
    return math.inf if play > 0.0 or backlash < 0.0 else 0.0


def installed_backlash(case: "Train", j: int, *, closer: float = 0.0) -> float:
    """Return the transverse backlash b_t [m] of mesh j at the distance of its nominal centres; NaN where it cannot mesh.

    b_t = b_w -+ 2 c0 (inv alpha_w - inv alpha), (4), b_w that at the working distance. With ``closer`` [m] teeth are deeper in
    mesh: external gears that much nearer, internal ones farther apart.
    """
    pair = pair_of(case, j)
    distance = installed_distance(case, j) - pair.second.sign * closer
    given = working_backlash(case, j)
    if abs(distance - pair.distance) < 1e-12 * pair.distance:
        return given
    if distance <= pair.least_distance:
        return math.nan
    opening = involute_from_distance(distance, pair.least_distance) - involute(pair.working_angle)
    return given + 2.0 * pair.second.sign * pair.least_distance * opening


def installed_normal_backlash(case: "Train", j: int) -> float:
    """Return the normal backlash [m] of mesh j at the distance of its nominal centres: `installed_backlash` times cos beta_b."""
    return installed_backlash(case, j) * math.cos(pair_of(case, j).first.base_helix)


def carrier_of(case: "Train", name: str) -> str | None:
    """Return the rotor that carries the part that holds this rotor, or None for the ground."""
    return next((part.on for part in case.holders(name) if part.on is not None), None)


def clearance_of(case: "Train", name: str) -> float | None:
    """Return the radial clearance [m] of the part that holds a rotor; None for a rotor that is in none."""
    return next((c for part in case.holders(name) if (c := part.clearance()) is not None), None)


def is_held(case: "Train", name: str) -> bool:
    """Return whether a rotor's centre is held: no part that holds it and no ``floating`` frees it."""
    return not case.rotors[name].floating and not any(part.frees_centre() for part in case.holders(name))


def mesh_frame(case: "Train", j: int) -> str | None:
    """Return the carrier in whose frame mesh j rolls, or None for the ground.

    Raises `InputError` where its two gears sit on two different carriers.
    """
    mesh = case.meshes[j]
    carriers = {carrier_of(case, n) for n in mesh.rotors} - {None, *mesh.rotors}
    if len(carriers) > 1:
        names = " and ".join(sorted(str(c) for c in carriers))
        raise InputError.of(
            f"meshes.{j}",
            names,
            "both gears of a mesh must share one carrier",
            "Mount one of them elsewhere.",
        )
    return next(iter(carriers), None)


def centres(case: "Train") -> dict[str, tuple[float, float]]:
    """Return every rotor's nominal centre [m], given or found by going along the meshes (docs/conventions).

    Raises `InputError` where two explicit positions cannot mesh at all.
    """
    found = {n: (r.position[0], r.position[1]) for n, r in case.rotors.items() if r.position is not None}
    axes = [set(joint.shared_axis()) for joint in case.joints if joint.shared_axis()]
    left = list(mesh_order(case))
    _spread(found, axes)
    while left:
        near = [j for j in left if found.keys() & set(case.meshes[j].rotors)]
        j = next((j for j in near if case.meshes[j].angle is not None), next(iter(near), None))
        if j is None:  # a new train: the ring or driver of its first mesh is the origin
            mesh = case.meshes[left[0]]
            found[rotor_of(case, ring_of(case, mesh) or mesh.driver)] = (0.0, 0.0)
            _spread(found, axes)
            continue
        left.remove(j)
        mesh = case.meshes[j]
        known, other = mesh.rotors if mesh.rotors[0] in found else mesh.rotors[::-1]
        if other not in found:
            x, y = _way(case, j, known)
            found[other] = (found[known][0] + x, found[known][1] + y)
            _spread(found, axes)
    for name in sorted(case.rotors):
        carried = [name]
        while carried[-1] not in found and (on := carrier_of(case, carried[-1])) is not None:
            carried.append(on)
        for each, on in zip(carried[::-1], [None, *carried[:0:-1]], strict=True):
            found.setdefault(each, found[on] if on else (0.0, 0.0))
            _spread(found, axes)
    for axis in axes:
        first, *others = sorted(axis, key=list(case.rotors).index)
        for other in others:
            if math.dist(found[first], found[other]) > POSITION_TOLERANCE:
                rule = f"must be that of {first}, since a coupling of ratio 1 puts both on one axis"
                cure = f"Leave one position out, or place it at {place_words(*found[first])}"
                raise InputError.of(f"rotors.{other}.position", place_words(*found[other]), rule, cure)
    return found


def _way(case: "Train", j: int, known: str) -> tuple[float, float]:
    """Return the vector [m] from the centre of the rotor ``known`` of mesh j to the other one's, at `placed_distance`."""
    mesh, A0 = case.meshes[j], placed_distance(case, j)
    if mesh.angle is not None:
        step = A0 if known == mesh.rotors[0] else -A0
        return step * math.cos(mesh.angle), step * math.sin(mesh.angle)
    ring = ring_of(case, mesh)
    return (A0 if ring is None or known == rotor_of(case, ring) else -A0), 0.0


def _spread(found: dict[str, tuple[float, float]], axes: list[set[str]]) -> None:
    """Propagate the known centre of one rotor on an axis to the others."""
    pending = [axis for axis in axes if axis & found.keys() and axis - found.keys()]
    while pending:
        for axis in pending:
            centre = found[next(name for name in sorted(axis) if name in found)]
            found.update(dict.fromkeys(axis - found.keys(), centre))
        pending = [axis for axis in axes if axis & found.keys() and axis - found.keys()]


def signed_radii(case: "Train", j: int) -> tuple[str, str, float, float]:
    """Return (a, b, r_a, r_b): gears at foot and tip of the vector of centres, and pitch radii [m], negative for a ring."""
    mesh = case.meshes[j]
    ring = ring_of(case, mesh)
    if ring is None:
        a, b = mesh.driver, mesh.driven
        return a, b, pitch_radius(case, mesh, a), pitch_radius(case, mesh, b)
    a, b = ring, mesh.driven if mesh.driver == ring else mesh.driver
    return a, b, -pitch_radius(case, mesh, a), pitch_radius(case, mesh, b)
