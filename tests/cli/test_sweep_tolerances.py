"""`gearplay sweep` with `[tolerance]`: the answers are written, printed, kept, and a wrong limit is told before anything runs."""

import json
from pathlib import Path
from typing import Any

import pytest

import gearplay as gp
from gearplay.cli.main import run
from gearplay.model.bundled import bundled
from gearplay.model.toml_files import write_toml
from gearplay.sweeps.plans.reading import PACKAGE, load_sweep
from gearplay.sweeps.running.evaluate import Sweep

PLAN: dict[str, Any] = {
    "title": "tolerances",
    "case": "han2021",
    "members": 2,
    "set": {"run.duration": 0.05, "run.transient": 0.0, "run.sampling": 1e3, "run.tolerance": 1e-6},
    "design": {
        "kind": "monte-carlo",
        "count": 16,
        "parameters": [
            {
                "name": "error",
                "path": "meshes.0.transmission_error.0.amplitude",
                "distribution": "uniform",
                "low": "0.5 um",
                "high": "4 um",
            }
        ],
    },
    "reduce": [{"kind": "statistic", "name": "rms", "signal": "ax", "at": "ring"}],
    "tolerance": {"measure": "rms", "limit": "0.2 m/s^2", "probability": 0.5, "scale": ["error"], "steps": 5},
}


def written(folder: Path, plan: dict[str, Any]) -> Path:
    path = folder / "plan.toml"
    path.write_text(write_toml(plan), encoding="utf-8")
    return path


@pytest.mark.slow
def test_the_answers_are_written_and_kept(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    plan, out = written(tmp_path, PLAN), tmp_path / "out"
    assert run(["sweep", str(plan), "--out", str(out)]) == 0
    assert "rms exceeds 0.2 m/s² with probability" in capsys.readouterr().out
    document = json.loads((out / "tolerance.json").read_text(encoding="utf-8"))
    assert document["search"] is not None
    runs = sorted(path.name for path in (out / "tolerance").iterdir())
    assert sum(name.startswith("factor-") for name in runs) >= 5
    before = {path: path.stat().st_mtime_ns for path in (out / "tolerance").glob("*/rows.sqlite")}
    assert run(["resume", str(out), "--json"]) == 0
    again = json.loads(capsys.readouterr().out)
    assert again["ran"] == 0
    assert again["tolerance"]["search"] == document["search"]
    assert {path: path.stat().st_mtime_ns for path in before} == before  # nothing was simulated twice


def test_limit__a_wrong_unit_is_reported_before_the_simulations(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    plan = written(tmp_path, {**PLAN, "tolerance": {**PLAN["tolerance"], "limit": "3 um"}})
    assert run(["sweep", str(plan), "--out", str(tmp_path / "out")]) == 2
    assert "tolerance.limit" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("name", bundled(PACKAGE, "plans"))
def test_bundled_plans_fit_their_cases(name: str) -> None:
    made = Sweep(load_sweep(name))
    assert len(made.template.points) >= 100


@pytest.mark.slow
def test_progress__the_search_for_tolerances_has_labels_of_its_own(tmp_path: Path) -> None:
    labels: list[str] = []
    gp.sweep(
        written(tmp_path, PLAN),
        folder=tmp_path / "out",
        report=True,
        progress=lambda label, *_: labels.append(label),
    )
    found = list(dict.fromkeys(labels))
    searched = [label for label in found if label.startswith("tolerances x ")]
    assert len(searched) >= 5
    assert all(label.endswith((", search", ", check by fresh draws")) for label in searched)
    assert [label for label in found if label not in searched] == found[:1]
