import copy
import json
import pickle
import re
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gearplay as gp
from gearplay.files.plan_files import plan_document
from gearplay.model.case import Case
from gearplay.model.reading import bundled_names, load_case, replace, to_toml
from gearplay.model.toml_files import text_depth, write_toml
from gearplay.rig.plan import load_rig
from gearplay.vocabulary.errors import InputError

BUNDLED = [
    "cooley-parker-2012",
    "external-pair",
    "han2021",
    "han2021-calibrated",
    "han2021-calibrated-uncoupled",
    "han2021-geometric-inertia",
    "han2021-pairs",
    "kahraman-singh-1990",
    "lin-parker-1999",
    "pinion-idler-ring",
    "planetary-reducer",
    "pulsating-pair",
    "space-drive",
    "space-launch",
    "torsional-train",
    "two-stage-reducer",
]


def refusal(call: Any, *arguments: Any) -> str:
    with pytest.raises(InputError) as caught:
        call(*arguments)
    return str(caught.value)


def test_the_bundled_cases_are_there() -> None:
    assert bundled_names() == BUNDLED


@pytest.mark.parametrize("name", BUNDLED)
def test_a_case_survives_every_way_of_writing_it(name: str, tmp_path: Path) -> None:
    case = load_case(name)
    path = tmp_path / "again.toml"
    path.write_text(to_toml(case), encoding="utf-8")
    through_json = json.loads(json.dumps(case.resolved(), allow_nan=False))
    copies = [
        load_case(path),
        load_case(str(path)),
        load_case(through_json),
        load_case(case.resolved()),
        replace(case, {}),
    ]
    copies += [pickle.loads(pickle.dumps(case)), copy.deepcopy(case)]
    for again in copies:
        assert again == case
        assert again.sha256 == case.sha256
        assert list(again.rotors) == list(case.rotors)


def test_the_article_s_case_in_si() -> None:
    case = load_case("han2021")
    pinion, ring, mesh = case.rotors["pinion"], case.rotors["ring"], case.meshes[0]
    assert (pinion.teeth, ring.teeth, ring.internal) == (20, 60, True)
    assert (pinion.mass, pinion.inertia, ring.mass, ring.inertia) == (0.235, 0.0189, 0.8, 0.0612)
    assert (mesh.module, mesh.backlash, case.sleeves["ring"].radial_clearance) == (0.004, 1e-4, 1e-4)
    assert list(case.sleeves) == ["ring"]
    assert pinion.drive is not None
    assert pinion.drive.kind == "speed"
    assert pinion.drive.speed == pytest.approx(4 * np.pi)
    assert ring.load.drag > 0.0


def test_the_geometric_inertias_are_those_of_disc_and_annulus() -> None:
    printed, fitting = load_case("han2021"), load_case("han2021-geometric-inertia")
    assert fitting.rotors["pinion"].inertia == pytest.approx(0.235 * 0.04**2 / 2, rel=1e-3)
    assert fitting.rotors["ring"].inertia == pytest.approx(0.8 * (0.118**2 + 0.135**2) / 2, rel=1e-9)
    same = {f"rotors.{name}.inertia": rotor.inertia for name, rotor in printed.rotors.items()}
    same["meshes.0.damping.maximum"] = printed.meshes[0].damping.maximum  # 7 % of critical in both
    assert replace(fitting, {"title": printed.title, "accepted": printed.accepted, **same}) == printed


def test_digest__depends_on_values_and_not_on_spelling() -> None:
    case = load_case("han2021")
    same = load_case(
        "han2021", ["meshes.0.backlash=0.1 mm", "run.seed=0", 'meshes.0.pressure_angle="20 deg"']
    )
    assert same.sha256 == case.sha256
    assert load_case("han2021", ["meshes.0.backlash=0.11 mm"]).sha256 != case.sha256
    document = case.resolved()
    document["rotors"] = dict(reversed(document["rotors"].items()))
    assert load_case(document).sha256 != case.sha256
    assert load_case({**case.resolved(), "gravity": [-0.0, 0]}).sha256 == case.sha256


def test_a_case_cannot_be_changed() -> None:
    case = load_case("han2021")
    with pytest.raises(InputError, match="must not be assigned"):
        case.title = "other"
    with pytest.raises(TypeError, match="replace"):
        case.rotors["other"] = case.rotors["ring"]
    with pytest.raises(TypeError, match="replace"):
        case.sleeves.clear()


@pytest.mark.parametrize(
    ("override", "read"),
    [
        ("meshes.0.backlash=200 um", lambda case: case.meshes[0].backlash == 2e-4),
        ("meshes.0.backlash=200um", lambda case: case.meshes[0].backlash == 2e-4),
        ('meshes.0.backlash = "200 um"', lambda case: case.meshes[0].backlash == 2e-4),
        ("meshes.0.backlash=0.0002", lambda case: case.meshes[0].backlash == 2e-4),
        ("run.seed=7", lambda case: case.run.seed == 7),
        ("run.max_steps=1000", lambda case: case.run.max_steps == 1000),
        ("title=a = b", lambda case: case.title == "a = b"),
        ("gravity=[0, -9.81]", lambda case: case.gravity == (0.0, -9.81)),
        ("rotors.pinion.load.drag=1e-3", lambda case: case.rotors["pinion"].load.drag == 1e-3),
        ("rotors.pinion.drive={kind='torque', torque=5}", lambda case: case.rotors["pinion"].drive.torque == 5.0),
        ("meshes.0.transmission_error.0.amplitude=3um", lambda c: c.meshes[0].transmission_error[0].amplitude == 3e-6),
        ("rotors.disc={mass=1, inertia=1}", lambda case: list(case.rotors) == ["pinion", "ring", "disc"]),
    ],
)  # fmt: skip
def test_overrides(override: str, read: Any) -> None:
    assert read(load_case("han2021", [override]))


@pytest.mark.parametrize(
    ("override", "named"),
    [
        ("meshes.0.backlsh=1", "'backlash'"),
        ("meshes.1.backlash=1", "no such item: meshes has 1 item"),
        ("meshes.-1.backlash=1", "no such item"),
        ("meshes.backlash=1", "no such item"),
        ("mesh.0.backlash=1", "'meshes'"),
        ("rotors.rng.mass=1", "'ring'"),
        ("sleeves.pinion.restitution=1", "no such entry"),
        ("bearings.rng.elements=7", "no such entry"),
        ("rotors.ring.lod.drag=1", "'load'"),
        ("run.duration.x=1", "has no parts"),
        ("run.duration", "path=value"),
        ("=1", "path=value"),
        ("run..seed=1", "not a path"),
        ("run.seed=" + "1" * 5000, "4096"),
        ("run.seed=" + "[" * 3000, "run.seed"),
        ("run." + "a." * 40 + "b=1", "not a path"),
        ("run.seed=1\nrun.x=2", "run.seed"),
        ("run.duration=9**9**9 s", "run.duration"),
    ],
)
def test_overrides_that_lead_nowhere(override: str, named: str) -> None:
    message = refusal(load_case, "han2021", [override])
    assert named in message
    assert "Traceback" not in message


def test_replace_validates_again() -> None:
    case = load_case("han2021")
    assert "meshes.0.backlash" in refusal(replace, case, {"meshes.0.backlash": "-1 um"})
    assert "'backlash'" in refusal(replace, case, {"meshes.0.backlsh": 1.0})
    assert replace(case, {"meshes.0.backlash": np.float64(3e-4), "run.seed": np.int64(3)}).run.seed == 3
    given = replace(case, {"sleeves.ring.material": None, "sleeves.ring.stiffness": 1.5e11})
    assert given.sleeves["ring"].stiffness == 1.5e11
    assert (
        replace(case, {"meshes.0.damping.ratio": None, "meshes.0.damping.maximum": "500 N s/m"})
        .meshes[0]
        .damping.maximum
        == 500
    )


def test_a_mark_of_byte_order_is_no_fault(tmp_path: Path) -> None:
    path = tmp_path / "case.toml"
    path.write_text(to_toml(load_case("han2021")), encoding="utf-8-sig")
    assert load_case(path).title.startswith("Han")


def test_parts_at_fault_do_not_hide_names_at_fault() -> None:
    document = load_case("pinion-idler-ring").resolved()
    document["meshes"][0] |= {"driven": "idlr", "module": -1.0}
    document["sleeves"]["rng"] = document["sleeves"].pop("ring")
    lines = refusal(load_case, document).splitlines()
    assert [line.split(":")[0].split(" =")[0] for line in lines] == [
        "meshes.0.module",
        "sleeves.rng",
        "meshes.0.driven",
    ]


@pytest.mark.parametrize(
    ("change", "named"),
    [
        ({"meshes.1.module": 0.005}, ["meshes.1.module", "idler is in both"]),
        ({"meshes.1.pressure_angle": "25 deg"}, ["meshes.1.pressure_angle"]),
        ({"sleeves.idler.on": "ring", "sleeves.ring.on": "idler"}, ["closes a circle", "on"]),
    ],
)
def test_parts_that_do_not_fit_each_other(change: dict[str, Any], named: list[str]) -> None:
    message = refusal(replace, load_case("pinion-idler-ring"), change)
    assert all(name in message for name in named)


def test_a_planet_on_a_carrier_is_accepted() -> None:
    case = replace(
        load_case("pinion-idler-ring"),
        {"rotors.carrier": {"mass": 1.0, "inertia": 0.01}, "sleeves.idler.on": "carrier"},
    )
    assert case.sleeves["idler"].on == "carrier"


def test_case_class__accepts_the_documents_of_load_case() -> None:
    assert Case.model_validate(load_case("han2021").resolved()) == load_case("han2021")


def test_toml_is_written_as_it_is_read() -> None:
    document = {
        "title": 'quote " backslash \\ tab \t delete \x7f and é',
        "rotors": {"a": {"x": 1e-300, "flag": True, "none": None, "deep": {"list": [1, 2.5, {"k": "v"}]}}},
        "meshes": [{"a": 1, "damping": {"ratio": 0.5}}, {"a": 2}],
        "empty": {},
        "list": [],
    }
    del (expected := copy.deepcopy(document))["rotors"]["a"]["none"]  # type: ignore[index]
    assert tomllib.loads(write_toml(document)) == expected


@pytest.mark.parametrize(
    ("text", "depth"),
    [
        ("a = 1", 0),
        ("a.b = 1", 2),
        ("[a.b.c]", 3),
        ("a = [[1.5, 2.5]]", 2),
        ('a = "[[[[.......]]]]"', 0),
        ("a = '''[[[['''", 0),
        ('a = """[["[["" [[ \\""" """', 0),
        ("# [[[[ a.b.c.d.e", 0),
        ("'a.b'.c = {d = [1]}", 2),
        ('a = "\\"[["', 0),
    ],
)
def test_the_depth_of_text(text: str, depth: int) -> None:
    assert text_depth(text) == depth


def test_case__a_stored_result_is_named_as_one(tmp_path: Path) -> None:
    """A result's file in place of a case is no file that is too long, or text that is no UTF-8."""
    place = tmp_path / "run.nc"
    gp.simulate("han2021", duration=0.01, transient=0.0).save(place)
    with pytest.raises(
        InputError, match=r"must be a case, not a stored result. Pass what gearplay.read_result returns"
    ):
        gp.load_sharing(str(place))


@pytest.mark.parametrize(
    ("field", "table"),
    [("sleeve", r"\[sleeves.wheel\]"), ("bearing", r"\[bearings.wheel\]"), ("mesh", r"\[\[meshes\]\]")],
)
def test_a_part_written_into_its_rotor_names_its_table(field: str, table: str) -> None:
    document = {"rotors": {"wheel": {"mass": 1.0, "inertia": 1.0, field: {}}}, "run": {"duration": 1.0}}
    with pytest.raises(
        gp.InputError, match=rf"rotors\.wheel\.{field}: unknown field\. Write it as a table: {table}"
    ):
        gp.load_case(document)


def test_a_missing_table_is_named_with_its_required_fields() -> None:
    with pytest.raises(gp.InputError, match=r"run: is required\. Add a table \[run\] with duration\."):
        gp.load_case({"rotors": {"wheel": {"mass": 1.0, "inertia": 1.0}}})


@pytest.mark.parametrize(("name", "heading"), [("rotors", "[rotors.NAME]"), ("run", "[run]")])
def test_missing_tables__are_named_as_a_file_writes_them(name: str, heading: str) -> None:
    document = {key: value for key, value in gp.load_case("han2021").resolved().items() if key != name}
    with pytest.raises(gp.InputError, match=re.escape(f"{name}: is required. Add a table {heading} with")):
        gp.load_case(document)


def test_fields__are_constant_and_the_cure_is_a_copy() -> None:
    case = gp.load_case("han2021")
    rule = r"^backlash = 0.0001: must not be assigned: fields are constant. Make a changed copy, for example gearplay.replace"
    with pytest.raises(gp.InputError, match=rule):
        case.meshes[0].backlash = 1e-4
    assert case == gp.load_case("han2021")


@pytest.mark.parametrize(("name", "kind"), [("m.csv", "table"), ("long.CSV", "table"), ("m.wav", "record")])
def test_a_table_or_record_given_as_a_case_is_named_as_one(name: str, kind: str, tmp_path: Path) -> None:
    """A long one was refused for its size, a short one for its TOML."""
    file = tmp_path / name
    file.write_text("time,acceleration\n" + "0.0,1.0\n" * (100_000 if name.startswith("long") else 3))
    said = refusal(load_case, file)
    assert f"must be a case in TOML, but this is a {kind} by its extension" in said
    assert "gearplay.read_measurement" in said
    assert f"must be a rig in TOML, but this is a {kind}" in refusal(load_rig, file)
    assert f"must be a plan in TOML, but this is a {kind}" in refusal(
        plan_document, str(file), "gearplay.sweeps"
    )
    assert "no such file" in refusal(load_case, tmp_path / f"missing-{name}")


def test_a_bare_angle_in_degrees_is_told_its_unit() -> None:
    """20 rad is far out of range; 20 deg is not. No hint where degrees would be out of range too, or the unit was written."""
    pair = load_case("external-pair").resolved()

    def said(angle: float | str) -> str:
        return refusal(replace, pair, {"meshes.0.pressure_angle": angle})

    assert 'A plain number is in rad: write "20 deg" if these are degrees' in said(20)
    assert "Choose a value in this range" in said(90)
    assert "Choose a value in this range" in said("20 rad")


@pytest.mark.parametrize("speed", ["16.6667 Hz", "16.6667 1/s", "3 furlongs", "3 degC"])
def test_a_speed_in_another_unit_is_told_usual_ones(speed: str) -> None:
    case = load_case("external-pair")
    driven = next(name for name, rotor in case.rotors.items() if getattr(rotor.drive, "kind", "") == "speed")
    assert "Use a unit such as rpm, rev/s or rad/s" in refusal(
        replace, case, {f"rotors.{driven}.drive.speed": speed}
    )
