"""Contact ratio and characteristic frequencies of every gear pair, as a note and as a table."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from gearplay.model import geometry
from gearplay.model.mesh_frequencies import mesh_frequencies, rolling_frame
from gearplay.schema.finding import Finding

if TYPE_CHECKING:
    from gearplay.model.case import Case


def pair_findings(case: Case) -> Iterator[Finding]:
    """Yield a note for each pair of gears, with all its names for pairs that are alike, as those of planets are."""
    alike: dict[tuple[Any, ...], list[int]] = {}
    for j, row in enumerate(pair_table(case)):
        frame = rolling_frame(case, j)
        numbers = [
            f"{each:.9g}" for each in (row["contact_ratio"], *row["shafts"].values(), row["mesh_frequency"])
        ]
        teeth = [geometry.teeth_of(case, name) for name in (case.meshes[j].driver, case.meshes[j].driven)]
        alike.setdefault((*numbers, *teeth, frame), []).append(j)
    for meshes in alike.values():
        names = ", ".join(case.meshes[j].label for j in meshes)
        words = f"{names}: {_ratio(case, meshes[0])}; {_frequencies(case, meshes[0])}."
        yield Finding("note", f"meshes.{meshes[0]}", words)


def pair_table(case: Case) -> list[dict[str, Any]]:
    """Return contact ratio and frequencies [Hz] of every mesh at nominal speed, one JSON-able table each."""
    rows = []
    for j, mesh in enumerate(case.meshes):
        found, ratio = mesh_frequencies(case, j), installed_contact_ratio(case, j)
        rows.append(
            {
                "mesh": mesh.label,
                "contact_ratio": ratio if math.isfinite(ratio) else None,
                "mesh_frequency": found.mesh,
                "shafts": found.shafts,
                "rotations": found.rotations,
                "sidebands": {name: list(pair) for name, pair in found.sidebands.items()},
                "hunting_tooth": found.hunting_tooth,
                "mesh_periods": found.mesh_periods,
                "common_period": found.common_period if found.hunting_tooth > 0.0 else None,
            }
        )
    return rows


def installed_distance(case: Case, j: int) -> float:
    """Return the distance [m] of the nominal centres of mesh j."""
    at = geometry.centres(case)
    return math.dist(*(at[name] for name in case.meshes[j].rotors))


def installed_contact_ratio(case: Case, j: int) -> float:
    """Return the contact ratio of mesh j at the distance of its nominal centres; NaN where these cannot mesh."""
    return geometry.mesh_contact_ratio(case, j, installed_distance(case, j))


def _ratio(case: Case, j: int) -> str:
    """Yield notes on the contact ratio and the limits of the path of contact."""
    mesh = case.meshes[j]
    start, end, line = geometry.mesh_contact_path(case, j, installed_distance(case, j))
    said = f"contact ratio {installed_contact_ratio(case, j):.4g}"
    uncut = (end - start) / (math.pi * mesh.module * math.cos(mesh.pressure_angle))
    pinion, wheel = sorted((mesh.driver, mesh.driven), key=lambda name: geometry.teeth_of(case, name))
    cuts = [
        f"the tips of {one} would reach {1e3 * beyond:.3g} mm beyond the base tangent point of {other}, where it has no "
        f"involute (interference), so the path of contact {verb} there"
        for one, other, beyond, verb in (
            (wheel, pinion, -start, "begins"),
            (pinion, wheel, end - line, "ends"),
        )
        if beyond > 0.0
    ]
    return f"{said} (uncut {uncut:.4g}: {' and '.join(cuts)})" if cuts else said


def _frequencies(case: Case, j: int) -> str:
    found, frame = mesh_frequencies(case, j), rolling_frame(case, j)
    repeats = f"the same two teeth meet every {found.mesh_periods} mesh periods"
    if found.mesh == 0.0:
        return f"no speed is prescribed, so that no frequency is known; {repeats}"
    turning = ", ".join(f"{name} {f:.6g} Hz" for name, f in found.shafts.items())
    said = [f"mesh frequency {found.mesh:.6g} Hz", f"shafts {turning}"]
    if frame is not None:
        beside = ", ".join(f"{name} {f:.6g} Hz" for name, f in found.rotations.items())
        said.append(f"relative to {frame} {beside}")
    said.append("sidebands " + ", ".join(f"{found.mesh:.6g} +- {f:.6g} Hz" for f in found.rotations.values()))
    said.append(f"hunting tooth {found.hunting_tooth:.6g} Hz")
    said.append(f"common period {found.common_period:.6g} s ({found.mesh_periods} mesh periods)")
    return "; ".join(said)
