"""A floating ring may travel round its pinion: the turning of the vector of centres has no jump at half a turn."""

import math

import numpy as np

from building import case_of, merged, pair_document
from gearplay.solver.simulate import run_members


def test_a_ring_may_orbit_its_pinion() -> None:
    """A hula hoop: the ring's centre circles the held pinion's; backlash stays within its bounds all the way round."""
    document = merged(
        pair_document("internal"),
        {
            "sleeves": None,
            "rotors": {"ring": {"floating": True}},
            "run": {"duration": 0.5, "sampling": 2000.0},
        },
    )
    document["sleeves"] = {}
    document["rotors"]["ring"]["floating"] = True
    distance = 0.5 * 4e-3 * (60 - 20)
    document["rotors"]["ring"]["initial"] = {"vy": -2.0, "omega": 2.0 / distance, "theta": 0.0}
    document["rotors"]["pinion"]["drive"] = {"kind": "speed", "speed": 2.0 / distance}
    run = run_members(case_of(document), [0])[0]
    assert run.success, run.message
    x, y = run.signal("x", "ring"), run.signal("y", "ring")
    angle = np.unwrap(np.arctan2(-y, distance - x))
    assert abs(angle[-1]) > 2.5 * math.pi, "it really goes round"
    for signal in ("drive_penetration", "back_penetration"):
        assert np.max(run.signal(signal, "pinion-ring")) < 1e-3
    assert np.max(np.abs(np.diff(run.signal("transmission_error_dynamic", "pinion-ring")))) < 1e-3
