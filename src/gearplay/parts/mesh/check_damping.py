"""Findings about tooth damping: depth of the ramp relative to the deflection under load."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Final

from gearplay.parts.mesh.flank import damping_ramp
from gearplay.parts.mesh.tooth_deflections import (
    LEAST_DEPTH,
    UNKNOWN_LOAD_DEPTH,
    damping_depths,
    tooth_deflections,
)
from gearplay.parts.mesh.tooth_loads import tooth_loads
from gearplay.schema.finding import Finding

if TYPE_CHECKING:
    from gearplay.parts.mesh.schema import Mesh
    from gearplay.parts.mesh.train.train import Train

HALF: Final = 0.5
"""Share of the full damping under load below which a depth is too large."""
STEEP: Final = 0.05
"""Depth over the deflection under load below which a ramp is nearly a jump."""


def damping_findings(case: Train) -> Iterator[Finding]:
    """Yield findings about the tooth damping of a valid case under its load; equal texts of several meshes once."""
    case = case.operating
    loads, deflections, depths = tooth_loads(case), tooth_deflections(case), damping_depths(case)
    found: dict[tuple[str, str], list[int]] = {}
    for j, mesh in enumerate(case.meshes):
        if mesh.damping.law == "ramp" and (mesh.damping.maximum or mesh.damping.ratio):
            finding = _finding(mesh, float(loads[j]), float(deflections[j]), float(depths[j]))
            if finding is not None:
                found.setdefault(finding, []).append(j)
    for (severity, words), meshes in found.items():
        where = ""
        if len(case.meshes) > 1:
            labels = [case.meshes[j].label for j in meshes]
            where = f" ({', '.join(labels[:3])}{', ...' if len(labels) > 3 else ''})"
        yield Finding(severity, f"meshes.{meshes[0]}.damping", words.replace("{where}", where))  # type: ignore[arg-type]


def _finding(mesh: Mesh, load: float, deflection: float, depth: float) -> tuple[str, str] | None:
    """Return severity and message, with ``{where}`` for the meshes; None without a finding."""
    given, full = mesh.damping.depth is not None, f"{1e6 * depth:.3g} um"
    if load == 0.0:
        if given:
            return None
        return "note", (
            f"without a constant load the damping{{where}} is full from {1e6 * UNKNOWN_LOAD_DEPTH:g} um of penetration on. "
            "Give damping.depth if that does not suit the motion."
        )
    pressed = f"the steady load of {load:.4g} N presses the teeth{{where}} {1e6 * deflection:.3g} um into each other"
    share = 1.0 if mesh.damping.ramp == "literal" else float(damping_ramp(deflection / depth, 0))
    if share < HALF:
        least = "" if given else ", the least that is taken,"
        now = (
            f"{share:.2g} of its maximum"
            if mesh.damping.ratio is None
            else f"a ratio of {share * mesh.damping.ratio:.2g}, not {mesh.damping.ratio:g}"
        )
        cure = "Leave damping.depth out" if given else "Give a smaller damping.depth"
        loaded = deflection >= LEAST_DEPTH  # else the teeth rattle, and impacts are what is damped
        return "warning" if loaded else "note", (
            f"{pressed}, the depth of full damping{least} is {full}: under that load the damping is {now}. "
            f'{cure}, or take law = "constant", unless only impacts are to be damped.'
        )
    if given and depth < STEEP * deflection:
        return "warning", (
            f"{pressed}, {deflection / depth:.3g} times the depth of full damping, {full}: the damping nearly jumps in. "
            'Leave damping.depth out, or take law = "constant".'
        )
    return None if given else ("note", f"{pressed}; the damping is full from {full} on.")
