"""Housing paths: one mode under a sine and an impulse, a table against the modes it was made of, what is refused."""

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gearplay as gp
from building import Document, Floats
from gearplay.rig.housing_paths import HousingPath
from gearplay.rig.measurement import housing_acceleration
from gearplay.rig.plan import Placement, load_rig
from gearplay.solver.simulate import run_members

MODE = {"frequency": 900.0, "damping_ratio": 0.03, "mass": 2.5, "shape": -0.8}
RATE = 2e5


def path_of(**fields: Any) -> HousingPath:
    return HousingPath.model_validate({"at": "sleeves.ring", **fields})


def accelerance(frequency: Floats, mode: Document = MODE) -> Any:
    """Return shape / m s^2 / (s^2 + 2 zeta w s + w^2)."""
    w, s = math.tau * mode["frequency"], 2j * math.pi * frequency
    return mode["shape"] / mode["mass"] * s**2 / (s**2 + 2.0 * mode["damping_ratio"] * w * s + w * w)


def table_of(frequency: Floats) -> list[list[float]]:
    return [[f, h.real, h.imag] for f, h in zip(frequency.tolist(), accelerance(frequency), strict=True)]


@pytest.mark.parametrize("frequency", [150.0, 900.0, 4000.0])
@pytest.mark.parametrize("measured", [False, True])
def test_sine__settles_to_the_accelerance(frequency: float, measured: bool) -> None:
    """The mean over an interval of a sine of magnitude and phase of a / F."""
    path = path_of(table=table_of(np.arange(0.0, 8000.5, 0.5))) if measured else path_of(modes=[MODE])
    time = np.arange(int(0.4 * RATE)) / RATE
    found = path.mean_acceleration(7.0 * np.sin(math.tau * frequency * time), RATE)
    expected = accelerance(np.array([frequency]))[0]
    assert path.response(np.array([frequency]))[0] == pytest.approx(expected, rel=1e-3 if measured else 1e-12)
    w = math.tau * frequency
    steps = np.exp(1j * w * time)
    means = np.imag(7.0 * expected * (steps[1:] - steps[:-1]) / (1j * w)) * RATE
    late = slice(int(0.2 * RATE), int(0.3 * RATE))
    assert np.max(np.abs(found - means)[late]) < (3e-3 if measured else 2e-5) * 7.0 * abs(expected)


def test_impulse__rings_in_its_mode() -> None:
    """After an impulse J the housing moves with J shape / m exp(-zeta w t) (cos w_d t - zeta w / w_d sin w_d t)."""
    time, force = np.arange(4000) / RATE, np.zeros(4000)
    force[100] = 50.0
    found = np.cumsum(path_of(modes=[MODE]).mean_acceleration(force, RATE)) / RATE
    w, zeta = math.tau * MODE["frequency"], MODE["damping_ratio"]
    w_d, t = w * math.sqrt(1.0 - zeta**2), time[1:] - time[100]
    ringing = np.exp(-zeta * w * t) * (np.cos(w_d * t) - zeta * w / w_d * np.sin(w_d * t))
    size = 50.0 / RATE * MODE["shape"] / MODE["mass"]
    assert np.max(np.abs(found - size * ringing)[105:]) < 1e-3 * abs(size)
    assert np.max(np.abs(found[:95])) == 0.0


def test_modes__add_up_and_a_constant_force_does_nothing() -> None:
    other = {**MODE, "frequency": 2300.0, "shape": 1.0}
    force = np.random.default_rng(1).normal(size=2000)
    each = [path_of(modes=[mode]).mean_acceleration(force, RATE) for mode in (MODE, other)]
    both = path_of(modes=[MODE, other]).mean_acceleration(force, RATE)
    np.testing.assert_allclose(both, each[0] + each[1], atol=1e-12)
    still = np.full(100, 300.0)
    for path in (path_of(modes=[MODE]), path_of(table=table_of(np.arange(0.0, 5000.0, 10.0)))):
        assert np.max(np.abs(path.mean_acceleration(still, RATE))) == 0.0


def test_table__ends_where_it_was_measured() -> None:
    path = path_of(table=table_of(np.linspace(20.0, 5000.0, 400)))
    for frequency in (19.9, 5000.1):
        with pytest.raises(gp.InputError, match=r"frequency.*must be within the table, 20 to 5000 Hz"):
            path.response(np.array([100.0, frequency]))
    sensor = {
        "kind": "own",
        "sensitivity": 1e-3,
        "range": 1e3,
        "lower_frequency": 20.0,
        "upper_frequency": 5000.0,
    }
    document = {"accelerometers": {"cover": {**sensor, "paths": [path.model_dump(mode="json")]}}}
    assert load_rig(document).accelerometers["cover"].paths[0] == path
    wider = {**document["accelerometers"]["cover"], "lower_frequency": 10.0}
    with pytest.raises(
        gp.InputError, match=r"accelerometers.cover.paths.0.table.*must cover the band.*10 to 5000 Hz"
    ):
        load_rig({"accelerometers": {"cover": wider}})


@pytest.mark.parametrize("polar", [False, True])
def test_file__of_a_rig_beside_it(polar: bool, tmp_path: Path) -> None:
    frequency = np.linspace(1.0, 5000.0, 300)
    h = accelerance(frequency)
    columns = (np.abs(h), np.degrees(np.angle(h))) if polar else (h.real, h.imag)
    heading = "frequency [Hz],magnitude,phase" if polar else "frequency,real,imaginary"
    rows = [",".join(map(repr, map(float, row))) for row in zip(frequency, *columns, strict=True)]
    (tmp_path / "frf.csv").write_text("\n".join([heading, *rows]))
    rig = '[accelerometers.cover]\n[[accelerometers.cover.paths]]\nat = "sleeves.ring"\nfile = "frf.csv"\n'
    (tmp_path / "rig.toml").write_text(rig)
    (path,) = load_rig(tmp_path / "rig.toml").accelerometers["cover"].paths
    np.testing.assert_allclose(path.response(frequency), h, atol=1e-12)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("f,re,im\n1,2,3", r"paths.0.file = \"line 1\": must be the heading frequency,real,imaginary or"),
        ("frequency,real,imaginary\n1,2", r"paths.0.file = \"line 2\": must have three numbers"),
        ("frequency,real,imaginary\n1,2,nan", r"paths.0.file = \"line 2\": must have finite numbers"),
        ("frequency,real,imaginary\n2,2,1\n1,2,1", r"paths.0.table.1.*frequency above"),
        ("frequency,real,imaginary\n2,2,1", r"paths.0.table.*two rows"),
        ("", r"paths.0.file.*heading and rows"),
    ],
)
def test_damaged_file__is_refused(text: str, words: str, tmp_path: Path) -> None:
    (tmp_path / "frf.csv").write_text(text)
    path = {"at": "sleeves.ring", "file": str(tmp_path / "frf.csv")}
    with pytest.raises(gp.InputError, match=words):
        load_rig({"accelerometers": {"cover": {"paths": [path]}}})


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"paths": [{"at": "sleeves.pinion", "modes": [MODE]}]}, r"paths.0.at.*must be one of the sleeves of the case"),
        ({"paths": [{"at": "bearings.ring", "modes": [MODE]}]}, r"paths.0.at.*The case has no bearings"),
        ({"paths": [{"at": "ring", "modes": [MODE]}]}, r"paths.0.at"),
        ({"paths": [{"at": "sleeves.ring"}]}, r"paths.0.modes.*required, or file or table"),
        ({"paths": [{"at": "sleeves.ring", "modes": [MODE], "table": [[1, 2, 3], [4, 5, 6]]}]}, r"paths.0.table"),
        ({"rotor": "ring", "paths": [{"at": "sleeves.ring", "modes": [MODE]}]}, r"rotor.*together with paths"),
        ({"transverse_sensitivity": 0.05, "paths": [{"at": "sleeves.ring", "modes": [MODE]}]}, r"transverse_sensitivity"),
    ],
)  # fmt: skip
def test_path__that_does_not_fit_is_refused(changes: Document, words: str) -> None:
    with pytest.raises(gp.InputError, match=words):
        gp.measure("han2021", {"accelerometers": {"cover": changes}}, duration=0.01, transient=0.0)


def test_sensor_on_the_housing__has_what_forces_of_its_bearings_make() -> None:
    """Against the sum of the paths of the forces of the same motion; the axis is the mesh's line of centres, turned."""
    case = gp.load_case("han2021", ["rotors.ring.initial.vx = 40 mm/s"])
    paths = [{"at": "sleeves.ring", "modes": [MODE], "angle": 0.4}]
    rig = load_rig({"accelerometers": {"cover": {"angle": 0.3, "paths": paths, "noise_density": 0.0}}})
    signals = ["ring.sleeve_force_x", "ring.sleeve_force_y"]
    run = run_members(case, [0], signals=signals, duration=0.02, transient=0.0, sampling=8e5)[0]
    found = housing_acceleration(run, rig.accelerometers["cover"], Placement("ring", 0.3))
    pressing = -(
        run.signal("sleeve_force_x", "ring") * math.cos(0.7)
        + run.signal("sleeve_force_y", "ring") * math.sin(0.7)
    )
    np.testing.assert_allclose(found, path_of(modes=[MODE]).mean_acceleration(pressing, 8e5), rtol=1e-12)
    assert np.max(np.abs(found)) > 1.0
    record = gp.measure(case, rig, duration=0.02, transient=0.0)
    ideal = record.channel("cover.acceleration").values
    means = found[: found.size // 8 * 8].reshape(-1, 8).mean(axis=1)
    ideal = ideal[: means.size]
    assert record.attributes["cover_place"].startswith("housing, ")
    assert np.corrcoef(ideal[20:-20], means[20 : ideal.size - 20])[0, 1] > 0.9


def test_sensor__on_the_housing_of_a_case_without_meshes() -> None:
    """An unbalance on a support that turns clockwise, against its steady state; axis 0.4 rad from +x, force 0.5 rad further."""
    stiffness, damping, mass, unbalance, speed = 2e6, 200.0, 3.0, 2e-4, 200.0 * math.pi
    case = {
        "rotors": {
            "fan": {
                "mass": mass,
                "inertia": 1e-2,
                "unbalance": {"amount": unbalance},
                "drive": {"kind": "speed", "speed": -speed},
            }
        },
        "supports": {"fan": {"stiffness": [stiffness, 2.0 * stiffness], "damping": [damping, damping]}},
        "run": {"duration": 0.05, "transient": 0.5},
    }
    mode = {"frequency": 130.0, "damping_ratio": 0.03, "mass": 5.0, "shape": -0.7}
    path = {"at": "supports.fan", "angle": 0.5, "modes": [mode]}
    sensor = {"angle": 0.4, "lower_frequency": 0.2, "paths": [path], "noise_density": 0.0}
    found = gp.measure(case, {"accelerometers": {"cover": sensor}, "collector": {"sampling": 2e4}})
    values = found.channel("cover.acceleration").values
    s = 1j * speed
    x, y = (
        unbalance * speed**2 * turn * (k + s * damping) / (k + s * damping + mass * s**2)
        for turn, k in ((1.0, stiffness), (1j, 2.0 * stiffness))
    )
    force = x * math.cos(0.9) + y * math.sin(0.9)
    accelerance = HousingPath.model_validate(path).response(np.array([speed / (2.0 * math.pi)]))[0]
    time = 0.5 + np.arange(values.size) / 2e4
    steady = np.real(accelerance * force * np.exp(s * time))
    np.testing.assert_allclose(values, steady, atol=2e-3 * np.max(np.abs(steady)))
