"""Torsional trains with gears: frequencies printed by Friswell et al. and by openTorsion.

M. I. Friswell, J. E. T. Penny, S. D. Garvey, A. W. Lees, Dynamics of Rotating Machines (Cambridge University Press, 2010),
chapter 9, its data and results as the tests of openTorsion give them (github.com/Aalto-Arotor/openTorsion,
opentorsion/tests/tests.py:
friswell_pagex, friswell_ex971, friswell_9_6_3, state_space), and the output printed in its documentation (notebook "Modal
analysis and forced response", a wind turbine). Their gears are rigid; here teeth have 1e13 N/m, no backlash and no load.
"""

import math
from typing import Any

import numpy as np
import pytest

import gearplay as gp
from building import Document

RIGID = {"kind": "harmonic", "mean": 1e13}


def train(rotors: dict[str, Any], shafts: dict[tuple[str, str], float], *meshes: tuple[str, str]) -> Document:
    """Return a train: inertias [kg m^2], or inertias and teeth, of rotors; stiffnesses [N m/rad] of shafts; pairs in mesh."""
    table = {}
    for name, given in rotors.items():
        inertia, teeth = given if isinstance(given, tuple) else (given, None)
        table[name] = {"mass": 1.0, "inertia": inertia} | ({"teeth": teeth} if teeth else {})
    return {
        "rotors": table,
        "couplings": [{"between": list(ends), "torsional_stiffness": k} for ends, k in shafts.items()],
        "meshes": [
            {"driver": a, "driven": b, "module": 0.02, "backlash": 0.0, "stiffness": RIGID} for a, b in meshes
        ],
        "run": {"duration": 1.0},
    }


def shaft(length: float, diameter: float, modulus: float) -> float:
    """Return G pi d^4 / (32 l) [N m/rad]."""
    return modulus * math.pi * diameter**4 / (32.0 * length)


GEARED = train(
    {"motor": 400e-6, "one": (25e-6, 40), "two": (25e-6, 40), "a": 700e-6, "b": 700e-6},
    {("motor", "one"): 1e4, ("two", "a"): 5e3, ("one", "b"): 5e3},
    ("one", "two"),
)
DISCS = train(
    {"a": 3.5e-3, "b": 3.5e-3, "c": 3.5e-3, "d": 0.15, "e": 0.05},
    {("a", "b"): 12e3, ("b", "c"): 12e3, ("c", "d"): 14e3, ("d", "e"): 10e3},
)
BRANCHED = train(
    {
        "turbine": 3200.0, "one": (200.0, 50), "two": (200.0, 50), "three": (800.0, 80), "four": (800.0, 80),
        "port": 450.0, "starboard": 450.0,
    },
    {
        ("turbine", "one"): shaft(2.5, 0.2, 68e9),
        ("three", "port"): shaft(3.5, 0.25, 68e9),
        ("four", "starboard"): shaft(3.5, 0.25, 68e9),
    },
    ("one", "two"), ("one", "three"), ("two", "four"),
)  # fmt: skip
TURBINE = train(
    {"blades": 1e7, "inner": 5770.0, "outer": 97030.0},
    {("blades", "inner"): 3.67e8, ("inner", "outer"): 5.496e9},
)


@pytest.mark.parametrize(
    ("document", "printed", "digits"),
    [
        (GEARED, [425.4, 634.1, 3247.2], 1),
        (DISCS, [81.21, 141.21, 378.95, 536.36], 2),
        (BRANCHED, [10.304, 20.479, 24.423], 3),
        (TURBINE, [58.34 / (2.0 * math.pi), 1034.115 / (2.0 * math.pi)], 3),
    ],
    ids=["geared pair", "example 9.7.1", "example 9.6.3", "wind turbine"],
)
def test_printed_frequencies(document: Document, printed: list[float], digits: int) -> None:
    found = gp.modes(document).ds["frequency"].values
    assert found[0] == 0.0
    np.testing.assert_allclose(found[1 : 1 + len(printed)], printed, rtol=0.0, atol=0.51 * 10.0**-digits)
    assert all(f > 1e2 * printed[-1] for f in found[1 + len(printed) :])  # of the teeth alone


def test_damped_geared_train__printed_state_matrix() -> None:
    """Two damped shafts, gears 10:60 without inertia of their own beside discs: frequencies and damping ratios of its A."""
    document = train(
        {"in": 1.0, "one": (0.1, 20), "two": (0.1, 120), "out": 1.0},
        {("in", "one"): 400.0, ("two", "out"): 800.0},
        ("one", "two"),
    )
    for coupling, c in zip(document["couplings"], (1.0, 0.5), strict=True):
        coupling["torsional_damping"] = c
    for rotor, c in zip(document["rotors"].values(), (0.5, 0.1, 0.1, 1.0), strict=True):
        rotor["load"] = {"drag": c}
    # Rows of the accelerations, printed to 16 digits.
    printed = np.array(
        [
            [-4.0e2, 4.0e2, 0.0, -1.5, 1.0, 0.0],
            [
                3891.891891891891, -4108.108108108107, -1297.2972972972968,
                9.729729729729728, -10.864864864864863, -0.8108108108108106,
            ],
            [0.0, -1.33333333e2, -8.0e2, 0.0, -8.33333333e-2, -1.5],
        ]
    )  # fmt: skip
    undamped = np.sqrt(np.sort(np.linalg.eigvals(-printed[:, :3]).real)[1:]) / (2.0 * math.pi)
    values = np.linalg.eigvals(np.block([[np.zeros((3, 3)), np.eye(3)], [printed]]))
    values = values[values.imag > 1.0]
    ratios = (-values.real / np.abs(values))[np.argsort(np.abs(values))]
    found = gp.modes(document).ds
    np.testing.assert_allclose(found["frequency"].values[1:3], undamped, rtol=1e-7)
    np.testing.assert_allclose(found["damping_ratio"].values[1:3], ratios, rtol=1e-7)


def test_gears_without_inertia__rigid_train() -> None:
    """The same pair with inertias of its gears left out: f of 3 inertias and 2 springs in series through the mesh, by hand."""
    document = train(
        {"motor": 0.196, "one": (0.0, 20), "two": (0.0, 60), "load": 0.575},
        {("motor", "one"): 20650.0, ("two", "load"): 41300.0},
        ("one", "two"),
    )
    k = 1.0 / (1.0 / 20650.0 + 1.0 / (41300.0 / 9.0))
    expected = math.sqrt(k * (1.0 / 0.196 + 9.0 / 0.575)) / (2.0 * math.pi)
    found = gp.modes(document).ds["frequency"].values
    assert found == pytest.approx([0.0, expected], rel=1e-8)
