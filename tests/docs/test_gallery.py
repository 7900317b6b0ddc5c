"""The gallery's scripts run from end to end, small, and draw every picture of their page."""

import re
from pathlib import Path

import pytest

from programs import load_script

GALLERY = Path(__file__).resolve().parents[2] / "docs" / "gallery"
PICTURE = re.compile(r"\]\(([\w-]+\.png)\)")
OF_SWEEPS = {"map-earlier-plan-swing.png", "map-earlier-plan-run-out.png", "tolerance-search.png"}
"""Pictures of sweep reports, which docs/gallery/map.md says how to make."""
PARTS = {
    "han2021": ("portrait", "models", "artefact", "tongue"),
    "nonlinear": ("jump", "route", "basins"),
    "planetary": ("modes", "sharing", "run_up"),
}


def test_every_picture_of_the_gallery_is_drawn_by_a_script_or_a_sweep() -> None:
    for page in GALLERY.glob("*.md"):
        script = page.with_suffix(".py")
        drawn = script.read_text(encoding="utf-8") if script.exists() else ""
        for picture in PICTURE.findall(page.read_text(encoding="utf-8")):
            assert (GALLERY / picture).exists()
            assert picture in OF_SWEEPS or f'"{picture}"' in drawn, picture


@pytest.mark.deep
@pytest.mark.parametrize(("name", "part"), [(name, part) for name, parts in PARTS.items() for part in parts])
def test_a_part_of_the_gallery_runs(
    name: str, part: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.syspath_prepend(str(GALLERY))
    load_script(GALLERY / f"{name}.py").main(["--short", "--out", str(tmp_path), "--only", part])
    pictures = {file.name for file in tmp_path.glob("*.png")}
    assert pictures
    assert pictures <= set(PICTURE.findall((GALLERY / f"{name}.md").read_text(encoding="utf-8")))


def test_the_parts_of_the_gallery_are_all_here() -> None:
    for name, parts in PARTS.items():
        text = (GALLERY / f"{name}.py").read_text(encoding="utf-8")
        assert f"draw(words, {', '.join(parts)})" in text
