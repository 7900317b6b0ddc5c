"""Findings about teeth as drawn: undercut, pointed tips, tip clearance, interference, contact ratio, planets that collide."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from itertools import combinations
from typing import TYPE_CHECKING, Final

from gearplay.parts.mesh.check_pairs import contact_ratios
from gearplay.parts.mesh.stiffness import TeethStiffness
from gearplay.parts.mesh.teeth_stiffness import nominal_line_load
from gearplay.parts.mesh.train import geometry
from gearplay.parts.rotor.schema import place_words
from gearplay.schema.finding import Finding
from gearplay.toothing.gear import DrawnGear
from gearplay.toothing.iso6336 import light_load_factor
from gearplay.toothing.pair import GearPair

if TYPE_CHECKING:
    from gearplay.parts.mesh.train.train import Train

TOLERATED: Final = 0.5
"""Teeth below the limit of undercut that do not matter: 17 at 20 deg, whose limit is 17.1."""
LEAST_TIP_CLEARANCE: Final = 0.1
"""Modules that should be left between tips and roots."""
FIT: Final = 0.01
"""Part of a tooth by which a planet may miss sun and ring."""


def teeth_findings(case: Train) -> Iterator[Finding]:
    """Yield findings about the teeth of a valid case."""
    seen: set[str] = set()
    for j in range(len(case.meshes)):
        pair = geometry.installed_pair(case, j)
        for name, gear in zip(geometry.gears_of_pair(case, j), (pair.first, pair.second), strict=True):
            full = geometry.full_name(case, name)
            if full not in seen:
                seen.add(full)
                path = case.field_path(geometry.rotor_of(case, name), "teeth")
                yield from _cut(path, gear)
                yield from _pointed(path, gear)
        yield from _contact_ratio(case, j, pair)
        yield from _tip_clearance(case, j, pair)
        yield from _fouling(case, j, pair)
    yield from _light_loads(case)
    yield from _planets(case)


def _shifted(gear: DrawnGear) -> str:
    return f" with a profile shift of {gear.profile_shift:g}" if gear.profile_shift else ""


def _cut(path: str, gear: DrawnGear) -> Iterator[Finding]:
    """Yield a finding for each gear that cannot have full involute flanks."""
    z, degrees, alpha = gear.teeth, math.degrees(gear.pressure_angle), gear.transverse_angle
    if gear.internal:
        if gear.tip >= gear.base_radius:
            return
        least = math.ceil(
            2.0 * (gear.addendum - gear.profile_shift) * math.cos(gear.helix_angle) / (1.0 - math.cos(alpha))
        )
        clean = (
            f"from {least} teeth on they do not. Take more teeth"
            if gear.tip_diameter is None
            else f"from a tip diameter of {2e3 * gear.base_radius:.7g} mm on they do not. Enlarge it"
        )
        yield Finding(
            "warning",
            path,
            f"the tips of {z} internal teeth of {degrees:.4g} deg{_shifted(gear)} lie inside their base circle, where there is "
            f"no involute; {clean}, or read forces near the tips with care.",
        )
        return
    least_teeth = (
        2.0 * math.cos(gear.helix_angle) * (gear.straight_flank - gear.profile_shift) / math.sin(alpha) ** 2
    )
    if z < least_teeth - TOLERATED:
        yield Finding(
            "warning",
            path,
            f"{z} teeth of {degrees:.4g} deg{_shifted(gear)} are undercut; from {round(least_teeth)} teeth on, or with a profile "
            f"shift of {gear.profile_shift + gear.undercut:.3g}, they are not. The involute near the root is missing, so that "
            "the true contact ratio is lower. Take more teeth, more profile shift or a larger pressure angle.",
        )


def _pointed(path: str, gear: DrawnGear) -> Iterator[Finding]:
    """Yield a finding for each gear whose flanks of a tooth meet before its tip circle."""
    if gear.tip_thickness > 0.0:
        return
    kind = "internal teeth" if gear.internal else "teeth"
    more = (
        ""
        if gear.internal or 0.25 * math.pi <= gear.addendum * math.tan(gear.pressure_angle)
        else ", or more teeth"
    )
    yield Finding(
        "warning",
        path,
        f"{gear.teeth} {kind} of {math.degrees(gear.pressure_angle):.4g} deg{_shifted(gear)} are pointed: their flanks meet "
        f"before the tip circle, so that the true contact ratio is lower. Take a smaller pressure angle{more}"
        f"{', less profile shift or a lower addendum' if gear.profile_shift else ''}.",
    )


def _contact_ratio(case: Train, j: int, pair: GearPair) -> Iterator[Finding]:
    installed = pair.contact_ratio + pair.overlap_ratio
    if installed < 1.0:
        nominal = geometry.pair_of(case, j).contact_ratio + pair.overlap_ratio
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
        return
    least, _ = contact_ratios(case, j)
    if least < 1.0:
        yield Finding(
            "warning",
            f"meshes.{j}",
            f"the contact ratio, {installed:.3g}, falls to {least:.3g} with the centres as "
            f"{'close' if pair.internal else 'far apart'} as the clearances allow: between two pairs of teeth nothing would be "
            "in contact. Lower the clearances, or lengthen the addenda.",
        )


def _tip_clearance(case: Train, j: int, pair: GearPair) -> Iterator[Finding]:
    """Yield a finding for tips too near to the roots of the other gear."""
    names = geometry.gears_of_pair(case, j)
    for one, other, gap in zip(names, names[::-1], pair.tip_clearances, strict=True):
        if gap < LEAST_TIP_CLEARANCE * pair.first.module:
            yield Finding(
                "warning",
                f"meshes.{j}",
                f"{1e3 * gap:.3f} mm are left between the tips of {one} and the roots of {other}, "
                f"{gap / pair.first.module:.2g} modules, where {LEAST_TIP_CLEARANCE:g} are usual at least. Shorten the tips "
                f"(tip_diameter of {one}), cut deeper, or correct the centre distance.",
            )


def _fouling(case: Train, j: int, pair: GearPair) -> Iterator[Finding]:
    """Yield a finding for each internal pair whose tips meet away from the line of action."""
    if not pair.tips_foul:
        return
    z_1, z_2 = pair.first.teeth, pair.second.teeth
    cure = "Shorten the tips"
    if pair.first.tip_diameter is None and pair.second.tip_diameter is None:
        least = next((z for z in range(z_2, z_2 + 200) if not _with_ring(pair, z).tips_foul), None)
        if least is not None:
            cure = f"Take at least {least} teeth for the ring, or fewer for the pinion"
    yield Finding(
        "warning",
        f"meshes.{j}",
        f"{z_1} teeth in {z_2}: their tips foul each other beside the mesh, which is not modelled. {cure}.",
    )


def _light_loads(case: Train) -> Iterator[Finding]:
    """Yield a note on the load at which ISO 6336-1 gives the stiffness of the teeth, once for meshes that are alike."""
    alike: dict[str, list[int]] = {}
    for j in range(len(case.meshes)):
        if words := _light_load(case, j):
            alike.setdefault(words, []).append(j)
    for words, meshes in alike.items():
        names = f"{', '.join(case.meshes[j].label for j in meshes)}: " if len(meshes) > 1 else ""
        yield Finding("note", f"meshes.{meshes[0]}.stiffness", f"{names}{words}. Give line_load for another.")


def _light_load(case: Train, j: int) -> str:
    """Return the load of mesh j and its factor of the stiffness as text; empty where the factor is 1 or does not apply."""
    mesh = case.meshes[j]
    if not isinstance(mesh.stiffness, TeethStiffness) or mesh.stiffness.method != "iso6336":
        return ""
    load = mesh.stiffness.line_load or nominal_line_load(case, j)
    if load is None:
        return "the case has no load, so that the stiffness of the teeth is that above 100 N/mm of facewidth"
    factor = light_load_factor(load)
    if factor == 1.0:
        return ""
    return f"at F_t/b = {1e-3 * load:.4g} N/mm the teeth have {factor:.3g} of the stiffness above 100 N/mm (ISO 6336-1)"


def _with_ring(pair: GearPair, teeth: int) -> GearPair:
    other = GearPair(pair.first, replace(pair.second, teeth=teeth), math.nan)
    return other.at(other.shifted_distance)


def _planets(case: Train) -> Iterator[Finding]:
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


def _tip_radius(case: Train, name: str) -> float:
    radii = [
        gear.tip
        for j in range(len(case.meshes))
        for called, gear in zip(geometry.gears_of_pair(case, j), geometry.gears_of(case, j), strict=True)
        if geometry.rotor_of(case, called) == name and not gear.internal
    ]
    return max(radii, default=0.0)


def _misfits(case: Train, names: list[str], at: dict[str, tuple[float, float]]) -> Iterator[Finding]:
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
                f"its teeth cannot mesh with {suns[0]} and {rings[0]} as those of {other} do: they are "
                f"{abs(steps - round(steps)):.3g} of a step of {360.0 / teeth:.5g} deg off. "
                f"Turn it by {turn:.4g} deg about the centre, to {place_words(x, y)}.",
            )
