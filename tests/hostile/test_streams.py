"""Closed and full standard streams: what was asked is done, and the sentence is true."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from gearplay.cli.main import run

pytestmark = pytest.mark.skipif(not os.path.exists("/dev/full"), reason="a Linux device")


def gearplay(words: str, streams: str, folder: Path) -> subprocess.CompletedProcess[str]:
    command = f"{sys.executable} -m gearplay {words} {streams}"
    return subprocess.run(["/bin/sh", "-c", command], cwd=folder, capture_output=True, text=True, timeout=300)


@pytest.mark.slow
@pytest.mark.parametrize("streams", [">&-", "2>&-", ">&- 2>&-", "<&-", "<&- >&- 2>&-", "2>/dev/full"])
def test_closed_stream__only_its_output_is_lost(streams: str, tmp_path: Path) -> None:
    ended = gearplay("copy han2021 --out mine.toml", streams, tmp_path)
    assert ended.returncode == 0, ended.stderr
    assert ended.stderr == ""
    assert run(["copy", "han2021", "--out", str(tmp_path / "other.toml")]) == 0
    assert (tmp_path / "mine.toml").read_bytes() == (tmp_path / "other.toml").read_bytes()


@pytest.mark.slow
@pytest.mark.parametrize("words", ["check han2021", "check han2021 --json", "--version", "check --help"])
def test_a_full_output_is_one_sentence(words: str, tmp_path: Path) -> None:
    ended = gearplay(words, ">/dev/full", tmp_path)
    assert ended.returncode == 5
    assert "Standard output cannot be written (No space left on device)" in ended.stderr
    assert "Traceback" not in ended.stderr
    assert "Exception ignored" not in ended.stderr


@pytest.mark.slow
def test_a_plotting_back_end_that_does_not_exist_draws_all_the_same(tmp_path: Path) -> None:
    (tmp_path / "run.csv").write_text("t,acc\n" + "".join(f"{k / 1000:.3f},{k % 7}\n" for k in range(2000)))
    assert run(["analyze", str(tmp_path / "run.csv"), "--out", str(tmp_path / "figures")]) == 0
    bad = subprocess.run(
        [sys.executable, "-m", "gearplay", "analyze", "run.csv", "--out", "again"],
        cwd=tmp_path, capture_output=True, text=True, timeout=300, env={**os.environ, "MPLBACKEND": "nonsense"},
    )  # fmt: skip
    assert bad.returncode == 0, bad.stderr
    assert (tmp_path / "again" / "history.png").read_bytes() == (
        tmp_path / "figures" / "history.png"
    ).read_bytes()
