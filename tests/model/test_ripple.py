"""Ripple of a drive: what a case file may say, what is refused in which words, what the kernels get."""

import math
import re
from typing import Any

import numpy as np
import pytest

from gearplay.kernels.prescribed import variation
from gearplay.model.check import check_case
from gearplay.model.pack import pack
from gearplay.model.reading import load_case, replace
from gearplay.vocabulary.errors import InputError

TERM = {"order": 1, "amplitude": 0.01, "phase": "0 deg"}


def with_drive(**drive: Any) -> Any:
    base = {"kind": "speed", "speed": "120 rpm"}
    return replace(load_case("han2021"), {"rotors.pinion.drive": {**base, **drive}})


def refusal(**drive: Any) -> str:
    with pytest.raises(InputError) as caught:
        with_drive(**drive)
    return str(caught.value)


@pytest.mark.parametrize(
    ("drive", "words"),
    [
        ({"ripple": [{**TERM, "order": 0}]}, r"ripple\.0\.order = 0: must be 1 or more"),
        ({"ripple": [{**TERM, "order": 65}]}, r"ripple\.0\.order = 65: must be at most 64"),
        ({"ripple": [{**TERM, "order": 1.5}]}, r"ripple\.0\.order = 1\.5: must be a whole number"),
        ({"ripple": [{**TERM, "amplitude": 0.6}]}, r"ripple\.0\.amplitude = 0\.6: must be .* at most 0\.5"),
        ({"ripple": [{**TERM, "amplitude": -0.1}]}, r"ripple\.0\.amplitude = -0\.1: must be 0 or more"),
        ({"ripple": [{**TERM, "phase": "1 m"}]}, r'ripple\.0\.phase = "1 m": is not an angle\. Use a unit such as deg or rad'),
        ({"ripple": [{**TERM, "phas": 0}]}, r"ripple\.0\.phas: unknown field\. Did you mean 'phase'\?"),
        ({"ripple": [{"order": 1}]}, r"ripple\.0\.amplitude: is required"),
        ({"ripple": [TERM] * 9}, r"ripple .*must have 0 to 8 items"),
        (
            {"ripple": [{**TERM, "amplitude": 0.5}] * 2},
            r"ripple .*must have amplitudes that add up to less than 1, .*they make 1\. Lower the amplitudes",
        ),
        ({"ripple": [TERM], "ramp": "0.1 s"}, r"ramp = .*must be 0 for a drive with a ripple, .*Remove the ramp or the ripple"),
    ],
)  # fmt: skip
def test_refusals(drive: dict[str, Any], words: str) -> None:
    found = refusal(**drive)
    assert re.search(r"rotors\.pinion\.drive\." + words, found), found


def test_only_a_prescribed_speed_ripples() -> None:
    words = refusal(kind="servo", proportional_gain=1, integral_gain=0, torque_limit=1, ripple=[TERM])
    assert "rotors.pinion.drive.ripple: unknown field" in words


def test_angle_speed_and_acceleration_are_each_others_slopes() -> None:
    """By differences of fourth order, and a hand's case: order 1, phase 0, a quarter turn: a, omega (1 + a), 0."""
    system = pack(with_drive(speed=2.0 * math.pi, ripple=[{"order": 1, "amplitude": 0.1}])).system
    assert variation(system, 0, 0.0) == (0.0, 0.0, pytest.approx(0.1 * 4.0 * math.pi**2))
    assert variation(system, 0, 0.25) == (
        pytest.approx(0.1),
        pytest.approx(0.2 * math.pi),
        pytest.approx(0.0, abs=1e-14),
    )
    terms = [{"order": 5, "amplitude": 0.1, "phase": 0.7}, {"order": 2, "amplitude": 0.2, "phase": -1.0}]
    system = pack(with_drive(ripple=terms)).system
    h = 1e-4
    for t in np.linspace(0.0, 2.0, 41):
        at = [variation(system, 0, t + k * h) for k in (-2, -1, 1, 2)]
        _, omega, alpha = variation(system, 0, t)
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
