"""Data sets as written: files, table of labels, data sheet; the same bytes in every way, after kills, on resumption."""

import csv
import hashlib
import os
import random
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gearplay as gp
from datasets.plans import FEW, RECORDS
from depth import sized
from gearplay.cli.main import run
from gearplay.model.toml_files import write_toml
from gearplay.vocabulary.errors import InputError, TakenError

pytestmark = pytest.mark.slow


def content(folder: Path) -> dict[str, str]:
    """Return the digest of every file of a data set but those of its store."""
    return {
        str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted(folder.rglob("*"))
        if path.is_file() and not path.name.startswith((".lock", "rows"))
    }


def table(folder: Path) -> list[dict[str, str]]:
    with (folder / "labels.csv").open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of a data set that nothing interrupted."""
    folder = tmp_path_factory.mktemp("dataset") / "whole"
    gp.make_dataset(FEW, folder, threads=1)
    return folder


@pytest.fixture
def plan(tmp_path: Path) -> Path:
    path = tmp_path / "few.toml"
    path.write_text(write_toml(FEW), encoding="utf-8")
    return path


def test_records_are_those_of_measure(whole: Path) -> None:
    rows = table(whole)
    assert [int(row["record"]) for row in rows] == list(range(RECORDS))
    row = rows[-1]
    changes = {
        "run.duration": 0.02,
        "run.transient": 0.0,
        "sleeves.ring.radial_clearance": float(row["clearance"]),
        "meshes.0.backlash": float(row["backlash"]),
        "rotors.pinion.drive.speed": float(row["speed"]),
        "rotors.ring.load.drag": gp.load_case("han2021").rotors["ring"].load.drag * float(row["drag"]),
    }
    record = gp.measure(
        gp.replace(gp.load_case("han2021"), changes), FEW["rig"], member=RECORDS, seed=FEW["seed"]
    )
    expected = record.channel("sensor.recorded").values
    found = np.load(whole / row["path"])
    assert found.dtype == np.float32
    assert found.shape == (1, 400)
    assert np.array_equal(found[0], expected.astype(np.float32))
    assert float(row["rms"]) == pytest.approx(float(np.sqrt(np.mean(expected**2))), rel=1e-12)
    assert float(row["peak"]) == np.max(np.abs(expected))
    assert float(row["clipped"]) == 0.0
    assert rows[0]["clearance"] == ""


def test_three_lines_read_it(whole: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The example of the data sheet, executed."""
    text = (whole / "README.md").read_text(encoding="utf-8")
    monkeypatch.chdir(whole)
    names: dict[str, Any] = {}
    exec(text.partition("```python\n")[2].partition("```")[0], names)
    assert names["x"].shape == (RECORDS, 400)
    assert set(names["table"]["label"]) == {"normal", "worn"}
    assert set(names["table"]["split"]) == {"train", "validation", "test"}
    assert "| `worn` | sleeves.ring.radial_clearance drawn | 12 | 4 | 4 |" in text
    assert "per record of worn, log-uniform: `sleeves.ring.radial_clearance`" in text


@pytest.mark.parametrize(("kind", "ending"), [("hdf5", ".h5"), ("wav", ".wav"), ("mat", ".mat")])
def test_other_formats(kind: str, ending: str, whole: Path, tmp_path: Path) -> None:
    stages = ["recorded", "acceleration"]
    gp.make_dataset(FEW | {"format": kind, "stages": stages, "members": 1}, tmp_path / "d")
    rows, plain = table(tmp_path / "d"), table(whole)
    assert rows[0]["path"].endswith(ending)
    record = gp.read_measurement(tmp_path / "d" / rows[0]["path"])
    assert list(record.names) == ["sensor.recorded", "sensor.acceleration"]  # as the plan lists them
    same = np.load(whole / plain[0]["path"])[0]
    assert np.array_equal(record.channel("sensor.recorded").values.astype(np.float32), same)


def test_channels_and_attributes_are_those_of_the_plan_and_its_table(tmp_path: Path) -> None:
    """In a file without names, too: the first is the first stage of the plan."""
    coarse = FEW["rig"] | {"collector": FEW["rig"]["collector"] | {"bits": 8}}
    few = FEW | {"stages": ["recorded", "acceleration"], "rig": coarse, "members": 1, "format": "npy"}
    gp.make_dataset(few, tmp_path / "npy")
    row = max(table(tmp_path / "npy"), key=lambda each: float(each["rms"]))
    found = np.load(tmp_path / "npy" / row["path"])
    assert np.sqrt(np.mean(found[0].astype(float) ** 2)) == pytest.approx(float(row["rms"]), rel=1e-6)
    assert not np.array_equal(found[0], found[1])
    gp.make_dataset(few | {"format": "hdf5"}, tmp_path / "hdf5")
    (last,) = table(tmp_path / "hdf5")[-1:]
    kept = gp.read_measurement(tmp_path / "hdf5" / last["path"]).attributes
    assert (kept["member"], kept["record"]) == (last["member"], last["record"])


def test_processes_and_shards_give_the_same_bytes(whole: Path, plan: Path, tmp_path: Path) -> None:
    gp.make_dataset(FEW, tmp_path / "processes", engine=gp.Engine("processes", workers=2))
    assert content(tmp_path / "processes") == content(whole)
    for part in (2, 1, 3):
        assert run(["dataset", str(plan), "--out", str(tmp_path / "shards"), "--shard", f"{part}/3"]) == 0
        assert not (tmp_path / "shards" / "labels.csv").exists()
    assert run(["dataset", str(plan), "--out", str(tmp_path / "shards")]) == 0
    assert content(tmp_path / "shards") == content(whole)


def kill_at_random(plan: Path, out: Path, kills: int) -> Iterator[int]:
    """Start the command again and again, kill it at random moments of its work; yield the number of records then."""
    chance = random.Random(7)
    command = [sys.executable, "-m", "gearplay", "dataset", str(plan), "--out", str(out), "--workers", "1"]
    for _ in range(kills):
        before = len(list(out.rglob("*.npy")))
        with subprocess.Popen(
            command, start_new_session=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
        ) as process:
            wanted = before + chance.randint(0, max(1, 2 * (RECORDS - before) // (kills + 1)))
            while process.poll() is None and len(list(out.rglob("*.npy"))) < wanted:
                time.sleep(0.002)
            time.sleep(chance.uniform(0.0, 0.02))
            os.killpg(process.pid, signal.SIGKILL)
        yield len(list(out.rglob("*.npy")))


@pytest.mark.skipif(sys.platform == "win32", reason="signals of process groups")
def test_kills_change_nothing(whole: Path, plan: Path, tmp_path: Path) -> None:
    out = tmp_path / "killed"
    for _ in kill_at_random(plan, out, sized(20)):
        for path in out.rglob("*.npy"):
            assert content(whole)[str(path.relative_to(out))] == hashlib.sha256(path.read_bytes()).hexdigest()
        assert not (out / "labels.csv").exists() or content(out) == content(whole)
    assert run(["dataset", str(plan), "--out", str(out)]) == 0
    assert content(out) == content(whole)


def test_a_lost_file_is_made_again(whole: Path, tmp_path: Path) -> None:
    out = tmp_path / "lost"
    made = gp.make_dataset(FEW, out)
    (out / str(made.ds["path"].values[7])).unlink()
    seen: list[float] = []
    gp.make_dataset(FEW, out, progress=lambda label, done, total: seen.append(done))
    assert min(seen) >= RECORDS - 1
    assert content(out) == content(whole)


def test_failed_records_are_rows(tmp_path: Path) -> None:
    plan = FEW | {"set": FEW["set"] | {"run.max_steps": 5}, "members": 1}
    made = gp.make_dataset(plan, tmp_path / "d")
    failed = made.ds["status"].values == 1
    assert 0 < failed.sum() == made.account.failed < RECORDS // 2
    assert [bool(path) for path in made.ds["path"].values] == (~failed).tolist()
    assert all("steps" in str(reason) for reason in made.ds["reason"].values[failed])
    assert [row["status"] for row in table(tmp_path / "d")] == [str(int(each)) for each in failed]
    assert all(row["rms"] == "" for row, lost in zip(table(tmp_path / "d"), failed, strict=True) if lost)
    document = tmp_path / "failing.toml"
    document.write_text(write_toml(plan), encoding="utf-8")
    assert run(["dataset", str(document), "--out", str(tmp_path / "d")]) == 4


def test_another_plan_is_refused_and_overwritten(whole: Path, tmp_path: Path) -> None:
    out, other = tmp_path / "d", FEW | {"members": 1}
    gp.make_dataset(other, out)
    with pytest.raises(TakenError, match="must hold the same plan"):
        gp.make_dataset(FEW, out)
    gp.make_dataset(FEW, out, overwrite=True)
    assert content(out) == content(whole)


def test_stopped_and_resumed(whole: Path, tmp_path: Path) -> None:
    import threading

    stop, out = threading.Event(), tmp_path / "d"
    with pytest.raises(KeyboardInterrupt):
        gp.make_dataset(FEW, out, threads=1, stop=stop, progress=lambda *_: stop.set())
    assert 0 < len(list(out.rglob("*.npy"))) < RECORDS
    gp.make_dataset(FEW, out)
    assert content(out) == content(whole)


def test_a_shard_must_not_overwrite(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="must not be given for one shard"):
        gp.make_dataset(FEW, tmp_path / "d", overwrite=True, engine=gp.Engine(shard=(1, 2)))
