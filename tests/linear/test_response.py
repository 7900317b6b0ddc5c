"""Frequency responses: torques of shafts, forces of bearings and meshes; unbalance and the housing as inputs."""

import cmath
import math
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import gearplay as gp
from building import Document
from gearplay.cli.main import app

INCH_POUND = 0.11298
INERTIA = {"prop": 2.454e6, "gear": 0.826e6, "hpi": 2.723e4, "hpt": 2.612e2, "lpi": 1.283e4, "lpt": 1.509e4}
DRAG = {"prop": 3.86e6, "hpt": 42.738, "lpt": 108.77}
FIRST = 9.4094
SHAFTS = [
    ("prop", "gear", 826e6, 1.0),
    ("lpi", "gear", 203.94e6, -FIRST),
    ("lpt", "lpi", 30.51e6, -40.0424 / FIRST),
    ("hpi", "gear", 24.17e6, -FIRST),
    ("hpt", "hpi", 14.26e6, -78.2365 / FIRST),
]


def propulsion() -> Document:
    """Return field row 27: propeller, double reduction, two turbines, dampers on their speeds."""
    rotors: Document = {name: {"mass": 1e3, "inertia": INCH_POUND * each} for name, each in INERTIA.items()}
    for name, drag in DRAG.items():
        rotors[name]["load"] = {"drag": INCH_POUND * drag}
    shafts = [
        {"between": [a, b], "torsional_stiffness": INCH_POUND * k, "ratio": ratio}
        for a, b, k, ratio in SHAFTS
    ]
    return {"rotors": rotors, "couplings": shafts, "run": {"duration": 1.0}}


def test_torque_of_a_propeller_shaft() -> None:
    """518 614 N m at 35.5 rpm by five blades, a tenth of the square-law torque; against dense matrices."""
    hertz, torque = 5.0 * 35.5 / 60.0, 22.24e6 * INCH_POUND * (35.5 / 85.0) ** 2 * 0.1
    names, stiffness = list(INERTIA), np.zeros((6, 6))
    for a, b, k, ratio in SHAFTS:
        row = np.zeros(6)
        row[names.index(a)], row[names.index(b)] = 1.0, -ratio
        stiffness += INCH_POUND * k * np.outer(row, row)
    omega = 2.0 * math.pi * hertz
    damping = np.diag([INCH_POUND * DRAG.get(name, 0.0) for name in names])
    inertia = np.diag([INCH_POUND * each for each in INERTIA.values()])
    turns = np.linalg.solve(
        stiffness + 1j * omega * damping - omega**2 * inertia, torque * np.eye(6, dtype=complex)[0]
    )
    expected = INCH_POUND * 826e6 * abs(turns[0] - turns[1])
    assert expected == pytest.approx(518614.0, rel=1e-5)
    found = gp.frequency_response(
        propulsion(), force="prop.torque", at=["prop-gear.torque", "prop.theta"], frequencies=[hertz]
    )
    assert torque * found.ds["amplitude"].values[0, 0] == pytest.approx(expected, rel=1e-9)
    assert found.ds["unit"].values.tolist() == ["N m", "rad"]
    found.plot().canvas.draw()


DISC = {
    "rotors": {"disc": {"mass": 2.0, "inertia": 1e-2}},
    "supports": {"disc": {"stiffness": [8e4, 8e4], "damping": [40.0, 40.0]}},
    "run": {"duration": 0.1},
}


def test_an_unbalance_turns_a_disc_on_its_bearing() -> None:
    """Jeffcott's rotor: m e omega^2 over k - m omega^2 + i c omega, y a quarter behind x, and the force of the bearing."""
    hertz = np.array([10.0, 30.0, 60.0])
    found = gp.frequency_response(
        DISC, force="disc.unbalance", at=["disc.x", "disc.y", "disc.force_x"], frequencies=hertz
    ).ds
    omega = 2.0 * math.pi * hertz
    x = omega**2 / (8e4 - 2.0 * omega**2 + 40.0j * omega)
    values = found["amplitude"].values * np.exp(1j * found["phase"].values)
    np.testing.assert_allclose(values[0], x, rtol=1e-9)
    np.testing.assert_allclose(values[1], -1j * x, rtol=1e-9)
    np.testing.assert_allclose(values[2], -(8e4 + 40.0j * omega) * x, rtol=1e-9)


def test_a_disc_moves_against_a_housing_that_shakes() -> None:
    omega = 2.0 * math.pi * 20.0
    found = gp.frequency_response(DISC, force="base.ay", at=["disc.y", "disc.x"], frequencies=[20.0]).ds
    expected = -2.0 / (8e4 - 2.0 * omega**2 + 40.0j * omega)
    value = found["amplitude"].values[0, 0] * cmath.exp(1j * found["phase"].values[0, 0])
    assert value == pytest.approx(expected, rel=1e-9)
    assert found["amplitude"].values[1, 0] == 0.0


def test_an_error_of_the_teeth_presses_a_mesh() -> None:
    """Two gears that only turn: F = k e (1 + rows of the response), by the two inertias in series along the line of action."""
    gears = {
        "a": {"teeth": 20, "mass": 1.0, "inertia": 2e-4, "drive": {"kind": "torque", "torque": 20.0}},
        "b": {"teeth": 40, "mass": 2.0, "inertia": 3e-3, "load": {"torque": 40.0}},
    }
    mesh = {"driver": "a", "driven": "b", "module": 4e-3, "backlash": 5e-5}
    case = {
        "rotors": gears,
        "meshes": [{**mesh, "stiffness": {"kind": "harmonic", "mean": 1e8}}],
        "run": {"duration": 0.1},
    }
    r_a, r_b = (0.5 * 4e-3 * z * math.cos(math.radians(20.0)) for z in (20, 40))
    mass = 1.0 / (r_a**2 / 2e-4 + r_b**2 / 3e-3)
    for hertz in (100.0, 1500.0, 6000.0):
        square = (2.0 * math.pi * hertz) ** 2
        found = gp.frequency_response(
            case, force="a-b.transmission_error", at="a-b.force", frequencies=[hertz]
        ).ds
        expected = abs(1e8 * mass * square / (1e8 - mass * square))
        assert found["amplitude"].values[0, 0] == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize(
    ("force", "at", "words"),
    [
        ("disc.unbalance", "disc.torque", "must be a coordinate that is free to move, the torque of a coupling"),
        ("disc.push", "disc.x", "its unbalance, the error of a mesh, or the housing's acceleration"),
        ("rotor.unbalance", "disc.x", "its unbalance, the error of a mesh, or the housing's acceleration"),
    ],
)  # fmt: skip
def test_what_there_is_not_is_refused(force: str, at: str, words: str) -> None:
    with pytest.raises(gp.InputError, match=words):
        gp.frequency_response(DISC, force=force, at=at, frequencies=[1.0])


def test_a_diagram_that_cannot_be_leaves_no_folder(tmp_path: Path) -> None:
    case = tmp_path / "case.toml"
    case.write_text(
        '[rotors.a]\nmass = "1 kg"\ninertia = "1 kg m^2"\n'
        '[supports.a]\ntorsional_stiffness = "1 N m/rad"\n[run]\nduration = "1 s"\n'
    )
    out = tmp_path / "out"
    ended = CliRunner().invoke(app, ["modes", str(case), "--campbell", "-5rpm", "--out", str(out)])
    assert ended.exit_code != 0
    assert not out.exists()
