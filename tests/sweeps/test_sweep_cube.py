"""The Zarr store of a sweep: the same as the product in one piece, however it is cut, and honest about what is missing."""

import json
import math
import os
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from tests.sweep_products import BACKLASH, PLAY, made, plan_of

from gearplay.cli.main import run
from gearplay.model.toml_files import write_toml
from gearplay.results.outcomes import MISSING, Account
from gearplay.sweeps.running import evaluate
from gearplay.sweeps.running import folder as in_folder
from gearplay.sweeps.running import zarr_export as cube
from gearplay.sweeps.running.evaluate import Sweep
from gearplay.sweeps.running.product import Rows
from gearplay.sweeps.running.zarr_export import blocks, write_cube
from gearplay.vocabulary.errors import InputError

PATH = {"kind": "history", "name": "path", "signal": "x", "at": "ring"}
FORMULATION = {"name": "formulation", "path": "formulation", "values": ["geometric", "as_published"]}


def cut_in(sweep: Sweep, points: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Let a block hold so many points."""
    monkeypatch.setattr(cube, "BLOCK", points * (8 * sweep.reducer.size + 10) + 1)


def rows_of(sweep: Sweep, dataset: xr.Dataset) -> dict[bytes, tuple[int, str, bytes]]:
    parts = [dataset[kept.name].values.reshape(-1, kept.size) for kept in sweep.reducer.layout]
    table = np.concatenate(parts, axis=1)
    ends = zip(dataset.status.values.ravel(), dataset.reason.values.ravel(), strict=True)
    return {
        sweep.template.address_of(at): (int(status), str(reason), row.tobytes())
        for at, (row, (status, reason)) in enumerate(zip(table, ends, strict=True))
    }


def opened(path: Path) -> xr.Dataset:
    with xr.open_zarr(path, consolidated=False) as dataset:
        return dataset.load()


def some(kept: Any, values: dict[str, Any], member: int) -> Any:
    if values["b"] > 350e-6:
        return "the shaft is locked"
    return np.arange(kept.size) + 1e5 * values["b"] + len(values["formulation"]) + member


@pytest.mark.slow
@pytest.mark.parametrize("points", [1, 2, 7, 9, 1000])
def test_a_cube_is_the_product_however_it_is_cut(
    points: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    sweep, whole = made(plan_of(FORMULATION, BACKLASH, members=3) | {"reduce": [PATH]}, some)
    cut_in(sweep, points, monkeypatch)
    rows = rows_of(sweep, whole)
    ended = write_cube(sweep, rows, tmp_path / "sweep.zarr")
    assert opened(tmp_path / "sweep.zarr").identical(whole)
    assert ended.failed == int((whole.status > 0).sum()) > 0
    assert ended.reasons == (("the shaft is locked", ended.failed),)
    assert ended == Account.of(whole.status.values, whole.reason.values)
    assert [each.name for each in tmp_path.iterdir()] == ["sweep.zarr"]


def test_a_sweep_of_one_case_has_a_cube(tmp_path: Path) -> None:
    sweep, whole = made(plan_of(), lambda kept, values, member: np.ones(kept.size))
    write_cube(sweep, rows_of(sweep, whole), tmp_path / "one.zarr")
    assert opened(tmp_path / "one.zarr").identical(whole)


@pytest.mark.parametrize("lost", ["row", "chunk"])
def test_what_is_missing_says_so(lost: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    sweep, whole = made(plan_of(BACKLASH, PLAY))
    cut_in(sweep, len(whole[PLAY["name"]]), monkeypatch)
    rows: dict[bytes, tuple[int, str, bytes]] = rows_of(sweep, whole)
    if lost == "row":
        del rows[sweep.template.address_of(0)]
    ended = write_cube(sweep, rows, tmp_path / "sweep.zarr")
    if lost == "chunk":
        shutil.rmtree(tmp_path / "sweep.zarr" / "status" / "c" / "0")
    found = opened(tmp_path / "sweep.zarr")
    assert found.status.dtype == np.int16
    assert int(found.status[0, 0]) == MISSING
    assert int(found.status[-1, -1]) == 0
    assert (ended.failed, ended.missing) == (0, int(lost == "row"))
    assert math.isnan(found.rms[0, 0]) == (lost == "row")


@pytest.mark.parametrize("shape", [(), (1,), (5,), (2, 3, 4), (7, 1, 5)])
@pytest.mark.parametrize("most", [1, 3, 4, 20, 100])
def test_blocks_cover_an_array_once(shape: tuple[int, ...], most: int) -> None:
    covered = np.zeros(shape, dtype=int)
    for block in blocks(shape, most):
        covered[block] += 1
        assert covered[block].size <= most
    assert np.all(covered == 1)


def test_a_folder_that_cannot_be_written_keeps_the_old_cube(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    sweep, whole = made(plan_of(BACKLASH))
    rows: Rows = rows_of(sweep, whole)
    for found in ({}, rows):  # the second replaces the first
        write_cube(sweep, found, tmp_path / "sweep.zarr")

    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(cube, "variables_of", full)
    with pytest.raises(InputError, match=r"sweep\.zarr.*must be writable \(No space left on device\)"):
        write_cube(sweep, rows, tmp_path / "sweep.zarr")
    assert opened(tmp_path / "sweep.zarr").identical(whole)
    assert [each.name for each in tmp_path.iterdir()] == ["sweep.zarr"]


def test_a_rename_that_fails_keeps_the_old_cube(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    sweep, whole = made(plan_of(BACKLASH))
    rows: Rows = rows_of(sweep, whole)
    write_cube(sweep, rows, tmp_path / "sweep.zarr")
    replace = os.replace

    def fails(source: Path, target: Path) -> None:
        if source.name.endswith(".part") and target.name == "sweep.zarr":
            raise OSError(5, "Input/output error")
        replace(source, target)

    with monkeypatch.context() as patched:
        patched.setattr(cube.os, "replace", fails)
        with pytest.raises(InputError, match="Input/output error"):
            write_cube(sweep, {}, tmp_path / "sweep.zarr")
    assert opened(tmp_path / "sweep.zarr").identical(whole)
    assert [each.name for each in tmp_path.iterdir()] == ["sweep.zarr"]
    os.replace(tmp_path / "sweep.zarr", tmp_path / ".sweep.zarr.old")  # killed between the two names
    write_cube(sweep, rows, tmp_path / "sweep.zarr")
    assert [each.name for each in tmp_path.iterdir()] == ["sweep.zarr"]


@pytest.mark.parametrize("named", [False, True])
@pytest.mark.parametrize("do", [in_folder._sweep_up, lambda folder: do_sweep(folder)])
def test_cube__leftovers_of_a_kill_are_removed_but_needed_pieces(
    do: Callable[[Path], object], named: bool, tmp_path: Path
) -> None:
    for name in (".sweep.zarr.part", ".sweep.zarr.old", *(["sweep.zarr"] if named else [])):
        (tmp_path / name).mkdir()
        (tmp_path / name / "what").write_text(name)
    do(tmp_path)
    assert [each.name for each in tmp_path.glob("*sweep.zarr*")] == ["sweep.zarr"]
    assert (tmp_path / "sweep.zarr" / "what").read_text() == ("sweep.zarr" if named else ".sweep.zarr.old")


def do_sweep(folder: Path) -> None:
    """Run a sweep there that writes no cube."""
    (folder / "plan.toml").write_text(write_toml(plan_of(BACKLASH | {"count": 2})), encoding="utf-8")
    assert run(["sweep", str(folder / "plan.toml"), "--out", str(folder)]) == 0


def test_a_forgotten_sweep_leaves_no_cube_that_could_come_back(tmp_path: Path) -> None:
    for name in (".sweep.zarr.part", ".sweep.zarr.old"):
        (tmp_path / name).mkdir()
    in_folder.remove_sweep(tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_ctrl_c_between_the_two_names_keeps_the_old_cube(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    sweep, whole = made(plan_of(BACKLASH))
    write_cube(sweep, rows_of(sweep, whole), tmp_path / "sweep.zarr")
    replace = os.replace

    def interrupted(source: Path, target: Path) -> None:
        replace(source, target)
        if target.name.endswith(".old"):
            raise KeyboardInterrupt

    with monkeypatch.context() as patched:
        patched.setattr(cube.os, "replace", interrupted)
        with pytest.raises(KeyboardInterrupt):
            write_cube(sweep, {}, tmp_path / "sweep.zarr")
    assert opened(tmp_path / "sweep.zarr").identical(whole)
    assert [each.name for each in tmp_path.iterdir()] == ["sweep.zarr"]


@pytest.mark.slow
def test_a_cube_beyond_memory_goes_without_the_product(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    plan = plan_of(BACKLASH | {"count": 3}, members=2)
    (tmp_path / "plan.toml").write_text(write_toml(plan), encoding="utf-8")
    monkeypatch.setattr(evaluate, "LARGEST", 100.0)
    words = ["sweep", str(tmp_path / "plan.toml"), "--out", str(tmp_path / "out"), "--json"]
    assert run(words) == 5
    assert "Say --zarr" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()
    assert run([*words, "--zarr"]) == 0
    said = json.loads(capsys.readouterr().out)
    assert (said["cases"], said["ran"], said["failed"]) == (6, 6, 0)
    assert not {"out", "report"} & said.keys()
    assert not (tmp_path / "out" / "sweep.nc").exists()
    monkeypatch.undo()
    assert run(["resume", str(tmp_path / "out")]) == 0
    with xr.open_dataset(tmp_path / "out" / "sweep.nc", engine="h5netcdf") as whole:
        assert opened(Path(said["cube"])).equals(whole)
