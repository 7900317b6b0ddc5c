"""Trains of 2 to 20 gears for the cost against the number of rotors."""

from itertools import pairwise

import numpy as np

import gearplay as gp

SIZES = (2, 3, 5, 8, 12, 20)


def _train(size, rotor, sleeve, mesh):
    names = [f"gear{i}" for i in range(size)]
    return gp.load_case(
        {
            "rotors": {name: rotor(i) for i, name in enumerate(names)},
            "sleeves": dict.fromkeys(names, sleeve),
            "meshes": [
                {"driver": a, "driven": b, "module": "4 mm", "pressure_angle": "20 deg", **mesh}
                for a, b in pairwise(names)
            ],
            "run": {"duration": "1 s", "transient": "0 s", "sampling": "1 kHz", "tolerance": 1e-6},
        }
    )


def rattling(size, seed):
    """Return an undriven train without losses whose gears all got the same mean energy."""
    rng = np.random.default_rng([size, seed])

    def rotor(_):
        v_x, v_y, spin = 0.02 * rng.standard_normal(3)
        x, y = 3e-5 * rng.standard_normal(2)
        return {
            "teeth": 20, "mass": "0.5 kg", "inertia": "3e-4 kg m^2",
            "initial": {"x": x, "y": y, "vx": v_x, "vy": v_y, "omega": spin / 0.0376},
        }  # fmt: skip

    sleeve = {
        "radial_clearance": "200 um",
        "law": "hunt-crossley",
        "stiffness": "1.5e11 N/m^1.5",
        "restitution": 1.0,
    }
    return _train(
        size, rotor, sleeve, {"backlash": "300 um", "stiffness": {"kind": "harmonic", "mean": "1.3e8 N/m"}}
    )


def loaded(size, _):
    """Return a driven train under load in linear bearings: every contact lasts."""

    def rotor(i):
        made = {"teeth": 20, "mass": "6.57 kg", "inertia": "0.0365 kg m^2", "radial_damping": "2000 N s/m"}
        if i == 0:
            made["drive"] = {"kind": "speed", "speed": "1000 rpm"}
        return made | ({"load": {"torque": "300 N m"}} if i == size - 1 else {})

    sleeve = {"radial_clearance": "0 um", "exponent": 1.0, "stiffness": "1e8 N/m", "restitution": 1.0}
    mesh = {
        "backlash": "200 um",
        "stiffness": {"kind": "harmonic", "mean": "3e8 N/m", "amplitude": "3e7 N/m"},
        "damping": {"ratio": 0.07, "depth": "1 um"},
    }
    return _train(size, rotor, sleeve, mesh)
