"""Tables of a case for notebooks: rotors with drives and loads, meshes, sleeves."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

from gearplay.parts.mesh.train import rolling
from gearplay.parts.mesh.train.geometry import toothings, working_backlash, working_distance

if TYPE_CHECKING:
    from gearplay.model.case import Case


def case_html(case: Case) -> str:
    """Return the parts of a valid case as a table of HTML, in the units of engineers."""
    import html

    lines = [f"<tr>{''.join(f'<td>{html.escape(cell)}</td>' for cell in row)}</tr>" for row in _rows(case)]
    return f"<p><b>{html.escape(case.title or 'untitled case')}</b></p><table>{''.join(lines)}</table>"


def _rows(case: Case) -> Iterator[tuple[str, str]]:
    speeds = rolling.nominal_speeds(case) * 30.0 / math.pi
    for (name, rotor), speed in zip(case.rotors.items(), speeds.tolist(), strict=True):
        teeth = ", ".join(f"{gear.teeth} teeth" for gear in toothings(case, name).values() if gear.teeth)
        words = [teeth, f"{rotor.mass:.4g} kg, {rotor.inertia:.4g} kg m^2", f"{speed:.5g} rpm"]
        words += [] if rotor.drive is None else [f"{rotor.drive.kind} drive"]
        words += [f"load {rotor.load.torque:.4g} N m"] if rotor.load.torque else []
        yield name, "; ".join(filter(None, words))
    for j, mesh in enumerate(case.meshes):
        distance, backlash = 1e3 * working_distance(case, j), 1e6 * working_backlash(case, j)
        yield (
            mesh.label,
            f"module {1e3 * mesh.module:.4g} mm, backlash {backlash:.4g} um, centres {distance:.6g} mm apart",
        )
    for name, sleeve in case.sleeves.items():
        yield f"sleeve of {name}", f"radial clearance {1e6 * sleeve.radial_clearance:.4g} um"
    for _, label, joint in case.named_joints():
        yield label, joint.summary
