"""Every command in README and docs is one that the command line takes, on files that are there by then; the quick ones run."""

import re
import shlex
from pathlib import Path
from typing import Any

import pytest
import typer
from typer.testing import CliRunner

import gearplay as gp
from gearplay.cli.copy import names
from gearplay.cli.main import app

ROOT = Path(__file__).resolve().parents[3]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
BLOCK = re.compile(r"```sh\n(.*?)```", re.DOTALL)
GROUP: Any = typer.main.get_command(app)
QUICK = {"check", "copy", "schema"}
KNOWN = names()
PLACEHOLDERS = {"PLAN.toml", "FOLDER", "CASE", "RUN.nc", "my-drive.toml"}


def commands_of(page: Path) -> list[list[str]]:
    """Return the words of every `gearplay` command of a page, without its comment and where its output goes."""
    text = "\n".join(BLOCK.findall(page.read_text(encoding="utf-8"))).replace("\\\n", " ")
    found = [
        shlex.split(line, comments=True) for line in text.splitlines() if line.strip().startswith("gearplay")
    ]
    return [words[1 : words.index(">") if ">" in words else None] for words in found]


COMMANDS = [(page, words) for page in PAGES for words in commands_of(page)]


def parsed(words: list[str]) -> dict[str, Any]:
    """Return the arguments of a command as the command line understands it; raises its usage error."""
    name, command, rest = GROUP.resolve_command(typer.Context(GROUP), words)
    return dict(command.make_context(name, rest).params)


@pytest.mark.parametrize(
    ("page", "words"), COMMANDS, ids=[f"{p.stem}: {' '.join(w)}"[:70] for p, w in COMMANDS]
)
def test_a_command_of_the_docs_is_understood(page: Path, words: list[str]) -> None:
    given = parsed(words)
    case = given.get("case")
    if case in KNOWN["case"]:
        gp.load_case(case, given.get("changes") or ())
    elif case is not None:
        assert case in PLACEHOLDERS or (ROOT / case).exists() or written_before(page, case), case
    plan = given.get("plan")
    if plan is not None:
        bundled = KNOWN["calibration" if words[0] == "calibrate" else "sweep"]
        assert plan in {*bundled, *PLACEHOLDERS} or written_before(page, plan), plan


def written_before(page: Path, file: str) -> bool:
    """Return whether a command of the page writes a file, or copies it."""
    for words in commands_of(page):
        if words[0] == "copy" and len(words) > 1 and (file in words or file == f"{words[1]}.toml"):
            return True
        if file in words and "--out" in words and words[words.index("--out") + 1] == file:
            return True
    return False


def test_there_are_commands() -> None:
    assert len(COMMANDS) > 30
    assert {words[0] for _, words in COMMANDS} >= {*GROUP.commands} - {"resume"}


@pytest.mark.parametrize(
    "words", [words for _, words in COMMANDS if words[0] in QUICK], ids=lambda words: " ".join(words)[:70]
)
def test_quick_commands_run(words: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    if any(word in PLACEHOLDERS for word in words):
        pytest.skip("a placeholder")
    monkeypatch.chdir(tmp_path)
    (tmp_path / "docs").symlink_to(ROOT / "docs")  # pages name files from the root of the repository
    done = CliRunner().invoke(app, words)
    assert done.exit_code == 0, done.output
