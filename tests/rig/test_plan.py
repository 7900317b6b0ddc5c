import json
import math
import pickle
import tomllib
from pathlib import Path
from typing import Any

import pytest

from gearplay.model.reading import load_case, replace
from gearplay.model.toml_files import write_toml
from gearplay.rig.plan import SENSORS, Accelerometer, Rig, load_rig, placements
from gearplay.vocabulary.errors import InputError

OWN = {
    "kind": "own",
    "sensitivity": "100 mV/gravity",
    "range": "50 gravity",
    "lower_frequency": "0.5 Hz",
    "upper_frequency": "10 kHz",
}


def refusal(call: Any, *arguments: Any) -> str:
    with pytest.raises(InputError) as caught:
        call(*arguments)
    return str(caught.value)


def sensor_of(**values: Any) -> Accelerometer:
    return load_rig({"accelerometers": {"a": values}}).accelerometers["a"]


def test_the_default_rig_is_the_articles() -> None:
    rig = load_rig()
    assert rig == Rig() == load_rig({})
    sensor = rig.accelerometers["sensor"]
    assert (sensor.sensitivity, sensor.range) == (1.02e-3, 4900.0)
    assert (sensor.lower_frequency, sensor.upper_frequency, sensor.resonance) == (1.0, 5e3, 25e3)
    assert sensor.density == pytest.approx(5e-3 / math.sqrt(9999.0), rel=1e-12)
    assert rig.collector.sampling == 1e5
    assert rig.collector.corner == 4e4
    assert load_rig(rig) is rig


@pytest.mark.parametrize("kind", SENSORS)
def test_every_sensor_of_the_table_fits_its_own_band(kind: str) -> None:
    sensor = sensor_of(kind=kind)
    assert sensor.natural_frequency == SENSORS[kind]["resonance"]
    assert sensor.sensitivity * sensor.range == pytest.approx(
        5.0, rel=1e-3
    )  # full scale of these amplifiers [V]


def test_given_values_go_before_the_table() -> None:
    sensor = sensor_of(kind="352C33", sensitivity="9.9 mV/(m/s^2)", noise_density=1e-5)
    assert sensor.sensitivity == pytest.approx(9.9e-3, rel=1e-15)
    assert sensor.range == 490.0
    assert sensor.resolution is None
    assert sensor.density == 1e-5


def test_own_values_and_units() -> None:
    sensor = sensor_of(**OWN)
    assert sensor.sensitivity == pytest.approx(0.1 / 9.80665, rel=1e-14)
    assert sensor.range == pytest.approx(490.3325, rel=1e-14)
    assert sensor.density == 0.0


@pytest.mark.parametrize(
    ("damping", "edge"), [(1e-4, 1.05), (0.02, 1.05), (0.3, 1.05), (0.6, 0.95), (0.9, 0.95)]
)
def test_a_resonance_that_is_not_given_follows_from_the_band(damping: float, edge: float) -> None:
    sensor = sensor_of(**OWN, damping_ratio=damping)
    r = sensor.upper_frequency / sensor.natural_frequency
    assert 1.0 / math.hypot(1.0 - r * r, 2.0 * damping * r) == pytest.approx(edge, rel=1e-12)
    assert sensor_of(**OWN, damping_ratio=damping, resonance=sensor.natural_frequency * (1.0 + 1e-12))
    nearer = {**OWN, "damping_ratio": damping, "resonance": sensor.natural_frequency * 0.99}
    assert "must keep the response within 5 %" in refusal(load_rig, {"accelerometers": {"a": nearer}})


def test_a_rig_survives_every_way_of_writing_it(tmp_path: Path) -> None:
    rig = load_rig(
        {"title": "r", "accelerometers": {"a": OWN, "b": {"angle": "90 deg"}}, "collector": {"bits": 12}}
    )
    path = tmp_path / "rig.toml"
    path.write_text(write_toml(rig.resolved()), encoding="utf-8")
    for copy in (load_rig(path), load_rig(str(path)), load_rig(json.loads(json.dumps(rig.resolved())))):
        assert copy == rig
        assert copy.sha256 == rig.sha256
    assert pickle.loads(pickle.dumps(rig)) == rig
    assert load_rig().sha256 != rig.sha256


@pytest.mark.parametrize(
    ("document", "says"),
    [
        ({"accelerometer": {}}, "accelerometer: unknown field. Did you mean 'accelerometers'?"),
        ({"accelerometers": {}}, "accelerometers = a table of 0: must have 1 to 64 entries."),
        ({"accelerometers": {"a": 1}}, "accelerometers.a = 1: must be a table."),
        (
            {"accelerometers": {"a": {"kind": "356A03"}}},
            """accelerometers.a.kind = "356A03": must be one of '356A02'""",
        ),
        ({"accelerometers": {"a": {"kind": "own"}}}, "accelerometers.a.sensitivity: is required. Add it."),
        (
            {"accelerometers": {"a": {"range": "5 V"}}},
            'accelerometers.a.range = "5 V": is not an acceleration. Use a unit such as m/s^2.',
        ),
        ({"accelerometers": {"a": {"sensitivty": 1}}}, "Did you mean 'sensitivity'?"),
        (
            {"accelerometers": {"a": {"sensitivity": -1e-3}}},
            "accelerometers.a.sensitivity = -0.001: must be greater than 0 V/(m/s^2). Remove the minus sign",
        ),
        (
            {"accelerometers": {"a": {"lower_frequency": "6 kHz"}}},
            'accelerometers.a.lower_frequency = "6 kHz": must be less than upper_frequency, 5000 Hz.',
        ),
        (
            {"accelerometers": {"a": {"resonance": "20 kHz"}}},
            'resonance = "20 kHz": must keep the response within 5 % up to upper_frequency, 5000 Hz. Give at least 22903.',
        ),
        (
            {"accelerometers": {"a": {"resonance": "3.5 kHz"}}},  # |H| is 1 again at sqrt(2) f_n
            "must keep the response within 5 %",
        ),
        (
            {"accelerometers": {"a": {"resolution": 1e-3, "noise_density": 1e-5}}},
            "noise_density = 1e-05: must not be given together with resolution.",
        ),
        ({"accelerometers": {"a": {"rotor": 3}}}, "accelerometers.a.rotor = 3: must be text."),
        ({"collector": {"bits": 16.5}}, "collector.bits = 16.5: must be a whole number."),
        ({"collector": {"bits": 64}}, "collector.bits = 64: must be at most 32."),
        (
            {"collector": {"filter": "bessel"}},
            """collector.filter = "bessel": must be one of 'butterworth', 'none'.""",
        ),
        (
            {"collector": {"filter_corner": "50 kHz"}},
            'collector.filter_corner = "50 kHz": must be less than half the sampling rate, 50000 Hz. Lower it',
        ),
        (
            {"collector": {"range": "5 mm"}},
            'collector.range = "5 mm": is not a voltage. Use a unit such as V.',
        ),
        (3, "rig = 3: must be a path or a table."),
    ],
)
def test_a_bad_rig_is_refused_in_one_sentence(document: Any, says: str) -> None:
    shown = refusal(load_rig, document)
    assert says in shown
    if says.count(":") == 1 and "own" not in str(document):
        assert len(shown.splitlines()) == 1


def test_all_faults_are_reported_together() -> None:
    document = {"accelerometers": {"a": {"range": "x"}, "b": {"angle": "1 m"}}, "collector": {"bits": 1}}
    assert len(refusal(load_rig, document).splitlines()) == 3


def test_the_example_on_the_page_is_the_default_rig() -> None:
    page = Path(__file__).resolve().parents[2] / "docs" / "rig.md"
    example = tomllib.loads(page.read_text(encoding="utf-8").split("```toml\n")[1].split("```")[0])
    rig = load_rig(example)
    default = load_rig()
    assert rig.collector.model_copy(update={"filter_corner": None}) == default.collector
    placed = default.accelerometers["sensor"].model_copy(update={"rotor": "ring"})
    assert rig.accelerometers["ring"] == placed


def test_files_that_are_no_rig(tmp_path: Path) -> None:
    assert "no such file" in refusal(load_rig, tmp_path / "missing.toml")
    assert refusal(load_rig, "missing.toml").startswith('rig = "missing.toml"')
    broken = tmp_path / "broken.toml"
    broken.write_text("[accelerometers\n", encoding="utf-8")
    assert refusal(load_rig, broken).startswith("broken.toml: is not valid TOML")


def test_where_sensors_sit() -> None:
    case = load_case("external-pair")
    rig = load_rig({"accelerometers": {"a": {}, "b": {"rotor": case.meshes[0].driver, "angle": "90 deg"}}})
    found = placements(rig, case)
    assert found["a"].rotor == case.meshes[0].driven
    assert found["a"].direction == pytest.approx(0.0, abs=1e-15)
    assert found["b"].rotor == case.meshes[0].driver
    assert found["b"].direction == pytest.approx(0.5 * math.pi)


def test_the_axis_follows_the_centre_line() -> None:
    case = load_case("han2021")  # ring at the origin, the line of an internal pair goes from ring to pinion
    turned = replace(case, {"rotors.ring.position": [0.0, 0.0], "rotors.pinion.position": ["0 mm", "-80 mm"]})
    assert placements(load_rig(), turned)["sensor"].direction == pytest.approx(-0.5 * math.pi)


@pytest.mark.parametrize(
    ("sensor", "says"),
    [
        (
            {"rotor": "rng"},
            """accelerometers.a.rotor = "rng": must be a rotor of the case. Did you mean 'ring'?""",
        ),
        ({"mesh": 1}, "accelerometers.a.mesh = 1: must be a mesh of the case, 0 to 0. Count"),
    ],
)
def test_a_place_that_the_case_does_not_have(sensor: dict[str, Any], says: str) -> None:
    rig = load_rig({"accelerometers": {"a": sensor}})
    assert says in refusal(placements, rig, load_case("han2021"))


def test_a_case_without_meshes__sensor_sits_on_the_only_rotor_that_can_move() -> None:
    rotor = {"mass": 1.0, "inertia": 1.0, "floating": True}
    disc = {"rotors": {"disc": rotor, "motor": rotor | {"floating": False}}, "run": {"duration": 1.0}}
    assert placements(load_rig(), load_case(disc))["sensor"].rotor == "disc"
    for floating in (True, False):
        both = {
            "rotors": {name: rotor | {"floating": floating} for name in disc["rotors"]},
            "run": {"duration": 1.0},
        }
        assert (
            "sensor.rotor: is required where the case has no mesh and several shafts that can move, or none. Add it."
            in refusal(placements, load_rig(), load_case(both))
        )
    rig = load_rig({"accelerometers": {"a": {"rotor": "disc", "angle": 0.3}}})
    assert placements(rig, load_case(disc))["a"].direction == 0.3
