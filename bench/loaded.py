"""Four loaded problems: bearings and flanks that stay pressed, which is what most drives do."""

import math
import time

import numpy as np

import gearplay as gp
from gearplay.kernels import run as kernel
from gearplay.solver.compiling import prepare
from gearplay.solver.flow import Flow

DURATION = 0.1
"""Of each problem [s], after ``LEAD`` of running in."""
LEAD = 0.3
TOLERANCES = (1e-3, 1e-6, 1e-9)
REPEATS = 5


def external_pair():
    """Return the bundled pair in linear bearings under 300 N m."""
    return gp.load_case("external-pair")


def chain():
    """Return the bundled pinion, idler and ring, lightly loaded: flanks that part and meet again."""
    return gp.load_case("pinion-idler-ring")


def article_pair():
    """Return the article's internal pair under gravity and 1 N m."""
    return gp.load_case("han2021", ["gravity.1=-9.81", "rotors.ring.load.torque=1"])


def planetary_set():
    """Return three planets between a driven sun, a ring on a torsional spring and a loaded carrier, bearings with play.

    Masses of J. Lin, R. G. Parker, J. Vib. Acoust. 121 (1999) 319.
    """
    module, alpha = 4e-3, math.radians(24.6)
    centre = 0.5 * module * 40
    base = {
        name: 0.5 * module * teeth * math.cos(alpha)
        for name, teeth in {"sun": 20, "planet": 20, "ring": 60}.items()
    }
    bearing = {"radial_clearance": 5e-6, "exponent": 1.0, "stiffness": 1e8, "restitution": 0.8}
    rotors = {
        "sun": {
            "teeth": 20,
            "mass": 0.4,
            "inertia": 0.39 * base["sun"] ** 2,
            "drive": {"kind": "speed", "speed": "1000 rpm", "ramp": "20 ms"},
        },
        "ring": {
            "teeth": 60,
            "internal": True,
            "mass": 2.35,
            "inertia": 3.0 * base["ring"] ** 2,
            "position": [0.0, 0.0],
        },
        "carrier": {
            "mass": 5.43,
            "inertia": 6.29 * centre**2,
            "position": [0.0, 0.0],
            "load": {"torque": "100 N m"},
        },
        "ground": {"mass": 1.0, "inertia": 1.0, "drive": {"kind": "speed", "speed": 0.0}},
    }
    rotors["sun"]["position"] = [0.0, 0.0]
    sleeves = {name: dict(bearing) for name in ("ring", "carrier")}
    mesh = {
        "module": module,
        "pressure_angle": alpha,
        "backlash": 1e-4,
        "stiffness": {"kind": "harmonic", "mean": 5e8, "amplitude": 5e7},
        "damping": {"ratio": 0.05},
    }
    meshes = []
    for k in range(3):
        angle, name = 2.0 * math.pi * k / 3, f"planet{k}"
        rotors[name] = {
            "teeth": 20,
            "mass": 0.66,
            "inertia": 0.61 * base["planet"] ** 2,
            "position": [centre * math.cos(angle), centre * math.sin(angle)],
        }
        sleeves[name] = {**bearing, "on": "carrier"}
        meshes += [{"driver": "sun", "driven": name, **mesh}, {"driver": name, "driven": "ring", **mesh}]
    support = {
        "between": ["ring", "ground"],
        "torsional_stiffness": 1e9 * base["ring"] ** 2,
        "torsional_damping": 65.0,
    }
    return gp.load_case(
        {
            "rotors": rotors,
            "sleeves": sleeves,
            "meshes": meshes,
            "couplings": [support],
            "run": {"duration": DURATION, "transient": LEAD, "sampling": "50 kHz"},
        }
    )


PROBLEMS = {
    "external-pair": external_pair,
    "pinion-idler-ring": chain,
    "article 1 g 1 N m": article_pair,
    "planetary": planetary_set,
}


def timed(case, tolerance, span=DURATION):
    """Return the positions [m] ``span`` [s] after `LEAD`, all on the first rotor's scale, wall time [s], steps per second."""
    flow = Flow(gp.replace(case, {"run.tolerance": 1e-11}))
    course = flow.begin(flow.start())
    course.advance(LEAD)
    course.run.clock[kernel.TOLERANCE] = tolerance
    course.run.scale[:] = tolerance * course.run.natural
    before, began = course.steps, time.perf_counter()
    course.advance(LEAD + span)
    seconds = time.perf_counter() - began
    n = flow.size // 2
    return course.state[:n] / flow.natural[:n] * flow.natural[0], seconds, (course.steps - before) / span


def report():
    """Return the table of the loaded problems."""
    lines = [
        f"From a state after {LEAD:g} s, over {DURATION:g} s; least and largest of {REPEATS} repeats, in turn.",
        "",
        "| problem | tolerance | error at its end | steps per second | simulated seconds per second |",
        "|---|---:|---:|---:|---:|",
    ]
    for name, make in PROBLEMS.items():
        case = make()
        prepare(case)
        exact, *_ = timed(case, 1e-13)
        found = {tolerance: [] for tolerance in TOLERANCES}
        for _ in range(REPEATS):
            for tolerance, runs in found.items():
                runs.append(timed(case, tolerance))
        for tolerance, runs in found.items():
            error = float(np.max(np.abs(runs[0][0] - exact)))
            speeds = [DURATION / seconds for _, seconds, _ in runs]
            lines.append(
                f"| {name} | {tolerance:.0e} | {error:.1e} m | {runs[0][2]:.0f} | {min(speeds):.3g} to {max(speeds):.3g} |"
            )
    return lines
