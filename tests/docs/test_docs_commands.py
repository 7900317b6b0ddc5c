"""Every command in README and docs is one that the command line takes, and every one runs, on files that are there by then."""

import importlib.util
import re
from pathlib import Path
from typing import Any

import pytest
import typer

import gearplay as gp
from docs_commands import COMMANDS, NEVER, PAGES, ROOT, Command, commands_of, given, run_commands
from docs_files import FILES
from gearplay.cli.copy import names
from gearplay.cli.main import app

GROUP: Any = typer.main.get_command(app)
KNOWN = names()
SPAN = re.compile(r"`gearplay ([a-z][a-z-]*)([^`]*)`")


def named(page: Path) -> str:
    return page.relative_to(ROOT).as_posix()


WITH_COMMANDS = [page for page in PAGES if any(each.verb for each in commands_of(page))]
WITH_LONG_ONES = [page for page in PAGES if any(each.long for each in commands_of(page))]


def parsed(words: list[str]) -> dict[str, Any]:
    """Return the arguments of a command as the command line understands it; raises its usage error."""
    name, command, rest = GROUP.resolve_command(typer.Context(GROUP), words)
    return dict(command.make_context(name, rest).params)


@pytest.mark.parametrize("command", [c for c in COMMANDS if c.verb], ids=str)
def test_a_command_of_the_docs_is_understood(command: Command) -> None:
    page, words = command.page, list(command.words[1:])
    given_to = parsed(words)
    case = given_to.get("case")
    if case in KNOWN["case"]:
        gp.load_case(case, given_to.get("changes") or ())
    elif case is not None:
        assert (ROOT / case).exists() or written_before(page, case), case
    plan = given_to.get("plan")
    if plan is not None:
        bundled = KNOWN[{"calibrate": "calibration", "dataset": "dataset"}.get(words[0], "sweep")]
        assert plan in bundled or (ROOT / plan).exists() or written_before(page, plan), plan


def written_before(page: Path, file: str) -> bool:
    """Return whether a command of the page writes a file, or copies it, or the page shows what is in it."""
    for words in (command.words for command in commands_of(page)):
        if words[1] == "copy" and len(words) > 2 and (given(words, "--out") or f"{words[2]}.toml") == file:
            return True
        if given(words, "--out") in (file, Path(file).parent.as_posix()):
            return True
    return file in FILES


@pytest.mark.parametrize("command", [c for c in COMMANDS if not c.verb], ids=str)
def test_other_programs__commands_name_existing_targets(command: Command) -> None:
    words = [word for word in command.words if "=" not in word]
    if words[0] == "make":
        targets = re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE)
        assert set(words[1:]) <= set(targets)
    elif words[0].startswith("python"):
        what = next(word for word in words[1:] if not word.startswith("-"))
        assert importlib.util.find_spec(what) if words[1] == "-m" else (ROOT / what).exists()
    else:
        project = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
        extras = re.search(r"gearplay\[(.*)\]", words[-1])
        assert extras is None or all(f"\n{extra} = [" in project for extra in extras[1].split(","))


@pytest.mark.parametrize("page", PAGES, ids=named)
def test_commands_within_the_text_exist_with_their_options(page: Path) -> None:
    for verb, rest in SPAN.findall(page.read_text(encoding="utf-8")):
        command = GROUP.get_command(typer.Context(GROUP), verb)
        assert command is not None, verb
        flags = {flag for each in command.params for flag in (*each.opts, *each.secondary_opts)}
        assert set(re.findall(r"(?<=\s)--[a-z-]+", rest)) <= flags, (verb, rest)


def test_there_are_commands() -> None:
    assert len(COMMANDS) > 50
    assert {command.verb for command in COMMANDS} >= {*GROUP.commands}
    assert {command.verb for command in COMMANDS} >= NEVER


@pytest.mark.slow
@pytest.mark.parametrize("page", WITH_COMMANDS, ids=named)
def test_the_commands_of_a_page_run(page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    make_files(page, tmp_path)
    monkeypatch.chdir(tmp_path)
    run_commands(page, tmp_path, long=False)


@pytest.mark.deep
@pytest.mark.parametrize("page", WITH_LONG_ONES, ids=named)
def test_the_long_commands_of_a_page_run(page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    make_files(page, tmp_path)
    monkeypatch.chdir(tmp_path)
    assert run_commands(page, tmp_path, long=True)


def make_files(page: Path, folder: Path) -> None:
    """Write the files that a page takes for granted."""
    text = page.read_text(encoding="utf-8")
    for name, make in FILES.items():
        if re.search(rf"(?<![\w-]){re.escape(name)}", text) and not (folder / name).exists():
            make(folder / name)
