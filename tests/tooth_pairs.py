"""A spur pair with a contact for each pair of teeth, for tests."""

from typing import Any

import gearplay as gp
from building import Document

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
