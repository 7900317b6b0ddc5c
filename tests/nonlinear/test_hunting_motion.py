"""Kinds of motion where all excitation repeats after a long time only, and progress where there is no terminal."""

import json
import sys
from typing import Any

import pytest

import gearplay as gp
from gearplay.cli import progress as cli_progress
from gearplay.cli.main import run
from gearplay.model.pack import pack
from gearplay.model.reading import to_toml
from gearplay.nonlinear.section_choice import chosen_period
from gearplay.solver import integration
from gearplay.solver.flow import Flow


def pair(z_1: int = 24, z_2: int = 38, load: float = 40.0) -> gp.Case:
    """Return a loaded pair with runouts of both gears, 42 mesh periods of its own decay in a section of 0.1 s."""
    part = {"runout": {"amplitude": "5 um"}}
    return gp.load_case(
        {
            "rotors": {
                "p": {
                    "teeth": z_1, "mass": 1.0, "inertia": 4e-4, **part,
                    "drive": {"kind": "speed", "speed": "1750 rpm"},
                },
                "w": {"teeth": z_2, "mass": 2.0, "inertia": 2e-3, "load": {"torque": load}, **part},
            },
            "meshes": [
                {
                    "driver": "p",
                    "driven": "w",
                    "module": "2 mm",
                    "backlash": "80 um",
                    "stiffness": {"kind": "harmonic", "mean": "2e8 N/m", "amplitude": "3e7 N/m"},
                    "damping": {"ratio": 0.08},
                    "transmission_error": [{"order": 1, "amplitude": "3 um"}],
                }
            ],
            "run": {"duration": 0.02, "transient": 0.02, "sampling": 2e4},
        }
    )  # fmt: skip


@pytest.mark.slow
def test_motion__hunting_teeth_by_mesh_periods() -> None:
    """Linear under load and forced: it repeats with the excitation, after lcm(24, 38) = 456 mesh periods of 1/700 s."""
    found = gp.motion(pair(), periods=600, settle=100, compare=False)
    assert found.period == pytest.approx(1.0 / 700.0, rel=1e-12)
    assert (found.kind, found.order) == ("periodic", 456)
    assert "456 periods (0.6514 s)" in found.reason
    assert found.exponent[0] < 0.0


@pytest.mark.slow
def test_motion__record_shorter_than_the_common_period() -> None:
    found = gp.motion(pair(), periods=200, settle=100, compare=False)
    assert found.kind != "periodic"
    assert "The record is shorter than 456 periods (0.6514 s)" in found.reason


@pytest.mark.parametrize(
    ("teeth", "which", "mesh_periods"),
    [
        ((24, 38), "auto", 1),
        ((24, 38), "common", 456),
        ((24, 38), "mesh", 1),
        ((10, 20), "auto", 20),  # every 20 mesh periods: taken as it is
        ((21, 42), "auto", 1),
        ((89, 97), "auto", 1),  # 8633: more than any search for a common period takes
    ],
)
def test_motion__period_of_the_section(teeth: tuple[int, int], which: str, mesh_periods: int) -> None:
    case = pair(*teeth)
    mesh = 60.0 / (1750.0 * teeth[0])
    assert chosen_period(pack(case), which).step == pytest.approx(mesh_periods * mesh, rel=1e-9)


def test_flow__limit_of_steps_is_that_of_one_piece(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(integration, "MOST_STEPS", 300)
    flow = Flow(pair())
    going = flow.begin(flow.start())
    for at in range(1, 41):
        going.advance(at / 700.0)
    assert going.steps > 300
    with pytest.raises(gp.SimulationError, match="limit on steps"):
        flow.begin(flow.start()).advance(10.0)


@pytest.mark.slow
def test_progress__lines_where_there_is_no_terminal(
    tmp_path: Any, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "pair.toml"
    file.write_text(to_toml(pair()))
    words = ["motion", str(file), "--periods", "100", "--settle", "20", "--no-compare"]
    monkeypatch.setattr(cli_progress, "INTERVAL", 0.0)
    assert not sys.stderr.isatty()
    assert run(words) == 0
    lines = capsys.readouterr().err.splitlines()
    assert "settling: 50 %" in lines
    assert "section: 100 %" in lines
    assert run([*words, "--json"]) == 0
    printed = capsys.readouterr()
    assert printed.err == ""
    assert json.loads(printed.out)["section"]["period"] == pytest.approx(1.0 / 700.0)
