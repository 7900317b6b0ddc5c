import math
from typing import Any

import pytest

import gearplay as gp
from gearplay.model.check import check_case
from gearplay.model.reading import bundled_names, load_case, replace
from gearplay.parts.mesh.train.rolling import mesh_frequency
from gearplay.parts.sleeve.amplitude import amplitude_bound


def found(name: str, changes: dict[str, Any] | None = None) -> dict[str, str]:
    findings = check_case(replace(load_case(name), changes or {}))
    assert [f.severity for f in findings] == sorted((f.severity for f in findings), reverse=True)
    warnings: dict[str, str] = {}
    for finding in findings:
        if finding.severity == "warning":
            warnings[finding.path] = f"{warnings.get(finding.path, '')} {finding.message}".strip()
    return warnings


PRINTED = ("han2021", "han2021-calibrated", "han2021-calibrated-uncoupled")
"""Cases with the article's moments of inertia."""


@pytest.mark.parametrize("name", PRINTED)
def test_accepted__the_printed_inertias_are_notes(name: str) -> None:
    """What a case accepts is a note; without that it is a warning; an accepted path without a warning is one itself."""
    assert found(name) == {}
    notes = [each for each in check_case(load_case(name)) if each.path.endswith(".inertia")]
    assert [(each.severity, each.message[-21:]) for each in notes] == [("note", "Accepted by the case.")] * 2
    plain = replace(load_case(name), {"accepted": []})
    assert plain.sha256 == load_case(name).sha256
    assert list(found(name, {"accepted": ["title", "rotors.ring.inertia"]})) == [
        "rotors.pinion.inertia",
        "accepted",
    ]
    warnings = found(name, {"accepted": []})
    assert list(warnings) == ["rotors.pinion.inertia", "rotors.ring.inertia"]
    assert "0.284 m" in warnings["rotors.pinion.inertia"]
    assert "0.04 m" in warnings["rotors.pinion.inertia"]


@pytest.mark.parametrize("name", sorted({*bundled_names()} - {*PRINTED}))
def test_the_other_bundled_cases_have_no_warnings(name: str) -> None:
    assert found(name) == {}


@pytest.mark.parametrize(
    ("changes", "path", "words"),
    [
        ({"meshes.0.backlash": "68 um"}, "meshes.0.backlash", "jam ratio"),
        ({"meshes.0.backlash": 0}, "meshes.0.backlash", "no backlash"),
        ({"sleeves.ring.radial_clearance": "200 um"}, "meshes.0.backlash", "1.37"),
        ({"meshes.0.transmission_error.0.amplitude": "101 um"}, "meshes.0.transmission_error", "101 um"),
        (
            {"rotors.pinion.position": ["80.1 mm", 0], "rotors.ring.position": [0, 0]},
            "meshes.0.backlash",
            "0.0801",
        ),
    ],
)
def test_check__misfits_are_found(changes: dict[str, Any], path: str, words: str) -> None:
    warnings = found("han2021-geometric-inertia", changes)
    assert words in warnings[path]


def test_a_contact_ratio_below_one_is_found() -> None:
    changes = {"rotors.pinion.addendum": 0.4, "rotors.ring.addendum": 0.4}
    assert "the contact ratio, 0.77, is below 1" in found("han2021-geometric-inertia", changes)["meshes.0"]


def test_a_jam_ratio_below_one_is_no_finding() -> None:
    assert 2 * math.sin(math.radians(20)) * 100 / 69 < 1
    assert found("han2021-geometric-inertia", {"meshes.0.backlash": "69 um"}) == {}


def test_nominal_positions_are_no_finding() -> None:
    changes = {"rotors.pinion.position": ["80 mm", 0], "rotors.ring.position": [0, 0]}
    assert found("han2021-geometric-inertia", changes) == {}


QUIET = {
    "rotors.ring.load.drag": 0,
    "rotors.ring.runout.amplitude": 0,
    "rotors.pinion.runout.amplitude": 0,
    "meshes.0.transmission_error": [],
}


@pytest.mark.parametrize("missing", [None, *QUIET])
def test_a_case_without_excitation_is_noted(missing: str | None) -> None:
    case = replace(load_case("han2021"), {path: value for path, value in QUIET.items() if path != missing})
    noted = any("nothing excites" in finding.message for finding in check_case(case))
    assert noted is (missing is None)


@pytest.mark.parametrize("kind", ["speed", "servo"])
def test_a_speed_over_time_excites(kind: str) -> None:
    gains = {"proportional_gain": 1.0, "integral_gain": 0.0, "torque_limit": 1.0}
    drive = {"kind": kind, "speed": {"table": [[0.0, 12.0], [1.0, 14.0]]}}
    case = replace(
        load_case("han2021"), QUIET | {"rotors.pinion.drive": drive | (gains if kind == "servo" else {})}
    )
    assert not any("nothing excites" in finding.message for finding in check_case(case))


def test_the_bound_of_a_line_is_that_of_a_square_wave() -> None:
    # 4 c / pi is the fundamental of a square wave of amplitude c
    wave = [math.copysign(1e-4, math.sin(2 * math.pi * (k + 0.5) / 4000)) for k in range(4000)]
    line = 2 / 4000 * sum(x * math.sin(2 * math.pi * (k + 0.5) / 4000) for k, x in enumerate(wave))
    assert amplitude_bound(1e-4, 40.0) == pytest.approx(line * (2 * math.pi * 40.0) ** 2, rel=1e-5)
    notes = [f for f in check_case(load_case("han2021")) if f.path == "sleeves.ring.radial_clearance"]
    assert "40 Hz" in notes[0].message
    assert "8.04 m/s^2" in notes[0].message


def test_the_mesh_frequency_counts_teeth() -> None:
    case = load_case("han2021")
    assert mesh_frequency(case, 0) == pytest.approx(40.0)


ELEMENTS: dict[str, Any] = {
    "rotors": {
        "motor": {"mass": 1.0, "inertia": 1e-3, "drive": {"kind": "speed", "speed": 10.0}},
        "disc": {"mass": 1.0, "inertia": 1e-3},
    },
    "couplings": [{"between": ["motor", "disc"], "torsional_stiffness": 100.0}],
    "run": {"duration": 0.1, "sampling": 1e4},
}
STEP = {"kind": "record", "values": [0.0, 1.0, 2.0, 3.0], "sampling": 1e3}
POSITION = {
    "kind": "position",
    "angle": 1.0,
    "proportional_gain": 1.0,
    "torque_limit": 1.0,
    "sample_time": 0.05,
}


@pytest.mark.parametrize(
    ("changes", "path", "words"),
    [
        ({"couplings.0.lateral_stiffness": 1e6}, "couplings.0.lateral_stiffness", "both centres are held"),
        ({"supports": {"disc": {"damping": [1.0, 1.0]}}}, "supports.disc.damping", "the centre is held"),
        ({"supports": {"disc": {"stiffness": [1e6, 0.0]}}}, "supports.disc.stiffness", "free along y"),
        ({"rotors.motor.unbalance": {"amount": 1e-4}}, "rotors.motor.unbalance", "does nothing"),
        ({"rotors.motor.drive": POSITION}, "rotors.motor.drive.sample_time", "2 samples"),
    ],
)
def test_elements_that_can_do_nothing_are_found(changes: dict[str, Any], path: str, words: str) -> None:
    def warnings(case: Any) -> dict[str, str]:
        return {each.path: each.message for each in check_case(case) if each.severity == "warning"}

    sound = load_case(ELEMENTS)
    assert warnings(sound) == {}
    assert words in warnings(replace(sound, changes))[path]


def test_housing_record__an_end_before_the_run_is_reported() -> None:
    case = replace(load_case(ELEMENTS), {"base": {"acceleration": STEP}})
    notes = {each.path: each.message for each in check_case(case)}
    assert "ends at 0.003 s, the run at 0.1 s" in notes["base.acceleration.values"]
    assert "3 m/s^2" in notes["base.acceleration.values"]


@pytest.mark.parametrize(
    ("changes", "path", "words"),
    [
        (["run.transient=0s"], "run.transient", "begin with the start. Give a transient, 0.5 s"),
        (["meshes.0.damping.maximum=0"], "meshes.0.damping", "0 N s/m in 1 of 1 meshes (pinion-ring)"),
        (
            ["run.transient=0s", "rotors.pinion.drive.ramp=1ms"],
            "rotors.pinion.drive.ramp",
            "Make the ramp longer than",
        ),
        (
            ["run.transient=0s", "rotors.ring.load.torque=1 N m", "rotors.ring.initial.omega=0"],
            "meshes.0",
            "meet at the start with up to",
        ),
    ],
)
def test_transient_check__remains_of_the_start_are_reported(
    changes: list[str], path: str, words: str
) -> None:
    case = load_case("han2021", changes)
    found = [each for each in check_case(case) if each.path == path and each.severity == "warning"]
    assert len(found) == 1
    assert words in found[0].message


def test_a_start_that_is_left_out_of_the_record_is_no_matter() -> None:
    case = load_case("han2021", ["rotors.pinion.drive.ramp=1ms"])
    assert not any(each.path.endswith("ramp") for each in check_case(case))


def test_check__a_drive_without_a_load() -> None:
    """Driven, with errors of the teeth but nothing that resists: the teeth float."""
    words = found("two-stage-reducer", {"rotors.output.load": {}, "sleeves.output.radial_clearance": 1e-5})
    assert "no rotor has a load that resists the drive" in words["rotors"]


@pytest.mark.parametrize(
    ("part", "rotor", "warned"),
    [
        ({"stiffness": ["1e8 N/m", "1e8 N/m"]}, {}, True),
        ({"stiffness": ["1e8 N/m", "1e8 N/m"], "damping": ["1e3 N s/m", "1e3 N s/m"]}, {}, False),
        ({"stiffness": ["1e8 N/m", "1e8 N/m"]}, {"rotors.ring.radial_damping": "1e3 N s/m"}, False),
    ],
)
def test_check__centre_that_nothing_but_a_mesh_damps(
    part: dict[str, Any], rotor: dict[str, Any], warned: bool
) -> None:
    case = gp.replace("han2021-geometric-inertia", {"sleeves": {}, "supports": {"ring": part}, **rotor})
    said = [
        each
        for each in gp.check_case(case)
        if "only meshes damp the motion of the centre of ring" in each.message
    ]
    assert bool(said) == warned
    assert [each.path for each in said] == ["rotors.ring.radial_damping"] * warned


def test_check__bearing_without_damping() -> None:
    bearing = {
        "rolling_elements": 9,
        "element_diameter": "8 mm",
        "pitch_diameter": "40 mm",
        "stiffness": 1e10,
    }
    for damping in ({}, {"damping": {"kind": "hunt-crossley", "value": "100 s/m"}}):
        case = gp.replace(
            "han2021-geometric-inertia", {"sleeves": {}, "bearings": {"ring": bearing | damping}}
        )
        assert any("only meshes damp" in each.message for each in gp.check_case(case)) == (not damping)
