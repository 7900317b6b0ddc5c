"""Meshes at temperature, and the backlash that is left.

A pair of gears meshes at abs(r_a f_a + r_b f_b) as it did at abs(r_a + r_b).
"""

import math
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

from gearplay.parts.mesh.allowance_range import backlash_range
from gearplay.parts.mesh.schema import Mesh
from gearplay.parts.mesh.train import geometry
from gearplay.schema.finding import Finding
from gearplay.schema.units import ICE

if TYPE_CHECKING:
    from gearplay.parts.mesh.train.train import Train


def mesh_at_temperature(case: "Train", j: int, factors: Mapping[str, float]) -> Mesh:
    """Return mesh j with the lengths that its gears have at the expansion ``factors`` of the rotors."""
    mesh = case.meshes[j]
    a, b, r_a, r_b = geometry.signed_radii(case, j)
    f_a, f_b = (factors[geometry.rotor_of(case, name)] for name in (a, b))
    factor = (r_a * f_a + r_b * f_b) / (r_a + r_b)
    pair = geometry.pair_of(case, j)
    normal = math.cos(pair.first.base_helix) if pair.first.helix_angle else 1.0
    update: dict[str, object] = {
        "module": factor * mesh.module,
        "backlash": factor * geometry.working_backlash(case, j) * normal,
    }
    if mesh.center_distance is not None or pair.is_shifted:
        update |= {"center_distance": factor * pair.distance, "center_distance_allowance": None}
    return mesh.model_copy(update=update)


def thermal_texts(case: "Train", hot: "Train") -> dict[str, str]:
    """Return texts on centre distance and backlash of all meshes of a case and the case at temperature, by path."""
    texts = {}
    cold_centres, hot_centres = geometry.centres(case), geometry.centres(hot)
    for j, mesh in enumerate(case.meshes):
        one, other = mesh.rotors
        cold, warm = (math.dist(at[one], at[other]) for at in (cold_centres, hot_centres))
        play, left = (geometry.installed_backlash(each, j) for each in (case, hot))
        gears = geometry.working_distance(hot, j) - geometry.working_distance(case, j)
        beyond = warm - cold - gears
        pair = geometry.pair_of(case, j)
        first = pair.second.sign * 2.0 * math.sin(pair.working_angle)
        texts[f"meshes.{j}"] = (
            f"at temperature the centre distance is {1e3 * warm:.6g} mm, {1e6 * (warm - cold):+.1f} um, which is "
            f"{1e6 * beyond:+.1f} um beyond its gears; the backlash is {1e6 * left:.1f} um, {1e6 * (left - play):+.1f} um "
            f"(2 sin alpha x centre distance: {1e6 * first * beyond:+.1f} um)"
        )
    return texts


def temperature_findings(case: "Train") -> Iterator[Finding]:
    """Yield the remaining backlash at both ends of ``environment.temperature_range``, a warning if there is none."""
    if case.environment is None or case.environment.temperature_range is None:
        return
    ends = {end: case.at_temperature(end) for end in case.environment.temperature_range}
    for j, mesh in enumerate(case.meshes):
        normal = math.cos(geometry.pair_of(case, j).first.base_helix)
        middle = geometry.installed_backlash(case, j) * normal
        limits = backlash_range(case, j)
        words, least = [], math.inf
        for end, found in ends.items():
            left = geometry.installed_backlash(found, j) * normal
            lowest = left if limits is None else left - (middle - limits[0])
            least = min(least, lowest)
            allowed = "" if limits is None else f", {1e6 * lowest:.4g} um by its allowances"
            words.append(f"{1e6 * left:.4g} um at {end - ICE:.6g} degC{allowed}")
        jams = least < 0.0 or math.isnan(least)
        yield Finding(
            "warning" if jams else "note",
            f"meshes.{j}.backlash",
            f"of {1e6 * middle:.4g} um of normal backlash of {mesh.label} are left {' and '.join(words)}"
            f"{': it jams there. Raise the backlash, or take materials that expand alike' if jams else ''}.",
        )
