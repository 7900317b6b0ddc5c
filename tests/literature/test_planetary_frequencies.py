"""Natural frequencies of planetary sets: J. Lin, R. G. Parker, J. Vib. Acoust. 121 (1999) 319, 3 planets, carrier at rest."""

import math

import numpy as np
import pytest
from scipy.optimize import curve_fit

from building import Document, Floats, Measured, case_of, merged
from gearplay.integrate.active_set import make_active_set
from gearplay.integrate.right_hand_side import make_loads, right_hand_side
from gearplay.integrate.switches import make_branch
from gearplay.kernels.layout import LOADED
from gearplay.solver.flow import Flow

SIMPLE = (1475.7, 1930.3, 2658.3, 7462.8, 11775.3)  # Hz, beside one rotation of the whole set
DOUBLE = (743.2, 1102.4, 1896.0, 2276.4, 6986.3, 9647.9)
ALPHA, MODULE, TEETH = math.radians(24.6), 4e-3, {"sun": 20, "planet": 20, "ring": 60}
CENTRE = 0.5 * MODULE * (TEETH["sun"] + TEETH["planet"])
SPAN = 2e-5  # s, less than half a period of the fastest mode
TORQUE = 100.0  # N m, on the sun
EXPECTED = np.sort([*SIMPLE, *DOUBLE, *DOUBLE])


def base(name: str) -> float:
    """Return a base radius [m]."""
    return 0.5 * MODULE * TEETH[name] * math.cos(ALPHA)


def planetary(model: str) -> Document:
    """Return the set of the paper in bearings of 1e8 N/m, the ring held by a torsional spring of 1e9 N/m on its base circle.

    All drive flanks are pressed together a little, as a load would do.
    """
    bearing = {"radial_clearance": 0.0, "exponent": 1.0, "stiffness": 1e8, "restitution": 1.0}
    moved = {"x": 1e-9, "y": 2e-9}  # off the centre, where the direction of a bearing's force has no slope
    rotors = {
        "sun": {
            "teeth": 20,
            "mass": 0.4,
            "inertia": 0.39 * base("sun") ** 2,
            "initial": {"theta": 4e-5, **moved},
        },
        "ring": {"teeth": 60, "internal": True, "mass": 2.35, "inertia": 3.0 * base("ring") ** 2},
        "carrier": {"mass": 5.43, "inertia": 6.29 * CENTRE**2},
        "ground": {"mass": 1.0, "inertia": 1.0, "drive": {"kind": "speed", "speed": 0.0}},
    }
    rotors["sun"]["drive"] = {"kind": "torque", "torque": 1e-6}  # says which flanks drive
    for name in ("ring", "carrier"):
        rotors[name] |= {"position": [0.0, 0.0], "initial": {"theta": 0.0, **moved}}
    sleeves = {name: dict(bearing) for name in ("sun", "ring", "carrier")}
    stiffness = {"kind": "harmonic", "mean": 5e8}
    mesh = {"module": MODULE, "pressure_angle": ALPHA, "backlash": 1e-4, "stiffness": stiffness}
    meshes = []
    for k in range(3):
        angle, name = 2.0 * math.pi * k / 3, f"planet{k}"
        rotors[name] = {
            "teeth": 20,
            "mass": 0.66,
            "inertia": 0.61 * base("planet") ** 2,
            "position": [CENTRE * math.cos(angle), CENTRE * math.sin(angle)],
            "initial": {"theta": -2e-5, **moved},
        }
        sleeves[name] = {**bearing, "on": "carrier"}
        meshes += [{"driver": "sun", "driven": name, **mesh}, {"driver": name, "driven": "ring", **mesh}]
    rotors["sun"]["position"] = [0.0, 0.0]
    support = {"between": ["ring", "ground"], "torsional_stiffness": 1e9 * base("ring") ** 2}
    return {
        "backlash_model": model,
        "rotors": rotors,
        "sleeves": sleeves,
        "meshes": meshes,
        "couplings": [support],
        "run": {"duration": 1e-3, "sampling": 1e5, "tolerance": 1e-11},
    }


@pytest.mark.parametrize("model", ["coupled", "uncoupled"])
def test_lin_and_parker_three_planets(model: str, measured: Measured) -> None:
    """All 17 vibrations within 0.1 %, from the exact derivative of the motion over 20 us."""
    flow = Flow(case_of(planetary(model)))
    changes = np.zeros((len(flow.free), flow.size + flow.impact_count))
    changes[np.arange(len(flow.free)), flow.free] = 1.0
    found = flow.go(flow.start(), SPAN, changes=changes)
    drive = [k for k, label in enumerate(flow.packed.contact_labels) if label.endswith(":drive")]
    assert np.all(found.closed[drive])
    matrix = (
        found.changes[:, flow.free] * np.outer(flow.natural[flow.free], 1.0 / flow.natural[flow.free])
    ).T
    angles = np.abs(np.angle(np.linalg.eigvals(matrix))) / SPAN / (2.0 * math.pi)
    frequencies = np.sort(angles[angles > 100.0])[::2]
    assert len(frequencies) == len(EXPECTED)
    worst = float(np.max(np.abs(frequencies / EXPECTED - 1.0)))
    measured(f"Lin & Parker, 3 planets, {model}", worst, "1e-3")
    assert worst < 1e-3


def accelerations(flow: Flow, q: Floats) -> Floats:
    """Return the accelerations at displacements q, everything at rest, all bearings and drive flanks pressed."""
    system, labels = flow.packed.system, flow.packed.contact_labels
    branch, loads = make_branch(system), make_loads(system)
    branch.impact_speeds[:] = 1.0
    branch.modes[: len(labels)] = [0 if label.endswith(":back") else LOADED for label in labels]
    y, dy = np.concatenate([q, np.zeros(q.size)]), np.zeros(2 * q.size)
    assert right_hand_side(system, make_active_set(system, y.size), 0.0, y, branch, dy, loads) == 0
    return dy[q.size :]


def loaded_set(model: str) -> Flow:
    """Return the set with a torque on its sun and the carrier's that balances it."""
    torques = {"sun": TORQUE, "carrier": -TORQUE * (1.0 + TEETH["ring"] / TEETH["sun"])}
    drives = {name: {"drive": {"kind": "torque", "torque": torque}} for name, torque in torques.items()}
    return Flow(case_of(merged(planetary(model), {"rotors": drives})))


@pytest.mark.slow
@pytest.mark.parametrize("model", ["coupled", "uncoupled"])
def test_lin_and_parker_three_planets_ring(model: str, measured: Measured) -> None:
    """Every vibration rung by itself beside the loaded set at rest: its frequency over 12 periods within 0.1 %.

    The shapes come from differences of the forces; that a shape rings at one frequency is part of the test.
    """
    flow = loaded_set(model)
    half = flow.size // 2
    free, natural = flow.free[flow.free < half], flow.natural[flow.free[flow.free < half]]
    rest, matrix = np.zeros(half), np.zeros((len(free), len(free)))
    for _ in range(3):
        for at, c in enumerate(free):
            away = np.eye(half)[c] * 1e-5 * natural[at]
            change = accelerations(flow, rest + away) - accelerations(flow, rest - away)
            matrix[:, at] = change[free] / (2e-5 * natural[at])
        rest[free] -= np.linalg.lstsq(matrix, accelerations(flow, rest)[free], rcond=1e-9)[0]
    squares, shapes = np.linalg.eig(matrix * np.outer(1.0 / natural, natural))
    found = []
    for r in np.argsort(-squares.real)[1:]:  # all but the rotation of the whole set
        shape, guess = np.real(shapes[:, r]), math.sqrt(-squares[r].real)
        y = np.concatenate([rest, np.zeros(half)])
        y[free] += 1e-5 * natural * shape / np.max(np.abs(shape))
        course = flow.begin(y)
        times, motion = np.linspace(0.0, 24.0 * math.pi / guess, 241), []
        for t in times:
            if t > 0.0:
                course.advance(float(t))
            motion.append(float(shape @ ((course.state[:half] - rest)[free] / natural)))

        def swing(t: Floats, a: float, b: float, w: float) -> Floats:
            return a * np.cos(w * t) + b * np.sin(w * t)

        (a, b, w), _ = curve_fit(swing, times, motion, (motion[0], 0.0, guess))
        assert np.max(np.abs(swing(times, a, b, w) - motion)) < 0.01 * abs(motion[0])
        found.append(w / (2.0 * math.pi))
    worst = float(np.max(np.abs(np.sort(found) / EXPECTED - 1.0)))
    measured(f"Lin & Parker, 3 planets ring, {model}", worst, "1e-3")
    assert worst < 1e-3
