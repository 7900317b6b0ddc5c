"""Hypotheses checked against simulated records: known clearances, teeth and bearings of simulated machines."""

import threading
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gearplay as gp
from gearplay.datasets.reading import load_dataset_plan
from gearplay.diagnosis.checks import _weighed, revised
from gearplay.diagnosis.evidence import Hypothesis
from gearplay.diagnosis.machine import machine_of_case
from gearplay.diagnosis.simulated_records import Simulated, at_speed, length_of, loads_of
from gearplay.diagnosis.suspects import Suspect, suspects_of

HOW_TO = Path(__file__).resolve().parents[2] / "docs" / "how-to"
PAIR, RIG = HOW_TO / "rattling-pair.toml", HOW_TO / "rattling-rig.toml"
SPEED = "rotors.pinion.drive.speed"
SHORT = 1.2
"""Length [s] of a record that suffices for most causes."""
CRACKED: dict[str, Any] = {"run.tolerance": 1e-6, "faults": []}


def taken(case: Any, changes: dict[str, Any], rig: Any, duration: float = 2.0) -> gp.Record:
    """Return a record of a changed case, its speed 1.3 % above the nominal one, from a start of its own."""
    base = gp.load_case(case)
    speed = 1.013 * base.rotors["pinion"].drive.speed  # type: ignore[union-attr]
    record = gp.measure(
        gp.replace(base, {**changes, SPEED: speed}), rig, duration=duration, member=40, seed=77
    )
    return gp.Record((record.channels[-1],), "bench")


def causes(found: Any) -> list[str]:
    """Return the causes that agree alike, the nearest first."""
    return [each["name"] for each in found.checks() if each["alike"]]


@pytest.mark.slow
@pytest.mark.compiled
def test_worn_flanks__are_told_from_a_worn_bush() -> None:
    """Without the check backlash and bush rattle alike; simulated, only one of them moves the spectrum as in the record."""
    record = taken(PAIR, {"meshes.0.backlash": "220 um"}, RIG)
    done: list[tuple[float, float]] = []
    found = gp.diagnose(record, case=PAIR, rig=RIG, members=2, progress=lambda _, k, n: done.append((k, n)))
    assert causes(found) == ["worn flanks"]
    first = found.checks()[0]
    assert first["level"].startswith("backlash ")
    assert 180.0 < float(first["level"].split()[1]) < 280.0
    assert first["deviation"] < 1.0
    assert f"with worn flanks ({first['level']}) agree with it" in found.message
    assert done[-1][0] == done[-1][1]
    assert found.ds["feature_simulated"].shape == (len(found.checks()), found.ds.sizes["feature"])
    assert not any("rattle alike" in sentence for sentence in found.cannot_be_told)


@pytest.mark.slow
@pytest.mark.compiled
def test_a_worn_bush__is_told_from_worn_flanks() -> None:
    record = taken(PAIR, {"sleeves.wheel.radial_clearance": "90 um"}, RIG, SHORT)
    found = gp.diagnose(record, case=PAIR, rig=RIG, members=2)
    assert causes(found) == ["worn bush of wheel"]
    assert 60.0 < float(found.checks()[0]["level"].split()[2]) < 130.0


@pytest.mark.slow
@pytest.mark.compiled
def test_the_case_as_it_is__needs_no_cause(tmp_path: Path) -> None:
    found = gp.diagnose(taken(PAIR, {}, RIG), case=PAIR, rig=RIG, members=2)
    assert "the case as it is" in causes(found)
    assert "no simulated cause is needed" in found.message
    found.save(tmp_path / "d.nc")
    assert gp.read_result(tmp_path / "d.nc").checks() == found.checks()


@pytest.mark.slow
@pytest.mark.compiled
def test_another_machine__agrees_with_nothing() -> None:
    """A record of twice the level in other bands: no cause of the case explains it, and that is the conclusion."""
    record = taken(PAIR, {"meshes.0.stiffness.mean": "5e6 N/m", "meshes.0.stiffness.amplitude": "0 N/m",
                          "rotors.wheel.mass": "40 kg", "rotors.wheel.inertia": "0.1 kg m^2"}, RIG, SHORT)  # fmt: skip
    found = gp.diagnose(record, case=PAIR, rig=RIG, members=2)
    assert found.checks()[0]["deviation"] > 1.5
    assert "No simulated record of the case agrees" in found.message
    assert any("calibrate it" in sentence for sentence in found.cannot_be_told)


@pytest.mark.slow
@pytest.mark.compiled
@pytest.mark.parametrize(
    ("fault", "name", "told"),
    [
        ({"kind": "crack", "tooth": 5, "depth": "1.9 mm"}, "crack of a tooth of pinion", True),
        ({"kind": "eccentricity", "amount": "60 um"}, "eccentric pinion", False),
    ],
)
def test_a_gear_of_a_loaded_pair(fault: dict[str, Any], name: str, told: bool) -> None:
    """A crack is distinguished from a spall; an eccentricity with sidebands too small to count agrees best when simulated."""
    case = gp.replace(gp.load_case(HOW_TO / "cracked-pinion.toml"), CRACKED)
    rig = {"accelerometers": {"a": {"kind": "352C33", "rotor": "wheel"}}, "collector": {"sampling": "20 kHz"}}
    record = taken(case, {"faults": [{"at": "pinion", **fault}]}, rig, SHORT)
    found = gp.diagnose(record, case=case, rig=rig, members=2)
    assert causes(found) == [name]
    assert found.told == told
    if told:
        assert found.hypotheses()[0]["name"] == "damaged tooth on pinion"
        assert 1.5 < 1e-3 * float(found.checks()[0]["level"].split()[1]) < 2.4


@pytest.mark.slow
@pytest.mark.compiled
def test_a_line_that_a_sound_bearing_has__is_not_told() -> None:
    """Balls of a sound bearing with clearance pass its load at BPFO: the record alone says outer ring, the case does not."""
    plan = load_dataset_plan("bearing-dents")
    record = taken(plan.case, {}, plan.rig, SHORT)
    alone = gp.diagnose(record, case=plan.case, quick=True)
    against = gp.diagnose(record, case=plan.case, members=2, rig=plan.rig)
    assert alone.hypotheses()[0]["name"] == "bearing of pinion, outer ring"
    assert alone.told
    assert "the case as it is" in causes(against)
    assert not against.told


@pytest.mark.slow
@pytest.mark.compiled
@pytest.mark.many
@pytest.mark.parametrize("part", ["inner", "outer"])
def test_a_ring_of_a_bearing_of_the_case(part: str) -> None:
    plan = load_dataset_plan("bearing-dents")
    dent = {"kind": part, "at": "pinion", "depth": "8 um", "arc": "3 deg", "angle": "-90 deg"}
    found = gp.diagnose(
        taken(plan.case, {"faults": [dent]}, plan.rig), case=plan.case, rig=plan.rig, members=2
    )
    assert found.hypotheses()[0]["name"] == f"bearing of pinion, {part} ring"
    agreeing = causes(found)  # another small fault beside it may agree as well
    assert f"bearing of pinion, {part} ring" in agreeing
    assert all(each.startswith(f"bearing of pinion, {part} ring") for each in agreeing)


@pytest.mark.compiled
@pytest.mark.parametrize("angle", ["2 deg", "8 deg"])
def test_a_broken_cage__is_not_stated_as_an_outer_ring(angle: str) -> None:
    """BPFO is the ninth multiple of FTF: the cage comes first, and which of both it is stays open without simulation."""
    plan = load_dataset_plan("bearing-dents")
    fault = {"kind": "cage", "at": "pinion", "element": 2, "angle": angle}
    found = gp.diagnose(taken(plan.case, {"faults": [fault]}, plan.rig), case=plan.case, quick=True)
    assert found.hypotheses()[0]["name"] == "bearing of pinion, cage"
    assert not found.told
    assert any(each["name"] == "FTF" and each["prominence"] > 10.0 for each in found.lines("envelope"))
    assert (
        "BPFO is a multiple of FTF: bearing of pinion, outer ring, cannot be ruled out."
        in found.cannot_be_told
    )


@pytest.mark.slow
@pytest.mark.compiled
def test_a_broken_cage__agrees_when_it_is_simulated() -> None:
    plan = load_dataset_plan("bearing-dents")
    fault = {"kind": "cage", "at": "pinion", "element": 2, "angle": "2 deg"}
    found = gp.diagnose(
        taken(plan.case, {"faults": [fault]}, plan.rig), case=plan.case, rig=plan.rig, members=2
    )
    assert causes(found) == ["bearing of pinion, cage"]


@pytest.mark.deep
@pytest.mark.compiled
def test_two_causes_of_a_case__agree_when_they_are_simulated_together() -> None:
    """A dent of 5 um of the inner ring and an eccentricity of the wheel of 60 um."""
    plan = load_dataset_plan("bearing-dents")
    dent = {"kind": "inner", "at": "pinion", "depth": "5 um", "arc": "3 deg"}
    off = {"kind": "eccentricity", "at": "wheel", "amount": "60 um"}
    record = taken(plan.case, {"faults": [dent, off]}, plan.rig)
    found = gp.diagnose(record, case=plan.case, rig=plan.rig, members=2)
    assert set(found.causes) <= {"bearing of pinion, inner ring", "eccentric wheel"}
    first = found.checks()[0]
    assert first["name"] == "bearing of pinion, inner ring together with eccentric wheel"
    depth, amount = (float(each.split()[-2]) for each in first["level"].split(";"))
    assert 3.0 < depth < 9.0
    assert 40.0 < amount < 90.0


def test_a_cause_that_agrees_best_as_the_case__is_no_second_row() -> None:
    """A crack whose records are the further off the deeper it is: the case alone is listed, and the hypothesis is not stated."""
    crack = Suspect("crack of a tooth", "tooth", ("damage",), "depth", (1e-3,), ({},))
    rows = [
        [Simulated(0, {"level": level - 0.01}, ""), Simulated(1, {"level": level + 0.01}, "")]
        for level in (0.0, 1.0)
    ]
    found = _weighed([crack], rows, 2, [{"level": 0.0}, {"level": -0.01}], None, [])
    assert ([row.name for row in found.rows], found.absent) == (["the case as it is"], ("damage",))
    assert "no simulated cause is needed" in found.conclusion
    (first,) = revised([Hypothesis("damage", "tooth", (), 1.0, 0.9)], found)
    assert first.confidence == 0.6


@pytest.mark.compiled
def test_quick__simulates_nothing() -> None:
    noise = gp.Channel("acc", np.random.default_rng(0).standard_normal(20_000), 10_000.0, "m/s^2")
    found = gp.diagnose(noise, case=PAIR, quick=True)
    assert found.checks() == []
    assert "imulated" not in found.message


@pytest.mark.compiled
def test_stop__ends_the_simulations() -> None:
    noise = gp.Channel("acc", np.random.default_rng(0).standard_normal(20_000), 10_000.0, "m/s^2")
    stop = threading.Event()
    with pytest.raises(KeyboardInterrupt):
        gp.diagnose(noise, case=PAIR, progress=lambda *_: stop.set(), stop=stop)


def test_speed_and_length_of_simulated_records() -> None:
    case = gp.load_case(PAIR)
    faster, found = at_speed(case, 1.02)
    assert found
    assert faster.rotors["pinion"].drive.speed == pytest.approx(1.02 * case.rotors["pinion"].drive.speed)  # type: ignore[union-attr]
    machine = machine_of_case(case)
    assert length_of(machine, 20.0, 60.0) == pytest.approx(12.0 / (20.0 * 20 / 41))
    assert length_of(machine, 20.0, 0.8) == 0.8
    assert length_of(machine, 0.1, 600.0) == 8.0


def test_speed_of_a_planetary_set__is_that_of_its_driven_member() -> None:
    case = gp.load_case("planetary-reducer")
    faster, found = at_speed(case, 1.01)
    assert found
    drives = [each.rotors["stage.sun"].drive.speed for each in (case, faster)]  # type: ignore[union-attr]
    assert drives[1] == pytest.approx(1.01 * drives[0])
    suspects, said = suspects_of(case, machine_of_case(case), [], {})
    assert ([each.name for each in suspects], said) == (["worn flanks of stage", "worn pins of stage"], [])


def test_bearings_of_a_case__have_their_lines() -> None:
    machine = machine_of_case(gp.load_case(load_dataset_plan("bearing-dents").case))
    (bearing,) = machine.bearings
    assert (bearing.name, bearing.rotor, bearing.order) == ("bearing of pinion", "pinion", 1.0)
    assert bearing.orders.bpfi == pytest.approx(5.415, abs=1e-3)


@pytest.mark.compiled
def test_load_of_a_bearing__is_where_gravity_and_the_mesh_press() -> None:
    """A shaft alone in its bearing lies down: its load points the way of gravity."""
    case = gp.load_case(HOW_TO / "shaft-in-6205.toml")
    assert loads_of(case, None)["shaft"] == pytest.approx(-0.5 * np.pi, abs=0.05)


NOISE = gp.Channel("acc", np.random.default_rng(0).standard_normal(20_000), 10_000.0, "m/s^2")
REFUSED: dict[str, tuple[str, dict[str, Any]]] = {
    "a rig without a case": ("must be given with a case", {"teeth": "20:41", "speed": "1200 rpm", "rig": {}}),
    "a rig and quick": ("must be given with a case", {"case": PAIR, "quick": True, "rig": {}}),
    "a rig elsewhere": ("must be a rotor", {"case": PAIR, "rig": {"accelerometers": {"a": {"rotor": "crank"}}}}),
    "one member": ("from 2 to 64", {"case": PAIR, "members": 1}),
    "a file that is no rig": (r"rattling-pair.toml\": must be a rig, but this is a case", {"case": PAIR, "rig": PAIR}),
    "a file that is no case": (r"rattling-rig.toml\": must be a case, but this is a rig", {"case": RIG}),
    "a rotor of another case": (r"rattling-rig.toml: accelerometers.wheel.rotor", {"case": "two-stage-reducer", "rig": RIG}),
    "no file of a rig": ("no such file", {"case": PAIR, "rig": "no-such.toml"}),
}  # fmt: skip


@pytest.mark.parametrize("kind", REFUSED)
def test_refusals(kind: str) -> None:
    words, given = REFUSED[kind]
    with pytest.raises(gp.InputError, match=words):
        gp.diagnose(NOISE, **given)
