"""Small data-set plans for tests."""

from typing import Any

FEW: dict[str, Any] = {
    "title": "few",
    "case": "han2021",
    "set": {"run.duration": 0.02, "run.transient": 0.0},
    "rig": {"collector": {"sampling": "20 kHz"}},
    "seed": 5,
    "members": 2,
    "classes": [
        {"label": "normal"},
        {
            "label": "worn",
            "set": {"sleeves.ring.radial_clearance": "150 um"},
            "draws": [
                {
                    "name": "clearance",
                    "path": "sleeves.ring.radial_clearance",
                    "distribution": "log-uniform",
                    "low": "120 um",
                    "high": "300 um",
                }
            ],
        },
    ],
    "axes": [{"name": "drag", "path": "rotors.ring.load.drag", "mode": "scale", "values": [1.0, 2.0]}],
    "design": {
        "count": 5,
        "seed": 3,
        "parameters": [{"name": "backlash", "path": "meshes.0.backlash", "low": "60 um", "high": "200 um"}],
    },
    "draws": [{"name": "speed", "path": "rotors.pinion.drive.speed", "low": "60 rpm", "high": "180 rpm"}],
}
RECORDS = 2 * 2 * 5 * 2
