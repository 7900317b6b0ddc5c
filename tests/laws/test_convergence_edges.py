"""Errors of non-smooth motions fall in proportion to the tolerance, and are as large as the motion itself makes them."""

import numpy as np
import pytest

import gearplay as gp
from building import Document
from depth import sized
from gearplay.model.initial import Starts
from gearplay.model.pack import pack
from gearplay.solver.integration import Course

Floats = np.ndarray
SPAN = 2.5e-3
ENLARGED = 300.0
"""How much larger than one allowed error, grown as the motion grows it, the sum of a motion's errors may be."""


def rocking_pair(rng: np.random.Generator) -> Document:
    """Return a free pair on a housing that shakes with 1000 m/s^2; teeth rock about an edge of their square stiffness."""
    single = float(10.0 ** rng.uniform(7.5, 8.5))
    backlash, teeth = float(rng.choice([1e-5, 5e-5])), rng.integers(18, 60, 2)
    phase = float(rng.uniform(-1e-4, 1e-4))  # rad, of the edge where they start
    stiffness = {"kind": "square", "single": single, "double": 1.6 * single, "phase": phase}
    start = float(rng.uniform(0.1, 0.9)) * backlash / (teeth[1] * 0.94e-3)
    sleeve = {"radial_clearance": float(rng.choice([1e-5, 5e-5])), "stiffness": 1e10, "restitution": 0.9}
    angle, frequency = float(rng.uniform(0.0, 6.28)), float(10.0 ** rng.uniform(2.0, 3.0))
    return {
        "rotors": {
            "a": {
                "teeth": int(teeth[0]),
                "mass": float(rng.uniform(0.2, 1.0)),
                "inertia": float(10.0 ** rng.uniform(-4.0, -3.0)),
                "initial": {"theta": 0.0, "omega": 0.0},
            },
            "b": {
                "teeth": int(teeth[1]),
                "mass": float(rng.uniform(0.2, 1.5)),
                "inertia": float(10.0 ** rng.uniform(-4.0, -2.5)),
                "initial": {"theta": start, "omega": 0.0},
            },
        },
        "sleeves": {"a": sleeve, "b": {**sleeve, "radial_clearance": 2e-5, "stiffness": 2e10}},
        "meshes": [
            {"driver": "a", "driven": "b", "module": 2e-3, "backlash": backlash, "stiffness": stiffness}
        ],
        "base": {
            "acceleration": {
                "kind": "harmonic",
                "amplitude": 1000.0,
                "frequency": frequency,
                "direction": angle,
            }
        },
        "run": {"duration": SPAN, "sampling": 1e4},
    }


def end_of(document: Document, tolerance: float, *, moved: float = 0.0) -> Floats:
    """Return the state at the end in units of its natural sizes, a's centre ``moved`` [m] at the start."""
    case = gp.load_case(document | {"run": document["run"] | {"tolerance": tolerance}})
    packed = pack(case, span=SPAN)
    start = Starts(case, packed).of_member(0).copy()
    start[0] += moved
    course = Course(case, packed, start)
    course.advance(SPAN)
    return course.state / packed.natural


@pytest.mark.slow
def test_error__is_the_tolerance_times_the_growth_of_the_motion() -> None:
    """200 pairs that rock on an edge of a square stiffness, some 30 events each: in proportion over four decades."""
    for seed in range(sized(200, 12)):
        document = rocking_pair(np.random.default_rng([9, seed]))
        exact = end_of(document, 1e-13)
        growth = float(np.abs(end_of(document, 1e-13, moved=1e-12) - exact).max()) / 1e-8
        for tolerance in (1e-11, 1e-9, 1e-8):
            error = float(np.abs(end_of(document, tolerance) - exact).max())
            assert error <= ENLARGED * tolerance * max(growth, 1.0), (seed, tolerance)
