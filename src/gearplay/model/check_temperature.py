"""Findings about the backlash that is left at the coldest and the hottest temperature of a case."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

from gearplay.model.reading import replace
from gearplay.parts.mesh.allowance_range import backlash_range
from gearplay.parts.mesh.train import geometry
from gearplay.schema.finding import Finding

if TYPE_CHECKING:
    from gearplay.model.case import Case

ICE = 273.15


def temperature_findings(case: Case) -> Iterator[Finding]:
    """Yield the remaining backlash at both ends of ``environment.temperature_range``, a warning if there is none."""
    if case.environment is None or case.environment.temperature_range is None:
        return
    ends = case.environment.temperature_range
    hot = {end: replace(case, {"environment.temperature": end}).operating for end in ends}
    for j, mesh in enumerate(case.meshes):
        normal = math.cos(geometry.pair_of(case, j).first.base_helix)
        middle = geometry.installed_backlash(case, j) * normal
        limits = backlash_range(case, j)
        words, least = [], math.inf
        for end, found in hot.items():
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
