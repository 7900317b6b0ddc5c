"""Set-points of drives over time: torques, speeds and angles against integrals by hand."""

import math
import re
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


def test_torque_over_time__each_drive_has_its_sine() -> None:
    """The slower sine last: momenta J omega = A (1 - cos(2 pi f t)) / (2 pi f) of both discs."""
    document = disc(kind="torque", torque=0.0)
    one, sines = document["rotors"].pop("disc"), {"fast": (1.0, 50.0), "slow": (3.0, 5.0)}
    for name, (amplitude, frequency) in sines.items():
        over_time = {"sine": {"amplitude": amplitude, "frequency": frequency}}
        drive = {"kind": "torque", "torque": 0.0, "over_time": over_time}
        document["rotors"][name] = {**one, "drive": drive}
    run = gp.simulate(document)
    for name, (amplitude, frequency) in sines.items():
        phase = 2.0 * math.pi * frequency * run.ds["time"].values
        momentum = amplitude * (1.0 - np.cos(phase)) / (2.0 * math.pi * frequency)
        assert INERTIA * run.signal("omega", name) == pytest.approx(momentum, abs=1e-12)


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


def prescribed(name: str, **more: Any) -> Document:
    """Return a gear of prescribed speed, which drives another against a torque."""
    mesh = {
        "driver": "input",
        "driven": "output",
        "module": 2e-3,
        "pressure_angle": math.radians(20.0),
        "backlash": 50e-6,
    }
    stiff = {"stiffness": {"kind": "harmonic", "mean": 1e8}, "damping": {"kind": "constant", "value": 500.0}}
    return {
        "rotors": {
            "input": {
                "mass": 1.0,
                "inertia": 1e-3,
                "teeth": 20,
                "drive": {"kind": "speed", "speed": CURVES[name] | more},
            },
            "output": {"mass": 1.0, "inertia": INERTIA, "teeth": 40, "load": {"drag": 0.5}},
        },
        "meshes": [mesh | stiff],
        "run": {"duration": 0.3, "sampling": 1e3, "tolerance": 1e-10},
    }


@pytest.mark.parametrize("name", CURVES)
def test_prescribed_speed_over_time(name: str, measured: Measured) -> None:
    """The rotation is the integral of the curve, the speed the curve, in touch and out of it."""
    run = gp.simulate(prescribed(name))
    times = run.ds["time"].values
    theta, omega = (run.ds[each].sel(rotor="input").values.ravel() for each in ("theta", "omega"))
    worst = float(np.max(np.abs(theta - theta[0] - integral(name, times))))
    measured(f"prescribed speed over time, {name}: rotation [rad]", worst, "1e-14")
    assert worst < 1e-14
    away = np.abs(times - 0.1) > 1e-9
    assert np.max(np.abs(omega - value(name, times))[away]) < 1e-14
    output = run.ds["theta"].sel(rotor="output").values.ravel()
    assert np.max(np.abs(output - output[0] + 0.5 * integral(name, times))) < 0.01  # it is driven, and coasts


def test_prescribed_speed_over_time__kinks_are_located() -> None:
    """Behind a torsional spring: exact response of an oscillator to a speed that is linear between points."""
    k, c = 50.0, 0.02
    document = {
        "rotors": {
            "input": {"mass": 1.0, "inertia": 1e-3, "drive": {"kind": "speed", "speed": CURVES["table"]}},
            "output": {"mass": 1.0, "inertia": INERTIA},
        },
        "couplings": [{"between": ["input", "output"], "torsional_stiffness": k, "torsional_damping": c}],
        "run": {"duration": 0.3, "sampling": 1e3, "tolerance": 1e-12},
    }
    run = gp.simulate(document)
    times = run.ds["time"].values
    relative = (run.ds["theta"].sel(rotor="output") - run.ds["theta"].sel(rotor="input")).values.ravel()
    # J q'' + c q' + k q = -J a(t), a constant between points; q = q' = 0 at the start
    rate = complex(-0.5 * c / INERTIA, math.sqrt(k / INERTIA - (0.5 * c / INERTIA) ** 2))

    def step_response(t: Any) -> Any:
        """Return the response to -J a, a = 1 from 0 on."""
        wave = np.exp(rate * t)
        return np.where(t > 0.0, -INERTIA / k * (1.0 - (wave.real - rate.real / rate.imag * wave.imag)), 0.0)

    slopes = [0.0] + [(b[1] - a[1]) / (b[0] - a[0]) for a, b in pairwise(TABLE)] + [0.0]
    expected = sum(
        (after - before) * step_response(times - point[0])
        for (before, after), point in zip(pairwise(slopes), TABLE, strict=True)
    )
    assert np.max(np.abs(relative - relative[0] - expected)) < 1e-11
    assert np.ptp(expected) > 1e-4


@pytest.mark.parametrize("name", ["sine", "trapezoid", "table"])
def test_prescribed_speed_over_time__torque_of_the_drive(name: str) -> None:
    """T = J alpha + drag omega."""
    document = disc(kind="speed", speed=CURVES[name])
    document["rotors"]["disc"] |= {"load": {"drag": 0.3}, "initial": {}}
    run = gp.simulate(document)
    times, h = run.ds["time"].values, 1e-7
    slope = (value(name, times + h) - value(name, times - h)) / (2.0 * h)
    smooth = np.min(np.abs(times[:, None] - [0.02, 0.05, 0.06, 0.1, 0.16, 0.18, 0.25]), axis=1) > 1e-6
    expected = INERTIA * slope + 0.3 * value(name, times)
    assert np.max(np.abs(run.ds["drive_torque"].values.ravel() - expected)[smooth]) < 1e-7


def test_prescribed_speed_over_time__jump_out_of_touch_is_not_missed() -> None:
    """A gear that waits in the middle of its backlash is struck by the speed that a step begins with."""
    document = prescribed("step")
    document["rotors"]["input"]["drive"]["speed"] = {"step": {"time": 0.1, "value": 1.0}}
    document["rotors"]["output"] |= {"load": {}, "initial": {"theta": -6.65e-4, "omega": 0.0}}
    run = gp.simulate(document, signals=["omega"])
    omega = run.ds["omega"].sel(rotor="output").values.ravel()
    times = run.ds["time"].values
    assert np.all(omega[times < 0.101] == 0.0)  # 25 um at 0.0188 m/s take 1.3 ms
    assert np.max(np.abs(omega[times > 0.102])) > 0.5


def test_prescribed_speed_over_time__from_a_file_and_back(tmp_path: Path) -> None:
    (tmp_path / "speed.csv").write_text("0.05,0.1\n0.1,0.5\n0.25,-0.3\n", encoding="utf-8")
    document = prescribed("table")
    case = gp.load_case(document)
    (tmp_path / "case.toml").write_text(text := to_toml(case), encoding="utf-8")
    assert gp.load_case(tmp_path / "case.toml") == case
    named = re.sub(r'drive = \{ kind = "speed".*', 'drive = { kind = "speed", speed = "speed.csv" }', text)
    (tmp_path / "file.toml").write_text(named, encoding="utf-8")
    assert gp.load_case(tmp_path / "file.toml").sha256 == case.sha256
    assert gp.replace(case, {"rotors.input.drive.speed": 2.0}).rotors["input"].drive.over_time is None


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        (
            {"ramp": 0.1},
            "ramp = .*must be 0 for a drive whose speed is given over time. Write it into the set-point",
        ),
        (
            {"ripple": [{"order": 2, "amplitude": 0.1}]},
            "must not be given for a drive whose speed is given over time",
        ),
        (
            {"speed": {"table": [[0.0, 1.0], [0.0, 2.0]]}},
            "must have a time later than that of the point before",
        ),
        ({"speed": "missing.csv"}, "missing.csv"),
    ],
)
def test_prescribed_speed_over_time__contradictions(changes: dict[str, Any], said: str) -> None:
    document = prescribed("table")
    document["rotors"]["input"]["drive"] |= changes
    with pytest.raises(gp.InputError, match=said):
        gp.load_case(document)
