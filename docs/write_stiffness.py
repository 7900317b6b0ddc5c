"""The table of mean mesh stiffnesses of docs/teeth.md: both methods of five pairs beside c_gamma of ISO 6336-1."""

from typing import Any

import gearplay as gp
from gearplay.parts.mesh.train.geometry import installed_pair
from gearplay.toothing.iso6336 import mean_factor, single_stiffness
from gearplay.toothing.path_stiffness import by_size

PAIRS: tuple[tuple[float, tuple[int, float, float], tuple[int, float, float]], ...] = (
    (2.0, (62, 0.0, 35.0), (62, 0.0, 35.0)),
    (4.0, (20, 0.0, 30.0), (60, 0.0, 60.0)),
    (3.0, (23, 0.3, 25.0), (34, 0.1, 30.0)),
    (21.0, (18, 0.389, 150.0), (36, 0.504, 300.0)),
    (3.0, (24, 0.2, 30.0), (71, 0.1, 80.0)),
)
"""Module [mm]; teeth, profile shift and bore [mm] of both gears, of steel, teeth 20 mm wide."""
WIDTH = 20.0


def document(
    module: float, first: tuple[int, float, float], second: tuple[int, float, float], method: str
) -> dict[str, Any]:
    """Return a case of a pair at the distance at which its shifts leave no backlash."""
    gear = {"mass": "1 kg", "inertia": "1e-3 kg m^2", "facewidth": f"{WIDTH} mm"}
    rotors = {
        name: gear | {"teeth": z, "profile_shift": x, "bore": f"{bore} mm"}
        for name, (z, x, bore) in (("one", first), ("two", second))
    }
    mesh = {"driver": "one", "driven": "two", "module": f"{module} mm", "backlash": "0 m"}
    return {
        "rotors": rotors,
        "meshes": [mesh | {"stiffness": {"kind": "teeth", "method": method}}],
        "run": {"duration": "10 ms"},
    }


def rows() -> list[tuple[str, float, float, float]]:
    """Return the name of each pair and its mean K per facewidth by potential energy, by iso6336, and c_gamma [N/(mm um)]."""
    found = []
    for module, first, second in PAIRS:
        means = []
        for method in ("potential-energy", "iso6336"):
            case = gp.load_case(document(module, first, second, method))
            means.append(1e-6 * gp.teeth(case).values["mean_stiffness"] / WIDTH)
        pair = installed_pair(case, 0)
        c_gamma = single_stiffness(*by_size(pair.first, pair.second)) * mean_factor(pair.contact_ratio)
        shifts = f", x {first[1]:g}/{second[1]:g}" if first[1] or second[1] else ""
        name = f"{first[0]}/{second[0]}, {module:g}{shifts}, {first[2]:g}/{second[2]:g}"
        found.append((name, *means, c_gamma))
    return found


def table() -> str:
    """Return the table as Markdown."""
    lines = [
        "| pair, module, shifts, bores [mm] | potential energy [N/(mm µm)] | iso6336 | c_gamma of ISO 6336-1 |",
        "|---|---:|---:|---:|",
    ]
    return "\n".join([*lines, *(f"| {name} | {a:.1f} | {b:.1f} | {c:.1f} |" for name, a, b, c in rows())])


if __name__ == "__main__":
    print(table())
