"""The tutorial's first answers are those that the commands give today."""

import re
from pathlib import Path

import pytest

from gearplay.cli.main import run

PAGE = Path(__file__).resolve().parents[2] / "docs" / "tutorial" / "index.md"


@pytest.mark.slow
def test_the_record_looks_as_the_tutorial_says(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    shown = re.findall(r"```text\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)[0]
    monkeypatch.chdir(tmp_path)
    assert run(["copy", "tutorial"]) == 0
    words = ["--line", "40", "--line", "80", "--speed", "120 rpm", "--out", "figures"]
    assert run(["analyze", "records/tutorial-120rpm.h5", *words]) == 0
    said = capsys.readouterr().out
    for line in shown.strip().splitlines():
        assert line.strip() in said
