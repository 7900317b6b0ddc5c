"""The study command: complete output, resumable when stopped, never overwriting unasked."""

import csv
import json
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

COMMAND = [sys.executable, "-m", "gearplay.cli.main", "study", "han2021", "--members", "3", "--duration", "3"]


def run(*words: str, timeout: float = 240.0) -> subprocess.CompletedProcess[str]:
    return subprocess.run([*COMMAND, *words], capture_output=True, text=True, timeout=timeout)


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict]:
    folder = tmp_path_factory.mktemp("study") / "han"
    done = run("--out", str(folder), "--json")
    assert done.returncode == 0, done.stderr
    return folder, json.loads(done.stdout)


def test_the_folder_holds_report_tables_and_figures(finished: tuple[Path, dict]) -> None:
    folder, document = finished
    with (folder / "tables.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == len(document["tables"]) == 36
    for row in rows:
        for column in ("test", "article_coupled", "article_uncoupled", "ours_coupled", "ours_uncoupled"):
            assert float(row[column]) > 0.0
        assert float(row["ours_coupled_error_pct"]) >= 0.0
    assert sum(row["article_coupled_error_follows"] == "False" for row in rows) == 4
    assert len(list((folder / "figures").glob("*.png"))) == 10
    assert json.loads((folder / "tables.json").read_text())["findings"]


def test_the_report_is_one_self_contained_page(finished: tuple[Path, dict]) -> None:
    folder, document = finished
    page = (folder / "report.html").read_text(encoding="utf-8")
    assert page.count("data:image/png;base64,") == 10
    sources = re.findall(r'(?:src|href)="([^"#][^"]*)"', page)
    assert all(source.startswith("data:") for source in sources), "nothing is fetched from elsewhere"
    for finding in document["findings"]:
        assert finding["verdict"] in ("holds", "fails", "cannot be told")
    for word in ("assumed", "jam ratio", "un-normalised FFT", "Hann"):
        assert word in page
    assert "nan" not in re.sub(r"data:image[^\"]*", "", page).lower().split()


def test_a_second_run_refuses_to_overwrite(finished: tuple[Path, dict]) -> None:
    again = run("--out", str(finished[0]))
    assert again.returncode == 2
    assert "must not exist yet" in again.stderr
    assert "Traceback" not in again.stderr


@pytest.mark.deep
def test_a_stopped_study_goes_on_where_it_was(tmp_path: Path) -> None:
    folder = tmp_path / "han"
    process = subprocess.Popen([*COMMAND, "--out", str(folder)], stderr=subprocess.PIPE, text=True)
    deadline = time.monotonic() + 120.0
    while not list(folder.glob("parts/*.json")) and time.monotonic() < deadline:
        time.sleep(0.02)
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate(timeout=60)
    assert process.returncode == 130, errors
    assert "goes on there" in errors
    kept = {f.name: f.stat().st_mtime_ns for f in folder.glob("parts/*.json")}
    assert 0 < len(kept) < 12
    assert run("--out", str(folder)).returncode == 0
    after = {f.name: f.stat().st_mtime_ns for f in folder.glob("parts/*.json")}
    assert len(after) == 12
    assert {name: after[name] for name in kept} == kept, "finished conditions are not run again"
    assert not [f for f in os.listdir(folder) if f.endswith(".part")]


def test_unknown_studies_are_named(tmp_path: Path) -> None:
    done = subprocess.run([*COMMAND[:4], "kahraman", "--out", str(tmp_path)], capture_output=True, text=True)
    assert done.returncode == 2
    assert "kahraman" in done.stderr
