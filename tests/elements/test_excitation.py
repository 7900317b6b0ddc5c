"""Torques that vary: against closed forms, and random ones for the tests of all elements."""

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gearplay as gp
from building import Document, Measured, simulate_one
from gearplay.model.toml_files import write_toml
from gearplay.vocabulary.errors import InputError

INERTIA = 2e-3  # kg m^2


def sample(rng: np.random.Generator, *, damped: bool = True, plain: bool = False) -> Document:
    """Return a disc whose torque has terms in time and in rotation; none for a mechanism that is to be mirrored."""
    terms = [
        {
            "frequency": float(rng.uniform(5.0, 500.0)),
            "amplitude": 0.3,
            "phase": float(rng.uniform(0.0, 6.0)),
        },
        {"order": float(rng.uniform(0.5, 20.0)), "amplitude": 0.5, "phase": float(rng.uniform(0.0, 6.0))},
    ]
    return {
        "rotors": {
            "disc": {
                "mass": 1.0,
                "inertia": INERTIA,
                "position": [0.01, 0.02],
                "drive": {"kind": "torque", "torque": 0.0, "terms": [] if plain else terms},
                "initial": {"omega": 10.0},
            }
        },
        "run": {"duration": 0.01, "sampling": 1e4},
    }


def disc(drive: dict[str, Any], load: dict[str, Any] | None = None, omega: float = 10.0) -> Document:
    """Return a disc with a torque drive and a load."""
    return {
        "rotors": {
            "disc": {
                "mass": 1.0,
                "inertia": INERTIA,
                "drive": {"kind": "torque", "torque": 0.0, **drive},
                "load": load or {},
                "initial": {"omega": omega},
            }
        },
        "run": {"duration": 0.05, "sampling": 1e4, "tolerance": 1e-12},
    }


def test_a_torque_in_time_turns_a_disc_in_closed_form(measured: Measured) -> None:
    """J omega' = T + a sin(2 pi f t + phase), transient included in t; a load's terms act against the nominal sense."""
    f, a, phase, load = 40.0, 0.3, 0.7, 0.2
    document = disc(
        {"torque": 0.1, "terms": [{"frequency": f, "amplitude": a, "phase": phase}]},
        {"terms": [{"frequency": 2.0 * f, "amplitude": load}]},
    )
    document["run"]["transient"] = 0.0123
    run = simulate_one(document)
    w = 2.0 * math.pi * f
    exact = 10.0 + 0.1 * run.time / INERTIA
    exact -= a / (INERTIA * w) * (np.cos(w * run.time + phase) - math.cos(phase))
    exact += load / (INERTIA * 2.0 * w) * (np.cos(2.0 * w * run.time) - 1.0)
    worst = float(np.max(np.abs(run.signal("omega", "disc") - exact)))
    measured("torque in time: speed [rad/s]", worst, "1e-8")
    assert worst < 1e-8
    torque = a * np.sin(w * run.time + phase) - load * np.sin(2.0 * w * run.time)
    assert np.allclose(run.signal("excitation_torque", "disc"), torque, atol=1e-12)


def test_a_torque_in_rotation_has_a_potential(measured: Measured) -> None:
    """J omega^2 / 2 + a / order cos(order theta + phase) stays, with the full angle."""
    order, a, phase = 3.5, 0.4, 0.3
    run = simulate_one(disc({"terms": [{"order": order, "amplitude": a, "phase": phase}]}, omega=15.0))
    theta, omega = run.signal("theta", "disc"), run.signal("omega", "disc")
    energy = 0.5 * INERTIA * omega**2 + a / order * np.cos(order * theta + phase)
    worst = float(np.ptp(energy) / energy[0])
    measured("torque in rotation: energy, relative", worst, "1e-9")
    assert worst < 1e-9
    assert np.ptp(omega) > 5.0


def test_a_load_that_opposes_nothing_is_refused() -> None:
    with pytest.raises(InputError, match=r"load\.terms.*nothing says which way"):
        gp.simulate(gp.load_case(disc({}, {"terms": [{"frequency": 1.0, "amplitude": 1.0}]}, omega=0.0)))


def test_torque_table__equals_the_sampled_torque(measured: Measured) -> None:
    """Half a sine of a drive and of a load, in time, by their splines; before and after them nothing."""
    sampling, f = 4000.0, 50.0
    times = np.arange(41) / sampling  # half a period
    table = {"values": np.sin(2.0 * math.pi * f * times).tolist(), "sampling": sampling, "start": 0.012}
    run = simulate_one(disc({"table": table}, {"table": {**table, "start": 0.0}}))
    w = 2.0 * math.pi * f

    def swept(t: Any) -> Any:
        return (1.0 - np.cos(w * np.clip(t, 0.0, 0.01))) / (w * INERTIA)

    exact = 10.0 + swept(run.time - 0.012) - swept(run.time)
    worst = float(np.max(np.abs(run.signal("omega", "disc") - exact)))
    measured("torque of a table: speed [rad/s]", worst, "1e-5")
    assert worst < 1e-5
    middle = int(np.argmin(np.abs(run.time - 0.017)))
    assert run.signal("drive_torque", "disc")[middle] == pytest.approx(1.0, abs=1e-6)
    assert run.signal("load_torque", "disc")[middle] == 0.0


def test_a_table_may_lie_in_a_file(tmp_path: Path) -> None:
    lines = "\n".join(f"{0.001 * k:g} {k % 3}" for k in range(20))
    (tmp_path / "torque.txt").write_text(f"# s, N m\n{lines}\n")
    (tmp_path / "case.toml").write_text(write_toml(disc({"table": {"file": "torque.txt"}})))
    drive = gp.load_case(tmp_path / "case.toml").rotors["disc"].drive
    assert drive is not None
    assert drive.kind == "torque"
    assert drive.table is not None
    assert drive.table.values[:4] == (0.0, 1.0, 2.0, 0.0)
    assert drive.table.sampling == pytest.approx(1000.0)
