"""Failing disk: every write, sync, rename and link fails once; nothing is lost, no file is partial."""

import json
import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import gearplay as gp
from calibration_problems import PLAN as CALIBRATION
from cli.test_sweep import FEW
from datasets.plans import FEW as FEW_RECORDS
from depth import sized
from gearplay.model.toml_files import write_toml
from gearplay.vocabulary.errors import GearplayError
from gearplay.web.frames import pack_frame
from gearplay.web.store import Store
from gearplay.work.pieces import PieceStore

pytestmark = pytest.mark.hostile
HERE = Path(__file__).resolve().parents[1]
SHORT = ["--duration", "0.02s", "--transient", "0s"]
Look = Callable[[Path, Path, Path], None]


@pytest.fixture(scope="module")
def shim(tmp_path_factory: pytest.TempPathFactory) -> Path:
    compiler = shutil.which("gcc") or shutil.which("cc")
    if sys.platform != "linux" or compiler is None:
        if os.environ.get("CI"):
            pytest.fail("the trials of a failing disk need a C compiler on Linux")
        pytest.skip("no C compiler: the trials of a failing disk are not run (install gcc)")
    made = tmp_path_factory.mktemp("shim") / "failing_disk.so"
    words = [compiler, "-shared", "-fPIC", "-O1", "-o", made, HERE / "failing_disk.c", "-ldl"]
    subprocess.run(words, check=True)
    return made


def same(one: Path, other: Path) -> bool:
    return one.exists() and other.exists() and one.read_bytes() == other.read_bytes()


def one_of_both(name: str) -> Look:
    """Return a look at a file: it is the old one or the new one, or, where there was no old one, absent."""

    def look(before: Path, held: Path, whole: Path) -> None:
        if (before / name).exists() or (held / name).exists():
            assert same(held / name, before / name) or same(held / name, whole / name)

    return look


def one_result(name: str) -> Look:
    """Return a look at a result, which has times in it: it is read whole, or absent where there was no old one."""

    def look(before: Path, held: Path, whole: Path) -> None:
        if (before / name).exists() or (held / name).exists():
            gp.read_result(held / name)

    return look


def one_sweep(before: Path, held: Path, whole: Path) -> None:
    """Look at a sweep's folder: the product is the old or the new one, or the new one lies whole beside its place."""
    beside = held / "out" / ".new"
    if not (held / "out" / "sweep.nc").exists() and (beside / ".whole").exists():
        assert same(beside / "sweep.nc", whole / "out" / "sweep.nc")
        return
    one_of_both("out/sweep.nc")(before, held, whole)


def parts_of(before: Path, held: Path, whole: Path) -> None:
    """Look at finished parts: each that is there is whole, and none is lost."""
    for folder in (before, held):
        for file in (folder / "out" / "parts").glob("*.json"):
            assert PieceStore(held / "out" / "parts").get(file.stem) is not None, file.name
    for name in ("out/report.html", "out/calibration.json", "out/tables.json"):
        if (before / name).exists():
            assert (held / name).stat().st_size > 0.5 * (before / name).stat().st_size


def whole_records(before: Path, held: Path, whole: Path) -> None:
    """Look at a data set's folder: each record that is there is whole, and so is the table of labels."""
    for path in (*(held / "out").rglob("*.npy"), *(held / "out").glob("labels.csv")):
        assert same(path, whole / path.relative_to(held)), path


RECORD = """
import gearplay as gp
record = gp.read_measurement("record.csv", sampling=1000.0)
gp.write_record(record, {name!r}, overwrite=True)
"""
DATASET = """
import gearplay as gp
gp.lyapunov(gp.torsional_pair(0.7), count=1, duration=0.2, transient=0.1).save("found.nc", overwrite=True)
"""
STORE = """
from pathlib import Path
from gearplay.web.frames import pack_frame
from gearplay.web.store import Store
store = Store(Path("kept"), most=3)
for name in "2345":
    store.save(32 * name, pack_frame({"kind": "run", "title": name}))
"""


def begin_store(before: Path) -> None:
    store = Store(before / "kept")
    for name in "12":
        store.save(32 * name, pack_frame({"kind": "run", "title": f"old {name}"}))


def frames_of(before: Path, held: Path, whole: Path) -> None:
    """Look at the results that the page keeps: each that is there is whole, and an old one went only for newer ones."""
    store = Store(held / "kept")
    kept = {
        key: store.load(key)
        for key in (32 * name for name in "12345")
        if (held / f"kept/{key}.frame").exists()
    }
    assert all(kept.values()), kept
    assert len(store.listed()) == len(kept)
    assert 32 * "2" in kept or 32 * "5" in kept
    assert 32 * "1" in kept or len(kept) >= 3


def begin_run(before: Path) -> None:
    gp.simulate("han2021", duration=0.01, transient=0.0).save(before / "run.nc")


def begin_sweep(before: Path) -> None:
    (before / "plan.toml").write_text(write_toml(FEW), encoding="utf-8")


def begin_dataset(before: Path) -> None:
    plan = FEW_RECORDS | {"members": 1, "axes": []}
    (before / "plan.toml").write_text(write_toml(plan), encoding="utf-8")


def begin_old_sweep(before: Path) -> None:
    begin_sweep(before)
    gp.sweep(before / "plan.toml", folder=before / "out")


def begin_records(before: Path) -> None:
    rows = "\n".join(f"{0.001 * k},{k % 7}" for k in range(400))
    (before / "record.csv").write_text(f"time [s],acc [m/s^2]\n{rows}\n", encoding="utf-8")


def begin_calibration(before: Path) -> None:
    effort = CALIBRATION["effort"] | {"evaluations": 12, "startup": 12, "polish": 0}
    small = CALIBRATION | {"effort": effort, "models": CALIBRATION["models"][:1]}
    small["simulation"] = small["simulation"] | {"duration": "0.5 s"}
    (before / "plan.toml").write_text(write_toml(small), encoding="utf-8")


def nothing(before: Path) -> None:
    return None


# Name: work, what is there before, the look at what is left, trials at full depth, for `make torture`, and whether it goes on.
WORK: dict[str, tuple[dict[str, Any], Callable[[Path], None], Look, int, int, bool]] = {
    "run": (
        {"words": ["run", "han2021", *SHORT, "--out", "new.nc"]},
        nothing,
        one_result("new.nc"),
        5,
        20,
        True,
    ),
    "run over": (
        {"words": ["run", "han2021", *SHORT, "--out", "run.nc", "--overwrite"]},
        begin_run,
        one_result("run.nc"),
        5,
        20,
        True,
    ),
    "dataset": ({"program": DATASET}, nothing, one_result("found.nc"), 4, 20, True),
    **{
        f"export {name}": (
            {"program": RECORD.format(name=name)},
            begin_records,
            one_of_both(name),
            6,
            40,
            True,
        )
        for name in ("out.h5", "out.mat", "out.wav", "out.csv")
    },
    "measure": (
        {"words": ["measure", "han2021", "--set", "run.duration=0.1s", "--out", "out.h5"]},
        nothing,
        one_result("out.h5"),
        6,
        20,
        False,
    ),
    "sweep": (
        {"words": ["sweep", "plan.toml", "--out", "out"]},
        begin_sweep,
        one_sweep,
        6,
        400,
        True,
    ),
    "sweep over": (
        {"words": ["sweep", "plan.toml", "--out", "out", "--overwrite"]},
        begin_old_sweep,
        one_sweep,
        5,
        400,
        True,
    ),
    "labelled records": (
        {"words": ["dataset", "plan.toml", "--out", "out"]},
        begin_dataset,
        whole_records,
        6,
        200,
        True,
    ),
    "calibrate": (
        {"words": ["calibrate", "plan.toml", "--out", "out"]},
        begin_calibration,
        parts_of,
        1,
        60,
        True,
    ),
    "page": ({"program": STORE}, begin_store, frames_of, 6, 60, True),
    "study": (
        {"words": ["study", "han2021", "--members", "2", "--duration", "1", "--out", "out"]},
        nothing,
        parts_of,
        0,
        60,
        True,
    ),
}


def trials_of(name: str) -> int:
    full, torture = WORK[name][3:5]
    return sized(full, 0 if full <= 3 else 1, torture=torture)


@pytest.mark.slow
@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.deep] if name == "calibrate" else []) for name in WORK]
)
def test_a_failing_disk_loses_nothing(
    name: str, shim: Path, tmp_path: Path, tried: Callable[[int], None]
) -> None:
    """Every write, sync, rename and link of a command fails once, alone or with all after it."""
    work, begin, look, _, _, goes_on = WORK[name]
    trials = trials_of(name)
    if trials == 0:
        pytest.skip("left to make test-full or make torture")
    before, held, whole = (tmp_path / each for each in ("before", "held", "whole"))
    before.mkdir()
    begin(before)
    asked = work | {"base": str(tmp_path), "trials": trials, "seed": name, "again": goes_on}
    process = subprocess.Popen(
        [sys.executable, str(HERE / "failing_disk.py"), json.dumps(asked)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
        env={**os.environ, "LD_PRELOAD": str(shim)},
    )
    assert process.stdin is not None
    assert process.stdout is not None
    count = 0
    try:
        first = json.loads(process.stdout.readline())
        assert first["calls"] > 2
        for line in process.stdout:
            found = json.loads(line)
            if found["code"] == 0:
                assert (held / "out").exists() or any(held.iterdir())
            else:
                assert found["code"] in (2, 3, 4, 5), found
                sentences = [each for each in found["said"].splitlines() if "ompiling" not in each]
                assert 1 <= len(sentences) <= 2, found
            assert "Traceback" not in found["said"], found
            try:
                look(before, held, whole)
            except GearplayError as error:
                raise AssertionError((found, str(error))) from error
            assert found["again"] in (None, 0), (found, (tmp_path / "said").read_text(encoding="utf-8"))
            count += 1
            process.stdin.write("next\n")
            process.stdin.flush()
    finally:
        process.kill()
        process.communicate()
    assert count >= 1
    tried(count)
