"""Spur pairs with a contact for each pair of teeth, and their pairs at given states, for tests."""

import math
from typing import Any

import numpy as np

import gearplay as gp
from building import Document, Floats, merged, mesh_at
from gearplay.model.pack import Packed
from gearplay.parts.mesh.geometry import P_D
from gearplay.parts.mesh.pairs.overlap import Pair, pair_overlap
from gearplay.parts.registry import MESH
from gearplay.toothing.gear import DrawnGear
from gearplay.toothing.pair import GearPair

MODULE = 4e-3
TEETH: Document = {"kind": "teeth", "method": "iso6336"}


def with_pairs(first: Document, second: Document, **mesh: Any) -> gp.Case:
    """Return a spur pair 20/60 of module 4 mm with backlash 0.1 mm; changes of both gears and of the mesh."""
    gear = {"mass": 1.0, "inertia": 1e-3, "facewidth": 0.02}
    usual = {"driver": "one", "driven": "two", "module": MODULE, "backlash": 1e-4}
    usual |= {"contact": "pairs", "stiffness": TEETH, "damping": {"ratio": 0.05}}
    return gp.load_case(
        {
            "rotors": {
                "one": {**gear, "teeth": 20, "drive": {"kind": "speed", "speed": 60.0}, **first},
                "two": {**gear, "teeth": 60, "load": {"torque": 100.0}, **second},
            },
            "meshes": [usual | mesh],
            "run": {"duration": 0.02},
        }
    )


def document_of(
    module: float, teeth: tuple[int, int], shifts: tuple[float, float], ring: bool, backlash: float, width: float, **more: Any
) -> Document:  # fmt: skip
    """Return two gears in mesh with pairs of teeth, at the distance at which their shifts leave no backlash."""
    gears = [
        DrawnGear(teeth=z, module=module, profile_shift=x, internal=ring and k == 1)
        for k, (z, x) in enumerate(zip(teeth, shifts, strict=True))
    ]
    distance = GearPair(*gears, math.nan).shifted_distance
    rotors = {
        name: {
            "teeth": teeth[k],
            "profile_shift": shifts[k],
            "facewidth": width,
            "mass": 1.0,
            "inertia": 1e-3,
            "position": [distance if (k == 0) == ring else 0.0, 0.0],
        }
        for k, name in enumerate(("one", "two"))
    }
    rotors["two"]["internal"] = ring
    found: Document = {
        "gravity": [0.0, 0.0],
        "rotors": rotors,
        "meshes": [
            {
                "driver": "one",
                "driven": "two",
                "module": module,
                "center_distance": distance,
                "backlash": backlash,
                "contact": "pairs",
                "stiffness": {"kind": "teeth", "method": "iso6336", "line_load": 1e6},
            }
        ],
        "run": {"duration": 6e-3, "transient": 0.0, "sampling": 1e6, "tolerance": 1e-10},
    }
    return merged(found, more)


def placed(packed: Packed, place: float, overlap: float) -> Floats:
    """Return a state with the pair of slot 0 at a place on the driver's path [m] and an overlap of the involutes [m]."""
    (mesh,) = packed.system.records[MESH]
    y = np.zeros(packed.state_size)
    for _ in range(3):
        out = mesh_at(packed, 0, y)
        pair = pair_overlap(mesh, packed.system, out, 0, 0)
        y[2] += (place - pair.place) / mesh.base_1
        out = mesh_at(packed, 0, y)
        y[5] += (overlap - out[P_D]) / (-mesh.s * mesh.base_2)
    return y


def pairs_at(packed: Packed, y: Floats, flank: int = 0) -> list[Pair]:
    """Return the pairs of a flank at a state."""
    (mesh,) = packed.system.records[MESH]
    out = mesh_at(packed, 0, y)
    return [pair_overlap(mesh, packed.system, out, flank, slot) for slot in range(mesh.pairs)]
