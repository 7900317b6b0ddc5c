"""Indicators of a loaded pair of gears with a cracked tooth, over the depth of the crack."""

import math
from itertools import pairwise

import numpy as np

from building import Document, Floats, merged, simulate_one
from gearplay.signals import gear_indicators, split_average
from laws.test_gear_faults import document

TURN = 0.05
SAMPLING = 4e4
NOISE = 0.01
"""Standard deviation of the noise of the average over that of the average."""
DRAWS = 50
DEPTHS = (0.5e-3, 1.0e-3, 1.5e-3, 2.0e-3, 2.5e-3)


def one_turn(faults: list[Document]) -> Floats:
    """Return the displacement of the wheel across the line of centres over one turn of the pinion [m], shape [sample]."""
    relief = {"amount": 15e-6, "length": 4e-3}
    found = document(faults)
    found["meshes"][0]["damping"] = {"kind": "constant", "value": 2000.0}
    loaded = {
        "rotors": {
            "one": {"tip_relief": relief, "drive": {"kind": "speed", "speed": 2.0 * math.pi / TURN}},
            "two": {"tip_relief": relief, "mass": 3.0, "inertia": 2e-2, "load": {"torque": 180.0}},
        },
        "supports": {name: {"stiffness": [1e8, 1e8], "damping": [2e3, 2e3]} for name in ("one", "two")},
        "run": {"duration": 2.02 * TURN, "sampling": SAMPLING, "tolerance": 1e-8},
    }
    samples = round(TURN * SAMPLING)
    return simulate_one(merged(found, loaded)).signal("y", "two")[samples : 2 * samples]


def test_indicators__rise_with_the_depth_of_a_crack() -> None:
    """Means over draws of noise rise by more than three standard errors from depth to depth; the kurtosis does not see it."""
    rng = np.random.default_rng(49)
    names = ("fm4", "m6a", "m8a", "energy_ratio")
    seen, kurtosis = [], []
    for depth in DEPTHS:
        turn = one_turn([{"kind": "crack", "at": "one", "tooth": 8, "depth": depth}])
        rows = []
        for _ in range(DRAWS):
            noisy = turn + NOISE * np.std(turn) * rng.standard_normal(turn.size)
            found = gear_indicators(noisy, 20)
            rows.append(
                [getattr(found, name) for name in names]
                + [float(np.std(split_average(noisy, 20).difference))]
            )
        seen.append((np.mean(rows, axis=0), np.std(rows, axis=0, ddof=1) / math.sqrt(DRAWS)))
        kurtosis.append(gear_indicators(turn, 20).kurtosis)
    for (mean, error), (higher, its_error) in pairwise(seen):
        assert np.all(higher - mean > 3.0 * np.hypot(error, its_error))
    assert np.ptp(kurtosis) < 0.01 * kurtosis[0]
