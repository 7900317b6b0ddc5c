"""Plane geometry and kinematics of a train: radii, centres, nominal speeds, contact and jam ratios."""

import math
from typing import TYPE_CHECKING

from gearplay.model.traversal import mesh_order
from gearplay.parts.mesh.involute import involute, involute_from_distance
from gearplay.parts.rotor.gear import ADDENDUM, split_name
from gearplay.parts.rotor.schema import POSITION_TOLERANCE, place_words
from gearplay.vocabulary.errors import Fault, InputError

if TYPE_CHECKING:
    from gearplay.model.case import Case
    from gearplay.parts.mesh.schema import Mesh
    from gearplay.parts.rotor.gear import Gear
    from gearplay.parts.rotor.schema import Rotor


def gear_of(case: "Case", name: str) -> "Gear | Rotor":
    """Return a gear as a mesh calls it, ``rotor`` or ``rotor.gear``."""
    rotor, gear = split_name(name, case.rotors)
    return case.rotors[rotor].gear(gear)


def rotor_of(case: "Case", name: str) -> str:
    """Return the rotor of a gear as a mesh calls it."""
    return split_name(name, case.rotors)[0]


def toothings(case: "Case", rotor: str) -> "dict[str, Gear | Rotor]":
    """Return the gears of a rotor by their full names: ``rotor.gear``, or ``rotor`` for one without a table of gears."""
    found = case.rotors[rotor]
    return {f"{rotor}.{name}": gear for name, gear in found.gears.items()} or {rotor: found}


def full_name(case: "Case", name: str) -> str:
    """Return the full name of a gear named by a mesh, with the default for a shaft's only gear."""
    return next(iter(toothings(case, name))) if name in case.rotors else name


def ring_of(case: "Case", mesh: "Mesh") -> str | None:
    """Return the mesh's internal gear as the mesh calls it, or None for an external pair."""
    for name in (mesh.driver, mesh.driven):
        if gear_of(case, name).internal:
            return name
    return None


def teeth_of(case: "Case", name: str) -> int:
    """Return the number of teeth of a gear that takes part in a mesh, called as the mesh does."""
    teeth = gear_of(case, name).teeth
    assert teeth is not None, "validated: gears in a mesh have teeth"
    return teeth


def pitch_radius(case: "Case", mesh: "Mesh", name: str) -> float:
    """Return the reference pitch radius m z / 2 [m] of one gear of a mesh."""
    return 0.5 * mesh.module * teeth_of(case, name)


def base_radii(case: "Case", j: int) -> tuple[float, float]:
    """Return the base radii r_b = m z cos(alpha0) / 2 [m] of mesh j's driver and driven gear."""
    mesh = case.meshes[j]
    c = math.cos(mesh.pressure_angle)
    return pitch_radius(case, mesh, mesh.driver) * c, pitch_radius(case, mesh, mesh.driven) * c


def nominal_center_distance(case: "Case", j: int) -> float:
    """Return A0 [m]: m (z_g - z_p) / 2 for an internal, m (z_1 + z_2) / 2 for an external pair."""
    mesh = case.meshes[j]
    r_1, r_2 = pitch_radius(case, mesh, mesh.driver), pitch_radius(case, mesh, mesh.driven)
    return abs(r_2 - r_1) if ring_of(case, mesh) else r_1 + r_2


def contact_path(
    z_1: int, z_2: int, internal: bool, module: float, alpha: float, distance: float | None = None
) -> tuple[float, float, float]:
    """Return where the tip circles of full-depth teeth cut the line of action: start, end and length of the line [m].

    ``z_1`` is the pinion (the smaller gear), ``z_2`` the ring of an internal pair; ``module`` in m, ``alpha`` in rad,
    ``distance`` of the centres in m, the nominal one if None. The start is that of the tip of gear 2, the end that of the
    pinion's tip, both counted from the pinion's base tangent point T1. The line ends at the tangent point of gear 2 of an
    external pair, at infinity for a ring. A start below 0 or an end beyond the line is interference: the tip would touch
    within the other gear's base circle, where there is no involute. NaN at a distance at which they cannot mesh.
    ISO 21771-1; J. R. Colbourne, The Geometry of Involute Gears, 1987.
    """

    def beyond_base(r_tip: float, r_base: float) -> float:
        return math.sqrt(max(r_tip * r_tip - r_base * r_base, 0.0))

    r_1, r_2 = 0.5 * module * z_1, 0.5 * module * z_2
    b_1, b_2 = r_1 * math.cos(alpha), r_2 * math.cos(alpha)
    nominal, least = (r_2 - r_1, b_2 - b_1) if internal else (r_1 + r_2, b_1 + b_2)
    if distance is None:
        across = nominal * math.sin(alpha)
    elif distance <= least:
        return math.nan, math.nan, math.nan
    else:
        across = math.sqrt(distance * distance - least * least)
    end = beyond_base(r_1 + ADDENDUM * module, b_1)
    if internal:
        return beyond_base(r_2 - ADDENDUM * module, b_2) - across, end, math.inf
    return across - beyond_base(r_2 + ADDENDUM * module, b_2), end, across


def contact_ratio(
    z_1: int, z_2: int, internal: bool, module: float, alpha: float, distance: float | None = None
) -> float:
    """Return the transverse contact ratio of full-depth teeth (addendum 1 m) at a centre ``distance`` [m], nominal if None.

    The path of contact between the tip circles, cut at the base tangent points (`contact_path`), over the base pitch.
    NaN at a distance at which they cannot mesh.

    >>> round(contact_ratio(20, 20, False, 0.004, math.radians(20.0)), 4)
    1.5568
    >>> round(contact_ratio(18, 48, True, 0.001, math.radians(20.0)), 3)  # cut at the pinion's tangent point, else 2.02
    1.808
    """
    start, end, line = contact_path(z_1, z_2, internal, module, alpha, distance)
    if math.isnan(start):
        return math.nan
    return (min(end, line) - max(start, 0.0)) / (math.pi * module * math.cos(alpha))


def mesh_contact_path(case: "Case", j: int, distance: float | None = None) -> tuple[float, float, float]:
    """Return start, end and line of mesh j's path of contact [m] at a centre ``distance`` [m]; see `contact_path`."""
    mesh = case.meshes[j]
    z_1, z_2 = sorted((teeth_of(case, mesh.driver), teeth_of(case, mesh.driven)))
    internal = ring_of(case, mesh) is not None
    return contact_path(z_1, z_2, internal, mesh.module, mesh.pressure_angle, distance)


def mesh_contact_ratio(case: "Case", j: int, distance: float | None = None) -> float:
    """Return the contact ratio of mesh j at a centre ``distance`` [m], the nominal one if None; see `contact_ratio`."""
    mesh = case.meshes[j]
    z_1, z_2 = sorted((teeth_of(case, mesh.driver), teeth_of(case, mesh.driven)))
    internal = ring_of(case, mesh) is not None
    return contact_ratio(z_1, z_2, internal, mesh.module, mesh.pressure_angle, distance)


def jam_ratio(case: "Case", j: int) -> float:
    """Return 2 sin(alpha0) (sum of both radial clearances) / b of mesh j: wedging is possible above 1.

    b is the backlash at the distance of the nominal centres. Infinite where it is 0 or less and a clearance is left; 0 without
    clearances.
    """
    mesh = case.meshes[j]
    play = sum(clearance_of(case, name) or 0.0 for name in mesh.rotors)
    backlash = installed_backlash(case, j)
    if backlash > 0.0:
        return 2.0 * math.sin(mesh.pressure_angle) * play / backlash
    return math.inf if play > 0.0 or backlash < 0.0 else 0.0


def installed_backlash(case: "Case", j: int) -> float:
    """Return the backlash b_t [m] of mesh j at the distance of its nominal centres: b0 where that is the nominal one.

    b_t = b0 - 2 s c0 (inv alpha_w - inv alpha0), (4); of positions that cannot mesh NaN.
    """
    mesh = case.meshes[j]
    at, nominal = centres(case), nominal_center_distance(case, j)
    distance = math.dist(*(at[name] for name in mesh.rotors))
    if abs(distance - nominal) < 1e-12 * nominal:
        return mesh.backlash
    c0 = nominal * math.cos(mesh.pressure_angle)
    if distance <= c0:
        return math.nan
    opening = involute_from_distance(distance, c0) - involute(mesh.pressure_angle)
    return mesh.backlash + (2.0 if ring_of(case, mesh) is None else -2.0) * c0 * opening


def amplitude_bound(radial_clearance: float, frequency: float) -> float:
    """Return the highest line of acceleration within a clearance, (4/pi) c (2 pi f)^2 [m/s^2].

    Parameters
    ----------
    radial_clearance
        c [m]; a displacement within -c .. c has no line higher than that of a square wave, 4 c / pi.
    frequency
        f of the line [Hz].

    Examples
    --------
    >>> round(amplitude_bound(100e-6, 40.0), 3)
    8.042

    """
    return 4.0 / math.pi * radial_clearance * (2.0 * math.pi * frequency) ** 2


def carrier_of(case: "Case", name: str) -> str | None:
    """Return the rotor that carries the part that holds this rotor, or None for the ground."""
    return next((part.on for part in case.holders(name) if part.on is not None), None)


def clearance_of(case: "Case", name: str) -> float | None:
    """Return the radial clearance [m] of the part that holds a rotor; None for a rotor that is in none."""
    return next((c for part in case.holders(name) if (c := part.clearance()) is not None), None)


def is_held(case: "Case", name: str) -> bool:
    """Return whether a rotor's centre is held: no part that holds it and no ``floating`` frees it."""
    return not case.rotors[name].floating and not any(part.frees_centre() for part in case.holders(name))


def mesh_frame(case: "Case", j: int) -> str | None:
    """Return the carrier in whose frame mesh j rolls, or None for the ground.

    Raises `InputError` where its two gears sit on two different carriers.
    """
    mesh = case.meshes[j]
    carriers = {carrier_of(case, n) for n in mesh.rotors} - {None, *mesh.rotors}
    if len(carriers) > 1:
        names = " and ".join(sorted(str(c) for c in carriers))
        raise InputError(
            [
                Fault(
                    f"meshes.{j}",
                    names,
                    "both gears of a mesh must share one carrier",
                    "Mount one of them elsewhere.",
                )
            ]
        )
    return next(iter(carriers), None)


def centres(case: "Case") -> dict[str, tuple[float, float]]:
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
                raise InputError([Fault(f"rotors.{other}.position", place_words(*found[other]), rule, cure)])
    return found


def _way(case: "Case", j: int, known: str) -> tuple[float, float]:
    """Return the vector [m] from the centre of a rotor of mesh j to the other's, at the nominal distance."""
    mesh, A0 = case.meshes[j], nominal_center_distance(case, j)
    if mesh.angle is not None:
        step = A0 if known == mesh.rotors[0] else -A0
        return step * math.cos(mesh.angle), step * math.sin(mesh.angle)
    ring = ring_of(case, mesh)
    return (A0 if ring is None or known == rotor_of(case, ring) else -A0), 0.0


def _spread(found: dict[str, tuple[float, float]], axes: list[set[str]]) -> None:
    """Give the centre that is known of one rotor on an axis to the others, as far as that leads."""
    pending = [axis for axis in axes if axis & found.keys() and axis - found.keys()]
    while pending:
        for axis in pending:
            centre = found[next(name for name in sorted(axis) if name in found)]
            found.update(dict.fromkeys(axis - found.keys(), centre))
        pending = [axis for axis in axes if axis & found.keys() and axis - found.keys()]


def signed_radii(case: "Case", j: int) -> tuple[str, str, float, float]:
    """Return (a, b, r_a, r_b): gears at foot and tip of the vector of centres, and pitch radii [m], negative for a ring."""
    mesh = case.meshes[j]
    ring = ring_of(case, mesh)
    if ring is None:
        a, b = mesh.driver, mesh.driven
        return a, b, pitch_radius(case, mesh, a), pitch_radius(case, mesh, b)
    a, b = ring, mesh.driven if mesh.driver == ring else mesh.driver
    return a, b, -pitch_radius(case, mesh, a), pitch_radius(case, mesh, b)
