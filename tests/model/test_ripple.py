"""Ripple of a drive: what a case file may say, what is refused in which words, what the kernels get."""

import math
import re
from typing import Any

import numpy as np
import pytest

from gearplay.kernels.ripple import ripple
from gearplay.model.check import check_case
from gearplay.model.pack import pack
from gearplay.model.reading import load_case, replace, to_toml
from gearplay.model.schema import json_schema
from gearplay.vocabulary.errors import InputError

TERM = {"order": 1, "amplitude": 0.01, "phase": "0 deg"}


def with_drive(**drive: Any) -> Any:
    base = {"kind": "speed", "speed": "120 rpm"}
    return replace(load_case("han2021"), {"rotors.pinion.drive": {**base, **drive}})


def refusal(**drive: Any) -> str:
    with pytest.raises(InputError) as caught:
        with_drive(**drive)
    return str(caught.value)


def test_there_is_none_by_default() -> None:
    case = load_case("han2021")
    assert case.rotors["pinion"].drive.ripple == ()  # type: ignore[union-attr]
    rotors = pack(case).system.rotors
    for field in ("ripple_count", "ripple_curvature", "ripple_rate"):
        assert np.all(rotors[field] == 0)


def test_units_are_read_and_survive_writing() -> None:
    terms = [{"order": 3, "amplitude": "1 %", "phase": "90 deg"}, {"order": 64, "amplitude": 0.5}]
    case = with_drive(ripple=terms)
    first, second = case.rotors["pinion"].drive.ripple
    assert (first.order, first.amplitude, first.phase) == (3, 0.01, pytest.approx(math.pi / 2.0))
    assert (second.order, second.amplitude, second.phase) == (64, 0.5, 0.0)
    assert load_case(case.resolved()) == case
    changed = replace(case, {"rotors.pinion.drive.ripple.0.amplitude": 0.02})
    assert changed.rotors["pinion"].drive.ripple[0].amplitude == 0.02


def test_it_survives_a_case_file(tmp_path: Any) -> None:
    case = with_drive(ripple=[TERM, {**TERM, "order": 2}])
    path = tmp_path / "rippling.toml"
    path.write_text(to_toml(case), encoding="utf-8")
    assert load_case(path) == case


@pytest.mark.parametrize(
    ("drive", "words"),
    [
        ({"ripple": [{**TERM, "order": 0}]}, r"ripple\.0\.order = 0: must be 1 or more"),
        ({"ripple": [{**TERM, "order": 65}]}, r"ripple\.0\.order = 65: must be at most 64"),
        ({"ripple": [{**TERM, "order": 1.5}]}, r"ripple\.0\.order = 1\.5: must be a whole number"),
        ({"ripple": [{**TERM, "amplitude": 0.6}]}, r"ripple\.0\.amplitude = 0\.6: must be .* at most 0\.5"),
        ({"ripple": [{**TERM, "amplitude": -0.1}]}, r"ripple\.0\.amplitude = -0\.1: must be 0 or more"),
        (
            {"ripple": [{**TERM, "phase": "1 m"}]},
            r'ripple\.0\.phase = "1 m": is not an angle\. Use a unit such as rad',
        ),
        ({"ripple": [{**TERM, "phas": 0}]}, r"ripple\.0\.phas: unknown field\. Did you mean 'phase'\?"),
        ({"ripple": [{"order": 1}]}, r"ripple\.0\.amplitude: is required"),
        ({"ripple": [TERM] * 9}, r"ripple .*must have 0 to 8 items"),
        (
            {"ripple": [{**TERM, "amplitude": 0.5}] * 2},
            r"ripple .*must have amplitudes that add up to less than 1, .*they make 1\. Lower the amplitudes",
        ),
        (
            {"ripple": [TERM], "ramp": "0.1 s"},
            r"ramp = .*must be 0 for a drive with a ripple, .*Remove the ramp or the ripple",
        ),
    ],
)
def test_refusals(drive: dict[str, Any], words: str) -> None:
    found = refusal(**drive)
    assert re.search(r"rotors\.pinion\.drive\." + words, found), found


def test_only_a_prescribed_speed_ripples() -> None:
    words = refusal(kind="servo", proportional_gain=1, integral_gain=0, torque_limit=1, ripple=[TERM])
    assert "rotors.pinion.drive.ripple: unknown field" in words


def test_what_the_kernels_get() -> None:
    speed = -4.0 * math.pi
    terms = [{"order": 5, "amplitude": 0.1, "phase": 0.7}, {"order": 2, "amplitude": 0.2, "phase": -1.0}]
    system = pack(with_drive(speed=speed, ripple=terms)).system
    r = system.rotors[0]
    assert r.ripple_count == 2
    assert r.ripple_curvature == pytest.approx((5 * 0.1 + 2 * 0.2) * speed**2)
    assert r.ripple_rate == pytest.approx(5 * abs(speed))
    rows = system.terms[r.ripple_start : r.ripple_start + 2]
    np.testing.assert_allclose(rows[:, 0], [2.0, 5.0])
    np.testing.assert_allclose(
        rows[:, 1:], [[0.2 * math.cos(1.0), -0.2 * math.sin(1.0)], [0.1 * math.cos(0.7), 0.1 * math.sin(0.7)]]
    )
    before = pack(load_case("han2021")).system
    np.testing.assert_array_equal(system.terms[: len(before.terms)], before.terms)
    assert r.ripple_start == len(before.terms)
    assert list(system.rotors.ripple_count) == [2, 0]


def test_angle_speed_and_acceleration_are_each_others_slopes() -> None:
    """By differences of fourth order, and a hand's case: order 1, phase 0, a quarter turn: a, omega (1 + a), 0."""
    system = pack(with_drive(speed=2.0 * math.pi, ripple=[{"order": 1, "amplitude": 0.1}])).system
    assert ripple(system, 0, 0.0) == (0.0, 0.0, pytest.approx(0.1 * 4.0 * math.pi**2))
    assert ripple(system, 0, 0.25) == (
        pytest.approx(0.1),
        pytest.approx(0.2 * math.pi),
        pytest.approx(0.0, abs=1e-14),
    )
    terms = [{"order": 5, "amplitude": 0.1, "phase": 0.7}, {"order": 2, "amplitude": 0.2, "phase": -1.0}]
    system = pack(with_drive(ripple=terms)).system
    h = 1e-4
    for t in np.linspace(0.0, 2.0, 41):
        at = [ripple(system, 0, t + k * h) for k in (-2, -1, 1, 2)]
        _, omega, alpha = ripple(system, 0, t)
        for place, slope in ((0, omega), (1, alpha)):
            v = [values[place] for values in at]
            assert (v[0] - 8.0 * v[1] + 8.0 * v[2] - v[3]) / (12.0 * h) == pytest.approx(slope, abs=1e-7)
        assert abs(alpha) <= system.rotors[0].ripple_curvature


def test_a_ripple_excites_a_case() -> None:
    quiet: dict[str, Any] = {"rotors.ring.load.drag": 0, "meshes.0.transmission_error": []}
    quiet |= {f"rotors.{name}.runout.amplitude": 0 for name in ("pinion", "ring")}
    found = [finding.message for finding in check_case(replace(load_case("han2021"), quiet))]
    assert any("nothing excites" in message for message in found)
    quiet["rotors.pinion.drive.ripple"] = [TERM]
    found = [finding.message for finding in check_case(replace(load_case("han2021"), quiet))]
    assert not any("nothing excites" in message for message in found)


def test_the_schema_describes_it() -> None:
    parts = json_schema()["$defs"]
    assert parts["SpeedDrive"]["properties"]["ripple"]["maxItems"] == 8
    assert parts["RippleTerm"]["properties"]["order"]["maximum"] == 64
    assert parts["RippleTerm"]["properties"]["phase"]["x-unit"] == "rad"
