"""The bundled data set: its dents show as envelope lines at the pass frequencies of machines not seen before."""

import runpy
from pathlib import Path

import pytest

import gearplay as gp
from gearplay.datasets.reading import load_dataset_plan

SCRIPT = Path(__file__).resolve().parents[2] / "docs" / "how-to" / "envelope_classes.py"


@pytest.mark.slow
def test_dents_show_as_lines_of_the_envelope(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """A third of the plan: dents of inner ring and ball are named in most test records, the others as outer ring or sound."""
    plan = load_dataset_plan("bearing-dents").model_dump(mode="json", exclude_none=True)
    gp.make_dataset(plan | {"members": 1}, tmp_path / "dents")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("sys.argv", [str(SCRIPT), "dents"])
    runpy.run_path(str(SCRIPT), run_name="__main__")
    _, *rows = capsys.readouterr().out.splitlines()[1:]
    found = {row.split()[0]: [int(word) for word in row.split()[1:]] for row in rows}
    assert sum(map(sum, found.values())) == 16
    assert found["inner"][1] >= 3
    assert found["ball"][3] >= 3
    assert found["outer"][2] >= 3
    assert found["sound"][1] + found["sound"][3] <= 1
