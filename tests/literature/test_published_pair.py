"""The torsional pair of the literature as a public case, against an own Runge-Kutta method, and functions of a parameter."""

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gearplay as gp
from gearplay.cli.main import run
from gearplay.model.reading import to_toml
from gearplay.model.toml_files import parse_toml

CASE = "kahraman-singh-1990"
FREQUENCY = "torsional_pair.frequency"


def own_section(
    omega: float,
    mean: float,
    force: float,
    zeta: float,
    *,
    stiffness: float = 0.0,
    phase: float = 0.0,
    start: tuple[float, float] = (1.1, 0.0),
    periods: int = 300,
) -> float:
    """Return x of Kahraman and Singh's equation (10) at tau = 0 mod 2 pi / omega: Runge-Kutta, 400 steps a period."""

    def rate(tau: float, x: float, v: float) -> float:
        gap = x - 1.0 if x > 1.0 else x + 1.0 if x < -1.0 else 0.0
        kappa = 1.0 + stiffness * math.cos(omega * tau)
        return mean + force * math.cos(omega * tau + phase) - 2.0 * zeta * v - kappa * gap

    (x, v), tau, h = start, 0.0, 2.0 * math.pi / omega / 400
    for _ in range(400 * periods):
        k1 = rate(tau, x, v)
        k2 = rate(tau + h / 2, x + h / 2 * v, v + h / 2 * k1)
        k3 = rate(tau + h / 2, x + h / 2 * v + h * h / 4 * k1, v + h / 2 * k2)
        k4 = rate(tau + h, x + h * v + h * h / 2 * k2, v + h * k3)
        x += h * v + h * h / 6 * (k1 + k2 + k3)
        v += h / 6 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
        tau += h
    return x


@pytest.mark.slow
@pytest.mark.parametrize(
    "numbers",
    [
        {"force": 0.05},
        {"force": 0.05, "force_phase": 0.5 * math.pi},
        {"force": 0.05, "stiffness_amplitude": 0.2},
        {"mean_force": 0.3, "damping_ratio": 0.1, "force": 0.1},
    ],
    ids=["plain", "phase", "kappa", "other"],
)
def test_x__own_runge_kutta_over_omega(numbers: dict[str, Any]) -> None:
    values = [0.3, 0.5, 0.9, 1.5]
    case = gp.replace(CASE, {f"torsional_pair.{name}": value for name, value in numbers.items()})
    found = gp.bifurcation(case, FREQUENCY, values, ["x"], settle=300, keep=1, directions=["up"], carry=False)
    expected = [
        own_section(
            omega,
            numbers.get("mean_force", 0.1),
            numbers["force"],
            numbers.get("damping_ratio", 0.05),
            stiffness=numbers.get("stiffness_amplitude", 0.0),
            phase=numbers.get("force_phase", 0.0),
        )
        for omega in values
    ]
    assert found.ds["x"].values.ravel() == pytest.approx(expected, abs=1e-5)
    assert found.ds["x"].attrs["units"] == "1"


def test_x__is_one_where_the_drive_flank_touches() -> None:
    """1 + p / (b / 2): -1 where the back flank touches, as p is then -b."""
    case = gp.replace(CASE, {"torsional_pair.mean_force": -0.4, "torsional_pair.force": 0.0})
    found = gp.section(case, ["x", "pinion-wheel.x", "drive_penetration"], settle=400, keep=1)
    values = dict(zip(found.names, found.values[0], strict=True))
    assert values["x"] == pytest.approx(-1.4, abs=1e-6)  # static: f(x) = F_m
    assert values["pinion-wheel.x"] == values["x"]
    assert values["pinion-wheel.drive_penetration"] == pytest.approx(50e-6 * (values["x"] - 1.0), rel=1e-12)
    other = gp.section("han2021", ["pinion-ring.x"], settle=2, keep=3, period="mesh")
    assert np.all(np.abs(other.values) < 1.5)


@pytest.mark.slow
def test_hysteresis__downward_sweep_holds_to_the_fold() -> None:
    """The upper branch ends at the fold that the branch of orbits has, 0.4505."""
    found = gp.bifurcation(CASE, FREQUENCY, np.linspace(0.44, 0.84, 81).tolist(), ["x"], settle=150, keep=1)
    up, down = (found.ds["x"].sel(direction=way).values[:, 0] for way in ("up", "down"))
    apart = found.parameters[np.abs(up - down) > 0.05]
    assert 0.45 < apart.min() < 0.456
    assert 0.742 < apart.max() < 0.7482


@pytest.mark.parametrize("path", ["rotors.pinion.drive.speed", "rotors.pinion.drive.start_speed"])
def test_speed_alone__is_refused_with_the_cure(path: str) -> None:
    for pair in (CASE, gp.torsional_pair(0.5, force=0.05)):
        with pytest.raises(
            gp.InputError, match=r"torque and error .* belong to one speed\. Change torsional_pair\.frequency"
        ):
            gp.bifurcation(pair, path, [200.0, 300.0], ["x"])
        with pytest.raises(gp.InputError, match=r"Change torsional_pair\.frequency"):
            gp.branch(pair, path, 200.0, 300.0)


def test_table__stands_for_the_parts_and_is_written_as_itself(tmp_path: Path) -> None:
    case = gp.load_case(CASE)
    document = case.resolved()
    assert "rotors" not in document
    assert "meshes" not in document
    assert gp.load_case(document) == gp.load_case(parse_toml(to_toml(case), "x")) == case
    assert gp.torsional_pair(0.5, force=0.05).rotors == case.rotors
    changed = gp.load_case(CASE, [f"{FREQUENCY}=0.8", "torsional_pair.damping_ratio=0.1", "run.seed=3"])
    made = gp.torsional_pair(0.8, force=0.05, damping_ratio=0.1)
    assert (changed.rotors, changed.meshes, changed.run.seed) == (made.rotors, made.meshes, 3)
    with pytest.raises(gp.InputError, match="must be left out where rotors and meshes are given"):
        gp.load_case({**document, **gp.load_case("external-pair").resolved()})
    with pytest.raises(gp.InputError, match=r"torsional_pair\.frequency = -1: must be"):
        gp.load_case({**document, "torsional_pair": {"frequency": -1}})
    other = gp.replace(
        case, {"meshes.0.backlash": "90 um"}
    )  # another mechanism: no pair of the literature any more
    assert (other.torsional_pair, other.meshes[0].backlash) == (None, 90e-6)


@pytest.mark.slow
def test_function_of_a_parameter__is_the_field_by_another_way(tmp_path: Path) -> None:
    values = [0.9, 1.2]

    def family(omega: float) -> gp.Case:
        return gp.torsional_pair(omega, force=0.05)

    asked: dict[str, Any] = {"settle": 200, "keep": 1, "directions": ["up"]}
    over = gp.bifurcation(family, "Omega", values, ["x"], **asked)
    assert list(over.ds["Omega"].values) == values
    assert over.ds["x"].values == pytest.approx(
        gp.bifurcation(family(0.9), FREQUENCY, values, ["x"], **asked).ds["x"].values, abs=1e-7
    )
    branch = gp.branch(family, "Omega", 0.9, 1.2, settle=200, orbits=4)
    x = branch.table(["x"])["x"].values
    assert x[0] == pytest.approx(own_section(0.9, 0.1, 0.05, 0.05), abs=1e-5)
    branch.save(tmp_path / "branch.nc")
    assert gp.read_result(tmp_path / "branch.nc").parameters == pytest.approx(branch.parameters)
    assert len(gp.branches(family, "Omega", 0.9, 1.0, orbits=3, doublings=0)) >= 1
    with pytest.raises(gp.InputError, match=r"values\.0 .*plain numbers for the parameter of a function"):
        gp.bifurcation(family, "Omega", ["3 rpm"], ["x"])
    with pytest.raises(gp.InputError, match="must return a Case"):
        gp.bifurcation(lambda omega: omega, "Omega", values, ["x"])


def test_basins_and_linear_response__take_the_bundled_case() -> None:
    grid = ("wheel.theta", -1e-3, 1e-3, 2), ("wheel.omega", -5.0, 5.0, 2)
    assert gp.basins(CASE, *grid, settle=200).labels.shape == (2, 2)
    at = 1e4 / (2.0 * math.pi)
    found = gp.frequency_response(
        CASE, force="pinion-wheel.transmission_error", at="wheel.theta", frequencies=[0.5 * at, at]
    )
    below, peak = found.ds["amplitude"].values[0]
    assert peak / below == pytest.approx(
        10.0 / abs(1.0 / (0.75 + 0.05j)), rel=1e-6
    )  # 1 / |1 - r^2 + 2 i zeta r|


def test_command__over_the_numbers_of_the_equation(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = [
        CASE,
        FREQUENCY,
        "--low",
        "0.9",
        "--high",
        "1.2",
        "--count",
        "3",
        "--settle",
        "50",
        "--keep",
        "1",
    ]
    out = tmp_path / "out"
    assert run(["bifurcation", *words, "--signal", "x", "--out", str(out)]) == 0
    assert "frequency from 0.9 to 1.2, 3 values up and down; 6 cases" in capsys.readouterr().out
    read = gp.read_result(out / "bifurcation.nc")
    assert read.names == ("x",)
