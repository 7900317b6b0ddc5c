"""`gp.export_dxf` and `gearplay export dxf`, read back by ezdxf."""

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gearplay as gp
from docs_files import make_drawn_gears
from gearplay.cli.main import run
from gearplay.parts.mesh.train import geometry

ezdxf = pytest.importorskip("ezdxf")


def drawn(case: Any, folder: Path) -> Any:
    document = ezdxf.readfile(gp.export_dxf(case, folder / "gears.dxf"))
    assert not document.audit().errors
    assert document.units == 4  # mm
    return document


def around(outline: Any, centre: tuple[float, float]) -> tuple[Any, Any]:
    """Return radii [m] and angles [rad] of an outline's points about a centre [m]."""
    points = 1e-3 * np.array([(x, y) for x, y, *_ in outline.get_points()]) - centre
    return np.hypot(*points.T), np.unwrap(np.arctan2(points[:, 1], points[:, 0]))


@pytest.mark.parametrize("name", ["han2021", "two-stage-reducer", "planetary-reducer", "wind"])
def test_outlines__closed_with_all_teeth_between_their_circles(name: str, tmp_path: Path) -> None:
    if name == "wind":
        make_drawn_gears(tmp_path / "wind.toml")
    case = gp.load_case(tmp_path / "wind.toml" if name == "wind" else name)
    document = drawn(case, tmp_path)
    gears = {
        geometry.full_name(case, called): (called, gear)
        for j in range(len(case.meshes))
        for called, gear in zip(geometry.gears_of_pair(case, j), geometry.gears_of(case, j), strict=True)
    }
    outlines = list(document.modelspace().query("LWPOLYLINE"))
    assert len(outlines) == len(gears)
    centres = geometry.centres(case)
    for called, gear in gears.values():
        rotor = geometry.rotor_of(case, called)
        own = [each for each in outlines if each.dxf.layer == rotor]
        found = next(
            each
            for each in own
            if abs(max(around(each, centres[rotor])[0]) - max(gear.tip, gear.root)) < 1e-9
        )
        radius, angle = around(found, centres[rotor])
        assert found.closed
        assert angle[-1] - angle[0] == pytest.approx(2.0 * math.pi, abs=2.0 * math.pi / gear.teeth)
        inner, outer = sorted((gear.tip, gear.root))
        assert [radius.min(), radius.max()] == pytest.approx([inner, outer], abs=1e-9)
        reached = np.abs(radius - outer) < 1e-9
        assert np.count_nonzero(reached & ~np.roll(reached, 1)) == gear.teeth
        bulges = np.array([each[-1] for each in found.get_points()])
        lands = np.nonzero(bulges)[0]
        steps = np.roll(angle, -1)[lands] - angle[lands]
        assert np.tan(0.25 * np.mod(steps, 2.0 * math.pi)) == pytest.approx(bulges[lands], abs=1e-12)
        assert np.roll(radius, -1)[lands] == pytest.approx(radius[lands], abs=1e-12)


def test_teeth__as_thick_as_thickness_and_backlash_leave_them_in_the_middle_of_spaces(tmp_path: Path) -> None:
    """On the working circles tooth and space differ by the backlash, and the gaps on both sides are equal."""
    document = drawn("two-stage-reducer", tmp_path)
    case = gp.load_case("two-stage-reducer")
    pair, centres = geometry.installed_pair(case, 0), geometry.centres(case)
    thick = []
    for rotor, towards, working in (
        ("input", 0.0, pair.working_radii[0]),
        ("layshaft", math.pi, pair.working_radii[1]),
    ):
        for each in document.modelspace().query(f'LWPOLYLINE[layer=="{rotor}"]'):
            radius, angle = around(each, centres[rotor])
            if radius.min() < working < radius.max():
                break
        crossings = np.nonzero((radius < working) != (np.roll(radius, -1) < working))[0]
        low, high = radius[crossings], np.roll(radius, -1)[crossings]
        step = np.mod(np.roll(angle, -1)[crossings] - angle[crossings] + math.pi, 2.0 * math.pi) - math.pi
        flanks = (
            np.sort(
                np.mod(
                    angle[crossings] + step * (working - low) / (high - low) - towards + math.pi,
                    2.0 * math.pi,
                )
            )
            - math.pi
        )
        before, after = flanks[flanks < 0.0].max(), flanks[flanks >= 0.0].min()
        assert before + after == pytest.approx(
            0.0, abs=1e-9
        )  # a tooth or a space lies on the line of centres
        thick.append(working * (after - before))
    gap = case.meshes[0].backlash / math.cos(pair.working_angle)
    assert abs(thick[0] - thick[1]) == pytest.approx(gap, abs=1e-6)  # within the chords of the flanks


def test_layers__circles_clearance_bore(tmp_path: Path) -> None:
    case = gp.replace(gp.load_case("han2021"), {"rotors.pinion.bore": "20 mm"})
    space = drawn(case, tmp_path).modelspace()
    radii = {
        layer: sorted(each.dxf.radius for each in space.query(f'CIRCLE[layer=="{layer}"]'))
        for layer in ("pinion", "pinion (circles)", "ring (clearance)")
    }
    assert radii["pinion"] == pytest.approx([10.0], rel=1e-12)
    assert radii["pinion (circles)"] == pytest.approx(
        [35.0, 40.0 * math.cos(math.radians(20.0)), 40.0, 44.0], rel=1e-12
    )
    assert radii["ring (clearance)"] == pytest.approx([1e3 * geometry.clearance_of(case, "ring")], rel=1e-12)
    centres = {each.dxf.layer: each.dxf.location.vec2 for each in space.query("POINT")}
    assert [centres["pinion"].x, centres["ring"].x] == pytest.approx([80.0, 0.0])


def test_command(tmp_path: Path, capsys: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert run(["export", "dxf", "han2021", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert Path(found["out"]).name == "han2021.dxf"
    assert found["size"] == Path("han2021.dxf").stat().st_size / 1e6
    assert run(["export", "dxf", "han2021"]) == 2
    assert "han2021.dxf" in capsys.readouterr().err
    assert run(["export", "dxf", "han2021", "--out", "gears.step"]) == 2
    assert "must end in .dxf. Write gears.dxf" in capsys.readouterr().err
