"""What replaces a whole result is made in a place of its own: whatever fails on the way, one of the two is there, whole."""

import os
import shutil
from pathlib import Path
from typing import Any

import pytest

from gearplay.files import renewal as module
from gearplay.files.renewal import renewal, replace_old, settle
from gearplay.vocabulary.errors import ResourceError

OLD = {"rows.sqlite": "old rows", "result.nc": "old", "figures/a.png": "old a", "figures/b.png": "old b"}
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
        if each.is_file() and ".new" not in each.parts
    }


def forget(folder: Path) -> None:
    for name in ("rows.sqlite", "result.nc"):
        (folder / name).unlink(missing_ok=True)
    shutil.rmtree(folder / "figures", ignore_errors=True)


def place(folder: Path, of: str = "plan", *, overwrite: bool = True) -> Path:
    return renewal(folder, overwrite=overwrite, of=of, whole=("result.nc",), forget=forget)


def test_the_old_result_stays_until_the_new_one_is_whole(tmp_path: Path) -> None:
    write(tmp_path, OLD)
    work = place(tmp_path)
    write(work, NEW)
    assert held(tmp_path) == OLD
    assert place(tmp_path) == work  # an interrupted one goes on
    assert (work / "result.nc").exists()
    replace_old(tmp_path, work, forget)
    assert held(tmp_path) == NEW
    assert not work.exists()


def test_of_another_plan_nothing_is_kept(tmp_path: Path) -> None:
    write(tmp_path, OLD)
    write(place(tmp_path), NEW)
    assert not (place(tmp_path, "another") / "result.nc").exists()
    assert held(tmp_path) == OLD


def test_what_is_not_whole_is_forgotten_at_once(tmp_path: Path) -> None:
    write(tmp_path, {"rows.sqlite": "some"})
    assert place(tmp_path) == tmp_path
    assert held(tmp_path) == {}
    assert place(tmp_path, overwrite=False) == tmp_path


@pytest.mark.hostile
@pytest.mark.parametrize("at", range(12))
def test_a_kill_while_one_takes_the_place_of_the_other(
    at: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write(tmp_path, OLD)
    work = place(tmp_path)
    write(work, NEW)
    calls = 0

    def fragile(do: Any) -> Any:
        def done(*words: Any, **more: Any) -> Any:
            nonlocal calls
            calls += 1
            if calls == at + 1:
                raise Killed
            return do(*words, **more)

        return done

    with monkeypatch.context() as patched:
        patched.setattr(module.shutil, "rmtree", fragile(shutil.rmtree))
        patched.setattr(os, "replace", fragile(os.replace))
        patched.setattr(Path, "unlink", fragile(Path.unlink))
        try:
            replace_old(tmp_path, work, forget)
        except Killed:
            if not (work / ".whole").exists():
                assert held(tmp_path) == OLD
    settle(tmp_path, forget)
    assert held(tmp_path) in ((OLD, NEW) if (work / ".of").exists() else (NEW,))


def test_a_disk_that_fails_while_a_new_result_takes_its_place_only_puts_it_off(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def forget(folder: Path) -> None:
        for name in ("a.nc", "b.nc"):
            (folder / name).unlink(missing_ok=True)

    (tmp_path / "a.nc").write_text("old", encoding="utf-8")
    place = renewal(tmp_path, overwrite=True, of="plan", whole=["a.nc"], forget=forget)
    for name in ("a.nc", "b.nc"):
        (place / name).write_text("new", encoding="utf-8")
    move = os.replace

    def fail(source: Path, target: Path) -> None:
        if target == tmp_path / "b.nc":
            raise OSError(5, "Input/output error")
        move(source, target)

    with monkeypatch.context() as disk:
        disk.setattr(os, "replace", fail)
        with pytest.raises(ResourceError, match=r"Input/output error.*the same command goes on"):
            replace_old(tmp_path, place, forget)
    assert renewal(tmp_path, overwrite=False, of="plan", whole=["a.nc"], forget=forget) == tmp_path
    assert {each.name: each.read_text(encoding="utf-8") for each in tmp_path.iterdir()} == {
        "a.nc": "new",
        "b.nc": "new",
    }
