"""The pair of Kahraman and Singh (1990) at F_m = 0.1, F_a = 0.05, zeta = 0.05: a sweep downwards holds its branch to the fold."""

import math
from functools import cache
from typing import Any

import numpy as np
import pytest

import gearplay as gp
from building import Floats
from depth import FULL

RADIUS = 0.1 * math.cos(math.radians(20.0))  # m, of the base circles
STIFFNESS, BACKLASH, NATURAL = 1e8, 1e-4, 1e4  # N/m, m, rad/s
INERTIA = STIFFNESS / NATURAL**2 * RADIUS**2
MEAN, SWING = 0.1 * 0.5 * BACKLASH * STIFFNESS * RADIUS, 0.05 * 0.5 * BACKLASH * STIFFNESS * RADIUS  # N m
DRAG = 2.0 * 0.05 * NATURAL * INERTIA  # N m s/rad
SPEED = "rotors.pinion.drive.speed"
PHASES = np.arange(4) * 0.5 * math.pi
# Speeds over that of the resonance. The fold lies at 0.451; above 0.74 there is one motion.
DOWN = [0.78, 0.70, 0.62, 0.56, 0.52, 0.49, 0.47, 0.46, 0.455, 0.4525, 0.445]


def pair(phase: float) -> gp.Case:
    """Return the pair; its wheel's torque swings with the mesh, so the teeth part and meet again up to 150 um deep."""
    body = {"teeth": 20, "mass": 1.0, "inertia": INERTIA}
    term = {"order": 20, "amplitude": SWING, "phase": phase}
    document: dict[str, Any] = {
        "rotors": {
            "pinion": {**body, "drive": {"kind": "speed", "speed": 350.0}},
            "wheel": {**body, "load": {"torque": MEAN, "terms": [term]}},
        },
        "meshes": [
            {
                "driver": "pinion",
                "driven": "wheel",
                "module": 0.01,
                "backlash": BACKLASH,
                "stiffness": {"kind": "harmonic", "mean": STIFFNESS},
            }
        ],
        "couplings": [
            {
                "between": ["pinion", "wheel"],
                "ratio": -1,
                "torsional_stiffness": 1e-6,
                "torsional_damping": DRAG,
            }
        ],
        "run": {"duration": 0.05, "sampling": 2e5, "tolerance": 1e-9},
    }
    return gp.load_case(document)


@cache
def sections(settle: int, steps: int = 100) -> Floats:
    """Return p [m] once a period at each speed for each phase, carried downwards, by RK4 of p alone, shape [speed, phase]."""
    p, v = np.zeros(4), np.zeros(4)
    found = []
    for speed in (x * NATURAL / 20.0 for x in DOWN):

        def rate(t: float, p: Floats, v: Floats, speed: float = speed) -> Floats:
            torque = MEAN + SWING * np.sin(20.0 * (p / RADIUS - speed * t) + PHASES)
            force = STIFFNESS * (np.maximum(p, 0.0) + np.minimum(p + BACKLASH, 0.0))
            return RADIUS / INERTIA * (torque - RADIUS * force - DRAG * v / RADIUS)

        h = 2.0 * math.pi / (20.0 * speed) / steps
        for n in range(settle * steps):
            t = n * h
            a_1 = rate(t, p, v)
            v_2, a_2 = v + 0.5 * h * a_1, rate(t + 0.5 * h, p + 0.5 * h * v, v + 0.5 * h * a_1)
            v_3, a_3 = v + 0.5 * h * a_2, rate(t + 0.5 * h, p + 0.5 * h * v_2, v + 0.5 * h * a_2)
            v_4, a_4 = v + h * a_3, rate(t + h, p + h * v_3, v + h * a_3)
            p = p + h / 6.0 * (v + 2.0 * v_2 + 2.0 * v_3 + v_4)
            v = v + h / 6.0 * (a_1 + 2.0 * a_2 + 2.0 * a_3 + a_4)
        found.append(p)
    return np.array(found)


@pytest.mark.slow
@pytest.mark.parametrize("phase", range(4))
def test_the_sweep_downwards_holds_its_branch_to_the_fold(phase: int) -> None:
    """Every phase of the torque, so however deep a flank is pressed at the section; against a plain RK4 of one equation."""
    settle = 150 if FULL else 80
    found = gp.bifurcation(
        pair(float(PHASES[phase])),
        SPEED,
        [x * NATURAL / 20.0 for x in DOWN[::-1]],
        ["pinion-wheel.drive_penetration"],
        settle=settle - 1,
        keep=1,
        period="mesh",
        directions=["down"],
    )
    expected = sections(settle)[:, phase]  # all phases in one go
    held = found.values[0, ::-1, 0, 0]
    assert found.interruptions == ()
    assert held == pytest.approx(expected, abs=0.01 * BACKLASH)
    alone = gp.bifurcation(
        pair(float(PHASES[phase])),
        SPEED,
        [x * NATURAL / 20.0 for x in DOWN[:-3:-1]],
        ["pinion-wheel.drive_penetration"],
        settle=settle - 1,
        keep=1,
        period="mesh",
        directions=["up"],
    ).values[0, :, 0, 0]
    assert held[-1] == pytest.approx(alone[0], abs=0.01 * BACKLASH), "below the fold there is one motion"
    assert abs(held[-2] - alone[1]) > 0.05 * BACKLASH, "at 0.4525 there are two"
