"""A planetary set as a plain document, for tests."""

from typing import Any

from building import Document, merged

PART = {"mass": 1.0, "inertia": 2e-3}


def planetary_document(**changes: Any) -> Document:
    """Return a case of a set 20/20/60 of module 4 mm with three planets on elastic pins, sun driven, ring fixed."""
    stage: Document = {
        "module": 4e-3,
        "backlash": 8e-5,
        "stiffness": {"kind": "harmonic", "mean": 3e8, "amplitude": 3e7},
        "damping": {"ratio": 0.05},
        "sun": {"teeth": 20, "drive": {"kind": "speed", "speed": 60.0}, **PART},
        "planets": {"count": 4, "teeth": 20, **PART},
        "ring": {"teeth": 60, "fixed": True, **PART},
        "carrier": {**PART, "load": {"torque": 40.0}},
        "support": {"stiffness": [2e8, 2e8], "damping": [2e3, 2e3]},
    }
    return {"planetary": {"stage": merged(stage, changes)}, "run": {"duration": 0.01, "sampling": 1e4}}
