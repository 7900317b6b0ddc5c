"""The data set of the page on cracks: a steady drive shows its damaged teeth, a rattling one hides a crack."""

import runpy
from pathlib import Path

import pytest

import gearplay as gp
from gearplay.datasets.reading import load_dataset_plan

HOW_TO = Path(__file__).resolve().parents[2] / "docs" / "how-to"


@pytest.mark.slow
@pytest.mark.compiled
def test_confusion_over_clearances(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Half of the drives, two backlashes: steady all right, rattling cracks called as sound teeth are."""
    plan = (
        load_dataset_plan(HOW_TO / "crack-over-clearances.toml")
        .frozen()
        .model_dump(mode="json", exclude_none=True)
    )
    plan["design"]["count"] = 6
    plan["axes"][0]["values"] = ["5 um", "80 um"]
    made = gp.make_dataset(plan, tmp_path / "cracks")
    assert int(made.ds["status"].sum()) == 0
    monkeypatch.setattr("sys.argv", ["crack_classes.py", str(tmp_path / "cracks")])
    monkeypatch.chdir(tmp_path)
    runpy.run_path(str(HOW_TO / "crack_classes.py"), run_name="__main__")
    rows = [line.split() for line in capsys.readouterr().out.splitlines()[1:]]
    found = {(row[0], row[1], row[3]): [int(count) for count in row[4:]] for row in rows}
    assert all(sum(counts) == 3 for counts in found.values())
    for c, label in enumerate(("sound", "crack", "spall")):
        assert all(found["steady", backlash, label][c] == 3 for backlash in ("5", "80"))
    for backlash in ("5", "80"):
        sound, crack = (found["ripples", backlash, label] for label in ("sound", "crack"))
        assert sum(abs(a - b) for a, b in zip(sound, crack, strict=True)) <= 2
