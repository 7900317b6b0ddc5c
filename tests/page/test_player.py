"""The page that `gearplay animate` writes: it plays in a browser by itself, from a file, without a server."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

import gearplay as gp
from gearplay.cli.main import run

CASES = ("han2021", "planetary-reducer", "two-stage-reducer", "torsional-train")


def pixels(page: Any, path: Path) -> np.ndarray:
    page.locator("#stage canvas").screenshot(path=str(path))
    return np.asarray(Image.open(path).convert("RGB"), dtype=float)


@pytest.mark.parametrize("name", CASES)
def test_it_plays_and_is_looked_at_closely(name: str, chromium: Any, tmp_path: Path) -> None:
    gp.simulate(name, duration=0.3, sampling=2e4).save(tmp_path / "run.nc")
    assert run(["animate", str(tmp_path / "run.nc"), "--out", str(tmp_path / "motion.html")]) == 0
    page = chromium.new_page(viewport={"width": 1100, "height": 850})
    complaints: list[str] = []
    page.on("pageerror", lambda error: complaints.append(str(error)))
    page.on("console", lambda said: complaints.append(said.text) if said.type == "error" else None)
    page.goto((tmp_path / "motion.html").as_uri())
    page.wait_for_function("document.getElementById('clock').textContent.endsWith(' s')")
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
