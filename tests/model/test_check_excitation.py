"""Findings about the sampling of a record (Nyquist), and about cases that nothing excites."""

import math
from typing import Any

import pytest

import gearplay as gp
from gearplay.model.check import check_case
from gearplay.parts.mesh.train.rolling import mesh_frequency
from planetary_sets import planetary_document


def said(changes: dict[str, Any], words: str, name: str = "external-pair") -> list[str]:
    found = check_case(gp.replace(gp.load_case(name), changes))
    return [f"{each.severity}: {each}" for each in found if words in each.message]


@pytest.mark.parametrize("times", [0.02, 0.9, 1.9, 2.1, 3.9, 4.1])
def test_sampling_is_compared_with_the_lines_that_it_shows(times: float) -> None:
    """A line above half the sampling is folded: mesh frequency and its double need more than four times it."""
    case = gp.load_case("external-pair")
    frequency = mesh_frequency(case, 0)
    found = said({"run.sampling": times * frequency}, "wrong places")
    assert len(found) == (times < 4.0)
    if found:
        assert found[0].startswith("warning: warning: run.sampling: ")
        assert ("are: the mesh frequency, " in found[0]) is (times < 2.0)
        assert f"twice the mesh frequency, {2.0 * frequency:.6g} Hz" in found[0]
        assert f"Choose more than {4.0 * frequency:.6g} Hz." in found[0]


def test_sampling_is_compared_with_terms_of_torques_and_ripples() -> None:
    case = gp.load_case("external-pair")
    driver = case.meshes[0].driver
    turns = abs(case.rotors[driver].drive.nominal_speed() or 0.0) / (2.0 * math.pi)  # type: ignore[union-attr]
    term = {"frequency": "40 kHz", "amplitude": 1.0}
    driven = case.meshes[0].driven
    found = said({f"rotors.{driven}.load.terms": [term]}, "wrong places")
    assert f"the torque on {driven}, 40000 Hz" in found[0]
    rate = 8.0 * mesh_frequency(case, 0)
    drive = {"kind": "speed", "speed": 2.0 * math.pi * turns}
    for order in (8, 64):
        ripple = drive | {"ripple": [{"order": order, "amplitude": 0.01}]}
        rate = 100.0 * turns
        found = said({f"rotors.{driver}.drive": ripple, "run.sampling": rate}, "wrong places")
        assert any(f"the ripple of {driver}, {order * turns:.6g} Hz" in each for each in found) is (
            order == 64
        )


@pytest.mark.parametrize("gravity", [[0.0, 0.0], [0.0, -9.81]])
def test_a_prescribed_speed_of_0_excites_nothing(gravity: list[float]) -> None:
    """It is a prescribed speed; ripple, runout and drag act on nothing at rest, gravity and ramps do not make it turn."""
    rest = {"rotors.pinion.drive": {"kind": "speed", "speed": 0.0}, "gravity": gravity}
    found = said(rest, "nothing excites this case", "han2021")
    assert len(found) == 1
    assert found[0].startswith("warning: warning: rotors.pinion.drive.speed: ")
    assert ("gravity only settles" in found[0]) is any(gravity)
    assert said(rest, "no speed other than 0 is prescribed", "han2021")
    assert not said(rest, "no speed is prescribed", "han2021")


@pytest.mark.parametrize(
    "mover",
    [
        {"rotors.pinion.drive.speed": 1.0},
        {"rotors.pinion.drive": {"kind": "speed", "speed": 0.0, "ramp": 0.1, "start_speed": 3.0}},
        {"rotors.ring.initial.vy": 0.1},
        {"rotors.ring.drive": {"kind": "torque", "torque": 1.0}},
        {
            "base": {
                "acceleration": {"kind": "spectral-density", "seed": 0, "density": [[20.0, 1.0], [50.0, 1.0]]}
            }
        },
    ],
    ids=["speed", "ramp", "start", "torque", "housing"],
)
def test_what_moves_a_rotor_excites(mover: dict[str, Any]) -> None:
    rest = {"rotors.pinion.drive": {"kind": "speed", "speed": 0.0}, "gravity": [0.0, -9.81]}
    assert not said(rest | mover, "nothing excites", "han2021")


def test_a_set_whose_ring_stands_without_a_drive_is_named_by_its_field() -> None:
    document = planetary_document()
    document["planetary"]["stage"]["sun"].pop("drive")
    document["planetary"]["stage"]["carrier"].pop("load")
    found = [each for each in gp.check_case(document) if "nothing excites this case" in each.message]
    assert [each.path for each in found] == ["planetary.stage.ring.fixed"]
