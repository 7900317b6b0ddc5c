"""Motor at a voltage: the winding's current against closed forms, locked and free, energy, linear form."""

import math
import tomllib
from typing import Any

import numpy as np
import pytest
from scipy.linalg import expm

import gearplay as gp
from building import Document
from gearplay.model.reading import to_toml

R, L, K, J, D = 0.8, 2e-3, 0.05, 4e-4, 1e-4  # ohm, H, N m/A, kg m^2, N m s
U = 12.0


def motor(voltage: Any = U, **initial: float) -> Document:
    """Return a rotor on a motor, at rest."""
    drive = {"kind": "motor", "voltage": voltage, "resistance": R, "inductance": L, "torque_constant": K}
    rotor = {
        "mass": 1.0,
        "inertia": J,
        "drive": drive,
        "load": {"drag": D},
        "initial": {"theta": 0.0, "omega": 0.0, **initial},
    }
    return {"rotors": {"motor": rotor}, "run": {"duration": 0.1, "sampling": 2e3, "tolerance": 1e-11}}


MATRIX = np.array([[-R / L, -K / L, U / L], [K / J, -D / J, 0.0], [0.0, 0.0, 0.0]])
"""Of (current, speed, 1)."""


def test_motor__free_rotor_from_rest() -> None:
    """L i' + R i + k omega = u, J omega' = k i - d omega, by matrix exponentials."""
    run = gp.simulate(motor())
    times = run.ds["time"].values
    exact = np.array([expm(MATRIX * t) @ [0.0, 0.0, 1.0] for t in times])
    assert np.max(np.abs(run.ds["omega"].values.ravel() - exact[:, 1])) < 1e-8 * np.max(exact[:, 1])
    assert np.max(np.abs(run.ds["drive_torque"].values.ravel() / K - exact[:, 0])) < 1e-8 * np.max(
        exact[:, 0]
    )


def test_motor__locked_rotor() -> None:
    """Current u / R (1 - exp(-R t / L)) of a rotor that hardly moves for its inertia."""
    document = motor()
    document["rotors"]["motor"]["inertia"] = 1e3
    run = gp.simulate(document)
    times = run.ds["time"].values
    current = run.ds["drive_torque"].values.ravel() / K
    assert np.max(np.abs(current - U / R * (1.0 - np.exp(-R / L * times)))) < 1e-6 * U / R


def test_motor__step_of_the_voltage() -> None:
    """From 0 V at rest: nothing until the step, then the response from rest; the mean of a sine has its response too."""
    run = gp.simulate(motor({"step": {"time": 0.03, "value": U}}))
    times = run.ds["time"].values
    exact = np.array([(expm(MATRIX * max(0.0, t - 0.03)) @ [0.0, 0.0, 1.0])[1] for t in times])
    assert np.max(np.abs(run.ds["omega"].values.ravel() - exact)) < 1e-8 * np.max(exact)


def test_motor__sine_of_the_voltage() -> None:
    document = motor({"sine": {"amplitude": 6.0, "frequency": 20.0, "mean": 3.0, "phase": 0.4}})
    run = gp.simulate(document)
    times, w = run.ds["time"].values, 2.0 * math.pi * 20.0
    wide = np.zeros((5, 5))  # (current, speed, mean, sine, cosine)
    wide[:2, :2] = MATRIX[:2, :2]
    wide[0, 2:4] = 1.0 / L
    wide[3, 4], wide[4, 3] = w, -w
    start = [0.0, 0.0, 3.0, 6.0 * math.sin(0.4), 6.0 * math.cos(0.4)]
    exact = np.array([(expm(wide * t) @ start)[1] for t in times])
    assert np.max(np.abs(run.ds["omega"].values.ravel() - exact)) < 1e-8 * np.max(exact)


def test_motor__derivative_of_the_motion() -> None:
    """The tangent of a step is the matrix exponential."""
    stepper = gp.Stepper(gp.load_case(motor()), outputs=["motor.omega"])
    stepper.step(5e-3)
    found = stepper.jacobian(5e-3)
    speed, torque = list(stepper.state_names).index("motor.omega"), found.shape[0] - 1
    exact = expm(MATRIX * 5e-3)
    assert found[speed, speed] == pytest.approx(exact[1, 1], rel=1e-7)
    assert found[speed, torque] == pytest.approx(exact[1, 0] / K, rel=1e-7)
    assert found[torque, speed] == pytest.approx(exact[0, 1] * K, rel=1e-7)
    assert found[torque, torque] == pytest.approx(exact[0, 0], rel=1e-7)


def test_motor__starts_with_the_speed_without_load() -> None:
    document = motor()
    document["rotors"]["motor"] |= {"initial": {}, "load": {}}
    run = gp.simulate(document)
    assert run.ds["omega"].values == pytest.approx(U / K, rel=1e-12)
    assert run.ds["drive_torque"].values == pytest.approx(0.0, abs=1e-12)


def test_motor__damps_modes_as_its_slope() -> None:
    """Torque per speed k^2 / R, of a motor behind a spring."""
    document = motor(0.0)
    document["rotors"] = {"motor": document["rotors"]["motor"], "load": {"mass": 1.0, "inertia": 2e-3}}
    document["rotors"]["motor"]["load"] = {}
    document["couplings"] = [{"between": ["motor", "load"], "torsional_stiffness": 30.0}]
    found = gp.modes(document)
    mass, damp, k = np.diag([J, 2e-3]), np.diag([K**2 / R, 0.0]), 30.0 * np.array([[1.0, -1.0], [-1.0, 1.0]])
    inverse = np.linalg.inv(mass)
    whole = np.block([[np.zeros((2, 2)), np.eye(2)], [-inverse @ k, -inverse @ damp]])
    roots = np.linalg.eigvals(whole)
    exact = max(roots, key=lambda root: root.imag)
    at = int(np.argmax(found.ds["frequency"].values))
    assert found.ds["damping_ratio"].values[at] == pytest.approx(-exact.real / abs(exact), rel=1e-9)


def test_motor__written_and_read_again() -> None:
    case = gp.load_case(motor("24 V"))
    assert gp.load_case(tomllib.loads(to_toml(case))) == case
    assert case.rotors["motor"].drive.voltage == 24.0
    document = motor()
    document["rotors"]["motor"]["drive"] |= {
        "resistance": "800 mohm",
        "inductance": "2 mH",
        "torque_constant": "50 mN m/A",
    }
    drive = gp.load_case(document).rotors["motor"].drive
    assert [drive.resistance, drive.inductance, drive.torque_constant] == pytest.approx([R, L, K])


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"resistance": 0.0}, "drive.resistance.*must be greater than 0 ohm"),
        ({"inductance": "3 ohm"}, "drive.inductance"),
        (
            {"over_time": {"table": [[0.0, 1.0], [1.0, 2.0]]}},
            "drive.voltage.*must be left out where over_time gives it",
        ),
    ],
)
def test_motor__refused(changes: dict[str, Any], said: str) -> None:
    document = motor()
    document["rotors"]["motor"]["drive"] |= changes
    with pytest.raises(gp.InputError, match=said):
        gp.load_case(document)
