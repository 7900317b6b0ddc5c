"""Findings about teeth: undercut, pointed tips, interference of internal pairs, contact ratio, planets that collide.

Full-depth teeth without profile shift (ISO 53), as everywhere. Fouling of internal pairs: tips that meet outside the line of
action, J. R. Colbourne, The Geometry of Involute Gears, Springer 1987.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import combinations
from typing import TYPE_CHECKING, Final

from gearplay.model import geometry
from gearplay.model.check_pairs import installed_contact_ratio
from gearplay.parts.mesh.involute import involute
from gearplay.parts.rotor.gear import ADDENDUM
from gearplay.parts.rotor.schema import place_words
from gearplay.schema.finding import Finding

if TYPE_CHECKING:
    from gearplay.model.case import Case
    from gearplay.parts.mesh.schema import Mesh

TOLERATED: Final = 0.5
"""Teeth below the limit of undercut that do not matter: 17 at 20 deg, whose limit is 17.1."""
FIT: Final = 0.01
"""Part of a tooth by which a planet may miss sun and ring."""


def teeth_findings(case: Case) -> Iterator[Finding]:
    """Yield findings about the teeth of a valid case."""
    seen: set[str] = set()
    for j, mesh in enumerate(case.meshes):
        for name in (mesh.driver, mesh.driven):
            full = geometry.full_name(case, name)
            if full not in seen:
                seen.add(full)
                yield from _cut(case, mesh, name)
                yield from _pointed(case, mesh, name)
        yield from _contact_ratio(case, j)
        yield from _fouling(case, j)
    yield from _planets(case)


def _cut(case: Case, mesh: Mesh, name: str) -> Iterator[Finding]:
    """Yield a finding for each gear that cannot have full involute flanks."""
    z, alpha = geometry.teeth_of(case, name), mesh.pressure_angle
    path, degrees = f"rotors.{geometry.rotor_of(case, name)}.teeth", math.degrees(alpha)
    if geometry.gear_of(case, name).internal:
        least = 2.0 * ADDENDUM / (1.0 - math.cos(alpha))
        if z < least:
            yield Finding(
                "warning",
                path,
                f"the tips of {z} internal teeth of {degrees:.4g} deg lie inside their base circle, where there is no involute; "
                f"from {math.ceil(least)} teeth on they do not. Take more teeth, or read forces near the tips with care.",
            )
        return
    least = 2.0 * ADDENDUM / math.sin(alpha) ** 2
    if z < least - TOLERATED:
        yield Finding(
            "warning",
            path,
            f"{z} teeth of {degrees:.4g} deg are undercut; from {round(least)} teeth on they are not. The involute near the root "
            "is missing, so that the true contact ratio is lower. Take more teeth or a larger pressure angle.",
        )


def _pointed(case: Case, mesh: Mesh, name: str) -> Iterator[Finding]:
    """Yield a finding for each gear whose flanks of a tooth meet before its tip circle."""
    z, alpha = geometry.teeth_of(case, name), mesh.pressure_angle
    internal = geometry.gear_of(case, name).internal
    if tip_thickness(z, internal, alpha) <= 0.0:
        kind = "internal teeth" if internal else "teeth"
        more = "" if internal or 0.25 * math.pi <= ADDENDUM * math.tan(alpha) else ", or more teeth"
        yield Finding(
            "warning",
            f"rotors.{geometry.rotor_of(case, name)}.teeth",
            f"{z} {kind} of {math.degrees(alpha):.4g} deg are pointed: their flanks meet before the tip circle, so that the true "
            f"contact ratio is lower. Take a smaller pressure angle{more}.",
        )


def tip_thickness(z: int, internal: bool, alpha: float) -> float:
    """Return the thickness of full-depth teeth along the tip circle, in modules; negative where the flanks meet before it.

    s_a = d_a (pi / (2 z) + inv alpha - inv alpha_a) of an external gear, with both inv terms reversed of a ring, whose teeth
    are the spaces of an external gear. A ring's tip within its base circle is as thick as at that circle.

    >>> round(tip_thickness(20, False, math.radians(20.0)), 3), tip_thickness(40, True, math.radians(45.0)) < 0.0
    (0.695, True)
    """
    sign = -1.0 if internal else 1.0
    base, tip = 0.5 * z * math.cos(alpha), 0.5 * z + sign * ADDENDUM
    at_tip = involute(math.acos(min(1.0, base / max(tip, base))))
    return 2.0 * tip * (0.5 * math.pi / z + sign * (involute(alpha) - at_tip))


def _contact_ratio(case: Case, j: int) -> Iterator[Finding]:
    nominal, installed = geometry.mesh_contact_ratio(case, j), installed_contact_ratio(case, j)
    if installed < 1.0:
        where = (
            ""
            if abs(installed - nominal) < 0.005
            else f" at the installed distance ({nominal:.2f} at the nominal one)"
        )
        yield Finding(
            "warning",
            f"meshes.{j}",
            f"the contact ratio, {installed:.2f}{where}, is below 1: between two pairs of teeth nothing would be in contact. "
            "Check teeth, module, pressure angle and positions.",
        )


def _fouling(case: Case, j: int) -> Iterator[Finding]:
    """Yield a finding for each internal pair whose tips meet away from the line of action."""
    mesh = case.meshes[j]
    ring = geometry.ring_of(case, mesh)
    if ring is None:
        return
    pinion = mesh.driven if mesh.driver == ring else mesh.driver
    z_1, z_2 = geometry.teeth_of(case, pinion), geometry.teeth_of(case, ring)
    if fouls(z_1, z_2, mesh.pressure_angle):
        least = next(z for z in range(z_2, z_2 + 200) if not fouls(z_1, z, mesh.pressure_angle))
        yield Finding(
            "warning",
            f"meshes.{j}",
            f"{z_1} teeth in {z_2}: their tips foul each other beside the mesh, which is not modelled. "
            f"Take at least {least} teeth for the ring, or fewer for the pinion.",
        )


def fouls(z_1: int, z_2: int, alpha: float) -> bool:
    """Return whether tips of full-depth teeth z_1 inside z_2 meet outside the line of action, at the nominal distance.

    >>> fouls(29, 30, math.radians(20.0)), fouls(24, 34, math.radians(20.0))
    (True, False)
    """
    r_1, r_2, h = 0.5 * z_1, 0.5 * z_2, ADDENDUM
    tip_1, tip_2, distance = r_1 + h, r_2 - h, r_2 - r_1
    base_1, base_2 = r_1 * math.cos(alpha), r_2 * math.cos(alpha)
    turn_1 = (tip_2**2 - tip_1**2 - distance**2) / (2.0 * distance * tip_1)
    turn_2 = (tip_2**2 - tip_1**2 + distance**2) / (2.0 * distance * tip_2)
    if abs(turn_1) >= 1.0 or abs(turn_2) >= 1.0:  # the tip circles do not cross
        return tip_2 <= tip_1 - distance
    angle_1 = math.acos(turn_1) + involute(math.acos(base_1 / tip_1)) - involute(alpha)
    at_tip = involute(math.acos(min(1.0, base_2 / tip_2)))
    return angle_1 * z_1 / z_2 + involute(alpha) - at_tip < math.acos(turn_2)


def _planets(case: Case) -> Iterator[Finding]:
    """Yield findings for planets that overlap or cannot all mesh with sun and ring; planets of a table are validated."""
    at = geometry.centres(case)
    carried: dict[str, list[str]] = {}
    for name in case.rotors:
        on = geometry.carrier_of(case, name)
        if on is not None and "." not in name:
            carried.setdefault(on, []).append(name)
    for names in carried.values():
        tips = {name: _tip_radius(case, name) for name in names}
        for one, other in combinations([name for name in names if tips[name] > 0.0], 2):
            apart = math.dist(at[one], at[other])
            if apart < tips[one] + tips[other]:
                yield Finding(
                    "warning",
                    f"rotors.{other}.position",
                    f"it overlaps {one}: the centres are {1e3 * apart:.4g} mm apart, the tips reach "
                    f"{1e3 * (tips[one] + tips[other]):.4g} mm. Move it, or take fewer or smaller planets.",
                )
        yield from _misfits(case, names, at)


def _tip_radius(case: Case, name: str) -> float:
    radii = [
        geometry.pitch_radius(case, mesh, called) + ADDENDUM * mesh.module
        for mesh in case.meshes
        for called in (mesh.driver, mesh.driven)
        if geometry.rotor_of(case, called) == name and not geometry.gear_of(case, called).internal
    ]
    return max(radii, default=0.0)


def _misfits(case: Case, names: list[str], at: dict[str, tuple[float, float]]) -> Iterator[Finding]:
    """Compare each planet with the first that meshes with the same sun and ring."""
    first: dict[tuple[str, str], tuple[str, float]] = {}
    for name in names:
        partners = [
            called
            for mesh in case.meshes
            if name in mesh.rotors
            for called in (mesh.driver, mesh.driven)
            if geometry.rotor_of(case, called) != name
        ]
        suns = [p for p in partners if not geometry.gear_of(case, p).internal]
        rings = [p for p in partners if geometry.gear_of(case, p).internal]
        if len(suns) != 1 or len(rings) != 1:
            continue
        centre = at[geometry.rotor_of(case, suns[0])]
        direction = math.atan2(at[name][1] - centre[1], at[name][0] - centre[0])
        other, known = first.setdefault((suns[0], rings[0]), (name, direction))
        teeth = geometry.teeth_of(case, suns[0]) + geometry.teeth_of(case, rings[0])
        steps = (direction - known) * teeth / (2.0 * math.pi)
        if abs(steps - round(steps)) > FIT:
            turn = math.degrees(2.0 * math.pi * (round(steps) - steps) / teeth)
            there, radius = direction + math.radians(turn), math.dist(at[name], centre)
            x, y = centre[0] + radius * math.cos(there), centre[1] + radius * math.sin(there)
            yield Finding(
                "warning",
                f"rotors.{name}.position",
                f"its teeth cannot mesh with {suns[0]} and {rings[0]} as those of {other} do: it is "
                f"{abs(steps - round(steps)):.3g} of a step of {360.0 / teeth:.5g} deg off. "
                f"Turn it by {turn:.4g} deg about the centre, to {place_words(x, y)}.",
            )
