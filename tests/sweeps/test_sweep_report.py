"""The report of a sweep: what it says of cases, failures and numbers, and what user text cannot do to it."""

import math
import re
import tomllib
from collections.abc import Mapping
from html import unescape
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gearplay.pictures import panels as figure_panels
from gearplay.sweeps.plans.reading import load_sweep
from gearplay.sweeps.report.page import failures_of, summary_of, varied_of, write_sweep_report
from gearplay.sweeps.running.evaluate import Sweep
from gearplay.sweeps.sweep import sweep as run_sweep
from sweep_products import BOUNCE, DRAG, MODEL, PLAY, RMS, SPECTRUM, SPEED, made, plan_of

SCRIPT = "<script>alert(1)</script> of $ 5 and $x$, " + "long" * 30


@pytest.mark.slow
def test_user_text_stays_text_on_the_page_and_in_the_pictures(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    figures, draw = [], figure_panels.to_png
    monkeypatch.setattr(figure_panels, "to_png", lambda figure: (figures.append(figure), draw(figure))[1])
    hostile = {"name": "t", "path": "title", "values": [SCRIPT, r"$\frac{1$", "_hidden", "☃ and 日本"]}
    plan = plan_of(hostile, MODEL, title=SCRIPT, reduce=[RMS, SPECTRUM])
    write_sweep_report(*made(plan), tmp_path)
    page = (tmp_path / "report.html").read_text()
    assert "<script" not in page
    assert "&lt;script&gt;alert(1)&lt;/script&gt; of $ 5" in page
    assert "http" not in page
    assert r"of \$ 5 an…nglong" in figures[0].get_suptitle()
    assert [path.stem for path in sorted(tmp_path.glob("figures/*"))] == ["lines-t-1", "spectrum-s"]


def test_the_summary_says_how_large_and_where() -> None:
    def value(kept: Any, values: Mapping[str, Any], member: int) -> Any:
        if values["play"] > 2.9e-4:
            return "refused $ <b>" if values["speed"] < 30.0 else "too wide"
        return np.full(kept.size, 7.0) if kept.name == "hits" else values["speed"] * values["play"]

    sweep, dataset = made(plan_of(SPEED, PLAY), value)
    rms, hits = summary_of(dataset)
    blank = "\N{NO-BREAK SPACE}"
    assert (rms["unit"], rms["count"]) == ("m/s²", 15)
    assert rms["low"] == pytest.approx(2.0 * math.pi * 1e-5)
    assert rms["high"] == pytest.approx(10.0 * math.pi * (10e-6 + 2.0 / 3.0 * 290e-6))
    assert rms["at_low"].replace(blank, " ") == "speed 60 rpm, play 10 µm"
    assert rms["at_high"].replace(blank, " ") == "speed 300 rpm, play 203.3 µm"
    assert (hits["low"], hits["median"], hits["at_low"]) == (7.0, 7.0, "everywhere")
    assert [(r, n, w.replace(blank, " ")) for r, n, w in failures_of(dataset)] == [
        ("refused $ <b>", 4, "speed 60 rpm, play 300 µm"),
        ("too wide", 1, "speed 300 rpm, play 300 µm"),
    ]
    assert [(r["name"], r["unit"], r["count"], r["values"]) for r in varied_of(sweep, dataset)] == [
        ("speed", "rpm", 5, "60, 120, 180, 240, 300"),
        ("play", "µm", 4, "10, 106.7, 203.3, 300"),
    ]


@pytest.mark.slow
def test_sweep_page__states_how_it_was_computed(tmp_path: Path) -> None:
    plan = load_sweep(
        plan_of(MODEL, {**SPEED, "count": 2}, {**DRAG, "count": 2, "scale": "log"}, members=2, title="")
    )
    dataset = run_sweep(plan).ds
    write_sweep_report(Sweep(plan), dataset, tmp_path)
    page = (tmp_path / "report.html").read_text()
    assert "<h1>Sweep</h1>" in page
    assert "16 cases of <code>han2021</code>" in page
    assert "None failed." in page
    assert "<code>rotors.ring.load.drag</code> (factor)" in page
    assert dataset.attrs["base_case_sha256"] in page
    text = re.search("<pre>(.*?)</pre>", page, re.DOTALL)
    assert text is not None
    assert load_sweep(tomllib.loads(unescape(text[1]))) == plan


@pytest.mark.slow
def test_the_page_begins_with_what_the_sweep_says(tmp_path: Path) -> None:
    plan = plan_of(SPEED, PLAY, members=2, reduce=[RMS])
    sweep, dataset = made(plan, lambda k, v, member: v["speed"] + 1e-3 * member)
    write_sweep_report(sweep, dataset, tmp_path)
    page = (tmp_path / "report.html").read_text()
    low, high = (f"{rpm * math.pi / 30.0:.3g}" for rpm in (60.0, 300.0))
    assert f"lies between {low} and {high} m/s²" in page
    assert "first order (alone) and total (with others): speed 100 and 100 %, play 0 and 0 %." in page
    assert "Scatter among members is" in page
    assert page.index("lies between") < page.index("data:image/png") < page.index("What was varied</h2>")


def test_missing_and_failed_cases_are_counted_on_the_page(tmp_path: Path) -> None:
    sweep, dataset = made(plan_of(SPEED), lambda k, v, m: f"reason <{v['speed']:.4g}>")
    dataset["status"][0] = -1
    write_sweep_report(sweep, dataset, tmp_path)
    page = (tmp_path / "report.html").read_text()
    assert "4 failed." in page
    assert "1 not run yet." in page
    assert page.count("reason &lt;") == 4
    assert "No case was finished." in page
    assert not (tmp_path / "figures").exists()


def test_a_single_case_has_a_page_without_pictures(tmp_path: Path) -> None:
    sweep, dataset = made(plan_of({**MODEL, "values": ["coupled"]}, {**BOUNCE, "values": [0.7]}))
    write_sweep_report(sweep, dataset.isel(model=0, bounce=0), tmp_path)
    page = (tmp_path / "report.html").read_text()
    assert "1 case of <code>han2021</code>" in page
    assert "Nothing: one case." in page
    assert "No number differs between cases." in page
