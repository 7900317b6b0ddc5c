"""A short case with wear of flanks and of a bush."""

from typing import Any

from building import Document, merged

K = 1e-16
"""Wear coefficient [m^2/N]."""


def wearing_pair(**changes: Any) -> Document:
    """Return a loaded pair 20/60 of module 4 mm with a contact for each pair of teeth; both flanks and the wheel's bush wear."""
    base: Document = {
        "title": "wearing pair",
        "rotors": {
            "one": {"teeth": 20, "mass": 0.4, "inertia": 2e-4, "facewidth": 0.01, "drive": {"kind": "speed", "speed": "600 rpm"}},
            "two": {"teeth": 60, "mass": 4.0, "inertia": 1e-2, "facewidth": 0.01, "load": {"torque": 60.0}},
        },
        "sleeves": {"two": {"radial_clearance": 20e-6, "stiffness": 1e10, "wear": {"coefficient": K, "length": 0.01}}},
        "meshes": [
            {
                "driver": "one",
                "driven": "two",
                "module": 4e-3,
                "backlash": 100e-6,
                "contact": "pairs",
                "wear": {"coefficient": K},
                "stiffness": {"kind": "teeth", "method": "iso6336"},
                "damping": {"ratio": 0.2},
            }
        ],
        "run": {"duration": 0.31, "transient": 0.1, "sampling": 2e4},
    }  # fmt: skip
    return merged(base, changes)
