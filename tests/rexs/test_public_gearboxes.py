"""Public gearboxes of other programs: numbers of their drawings, one case from every form, assembly and a run."""

import json
import re
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest

import gearplay as gp
from gearplay.cli.main import run
from gearplay.model.toml_files import parse_toml
from gearplay.parts.mesh.train.rolling import nominal_speeds
from gearplay.rexs.importing import import_rexs
from rexs.gearbox_files import DOCS, PLANETARY, TWO_STAGES, WORM, packed, unpacked


@pytest.fixture(scope="module")
def stages() -> gp.Case:
    return import_rexs(TWO_STAGES).case


@pytest.fixture(scope="module")
def planets() -> gp.Case:
    return import_rexs(PLANETARY).case


def test_shafts_have_the_mass_and_inertia_of_their_sections(stages: gp.Case) -> None:
    """Computed elsewhere from the sections of the file and 7.85 kg/dm^3."""
    expected = [(3.471106, 1.328870e-3), (11.282637, 9.662839e-3), (5.384938, 3.135031e-3)]
    found = [(rotor.mass, rotor.inertia) for rotor in stages.rotors.values()]
    np.testing.assert_allclose(found, expected, rtol=4e-7)


def test_two_stages_have_the_ratio_of_their_teeth(stages: gp.Case) -> None:
    teeth = [[stages.rotors[name].gear(gear).teeth for name, gear in _gears(mesh)] for mesh in stages.meshes]
    assert teeth == [[27, 51], [23, 34]]
    ratio = gp.simulate(stages, duration="20 ms", transient="0 s").ds
    speeds = [float(ratio.omega.sel(rotor=name).mean()) for name in ("shaft_12", "shaft_14")]
    assert speeds[0] / speeds[1] == pytest.approx(51 / 27 * 34 / 23, rel=2e-3)
    nominal = dict(zip(stages.rotors, nominal_speeds(stages), strict=True))
    assert abs(nominal["shaft_12"] / nominal["shaft_14"] - 51 / 27 * 34 / 23) < 1e-12


def _gears(mesh: Any) -> list[tuple[str, str]]:
    return [(name.partition(".")[0], name.partition(".")[2]) for name in (mesh.driver, mesh.driven)]


def test_two_stages_have_the_drawing_of_the_file(stages: gp.Case) -> None:
    """The pairs are mounted where their shifts leave no backlash, within 6 nm; the tip diameter of 1 mm is none."""
    first, second = stages.meshes
    assert [mesh.module for mesh in stages.meshes] == [0.0045, 0.0065]
    assert [mesh.center_distance for mesh in stages.meshes] == [0.19, 0.19]
    wheel, pinion = (
        stages.rotors["shaft_13"].gears[name] for name in ("cylindrical_gear_17", "cylindrical_gear_16")
    )
    assert (wheel.profile_shift, pinion.profile_shift) == (0.231415, 0.15074)
    assert np.degrees([wheel.helix_angle, pinion.helix_angle]).tolist() == pytest.approx([-21.0, -10.0])
    assert pinion.tip_diameter is None
    assert np.degrees([first.angle, second.angle]).tolist() == pytest.approx([270.0, 90.0])


def test_loads_of_a_spectrum_are_balanced_by_power(stages: gp.Case) -> None:
    assert stages.rotors["shaft_12"].drive.speed == pytest.approx(543.0 * np.pi / 30.0)
    assert stages.rotors["shaft_14"].load.torque == pytest.approx(567.0 * 51 / 27 * 34 / 23, rel=1e-10)
    third = import_rexs(TWO_STAGES, load_case=3).case
    assert third.rotors["shaft_14"].load.torque == pytest.approx(456.0 * 51 / 27 * 34 / 23, rel=1e-10)
    assert third.rotors["shaft_12"].drive.speed == pytest.approx(1234.0 * np.pi / 30.0)


def test_bearings_of_two_stages(stages: gp.Case) -> None:
    """Concept bearings without a stiffness hold the layshaft; catalogue bearings are supports."""
    assert set(stages.supports) == {"shaft_12", "shaft_14"}
    notes = "\n".join(map(str, import_rexs(TWO_STAGES).notes))
    for word in ("33014", "6210-2Z", "tip diameter", "axial forces", "tilt of shafts", "c25", "lubricant"):
        assert word in notes


def test_planetary_stage_has_the_drawing_of_the_file(planets: gp.Case) -> None:
    stage = planets.planetary["stage"]
    assert (stage.sun.teeth, stage.planets.teeth, stage.ring.teeth) == (17, 22, 61)
    assert stage.center_distance == 0.078
    assert stage.center_distance_allowance == "js7"
    assert (stage.sun.allowance, stage.planets.allowance, stage.ring.allowance) == ("c25", "c25", None)
    assert stage.ring.fixed
    assert np.degrees(stage.planets.directions).tolist() == pytest.approx([90.0, 210.0, 330.0])


def test_rigid_couplings_make_one_carrier(planets: gp.Case) -> None:
    """Two shafts, two plates and three pins 78 mm off the axis; the strut's material has no density."""
    rho, ring = (
        7850.0,
        lambda length, outer, inner: (np.pi / 4 * length * (outer**2 - inner**2), (outer**2 + inner**2) / 8),
    )
    parts = [
        ring(0.1, 0.08, 0.06),
        ring(0.008, 0.099, 0.088),
        ring(0.008, 0.219, 0.08),
        ring(0.008, 0.219, 0.099),
    ]
    pin = ring(0.066, 0.0432, 0.0)
    mass = rho * (sum(volume for volume, _ in parts) + 3 * pin[0])
    inertia = rho * (sum(volume * square for volume, square in parts) + 3 * pin[0] * (pin[1] + 0.078**2))
    carrier = planets.planetary["stage"].carrier
    assert (carrier.mass, carrier.inertia) == pytest.approx((mass, inertia), rel=1e-7)


def test_planetary_load_is_that_of_willis(planets: gp.Case) -> None:
    stage = planets.planetary["stage"]
    assert stage.sun.drive.speed == pytest.approx(1500.0 * np.pi / 30.0)
    assert stage.carrier.load.torque == pytest.approx(1591.5494309189535 * (1 + 61 / 17), rel=1e-10)


def as_json(text: str, *, lose_vectors: bool) -> str:
    """Return a model as JSON, as a program writes it that loses vectors and writes whole numbers as floats."""
    root = ElementTree.fromstring(text)

    def attribute(each: ElementTree.Element) -> dict[str, Any]:
        given = {"id": each.get("id"), "unit": (each.get("unit") or "").replace("°", "deg")}
        cells = [cell.text for cell in each.iter("c")]
        value = (each.text or "").strip()
        if cells:
            numbers = (
                {"floating_point_array": [float(cell or 0) for cell in cells]}
                if cells[0] != "true"
                else {"boolean_array": [True]}
            )
            return given | ({"boolean": False} if lose_vectors and cells[0] != "true" else numbers)
        if re.fullmatch(r"-?[\d.]+(E-?\d+)?", value):
            return given | {"floating_point": float(value)}
        return given | ({"boolean": value == "true"} if value in ("true", "false") else {"string": value})

    model = dict(root.attrib)
    relations = [
        {
            "id": int(each.get("id", "0")),
            "type": each.get("type"),
            "refs": [{"id": int(ref.get("id", "0")), "role": ref.get("role")} for ref in each],
        }
        for each in root.iter("relation")
    ]
    components = [
        {
            "id": int(each.get("id", "0")),
            "type": each.get("type"),
            "name": each.get("name"),
            "attributes": [attribute(a) for a in each],
        }
        for each in root.iter("component")
    ]
    return json.dumps({"model": model | {"relations": relations, "components": components}})


@pytest.mark.parametrize("lose_vectors", [False, True])
def test_every_form_of_a_file_is_one_case(planets: gp.Case, tmp_path: Path, lose_vectors: bool) -> None:
    """XML, JSON and zip; of JSON also as one program writes it, with a truth value instead of every vector."""
    text = unpacked(PLANETARY)
    (tmp_path / "stage.rexs").write_text(text, encoding="utf-8-sig")
    (tmp_path / "stage.rexsj").write_text(as_json(text, lose_vectors=lose_vectors), encoding="utf-8")
    (tmp_path / "stage.rexsz").write_bytes(packed(as_json(text, lose_vectors=lose_vectors), "model.rexsj"))
    for name in ("stage.rexs", "stage.rexsj", "stage.rexsz"):
        assert import_rexs(tmp_path / name).case == planets
        assert import_rexs(tmp_path / name).case.sha256 == planets.sha256


def test_a_file_that_has_lost_its_allowances(planets: gp.Case, tmp_path: Path) -> None:
    """As one program writes enumerations in JSON: sun and planets get the series, which leaves the ring without, as it was."""
    text = as_json(unpacked(PLANETARY), lose_vectors=False).replace('"string": "c25"', '"boolean": false')
    (tmp_path / "stage.rexsj").write_text(text, encoding="utf-8")
    found = import_rexs(tmp_path / "stage.rexsj")
    assert found.case == planets
    assert any("truth value" in str(note) for note in found.notes)


def test_a_worm_stage_is_refused_with_its_reason() -> None:
    with pytest.raises(gp.InputError, match=r"worm_stage 3.*cannot be imported.*axes of a worm stage cross"):
        import_rexs(WORM)


@pytest.mark.parametrize("path", [PLANETARY, TWO_STAGES], ids=["planetary", "stages"])
def test_import_check_run(path: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    case = tmp_path / "case.toml"
    assert run(["import", str(path), "--out", str(case), "--gear-bodies", "solid"]) == 0
    said = capsys.readouterr()
    assert "left out: bending and tilt of shafts" in said.err
    assert f"Next: gearplay check {case}" in said.out
    assert run(["check", str(case)]) == 0
    assert "valid, no warnings" in capsys.readouterr().out
    assert run(["run", str(case), "--duration", "20ms", "--out", str(tmp_path / "run.nc")]) == 0
    assert gp.read_result(tmp_path / "run.nc").success


def test_what_is_written_is_what_was_validated(tmp_path: Path) -> None:
    found = import_rexs(PLANETARY)
    assert gp.load_case(found.save(tmp_path / "stage.toml")) == found.case
    lines = found.text.splitlines()
    for note in found.notes:
        assert any(line.startswith(f"# - {note.kind}") for line in lines)
    assert max(map(len, (line for line in lines if line.startswith("#")))) < 120


@pytest.mark.slow
def test_thinner_teeth_strike_harder(tmp_path: Path) -> None:
    """The table of the page: the plan that it shows, at 900 rpm. The motion is chaotic: 0.3 s of it differ by 10 %."""
    page = (DOCS.parent / "how-to" / "gearbox-program.md").read_text(encoding="utf-8")
    plan = parse_toml(re.findall(r"```toml\n(.*?)```", page, re.DOTALL)[0], "plan")
    row = re.search(r"at 900 rpm, rms \[m/s²\] \|(.*)\|", page)
    assert row is not None
    axes = [{"name": "speed", "path": plan["axes"][0]["path"], "values": ["900 rpm"]}, plan["axes"][1]]
    case = import_rexs(TWO_STAGES, gear_bodies="solid").case
    noise = gp.sweep(case, axes, set=plan["set"], reduce=plan["reduce"]).ds.noise.values.ravel()
    np.testing.assert_allclose(noise, [float(each) for each in row[1].split("|")], rtol=0.2)
    assert np.all(np.diff(noise) > 0.0)
