"""Every Python example of README and docs runs as it stands, page by page, in a folder with the files that it names."""

import re
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import gearplay as gp
from gearplay.model.reading import to_toml

ROOT = Path(__file__).resolve().parents[3]
BLOCK = re.compile(r"```python\n(.*?)```", re.DOTALL)
LONG = ("nonlinear.md", "planetary.md", "gallery/planetary.md")
"""Pages whose examples take more than some seconds: left to the full depth."""


def pages() -> list[str]:
    """Return the pages with examples of their own; those of the reference are doctests."""
    every = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
    found = [page for page in every if BLOCK.search(page.read_text(encoding="utf-8"))]
    return [page.relative_to(ROOT).as_posix() for page in found if page.name != "reference.md"]


def make_record(path: Path) -> None:
    """Write two seconds of a channel with the two lines that examples look for."""
    t = np.arange(2 * 12800) / 12800.0
    noise = np.random.default_rng(0).normal(size=t.size)
    acc = np.sin(2 * np.pi * 40.0 * t) + 0.2 * np.sin(2 * np.pi * 80.0 * t) + 0.1 * noise
    from nptdms import ChannelObject, TdmsWriter

    properties = {"wf_increment": 1.0 / 12800.0, "wf_start_offset": 0.0}
    with TdmsWriter(path) as writer:
        writer.write_segment(
            [
                ChannelObject("run", "acc", acc, properties | {"unit_string": "m/s^2"}),
                ChannelObject("run", "force", 0.1 * acc, properties | {"unit_string": "N"}),
            ]
        )


def make_bare(path: Path) -> None:
    path.write_text(
        "acc\n" + "\n".join(f"{np.sin(0.1 * k):.6f}" for k in range(2000)) + "\n", encoding="utf-8"
    )


def make_sound(path: Path) -> None:
    values = 0.5 * np.sin(0.1 * np.arange(8000.0))
    gp.write_record(gp.Record((gp.Channel("channel 1", values, 8000.0, "Pa"),)), path)


def make_case(path: Path) -> None:
    path.write_text(
        to_toml(gp.torsional_pair(0.8, mean_force=0.1, force=0.2, damping_ratio=0.1)), encoding="utf-8"
    )


def make_rig(path: Path) -> None:
    text = (ROOT / "docs" / "rig.md").read_text(encoding="utf-8")
    path.write_text(re.findall(r"```toml\n(.*?)```", text, re.DOTALL)[0], encoding="utf-8")


FILES: dict[str, Callable[[Path], None]] = {
    "run 7.tdms": make_record,
    "run.tdms": make_record,
    "bare.csv": make_bare,
    "loud.wav": make_sound,
    "my-case.toml": make_case,
    "rig.toml": make_rig,
}


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
    shutil.copytree(ROOT / "docs" / "gallery", tmp_path / "docs" / "gallery")
    monkeypatch.chdir(tmp_path)
    held = {"gp": gp}
    for block in BLOCK.findall(text):
        exec(compile(block, page, "exec"), held)


def test_there_are_examples() -> None:
    assert len(pages()) >= 9
