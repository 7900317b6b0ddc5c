"""Numbers of a pair of gears as on a gear drawing, and as rows of text."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from gearplay.parts.mesh.check_pairs import pair_table
from gearplay.parts.mesh.train import geometry
from gearplay.toothing.gear import inv

if TYPE_CHECKING:
    from gearplay.model.case import Case
    from gearplay.toothing.gear import DrawnGear

Row = tuple[str, str]


def span(gear: DrawnGear) -> tuple[int, float]:
    """Return how many teeth a span measurement of an external gear takes, and the base tangent length W_k [m] over them.

    W_k = cos(alpha_n) (m_n ((k - 1/2) pi + z inv(alpha_t) + 2 x tan(alpha_n)) + change of the thickness), ISO 21771-1; k so that
    the span touches near the middle of the teeth.
    """
    alpha, module = gear.pressure_angle, gear.module
    involute = inv(gear.transverse_angle)
    middle = gear.reference_radius + gear.profile_shift * module
    wanted = 2.0 * math.sqrt(max(middle**2 - gear.base_radius**2, 0.0)) / math.cos(gear.base_helix)
    step = math.pi * module * math.cos(alpha)
    first = math.cos(alpha) * (
        module * (-0.5 * math.pi + gear.teeth * involute + 2.0 * gear.profile_shift * math.tan(alpha))
        + gear.thickness_change
    )
    count = max(2, round((wanted - first) / step))
    return count, first + count * step


def gear_tables(case: Case, j: int) -> dict[str, dict[str, Any]]:
    """Return the numbers [SI] of both gears of mesh j by name, JSON-able."""
    pair = geometry.installed_pair(case, j)
    working = pair.working_radii if math.isfinite(pair.working_angle) else (math.nan, math.nan)
    found = {}
    for name, gear, rolling in zip(
        geometry.gears_of_pair(case, j), (pair.first, pair.second), working, strict=True
    ):
        drawn = geometry.gear_of(case, name)
        upper, lower = drawn.thickness_change(gear.module, gear.pressure_angle, gear.teeth, gear.sign)
        table: dict[str, Any] = {
            "teeth": gear.teeth,
            "internal": gear.internal,
            "profile_shift": gear.profile_shift,
            "helix_angle": gear.helix_angle,
            "reference_diameter": 2.0 * gear.reference_radius,
            "base_diameter": 2.0 * gear.base_radius,
            "tip_diameter": 2.0 * gear.tip,
            "root_diameter": 2.0 * gear.root,
            "working_pitch_diameter": 2.0 * rolling,
            "normal_thickness": gear.normal_thickness,
            "thickness_allowances": [upper, lower],
            "tip_thickness": gear.tip_thickness,
            "facewidth": gear.facewidth,
        }
        if not gear.internal:
            table["span_teeth"], table["span"] = span(gear)
        found[geometry.full_name(case, name)] = table
    return found


def pair_values(case: Case, j: int) -> dict[str, Any]:
    """Return the numbers [SI] of mesh j at its nominal centres, JSON-able; those of `gearplay check --json` among them."""
    pair = geometry.installed_pair(case, j)
    row = pair_table(case)[j]
    names = (
        "working_pressure_angle",
        "center_distance",
        "contact_ratio",
        "overlap_ratio",
        "backlash",
        "backlash_range",
        "mesh_frequency",
        "hunting_frequency",
    )
    path = pair.path
    first, second = pair.tip_clearances
    return {name: row[name] for name in names} | {
        "module": pair.first.module,
        "pressure_angle": pair.first.pressure_angle,
        "transverse_pressure_angle": pair.first.transverse_angle,
        "reference_center_distance": pair.reference_distance,
        "zero_backlash_center_distance": pair.tight_distance,
        "base_pitch": pair.first.base_pitch,
        "path_start": path.start,
        "path_end": path.end,
        "pitch_point": pair.pitch_place,
        "uncut_contact_ratio": path.uncut / pair.first.base_pitch,
        "tip_clearances": [first, second],
    }


def drawing_rows(gears: Mapping[str, Mapping[str, Any]], pair: Mapping[str, Any]) -> Sequence[Row]:
    """Return the table of both gears and of the pair: names and values as text."""
    tables, uncut = list(gears.values()), pair["uncut_contact_ratio"]

    def both(name: str, words: str, form: str, factor: float = 1) -> Row:
        cells = [
            "-" if (value := table.get(name)) is None else format(value * factor, form) for table in tables
        ]
        return words, " / ".join(cells)

    rows = [
        ("gears", " / ".join(gears)),
        both("teeth", "teeth", "d"),
        ("normal module, pressure angle", f"{1e3 * pair['module']:g} mm, {math.degrees(pair['pressure_angle']):.6g} deg"),
        both("helix_angle", "helix angle [deg]", ".6g", 180.0 / math.pi),
        both("profile_shift", "profile shift", ".4f"),
        both("reference_diameter", "reference diameter [mm]", ".4f", 1e3),
        both("base_diameter", "base diameter [mm]", ".4f", 1e3),
        both("tip_diameter", "tip diameter [mm]", ".4f", 1e3),
        both("root_diameter", "root diameter [mm]", ".4f", 1e3),
        both("working_pitch_diameter", "working pitch diameter [mm]", ".4f", 1e3),
        both("normal_thickness", "normal thickness [mm]", ".4f", 1e3),
        (
            "thickness allowances [um]",
            " / ".join("{:+.1f} {:+.1f}".format(*(1e6 * each for each in table["thickness_allowances"])) for table in tables),
        ),
        both("tip_thickness", "tip thickness [mm]", ".4f", 1e3),
        (
            "base tangent length [mm]",
            " / ".join(f"{1e3 * table['span']:.4f} over {table['span_teeth']}" if "span" in table else "-" for table in tables),
        ),
        both("facewidth", "facewidth [mm]", ".6g", 1e3),
        ("centre distance [mm]", f"{1e3 * pair['center_distance']:.4f}"),
        ("of zero backlash [mm]", f"{1e3 * pair['zero_backlash_center_distance']:.4f}"),
        (
            "working pressure angle [deg]",
            f"{math.degrees(pair['working_pressure_angle']):.4f} (transverse at the reference circle "
            f"{math.degrees(pair['transverse_pressure_angle']):.4f})",
        ),
        (
            "contact ratio",
            f"{pair['contact_ratio']:.4f}"
            + (f" (uncut {uncut:.4f})" if uncut - pair["contact_ratio"] > 1e-9 else "")
            + (f", overlap {pair['overlap_ratio']:.4f}" if pair["overlap_ratio"] else ""),
        ),
        (
            "path of contact [mm]",
            f"{1e3 * pair['path_start']:.4f} to {1e3 * pair['path_end']:.4f}, pitch point at {1e3 * pair['pitch_point']:.4f}",
        ),
        ("tip clearances [mm]", " / ".join(f"{1e3 * each:.4f}" for each in pair["tip_clearances"])),
        ("normal backlash [um]", f"{1e6 * pair['backlash']:.4g}"),
    ]  # fmt: skip
    if pair["backlash_range"] is not None:
        least, largest = pair["backlash_range"]
        rows.append(("by allowances [um]", f"{1e6 * least:.4g} to {1e6 * largest:.4g}"))
    return rows
