"""What replaces a whole result is made in a place of its own: whatever fails on the way, one of the two is there, whole."""

import os
import shutil
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest

from gearplay.files.atomic import write_figures
from gearplay.vocabulary.errors import ResourceError
from gearplay.work import folder as module
from gearplay.work.folder import OutputFolder

OLD = {
    "rows.sqlite": "old rows",
    "result.nc": "old",
    "figures/a.png": "old a",
    "figures/b.png": "old b",
    "page.html": "old",
}
NEW = {"rows.sqlite": "new rows", "result.nc": "new", "figures/a.png": "new a"}


class Killed(BaseException):
    pass


def write(folder: Path, files: dict[str, str]) -> None:
    for name, text in files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text, encoding="utf-8")


def held(folder: Path) -> dict[str, str]:
    return {
        str(each.relative_to(folder)): each.read_text(encoding="utf-8")
        for each in folder.rglob("*")
        if each.is_file() and ".new" not in each.parts and each.name not in (".of", ".lock")
    }


def forget(folder: Path) -> None:
    for name in ("rows.sqlite", "result.nc", "page.html"):
        (folder / name).unlink(missing_ok=True)
    shutil.rmtree(folder / "figures", ignore_errors=True)


def output(folder: Path) -> OutputFolder:
    return OutputFolder(folder, lambda place: (place / "result.nc").exists(), forget)


def place(folder: Path, of: str = "plan", *, overwrite: bool = True) -> Path:
    return output(folder).place(of, overwrite=overwrite)


def test_replacement__keeps_the_old_result_until_the_new_one_is_complete(tmp_path: Path) -> None:
    write(tmp_path, OLD)
    work = place(tmp_path)
    write(work, NEW)
    assert held(tmp_path) == OLD
    assert place(tmp_path) == work  # an interrupted one goes on
    assert (work / "result.nc").exists()
    output(tmp_path).replace_with(work)
    assert held(tmp_path) == NEW
    assert not work.exists()


def test_of_another_plan_nothing_is_kept(tmp_path: Path) -> None:
    write(tmp_path, OLD)
    write(place(tmp_path), NEW)
    assert not (place(tmp_path, "another") / "result.nc").exists()
    assert held(tmp_path) == OLD


def test_replacement__incomplete_work_is_removed(tmp_path: Path) -> None:
    write(tmp_path, {"rows.sqlite": "some"})
    assert place(tmp_path) == tmp_path
    assert held(tmp_path) == {}
    assert place(tmp_path, overwrite=False) == tmp_path


def test_replacement__of_an_incomplete_result_resumes(tmp_path: Path) -> None:
    """Until it has ended, or another plan's takes its place; whatever is whole by then."""
    write(tmp_path, {"rows.sqlite": "another plan's"})
    assert place(tmp_path) == tmp_path
    write(tmp_path, {"rows.sqlite": "a week of finished cases"})
    assert place(tmp_path) == tmp_path
    assert held(tmp_path) == {"rows.sqlite": "a week of finished cases"}
    write(tmp_path, NEW)
    assert place(tmp_path) == tmp_path  # killed before its report
    assert held(tmp_path) == NEW
    output(tmp_path).replace_with(tmp_path)
    assert place(tmp_path) == tmp_path / ".new"
    (tmp_path / "result.nc").unlink()
    assert place(tmp_path, "another") == tmp_path
    assert held(tmp_path) == {}


@pytest.mark.hostile
@pytest.mark.parametrize("at", range(6))
def test_a_kill_while_a_part_is_forgotten_keeps_nothing_of_another_plan(
    at: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    place(tmp_path, "another")
    write(tmp_path, {"rows.sqlite": "another's", "figures/a.png": "another's"})
    with monkeypatch.context() as patched, suppress(Killed):
        kill_at(at, patched)
        place(tmp_path)
    if held(tmp_path) != {"rows.sqlite": "another's", "figures/a.png": "another's"}:
        assert not (tmp_path / ".of").exists() or (tmp_path / ".of").read_text(encoding="utf-8") == "plan"
    assert place(tmp_path) == tmp_path
    assert held(tmp_path) == {}


def kill_at(at: int, patched: pytest.MonkeyPatch) -> None:
    """Let the process die at the call number ``at`` that moves or removes something."""
    calls = 0

    def fragile(do: Any) -> Any:
        def done(*words: Any, **more: Any) -> Any:
            nonlocal calls
            calls += 1
            if calls == at + 1:
                raise Killed
            return do(*words, **more)

        return done

    patched.setattr(module.shutil, "rmtree", fragile(shutil.rmtree))
    patched.setattr(os, "replace", fragile(os.replace))
    patched.setattr(Path, "unlink", fragile(Path.unlink))


@pytest.mark.slow
@pytest.mark.hostile
@pytest.mark.parametrize("first", range(14))
@pytest.mark.parametrize("second", range(14))
def test_a_command_that_is_killed_twice_loses_neither(
    first: int, second: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def command() -> None:
        work = place(tmp_path)
        write(work, NEW)
        output(tmp_path).replace_with(work)

    write(tmp_path, OLD)
    for at in (first, second):
        with monkeypatch.context() as patched, suppress(Killed):
            kill_at(at, patched)
            command()
        beside = {}
        if (tmp_path / ".new" / ".whole").exists():
            beside = {name: "new" for name in NEW if (tmp_path / ".new" / name).exists()}
        assert held(tmp_path) in (OLD, NEW) or {*held(tmp_path), *beside} >= set(NEW)
    command()
    assert held(tmp_path) == NEW
    assert sorted(each.name for each in tmp_path.iterdir()) == sorted({name.split("/")[0] for name in NEW})


def test_replacement__an_incomplete_staging_folder_is_not_used(tmp_path: Path) -> None:
    write(tmp_path, OLD)
    write(place(tmp_path), {**NEW, "..whole.0123456789ab.part": "", ".result.nc.0123456789ab.part": "half"})
    output(tmp_path).replace_with(tmp_path / ".new")
    assert held(tmp_path) == NEW


def test_finish_replacement__makes_no_folder(tmp_path: Path) -> None:
    output(tmp_path / "nowhere").finish_replacement()
    assert not (tmp_path / "nowhere").exists()


def test_report__is_written_by_the_same_command_after_a_failed_disk(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It is whole and in its place: nothing is begun anew."""
    write(tmp_path, OLD)
    work = place(tmp_path)
    write(work, NEW)

    def fails(*_: object) -> None:
        raise OSError(5, "Input/output error")

    (work / ".whole").touch()
    with monkeypatch.context() as disk:
        disk.setattr(os, "replace", fails)
        with pytest.raises(ResourceError, match="the same command goes on"):
            output(tmp_path).finish_replacement()
    assert place(tmp_path) == tmp_path
    assert held(tmp_path) == NEW
    assert not work.exists()


def test_figures__those_of_an_earlier_result_go(tmp_path: Path) -> None:
    """A folder whose result is replaced has the new pictures only, with ``add`` those of both."""
    write_figures(tmp_path, {"one": b"1", "two": b"2"})
    write_figures(tmp_path, {"three": b"3"}, add=True)
    assert {each.stem for each in (tmp_path / "figures").iterdir()} == {"one", "two", "three"}
    write_figures(tmp_path, {"two": b"4"})
    assert [(each.stem, each.read_bytes()) for each in (tmp_path / "figures").iterdir()] == [("two", b"4")]
