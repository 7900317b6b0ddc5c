"""The pages tell the truth: names exist, all twenty equations are there, the README's program runs."""

import importlib.util
import json
import re
from pathlib import Path
from typing import Any

import pytest
import typer

import gearplay as gp
from gearplay.cli.main import app
from gearplay.model.schema import json_schema
from gearplay.model.variables import RESULT_VARIABLES
from gearplay.vocabulary.quantities import OUTPUT_STATISTICS

ROOT = Path(__file__).resolve().parents[2]
ROOMS = "kernels|integrate|parts|model|solver|files|pictures|results|signals|rig|sweeps|calibration|nonlinear|work|vocabulary"
NAME = re.compile(rf"`((?:{ROOMS})\.[a-z_0-9.]+)`")
NOTATION = {"gp", "gearplay", "j_n", "j_t", "cos", "f_m", "mesh_1x", "mesh_2x", "planet1"}
"""Of the glossary: formula symbols, the package, and names that results number."""
FILE = re.compile(rf"`((?:{ROOMS}|cli|web)/[a-z_0-9/]+\.py)(?::([A-Za-z_0-9]+))?`")


def test_names_in_the_theory_page_exist() -> None:
    names = set(NAME.findall((ROOT / "docs" / "theory.md").read_text(encoding="utf-8")))
    assert len(names) > 12
    for name in names:
        module, _, attribute = f"gearplay.{name}".rpartition(".")
        try:
            found = hasattr(importlib.import_module(module), attribute)
        except ModuleNotFoundError:
            found = False
        assert found or importlib.util.find_spec(f"gearplay.{name}"), name


def test_files_in_the_contributing_page_exist() -> None:
    places = set(FILE.findall((ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")))
    assert len(places) > 8
    for file, attribute in places:
        text = (ROOT / "src" / "gearplay" / file).read_text(encoding="utf-8")
        assert attribute in text, (file, attribute)


def test_tests_in_the_validation_page_exist() -> None:
    text = (ROOT / "docs" / "validation.md").read_text(encoding="utf-8")
    named = set(re.findall(r"`((?:[a-z]+/)+test_[a-z0-9_*]+\.py)`", text))
    assert len(named) > 20
    assert [each for each in sorted(named) if not [*(ROOT / "tests").glob(each)]] == []


def test_glossary__names_are_those_of_the_program() -> None:
    """Each name in the right column is a field, a value, a variable of results, a public function, a command or an option."""
    known = (
        set(re.findall(r"[A-Za-z_][\w-]*", json.dumps(json_schema()))) | set(dir(gp)) | set(RESULT_VARIABLES)
    ) | set(OUTPUT_STATISTICS)
    commands: Any = typer.main.get_command(app)
    for name, command in commands.commands.items():
        known |= {name} | {word.lstrip("-") for each in command.params for word in each.opts}
    text = (ROOT / "docs" / "glossary.md").read_text(encoding="utf-8")
    rows = [row.split("|") for row in text.splitlines() if row.startswith("|")]
    spans = [span for row in rows for span in re.findall(r"`([^`]+)`", row[2])]
    words = {word for span in spans for word in re.findall(r"[A-Za-z_][\w-]*", span.replace("--", ""))}
    assert len(words) > 25
    assert words - known - NOTATION == set()


def test_tables_of_the_pages_begin_with_a_header() -> None:
    """A row above the header, or a separator in another place, would be shown as text with bars."""
    for page in [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]:
        text = re.sub(r"^```.*?^```$", "", page.read_text(encoding="utf-8"), flags=re.MULTILINE | re.DOTALL)
        for block in re.findall(r"(?:^\|.*\n)+", text, flags=re.MULTILINE):
            lines = block.splitlines()
            separators = [k for k, line in enumerate(lines) if re.fullmatch(r"\|[-:| ]*-[-:| ]*\|", line)]
            assert separators == [1], f"{page.name}: {lines[0]}"


@pytest.mark.parametrize("number", range(1, 21))
def test_every_published_equation_is_in_the_table(number: int) -> None:
    table = (ROOT / "docs" / "theory.md").read_text(encoding="utf-8").split("## 2.")[0]
    assert f"({number})" in table


@pytest.mark.slow
def test_the_readmes_program_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    program = re.search(r"```python\n(.*?)```", (ROOT / "README.md").read_text(encoding="utf-8"), re.DOTALL)
    assert program is not None
    monkeypatch.chdir(tmp_path)
    short = program.group(1).replace("duration=2.0, ensemble=16", "duration=0.05, ensemble=2")
    assert short != program.group(1)
    exec(compile(short, "README.md", "exec"), {"print": lambda *_: None})
    assert (tmp_path / "run.nc").exists()
    assert (tmp_path / "orbit.png").exists()
