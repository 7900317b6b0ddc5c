"""`gp.teeth` and `gearplay teeth`: numbers of the drawing, stiffness and sharing, the clearance circle, the picture."""

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gearplay as gp
from docs_files import make_drawn_gears
from gearplay.cli.main import run
from gearplay.parts.mesh.mesh_stiffness import pack_stiffness
from gearplay.parts.mesh.train import geometry


@pytest.fixture
def stage(tmp_path: Path) -> Path:
    path = tmp_path / "wind-stage.toml"
    make_drawn_gears(path)
    return path


def test_numbers_of_the_drawing(stage: Path) -> None:
    found = gp.teeth(stage)
    assert found.values["contact_ratio"] == pytest.approx(1.370399731, abs=2e-9)
    assert math.degrees(found.values["working_pressure_angle"]) == pytest.approx(24.16945, abs=1e-5)
    pinion, wheel = found.gears.values()
    assert pinion["base_diameter"] == pytest.approx(0.378 * math.cos(math.radians(20.0)), rel=1e-12)
    assert pinion["working_pitch_diameter"] / 2 + wheel["working_pitch_diameter"] / 2 == pytest.approx(0.584)
    assert pinion["thickness_allowances"] == pytest.approx([-155e-6, -215e-6])
    table = dict(found.rows())
    assert table["teeth"] == "18 / 36"
    assert table["working pressure angle [deg]"].startswith("24.1695")


def test_span_measurement() -> None:
    """W_k touches parallel tangents k - 1 base pitches and a thickness at the base circle apart."""
    found = gp.teeth(gp.replace(gp.load_case("han2021"), {"rotors.pinion.allowance": "c25"}))
    pinion = found.gears["pinion"]
    alpha, radius = math.radians(20.0), 0.5 * pinion["base_diameter"]
    inv = math.tan(alpha) - alpha
    half = pinion["normal_thickness"] / (2.0 * 0.04) + inv  # half angle of the tooth at the base circle
    expected = (pinion["span_teeth"] - 1) * 2.0 * math.pi * radius / 20 + 2.0 * half * radius
    assert pinion["span"] == pytest.approx(expected, rel=1e-12)
    assert pinion["span_teeth"] == 3


def test_stiffness_and_sharing(stage: Path) -> None:
    """K is the sum of its pairs; shares add up to 1; the mean is that of the simulation."""
    found = gp.teeth(stage)
    pairs = found.ds["pair_stiffness"].values
    assert pairs.sum(axis=1) == pytest.approx(found.ds["mesh_stiffness"].values, rel=1e-12)
    assert found.ds["load_sharing_ratio"].values.sum(axis=1) == pytest.approx(1.0, rel=1e-9)
    assert np.all((pairs > 0.0).sum(axis=1) == found.ds["pairs_in_contact"].values)
    assert found.values["mean_stiffness"] == pytest.approx(
        pack_stiffness(gp.load_case(stage), 0).average, rel=1e-12
    )
    error = found.ds["static_transmission_error"].values
    force = 30e3 / found.gears["wheel"]["base_diameter"] * 2.0
    assert error.max() < force / found.ds["mesh_stiffness"].values.min()
    assert error.min() == pytest.approx(force / found.ds["mesh_stiffness"].values.max(), rel=2e-2)


@pytest.mark.parametrize("name", ["han2021", "two-stage-reducer", "planetary-reducer", "pinion-idler-ring"])
def test_every_bundled_mesh(name: str) -> None:
    """Other kinds of stiffness over the mesh period; contact ratio at the installed distance in the middle of the curve."""
    case = gp.load_case(name)
    for j, mesh in enumerate(case.meshes):
        found = gp.teeth(case, mesh.label)
        assert found.ds.attrs["mesh"] == mesh.label
        here = float(
            np.interp(found.values["center_distance"], found.ds["center_distance"], found.ds["backlash"])
        )
        assert here == pytest.approx(found.values["backlash"], rel=1e-4, abs=1e-9)
        stiffness = found.ds["mesh_stiffness"].values
        assert stiffness[:-1].mean() == pytest.approx(pack_stiffness(case, j).average, rel=2e-2)
        assert gp.teeth(case, j).ds.equals(found.ds)


def test_over_the_clearance_circle() -> None:
    """On the circle the centres are apart by |a + c e^(i phi)|; contact ratio and backlash are those of that distance."""
    case = gp.load_case("han2021")
    found = gp.teeth(case)
    play = 100e-6  # of the ring; the pinion is held
    for k in (0, 17, 36):
        phi = float(found.ds["direction"][k])
        distance = math.hypot(0.08 + play * math.cos(phi), play * math.sin(phi))
        drawn = geometry.pair_of(case, 0).at(distance)
        assert float(found.ds["contact_ratio_on_circle"][k]) == pytest.approx(drawn.contact_ratio, rel=1e-12)
        assert float(found.ds["backlash_on_circle"][k]) == pytest.approx(drawn.backlash + 100e-6, rel=1e-9)


def test_a_mesh_is_named() -> None:
    case = gp.load_case("two-stage-reducer")
    for mesh in (None, "nothing", 7, -1, 1.5):
        with pytest.raises(gp.InputError, match="must name a mesh"):
            gp.teeth(case, mesh)  # type: ignore[arg-type]


def test_the_command(stage: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = str(tmp_path / "out")
    assert run(["teeth", str(stage), "--out", out]) == 0
    assert "working pressure angle [deg]" in capsys.readouterr().out
    assert run(["teeth", str(stage), "--out", out, "--overwrite", "--json"]) == 0
    document: dict[str, Any] = json.loads(capsys.readouterr().out)
    assert document["pair"]["contact_ratio"] == pytest.approx(1.370399731, abs=2e-9)
    assert document["stiffness"]["least"] < document["stiffness"]["mean"] < document["stiffness"]["largest"]
    again = gp.read_result(document["out"])
    assert again.values == gp.teeth(stage).values
    assert Path(document["picture"]).stat().st_size > 10_000
    assert run(["teeth", str(stage), "--mesh", "wheel-pinion", "--out", out, "--overwrite"]) == 2


def test_the_picture(stage: Path) -> None:
    """Outlines, path of contact and curves are drawn from the numbers."""
    found = gp.teeth(stage)
    figure = found.plot()
    curve = 1e-6 * found.ds["mesh_stiffness"].values
    assert any(np.array_equal(line.get_ydata(), curve) for line in figure.axes[1].get_lines())
    x = 1e3 * found.ds["outline_first"].values[:, 0]
    assert any(np.array_equal(line.get_xdata(), x) for line in figure.axes[0].get_lines())
    assert figure.axes[0].get_xlabel() == "x [mm]"
