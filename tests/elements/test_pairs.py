"""Random meshes with pairs of teeth for the tests of all elements; their forces against the energy of constant stiffness."""

import math

import numpy as np

from building import Document, Floats, Measured, mesh_at
from elements.test_elements import Scene
from gearplay.parts.mesh.pairs.overlap import TIP_OF_1, TIP_OF_2, pair_overlap
from gearplay.parts.registry import MESH


def sample(rng: np.random.Generator, *, damped: bool = True, plain: bool = False) -> Document:
    """Return an external or internal pair, of which either gear drives, on the ground or on a carrier that turns."""
    internal, carried, first_drives = (bool(rng.integers(2)) for _ in range(3))
    sleeve = {"radial_clearance": 1e-4, "stiffness": 1e9, "restitution": 0.9, "law": "hunt-crossley"}
    method = "iso6336" if rng.random() < 0.7 or plain else "potential-energy"
    helix = 0.0 if method == "potential-energy" or rng.random() < 0.7 else math.radians(12.0)
    rotors: dict[str, Document] = {
        "small": {"teeth": 20, "mass": 0.4, "inertia": 2e-4, "facewidth": 0.01, "bore": 0.03},
        "large": {"teeth": 60, "internal": internal, "mass": 1.0, "inertia": 5e-3, "facewidth": 0.012},
    }
    if not internal:
        rotors["large"]["bore"] = 0.06
    rotors["large"]["profile_shift"] = 0.3 if internal else 0.1
    for each in rotors.values():
        each["helix_angle"] = helix
    driver, driven = ("small", "large") if first_drives else ("large", "small")
    rotors[driver]["initial"] = {"omega": float(rng.choice([-1.0, 1.0]) * rng.uniform(1.0, 5.0))}
    sleeves = {"small": dict(sleeve), "large": dict(sleeve)}
    if carried:
        rotors["carrier"] = {"mass": 1.0, "inertia": 5e-3, "position": [0.0, 0.0]}
        sleeves["small"]["on"] = "carrier"
    errors = [] if plain else [{"order": 1, "amplitude": 5e-6, "phase": 0.4}]
    if not plain:
        rotors["small"]["runout"] = {"amplitude": 2e-5, "phase": float(rng.uniform(0.0, 6.0))}
        rotors["large"]["load"] = {"torque": float(rng.uniform(0.0, 5.0))}
    faults: list[Document] = []
    if not plain:
        for each in rotors.values():
            if "teeth" in each and rng.random() < 0.5:
                relief = {"amount": 5e-6, "length": 2e-3, "shape": str(rng.choice(["linear", "parabolic"]))}
                each |= {"tip_relief": relief, "quality": int(rng.integers(4, 9))}
        for name, teeth in (("small", 20), ("large", 60)):
            if rng.random() < 0.4:
                shaped = helix == 0.0
                faults += _faults(name, teeth, internal and name == "large") if shaped else [_worn(name)]
    constant = bool(rng.integers(2))
    law: Document = {"law": "constant"} if constant else {"depth": 2e-5}
    return {
        "gravity": [0.0, 0.0] if plain else [0.0, -9.81],
        "mesh_phases": "from_zero",
        "rotors": rotors,
        "sleeves": sleeves,
        "faults": faults,
        "meshes": [
            {
                "driver": driver,
                "driven": driven,
                "module": 4e-3,
                "pressure_angle": math.radians(20.0),
                "backlash": float(rng.uniform(2e-5, 1e-4)),
                "contact": "pairs",
                "tip_contact": bool(rng.random() < 0.8),
                "stiffness": {"kind": "teeth", "method": method, "line_load": 1e6},
                "transmission_error": errors,
                "phase": float(rng.uniform(0.0, 2.0 * math.pi)),
                "damping": {"maximum": 300.0 if damped else 0.0, **law},
                "friction_coefficient": 0.1 if damped and rng.random() < 0.6 else 0.0,
                "friction_speed": 0.02,
            }
        ],
        "run": {"duration": 0.01, "sampling": 1e4},
    }


def _faults(name: str, teeth: int, internal: bool) -> list[Document]:
    """Return a fault of each kind that has a shape, on all teeth in turn."""
    shapes: list[Document] = [
        {"kind": "spall", "depth": 8e-6, "start": 0.3, "end": 0.7, "flank": "both"},
        {"kind": "chip", "share": 0.4, "height": 0.5},
    ]
    if not internal:
        shapes.append({"kind": "crack", "depth": 2e-3})
    found = [{**shapes[tooth % len(shapes)], "at": name, "tooth": tooth} for tooth in range(min(teeth, 20))]
    profile = [[0.0, 6e-6], [0.2, 2e-6], [0.45, 0.0], [0.8, 3e-6], [0.95, 1e-6]]
    worn = {"kind": "wear", "at": name, "flank": "left", "profile": profile}
    return [*found, worn, _worn(name)]


def _worn(name: str) -> Document:
    return {"kind": "wear", "at": name, "depth": 4e-6, "flank": "both"}


def carried(document: Document, sign: float, angle: float) -> Document:
    """Mirror the phase of the mesh."""
    (mesh,) = document["meshes"]
    return {**document, "meshes": [{**mesh, "phase": sign * mesh["phase"]}]}


def _energy(scene: Scene, y: Floats) -> tuple[float, bool]:
    """Return the elastic energy [J] of the pairs that touch at a state, and whether a corner does."""
    (mesh,) = scene.system.records[MESH]
    out, total, corners = mesh_at(scene.packed, 0, y), 0.0, False
    for flank in range(2):
        for slot in range(mesh.pairs):
            pair = pair_overlap(mesh, scene.system, out, flank, slot)
            if scene.branch.modes[mesh.contact + 2 + flank * mesh.pairs + slot]:
                total += 0.5 * scene.system.spline[0, 1] * pair.p**2
                corners |= pair.touching in (TIP_OF_1, TIP_OF_2)
    return total, corners


def test_pairs__press_along_the_gradient_of_their_energy(measured: Measured) -> None:
    """With one stiffness along the path -dV/dq are the forces, of corners too."""
    worst, corners = 0.0, 0
    for seed in range(40):
        rng = np.random.default_rng([23, seed])
        document = sample(rng, damped=False, plain=True)
        document["rotors"]["small"]["helix_angle"] = document["rotors"]["large"]["helix_angle"] = 0.0
        scene = Scene(document, "pairs", rng, depth=3.0)
        scene.system.spline[:, 2:] = 0.0
        scene.decide(scene.y)
        force, _ = scene.forces(scene.y)
        value, cornered = _energy(scene, scene.y)
        corners += cornered
        for c in range(3 * scene.n):
            if c in scene.held:
                continue
            h = 1e-4 * scene.packed.natural[c]
            ends = [_energy(scene, scene.y + s * h * np.eye(scene.y.size)[c])[0] for s in (1.0, -1.0)]
            off = abs((ends[0] - ends[1]) / (2.0 * h) + force.ravel()[c])
            worst = max(worst, off * scene.packed.natural[c] / (value + 1e-12))
    measured("pairs of teeth: force against energy", worst, "1e-6")
    assert worst < 1e-6
    assert corners >= 3
