"""`gearplay study`: complete output, resumption after an interrupt, no overwriting unless requested."""

import csv
import html
import json
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from gearplay.cli.study import _words
from gearplay.studies.han2021.comparison import GROUPS
from gearplay.studies.han2021.report import QUESTIONS

FIGURES = 17
COMMAND = [sys.executable, "-m", "gearplay.cli.main", "study", "han2021", "--members", "2", "--duration", "2"]


def run(*words: str, timeout: float = 240.0) -> subprocess.CompletedProcess[str]:
    return subprocess.run([*COMMAND, *words], capture_output=True, text=True, timeout=timeout)


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict]:
    folder = tmp_path_factory.mktemp("study") / "han"
    done = run("--out", str(folder), "--json", "--pdf")
    assert done.returncode == 0, done.stderr
    return folder, json.loads(done.stdout)


@pytest.mark.slow
def test_folder__report_tables_figures(finished: tuple[Path, dict]) -> None:
    folder, document = finished
    with (folder / "tables.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == len(document["tables"]) == 36
    for row in rows:
        for column in ("test", "article_coupled", "article_uncoupled", "ours_coupled", "ours_uncoupled"):
            assert float(row[column]) > 0.0
        assert float(row["ours_coupled_error_pct"]) >= 0.0
        assert float(row["ours_coupled_left_out_error_pct"]) >= 0.0
    assert sum(row["article_coupled_error_follows"] == "False" for row in rows) == 4
    assert len(list((folder / "figures").glob("*.png"))) == FIGURES
    summary = json.loads((folder / "tables.json").read_text())
    drawn = {p.stem for p in (folder / "figures").glob("*.png")}
    assert {f["figure"] for f in summary["findings"]} <= drawn
    assert json.loads((folder / "claims.json").read_text())["shares"]


@pytest.mark.slow
def test_standard_output__names_of_all_figures(finished: tuple[Path, dict]) -> None:
    folder, document = finished
    said = _words(document)
    assert all(each.name in said for each in (folder / "figures").iterdir())
    assert str(folder / "report.html") in said
    assert str(folder / "report.pdf") in said


@pytest.mark.slow
def test_findings__levels_of_the_tables(finished: tuple[Path, dict]) -> None:
    _, document = finished
    claim = next(
        f for f in document["findings"] if f["claim"].startswith("Coupled: the vibration is largest")
    )
    rows = {
        (row["line"], row["speed_rpm"]): row["ours_coupled_m_per_s2"]
        for row in document["tables"]
        if row["quantity"] == "amplitude_as_printed"
        and row["radial_clearance_um"] == row["backlash_um"] == 100.0
    }
    for line in ("radial", "mesh_1x", "mesh_2x"):
        middle, *others = (f"{rows[line, speed]:.3g}" for speed in (120.0, 60.0, 180.0))
        assert f"{middle} against {', '.join(others)} m/s²" in claim["evidence"]


@pytest.mark.slow
def test_report__one_self_contained_page(finished: tuple[Path, dict]) -> None:
    folder, document = finished
    page = (folder / "report.html").read_text(encoding="utf-8")
    assert page.count("data:image/png;base64,") == FIGURES
    sources = re.findall(r'(?:src|href)="([^"#][^"]*)"', page)
    assert all(source.startswith("data:") for source in sources), "nothing is fetched from elsewhere"
    for finding in document["findings"]:
        assert finding["verdict"] in GROUPS
        assert f'<figure id="fig-{finding["figure"]}"' in page
    for word in ("assumed", "jam ratio", "un-normalised FFT", "Hann", "members that no fit has seen"):
        assert word in page
    assert "nan" not in re.sub(r"data:image[^\"]*", "", page).lower().split()


@pytest.mark.slow
def test_report__five_answers_before_any_table(finished: tuple[Path, dict]) -> None:
    """Each answer is one sentence with numbers of this run."""
    folder, document = finished
    page = (folder / "report.html").read_text(encoding="utf-8")
    first = html.unescape(page[page.index("<h1>") : page.index('<h2 id="findings">')])
    assert [each["question"] for each in document["story"]] == list(QUESTIONS)
    for each in document["story"]:
        answer = each["answer"]
        assert f"<dt>{each['question']}</dt><dd>{answer}</dd>" in first
        assert answer.endswith(".")
        assert len(re.findall(r"[.!?](?= [A-Z])", answer)) == 0, "one sentence"
    simulated, agrees, where, why, believe = (each["answer"] for each in document["story"])
    assert "6 test conditions" in simulated
    assert "2 runs of 2 s" in simulated
    for number in (7.3, 16.2):
        assert f"{number:g}" in agrees
    fresh = document["errors"][0]["fresh"]
    assert f"{fresh[0]:.0f} %" in agrees
    assert f"{fresh[1]:.0f} %" in agrees
    assert "times too" in where
    assert "chaotic" in why
    assert "swing of the driven gear" in believe
    assert first.count("<img ") == 1


@pytest.mark.slow
def test_errors__means_of_the_tables(finished: tuple[Path, dict]) -> None:
    """The errors of fresh members are the means of this run's tables, not those of the search."""
    _, document = finished
    rows = [row for row in document["tables"] if row["quantity"] == "amplitude_as_printed"]
    radial = [
        row for row in document["tables"] if (row["quantity"], row["line"]) == ("frequency_hz", "radial")
    ]
    for errors in document["errors"]:
        own = sum(row[f"ours_{errors['model']}_error_pct"] for row in rows) / len(rows)
        assert errors["fresh"][0] == pytest.approx(own)
        assert errors["fresh"][0] != pytest.approx(errors["in_sample"], rel=1e-6)
        left_out = sum(row[f"ours_{errors['model']}_left_out_error_pct"] for row in radial) / len(radial)
        assert errors["left_out"][1] == pytest.approx(left_out)


@pytest.mark.slow
def test_figures__neither_empty_nor_cut_off(finished: tuple[Path, dict]) -> None:
    """Dark pixels in the middle of every figure, few at its edges."""
    from PIL import Image

    folder, _ = finished
    for path in (folder / "figures").glob("*.png"):
        pixels = np.asarray(Image.open(path).convert("L"), dtype=float)
        height, width = pixels.shape
        middle = pixels[height // 6 : -height // 6, width // 6 : -width // 6]
        assert np.mean(middle < 200.0) > 2e-3, path.name
        edges = np.concatenate(
            [pixels[:2].ravel(), pixels[-2:].ravel(), pixels[:, :2].ravel(), pixels[:, -2:].ravel()]
        )
        assert np.mean(edges < 128.0) < 1e-3, path.name


@pytest.mark.slow
def test_pdf__pages_and_figures(finished: tuple[Path, dict]) -> None:
    folder, _ = finished
    written = (folder / "report.pdf").read_bytes()
    assert written.startswith(b"%PDF-")
    assert written.count(b"/Type/Page") + written.count(b"/Type /Page") >= 3
    assert len(written) > 200_000  # with its figures


@pytest.mark.deep
def test_folder__same_seed_same_bytes(finished: tuple[Path, dict], tmp_path: Path) -> None:
    """Page, tables, claims and every picture of two studies with one seed are the same to the last byte."""
    folder, again = finished[0], tmp_path / "again"
    assert run("--out", str(again), "--json", "--pdf").returncode == 0
    names = sorted(p.relative_to(folder) for p in folder.rglob("*.*") if "parts" not in p.parts)
    names = [name for name in names if name.suffix in (".html", ".csv", ".json", ".png")]
    assert len(names) >= FIGURES + 4
    for name in names:
        assert (again / name).read_bytes() == (folder / name).read_bytes(), name


@pytest.mark.slow
def test_existing_report__refused(finished: tuple[Path, dict]) -> None:
    again = run("--out", str(finished[0]))
    assert again.returncode == 2
    assert "must not exist yet" in again.stderr
    assert "Traceback" not in again.stderr


@pytest.mark.deep
def test_interrupted_study__resumes(tmp_path: Path) -> None:
    folder = tmp_path / "han"
    process = subprocess.Popen([*COMMAND, "--out", str(folder)], stderr=subprocess.PIPE, text=True)
    deadline = time.monotonic() + 120.0
    while not list(folder.glob("parts/*.json")) and time.monotonic() < deadline:
        time.sleep(0.02)
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate(timeout=60)
    assert process.returncode == 130, errors
    assert "continues there" in errors
    kept = {f.name: f.stat().st_mtime_ns for f in folder.glob("parts/*.json")}
    assert 0 < len(kept) < 18
    assert run("--out", str(folder)).returncode == 0
    after = {f.name: f.stat().st_mtime_ns for f in folder.glob("parts/*.json")}
    assert len(after) == 18
    assert {name: after[name] for name in kept} == kept, "finished conditions are not run again"
    assert not [f for f in os.listdir(folder) if f.endswith(".part")]


@pytest.mark.deep
def test_parameters__assumed(tmp_path: Path) -> None:
    done = run("--out", str(tmp_path / "a"), "--json", "--parameters", "assumed")
    assert done.returncode == 0, done.stderr
    document = json.loads(done.stdout)
    assert document["case"] == "han2021"
    assert "left_out" not in document["errors"][0]
    page = (tmp_path / "a" / "report.html").read_text(encoding="utf-8")
    assert "with assumed parameters" in page
    assert page.count("data:image/png;base64,") == FIGURES


@pytest.mark.deep
def test_claims__computed_afresh(tmp_path: Path) -> None:
    done = run("--out", str(tmp_path / "c"), "--json", "--claims", "--points", "2", timeout=900.0)
    assert done.returncode == 0, done.stderr
    claims = json.loads((tmp_path / "c" / "claims.json").read_text())
    assert claims["settings"]["points"] == 2
    assert claims["floors"][0]["pairs"] == 8 * 7
    assert {row["of"] for row in claims["repeated"]} == {1}
    assert "2 Sobol points" in (tmp_path / "c" / "report.html").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--parameters", "guessed"), "must be one of calibrated, assumed, geometric-inertia, all"),
        (("--fit-drag",), "must go with assumed parameters"),
    ],
)
def test_options__refused_with_a_cure(tmp_path: Path, words: tuple[str, ...], said: str) -> None:
    done = run("--out", str(tmp_path / "x"), *words)
    assert done.returncode == 2
    assert said in " ".join(done.stderr.split())
    assert not (tmp_path / "x").exists()


def test_unknown_study__refused(tmp_path: Path) -> None:
    done = subprocess.run([*COMMAND[:4], "kahraman", "--out", str(tmp_path)], capture_output=True, text=True)
    assert done.returncode == 2
    assert "kahraman" in done.stderr
