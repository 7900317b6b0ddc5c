"""Torsional trains with gears: a printed state matrix, and a train by hand; printed frequencies are those of `gearplay validate`.

M. I. Friswell, J. E. T. Penny, S. D. Garvey, A. W. Lees, Dynamics of Rotating Machines (Cambridge University Press, 2010),
chapter 9, its data and results as the tests of openTorsion give them (github.com/Aalto-Arotor/openTorsion,
opentorsion/tests/tests.py:
friswell_pagex, friswell_ex971, friswell_9_6_3, state_space), and the output printed in its documentation (notebook "Modal
analysis and forced response", a wind turbine). Their gears are rigid; here teeth have 1e13 N/m, no backlash and no load.
"""

import math

import numpy as np
import pytest

import gearplay as gp
from gearplay.validation.motions import train


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
