"""Set-points of drives over time: torques, speeds and angles against integrals by hand."""

import math
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gearplay as gp
from building import Document, Measured
from gearplay.model.reading import to_toml

INERTIA = 2e-3  # kg m^2
TABLE = [[0.05, 0.1], [0.1, 0.5], [0.25, -0.3]]
CURVES: dict[str, Document] = {
    "step": {"step": {"time": 0.1, "value": 0.5, "before": 0.2}},
    "sine": {"sine": {"amplitude": 0.4, "frequency": 7.0, "phase": 0.3, "mean": 0.1}},
    "trapezoid": {"trapezoid": {"value": 0.5, "start": 0.02, "rise": 0.04, "hold": 0.1, "fall": 0.02}},
    "table": {"table": TABLE},
}


def value(name: str, t: Any) -> Any:
    """Return a curve at times t [s]."""
    if name == "step":
        return np.where(t < 0.1, 0.2, 0.5)
    if name == "sine":
        return 0.1 + 0.4 * np.sin(14.0 * math.pi * t + 0.3)
    if name == "trapezoid":
        return np.interp(t, [0.02, 0.06, 0.16, 0.18], [0.0, 0.5, 0.5, 0.0])
    return np.interp(t, *zip(*TABLE, strict=True))


def integral(name: str, times: Any) -> Any:
    """Return the integral of a curve from 0 to each of some times: Gauss's rule between its kinks."""
    knots = {"step": [0.1], "sine": [], "trapezoid": [0.02, 0.06, 0.16, 0.18], "table": [0.05, 0.1, 0.25]}[
        name
    ]
    nodes, weights = np.polynomial.legendre.leggauss(24)
    found = []
    for end in times:
        ends = [0.0, *(k for k in knots if k < end), end]
        parts = [
            0.5 * (b - a) * weights @ value(name, 0.5 * (a + b + (b - a) * nodes)) for a, b in pairwise(ends)
        ]
        found.append(sum(parts))
    return np.array(found)


def disc(**drive: Any) -> Document:
    """Return a disc on a drive."""
    return {
        "rotors": {
            "disc": {"mass": 1.0, "inertia": INERTIA, "drive": drive, "initial": {"theta": 0.0, "omega": 0.0}}
        },
        "run": {"duration": 0.3, "sampling": 1e3, "tolerance": 1e-12},
    }


@pytest.mark.parametrize("name", CURVES)
def test_torque_over_time(name: str, measured: Measured) -> None:
    """J omega' = T(t), a constant besides."""
    document = disc(kind="torque", torque=0.0)
    document["rotors"]["disc"]["drive"]["torque"] = CURVES[name]
    run = gp.simulate(document)
    times = run.ds["time"].values
    worst = float(np.max(np.abs(run.ds["omega"].values.ravel() * INERTIA - integral(name, times))))
    measured(f"torque over time, {name}: momentum [N m s]", worst, "1e-12")
    assert worst < 1e-12


@pytest.mark.parametrize("name", CURVES)
def test_speed_over_time(name: str, measured: Measured) -> None:
    """Without an integral J omega = kp (integral of the wanted speed - theta) from rest at theta = 0."""
    document = disc(
        kind="servo", speed=CURVES[name], proportional_gain=0.05, integral_gain=0.0, torque_limit=100.0
    )
    run = gp.simulate(document)
    times = run.ds["time"].values
    omega, theta = (run.ds[each].values.ravel() for each in ("omega", "theta"))
    misfit = INERTIA * omega - 0.05 * (integral(name, times) - theta)
    worst = float(np.max(np.abs(misfit)))
    measured(f"speed over time, {name}: momentum [N m s]", worst, "1e-12")
    assert worst < 1e-12
    assert np.ptp(omega) > 0.1


@pytest.mark.parametrize("limit", [100.0, 0.004])
def test_speed_over_time__limit_of_the_torque(limit: float) -> None:
    """A step beyond what the torque allows: constant acceleration until the speed is near."""
    step = {"step": {"time": 0.1, "value": 1.0}}
    run = gp.simulate(
        disc(kind="servo", speed=step, proportional_gain=0.05, integral_gain=0.0, torque_limit=limit)
    )
    torque, times = run.ds["drive_torque"].values.ravel(), run.ds["time"].values
    assert np.all(torque[times < 0.0999] == 0.0)
    assert np.max(np.abs(torque)) == pytest.approx(min(limit, 0.05), rel=1e-9)
    omega = run.ds["omega"].values.ravel()
    expected = (
        1.0 - np.exp(-0.05 / INERTIA * (times - 0.1)) if limit > 1.0 else limit / INERTIA * (times - 0.1)
    )
    late = times > 0.1005
    assert np.max(np.abs((omega - expected)[late])) < 1e-9


def test_angle_over_time__a_trapezoid_of_the_speed() -> None:
    """A stiff loop with full feedforward follows it: it ends at the value, its speed is the trapezoid."""
    move = {"value": 0.5, "start": 0.02, "rise": 0.04, "hold": 0.1, "fall": 0.02}
    run = gp.simulate(
        disc(
            kind="cascade",
            angle={"trapezoid": move},
            position_gain=50.0,
            speed_gain=40.0,
            feedforward=1.0,
            torque_limit=1e3,
        )
    )
    times, top = run.ds["time"].values, 0.5 / (0.02 + 0.1 + 0.01)
    wanted = top * np.interp(times, [0.02, 0.06, 0.16, 0.18], [0.0, 1.0, 1.0, 0.0])
    lag = top / 0.02 * INERTIA / 40.0  # the speed of a ramp behind a first-order loop
    assert np.max(np.abs(run.ds["omega"].values.ravel() - wanted)) < 1.1 * lag
    assert run.ds["theta"].values.ravel()[-1] == pytest.approx(0.5, abs=1e-4)


def test_set_point_over_time__file_and_round_trip(tmp_path: Path) -> None:
    """The name of a CSV file in place of the number; the written case reads back equal."""
    (tmp_path / "move.csv").write_text("t [s],torque [N m]\n" + "".join(f"{t},{v}\n" for t, v in TABLE))
    file = tmp_path / "case.toml"
    file.write_text(
        '[rotors.disc]\nmass = 1.0\ninertia = 2e-3\ndrive = { kind = "torque", torque = "move.csv" }\n'
        'initial = { theta = "0 rad", omega = 0.0 }\n[run]\nduration = 0.3\nsampling = 1000.0\ntolerance = 1e-12\n'
    )
    one, other = gp.load_case(file), gp.load_case(disc(kind="torque", torque=CURVES["table"]))
    assert one.rotors["disc"].drive == other.rotors["disc"].drive
    written = tmp_path / "written.toml"
    written.write_text(to_toml(one))
    assert gp.load_case(written).rotors == one.rotors
    changed = gp.replace(one, {"rotors.disc.drive.torque": str(tmp_path / "move.csv")})
    assert changed.rotors["disc"].drive == one.rotors["disc"].drive
    beside = gp.replace(one, {"rotors.disc.drive.torque": 0.3}).rotors["disc"].drive
    assert (beside.torque, beside.over_time) == (0.3, one.rotors["disc"].drive.over_time)
    servo = disc(
        kind="servo", speed=CURVES["sine"], proportional_gain=0.05, integral_gain=0.0, torque_limit=1.0
    )
    assert (
        gp.replace(gp.load_case(servo), {"rotors.disc.drive.speed": 0.3}).rotors["disc"].drive.over_time
        is None
    )


def test_plain_drives_keep_their_digest() -> None:
    """A drive without a set-point over time is written as before."""
    assert "over_time" not in to_toml(gp.load_case(disc(kind="torque", torque=1.0)))
