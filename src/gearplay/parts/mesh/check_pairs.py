"""Contact ratio and characteristic frequencies of every gear pair, as a note and as a table."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, Final

from gearplay.parts.mesh.allowance_range import backlash_range
from gearplay.parts.mesh.frequencies import mesh_frequencies, rolling_frame
from gearplay.parts.mesh.train import geometry
from gearplay.schema.finding import Finding

if TYPE_CHECKING:
    from gearplay.parts.mesh.train.train import Train

SAME_ANGLE: Final = math.radians(5e-5)
"""Difference of angles [rad] that is not said."""
SAME_RATIO: Final = 5e-4
"""Difference of contact ratios that is not said."""


def pair_findings(case: Train) -> Iterator[Finding]:
    """Yield a note for each pair of gears, with all names of identical pairs, such as those of planets."""
    alike: dict[tuple[Any, ...], list[int]] = {}
    for j, row in enumerate(pair_table(case)):
        frame = rolling_frame(case, j)
        numbers = [
            f"{each:.9g}"
            for each in (
                row["contact_ratio"] or 0.0,
                row["backlash"] or 0.0,
                *row["shafts"].values(),
                row["mesh_frequency"],
            )
        ]
        teeth = [geometry.teeth_of(case, name) for name in (case.meshes[j].driver, case.meshes[j].driven)]
        alike.setdefault((*numbers, *teeth, frame), []).append(j)
    for meshes in alike.values():
        names = ", ".join(case.meshes[j].label for j in meshes)
        words = f"{names}: {_ratio(case, meshes[0])}; {_frequencies(case, meshes[0])}."
        yield Finding("note", f"meshes.{meshes[0]}", words)


def pair_table(case: Train) -> list[dict[str, Any]]:
    """Return geometry [m, rad] at the nominal centres and frequencies [Hz] of every mesh, one JSON-able table each.

    The backlash is normal to the teeth.
    """
    rows = []
    for j, mesh in enumerate(case.meshes):
        found, pair = mesh_frequencies(case, j), geometry.installed_pair(case, j)
        backlash = geometry.installed_normal_backlash(case, j)
        rows.append(
            {
                "mesh": mesh.label,
                "working_pressure_angle": _finite(pair.working_angle),
                "center_distance": pair.distance,
                "contact_ratio": _finite(pair.contact_ratio),
                "overlap_ratio": pair.overlap_ratio,
                "backlash": _finite(backlash),
                "backlash_range": backlash_range(case, j),
                "mesh_frequency": found.mesh,
                "shafts": found.shafts,
                "rotations": found.rotations,
                "sidebands": {name: list(pair) for name, pair in found.sidebands.items()},
                "hunting_frequency": found.hunting_tooth,
                "mesh_periods": found.mesh_periods,
                "common_period": found.common_period if found.hunting_tooth > 0.0 else None,
            }
        )
    return rows


def contact_ratios(case: Train, j: int) -> tuple[float, float]:
    """Return the least and the largest total contact ratio of mesh j with its centres anywhere in their clearances.

    Transverse and overlap ratio together; NaN where the pair cannot mesh at one of the distances.
    """
    at = geometry.installed_distance(case, j)
    play = sum(geometry.clearance_of(case, name) or 0.0 for name in case.meshes[j].rotors)
    pair = geometry.pair_of(case, j)
    found = [pair.at(distance).contact_ratio for distance in (at - play, at, at + play)]
    return min(found) + pair.overlap_ratio, max(found) + pair.overlap_ratio


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _ratio(case: Train, j: int) -> str:
    """Return contact ratio, working angle and limits of the path of contact as text."""
    pair = geometry.installed_pair(case, j)
    helical = bool(pair.first.helix_angle)
    said = f"{'transverse ' if helical else ''}contact ratio {pair.contact_ratio:.4g}"
    first, second = geometry.gears_of_pair(case, j)
    cuts = [
        f"the tip of {one} stands {1e3 * beyond:.3f} mm inside the base tangent point of {other}, where there is no involute "
        f"(interference; clean from a tip diameter of {1e3 * clean:.7g} mm{less}), so the path of contact {verb} there"
        for one, other, beyond, clean, less, verb in (
            (
                second,
                first,
                -pair.path.tip_of_second,
                pair.clean_tip_diameter,
                "" if pair.internal else " down",
                "begins",
            ),
            (
                first,
                second,
                pair.path.tip_of_first - pair.path.tangent_of_second,
                2.0 * math.hypot(pair.base_tangent, pair.first.base_radius),
                " down",
                "ends",
            ),
        )
        if beyond > 0.0
    ]
    if cuts:
        said += f" (uncut {pair.path.uncut / pair.first.base_pitch:.4g}: {' and '.join(cuts)})"
    least, largest = contact_ratios(case, j)
    if largest - least > SAME_RATIO:
        said += f", {'in total ' if helical else ''}{least:.4g} to {largest:.4g} within the clearances"
    if abs(pair.working_angle - case.meshes[j].pressure_angle) > SAME_ANGLE:
        said += f", working pressure angle {math.degrees(pair.working_angle):.4f} deg at {1e3 * pair.distance:.6g} mm"
    if (limits := backlash_range(case, j)) is not None:
        middle = geometry.installed_normal_backlash(case, j)
        said += f", normal backlash {1e6 * middle:.4g} um, by its allowances {1e6 * limits[0]:.4g} to {1e6 * limits[1]:.4g} um"
    if helical:
        width = f", overlap ratio {pair.overlap_ratio:.4g}" if pair.facewidth else ""
        said += f"{width}, helical: its axial force and tilting moment are not modelled"
    return said


def _frequencies(case: Train, j: int) -> str:
    found, frame = mesh_frequencies(case, j), rolling_frame(case, j)
    repeats = f"the same two teeth meet every {found.mesh_periods} mesh periods"
    if found.mesh == 0.0:
        other = " other than 0" if any(rotor.is_prescribed for rotor in case.rotors.values()) else ""
        return f"no speed{other} is prescribed, so that no frequency is known; {repeats}"
    turning = ", ".join(f"{name} {f:.6g} Hz" for name, f in found.shafts.items())
    said = [f"mesh frequency {found.mesh:.6g} Hz", f"shafts {turning}"]
    if frame is not None:
        beside = ", ".join(f"{name} {f:.6g} Hz" for name, f in found.rotations.items())
        said.append(f"relative to {frame} {beside}")
    said.append("sidebands " + ", ".join(f"{found.mesh:.6g} ± {f:.6g} Hz" for f in found.rotations.values()))
    said.append(f"hunting tooth {found.hunting_tooth:.6g} Hz")
    said.append(f"common period {found.common_period:.6g} s ({found.mesh_periods} mesh periods)")
    return "; ".join(said)
