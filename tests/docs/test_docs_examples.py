"""Every Python example of README and docs runs as it stands, page by page, in a folder with the files that it names."""

import re
import shutil
from pathlib import Path

import pytest

import gearplay as gp
from docs_commands import PAGES, ROOT
from docs_files import FILES

BLOCK = re.compile(r"```python\n(.*?)```", re.DOTALL)
LONG = ("nonlinear.md", "planetary.md", "gallery/planetary.md")
"""Pages whose examples take more than some seconds: left to the full depth."""


def pages() -> list[str]:
    """Return the pages with examples of their own; those of the reference are doctests."""
    found = [page for page in PAGES if BLOCK.search(page.read_text(encoding="utf-8"))]
    return [page.relative_to(ROOT).as_posix() for page in found]


@pytest.mark.slow
@pytest.mark.parametrize(
    "page",
    [
        pytest.param(page, marks=pytest.mark.deep) if page.removeprefix("docs/") in LONG else page
        for page in pages()
    ],
)
def test_the_examples_of_a_page_run(page: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    text = (ROOT / page).read_text(encoding="utf-8")
    for name, make in FILES.items():
        if f'"{name}"' in text:
            make(tmp_path / name)
    for folder in ("gallery", "gearboxes", "how-to", "tutorial"):
        shutil.copytree(ROOT / "docs" / folder, tmp_path / "docs" / folder)
    monkeypatch.chdir(tmp_path)
    held = {"gp": gp}
    for block in BLOCK.findall(text):
        exec(compile(block, page, "exec"), held)


def test_there_are_examples() -> None:
    assert len(pages()) >= 9
