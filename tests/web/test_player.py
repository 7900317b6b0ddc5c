"""The page that `gearplay animate` writes: it plays in a browser by itself, from a file, without a server."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

import gearplay as gp
from gearplay.cli.main import run

CASES = ("han2021", "planetary-reducer", "two-stage-reducer", "torsional-train")
LEFT = ("planetary-reducer", "two-stage-reducer")
"""Drawn as the others are; left to the full depth."""


def pixels(page: Any, path: Path) -> np.ndarray:
    page.locator("#stage canvas").screenshot(path=str(path))
    return np.asarray(Image.open(path).convert("RGB"), dtype=float)


def opened(name: str, chromium: Any, folder: Path) -> tuple[Any, list[str]]:
    """Return the page of a case's motion, and the list that its complaints go to."""
    gp.simulate(name, duration=0.3, sampling=2e4).save(folder / "run.nc")
    assert run(["animate", str(folder / "run.nc"), "--out", str(folder / "motion.html")]) == 0
    page = chromium.new_page(viewport={"width": 1100, "height": 850})
    complaints: list[str] = []
    page.on("pageerror", lambda error: complaints.append(str(error)))
    page.on("console", lambda said: complaints.append(said.text) if said.type == "error" else None)
    page.goto((folder / "motion.html").as_uri())
    page.wait_for_function("document.getElementById('clock').textContent.endsWith(' s')")
    return page, complaints


@pytest.mark.slow
@pytest.mark.parametrize(
    "name", [pytest.param(each, marks=[pytest.mark.deep] if each in LEFT else []) for each in CASES]
)
def test_it_plays_and_is_looked_at_closely(name: str, chromium: Any, tmp_path: Path) -> None:
    page, complaints = opened(name, chromium, tmp_path)
    first = page.locator("#clock").text_content()
    page.wait_for_function("(was) => document.getElementById('clock').textContent !== was", arg=first)
    page.locator("#play").click()
    assert page.locator("#play").text_content() == "Play"
    page.locator("#scrub").fill("0.2")
    one = pixels(page, tmp_path / "one.png")
    assert np.count_nonzero(one.min(axis=2) < 120.0) > 2000
    page.locator("#scrub").fill("0.6")
    other = pixels(page, tmp_path / "other.png")
    assert np.count_nonzero(np.abs(one - other).max(axis=2) > 60.0) > 100
    before = page.locator("#factor").text_content()
    page.locator("#magnify").fill("0.5")
    assert page.locator("#factor").text_content() != before
    larger = pixels(page, tmp_path / "larger.png")
    assert np.count_nonzero(np.abs(larger - other).max(axis=2) > 60.0) > 100
    page.set_viewport_size({"width": 390, "height": 844})
    assert page.evaluate("document.documentElement.scrollWidth") <= 391
    page.close()
    assert complaints == []


@pytest.mark.slow
def test_close_ups_go_with_a_carrier_that_turns(chromium: Any, tmp_path: Path) -> None:
    page, complaints = opened("planetary-reducer", chromium, tmp_path)
    page.locator("#play").click()
    page.locator("#scrub").fill("0.6")
    held = pixels(page, tmp_path / "held.png")
    page.locator("#carrier").select_option("turning")
    changed = np.abs(pixels(page, tmp_path / "turning.png") - held).max(axis=2) > 60.0
    height, width = changed.shape
    whole = width - int(min(0.38 * width, 0.55 * height)) - 2  # beside it the close-ups
    assert np.count_nonzero(changed[:, :whole]) > 1000
    assert np.count_nonzero(changed[:, whole + 4 :]) == 0
    page.close()
    assert complaints == []
