"""`gearplay sweep`: the same bytes with every engine, after kills, beside other sweeps, on a full disk.

Run as a script, this file is the process that starts a sweep again and again and kills it: see `kill_again_and_again`.
"""

import json
import os
import random
import signal
import sqlite3
import subprocess
import sys
import threading
import time
import traceback
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO

import psutil
import pytest

import gearplay as gp
from depth import sized
from gearplay.cli.main import run
from gearplay.files.atomic import shown_path
from gearplay.model.reading import load_case, to_toml
from gearplay.model.toml_files import write_toml
from gearplay.sweeps import sweep
from gearplay.sweeps.plans.reading import load_sweep
from gearplay.sweeps.running import folder as in_folder
from gearplay.sweeps.running.evaluate import REDUCED, REFUSED, Sweep
from gearplay.vocabulary.cores import worker_count
from gearplay.vocabulary.errors import InputError
from gearplay.work import cluster as on_cluster
from gearplay.work import engine as engines
from gearplay.work import processes
from gearplay.work.folder import locked
from gearplay.work.rows import Outcome, RowStore

pytestmark = pytest.mark.usefixtures("undrawn")

CASES, KILLS = 300, sized(40, torture=100)
RMS: dict[str, Any] = {"kind": "statistic", "name": "rms", "signal": "ax", "at": "ring"}
SPEED: dict[str, Any] = {
    "name": "speed",
    "path": "rotors.pinion.drive.speed",
    "low": "20 rpm",
    "high": "300 rpm",
    "count": 25,
}
RUN = {"run.duration": "0.5 s", "run.transient": "0 s", "run.sampling": "1 kHz"}
PLAN: dict[str, Any] = {
    "title": "small",
    "case": "han2021",
    "members": 2,
    "set": RUN,
    "axes": [
        SPEED,
        {
            "name": "clearance",
            "path": "sleeves.ring.radial_clearance",
            "values": ["10 um", "100 um", "300 um"],
        },
        {"name": "model", "path": "backlash_model", "values": ["coupled", "uncoupled"]},
    ],
    "reduce": [RMS],
}
FEW: dict[str, Any] = {
    "case": "han2021",
    "set": {**RUN, "run.duration": "0.02 s"},
    "axes": [{**SPEED, "count": 3}],
    "reduce": [RMS],
}
NEVER = FEW | {"set": {**RUN, "run.duration": "5e5 s", "run.sampling": "1 Hz"}}
ENDLESS = ["--set", "run.duration=5e5 s", "--set", "run.sampling=1 Hz"]
"""Each case would take half an hour."""

CLUSTER = """
import sys
from distributed import LocalCluster
settings = dict(processes=True, threads_per_worker=1, dashboard_address=None, host="127.0.0.1", memory_limit=0)
with LocalCluster(n_workers=2, **settings) as cluster:
    print(cluster.scheduler_address, *(nanny.pid for nanny in cluster.workers.values()), flush=True)
    sys.stdin.read()
"""
LINE = len(f"+{32 * '00'}\n")  # of the log of a sweep that is killed


Begin = Callable[..., subprocess.Popen[str]]


@pytest.fixture
def begin() -> Iterator[Begin]:
    """Yield a function that starts a command in a process group of its own, which ends with the test at the latest."""
    begun: list[subprocess.Popen[str]] = []

    def begin(*words: object, **more: Any) -> subprocess.Popen[str]:
        command = [sys.executable, "-m", "gearplay.cli.main", *map(str, words)]
        pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
        begun.append(subprocess.Popen(command, text=True, start_new_session=True, **pipes, **more))
        return begun[-1]

    yield begin
    for process in begun:
        kill(process)


def kill(process: subprocess.Popen[str]) -> None:
    """Kill a command with all its processes."""
    with suppress(ProcessLookupError):
        os.killpg(process.pid, signal.SIGKILL)
    process.communicate()


def do(*words: object) -> int:
    """Run a command in this process and return its exit code."""
    return run([str(word) for word in words])


def finish(plan: Path, folder: Path, **policy: Any) -> None:
    """Run a sweep in its folder to its end, without its report."""
    found = sweep.sweep(plan, folder=folder, engine=engines.Engine(**policy)).ds
    assert not found.status.any()


def content(folder: Path) -> bytes:
    return (folder / "sweep.nc").read_bytes()


def rows(folder: Path) -> list[tuple[bytes, int]]:
    """Return address and status of every stored row of all writers; fail where a file is not sound."""
    found: list[tuple[bytes, int]] = []
    for path in folder.glob("rows*.sqlite"):
        with closing(sqlite3.connect(path)) as connection:
            assert connection.execute("pragma integrity_check").fetchall() == [("ok",)]
            if connection.execute("select 1 from sqlite_master").fetchall():
                found += connection.execute("select address, status from rows").fetchall()
    return sorted(found)


def leftovers(folder: Path) -> list[str]:
    """Return the names of files that a sweep which ended should not leave."""
    ends = (".part", "-wal", "-shm", "-journal")
    return [path.name for path in folder.rglob("*") if path.name.endswith(ends)]


def wait_for(what: Callable[[], object], process: subprocess.Popen[str] | None = None) -> None:
    """Wait until something holds; fail where the process ends before, or after two minutes."""
    deadline = time.monotonic() + 120.0
    while not what():
        assert process is None or process.poll() is None, process.communicate()
        assert time.monotonic() < deadline
        time.sleep(0.003)


def log_size(folder: Path) -> int:
    """Return the size of the store's write-ahead log, which grows by 8 to 12 kB each time that cases are stored."""
    try:
        return os.stat(folder / "rows.sqlite-wal").st_size
    except FileNotFoundError:
        return 0


def workers_of(process: "subprocess.Popen[str] | psutil.Process") -> list[psutil.Process]:
    """Return the worker processes below a process; one that has ended is none, though its parent may not have asked yet."""

    def works(each: psutil.Process) -> bool:
        with suppress(psutil.NoSuchProcess):
            return any("spawn_main" in word for word in each.cmdline())
        return False

    return [each for each in psutil.Process(process.pid).children(recursive=True) if works(each)]


def write_plan(document: dict[str, Any], path: Path) -> Path:
    path.write_text(write_toml(document), encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def plan(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_plan(PLAN, tmp_path_factory.mktemp("plan") / "small.toml")


@pytest.fixture(scope="module")
def few(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_plan(FEW, tmp_path_factory.mktemp("plan") / "few.toml")


@pytest.fixture(scope="module")
def whole(plan: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of a sweep that nothing interrupted."""
    out = tmp_path_factory.mktemp("whole")
    finish(plan, out, workers=1)
    assert len(set(rows(out))) == CASES
    assert leftovers(out) == []
    return out


@dataclass
class Cluster:
    address: str
    workers: list[int]  # process ids


@pytest.fixture(scope="module")
def cluster() -> Iterator[Cluster]:
    """Yield a Dask cluster of two processes, in a process tree of its own."""
    with subprocess.Popen(
        [sys.executable, "-c", CLUSTER],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
        start_new_session=True,
    ) as process:
        assert process.stdin
        assert process.stdout
        try:
            address, *workers = process.stdout.readline().split()
            yield Cluster(address, [int(pid) for pid in workers])
            process.stdin.close()
            process.wait(60)
        finally:
            if process.poll() is None:
                os.killpg(process.pid, signal.SIGKILL)


# The same bytes in every way


@pytest.mark.slow
@pytest.mark.parametrize("engine", ["threads", "processes"])
def test_threads_and_processes_give_the_same_bytes(
    engine: str, plan: Path, whole: Path, tmp_path: Path
) -> None:
    assert do("sweep", plan, "--out", tmp_path, "--engine", engine, "--workers", 2) == 0
    assert content(tmp_path) == content(whole)
    assert rows(tmp_path) == rows(whole)


@pytest.mark.slow
def test_shards_give_the_same_bytes(
    plan: Path, whole: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for part in (3, 1, 2):
        assert do("sweep", plan, "--out", tmp_path, "--shard", f"{part}/3", "--json") == 0
        assert json.loads(capsys.readouterr().out)["ran"] == CASES // 3
    assert not (tmp_path / "sweep.nc").exists()
    assert do("resume", tmp_path, "--json") == 0
    assert json.loads(capsys.readouterr().out)["ran"] == 0
    assert content(tmp_path) == content(whole)
    assert rows(tmp_path) == rows(whole)
    assert leftovers(tmp_path) == []


@pytest.mark.slow
def test_a_cluster_gives_the_same_bytes(
    begin: Begin, cluster: Cluster, plan: Path, whole: Path, tmp_path: Path
) -> None:
    process = begin("sweep", plan, "--out", tmp_path, "--scheduler", cluster.address)
    words = process.communicate(timeout=120)
    assert process.returncode == 0, words
    assert content(tmp_path) == content(whole)


@pytest.mark.slow
def test_memory_and_folder_hold_the_same(plan: Path, whole: Path) -> None:
    found = sweep.sweep(plan).ds
    assert gp.read_result(whole / "sweep.nc").ds.identical(found)
    assert found.rms.dims == ("speed", "clearance", "model", "member")
    assert bool(found.rms.notnull().all())


# Kills


def kill_again_and_again(plan: str, out: str, log: str) -> None:
    """Start a sweep in a process group of its own and kill it, `KILLS` times; then let it end. Print how many hit it at work.

    What is imported and compiled stays from one start to the next, so that the kills fall on the work and its files. The log
    has a line for each case that begins (?) or was stored (+).
    """
    chance, kills, at_work = random.Random(1), 0, 0
    made = Sweep(load_sweep(plan))
    import h5netcdf  # noqa: F401
    import xarray  # noqa: F401

    with open(log, "ab", buffering=0) as told:
        while kills < KILLS:
            before = os.stat(log).st_size
            left = CASES - Path(log).read_bytes().count(b"+")
            # Spread over what is left; with nothing left to spare the kill falls into the start or the end.
            further = chance.randint(0, max(0, 2 * left // (KILLS - kills)))
            child, ended, status = start_once(made, Path(out), told), 0, 0
            while not ended and os.stat(log).st_size < before + further * LINE:
                time.sleep(0.001)
                ended, status = os.waitpid(child, os.WNOHANG)
            if not ended:
                time.sleep(chance.random() * (0.005 if further else 0.05))
                os.killpg(child, signal.SIGKILL)
                _, status = os.waitpid(child, 0)
            assert os.WIFSIGNALED(status) or status == 0
            kills += os.WIFSIGNALED(status)
            at_work += os.stat(log).st_size > before
        assert os.waitpid(start_once(made, Path(out), told), 0)[1] == 0
    print(at_work)  # noqa: T201


def start_once(made: Sweep, folder: Path, told: BinaryIO) -> int:
    """Run what is missing of a sweep in a process group of its own, which tells of each case; return its number."""

    class Telling(RowStore):
        def add(self, outcomes: Sequence[Outcome]) -> None:
            super().add(outcomes)
            for outcome in outcomes:
                told.write(f"+{outcome.address.hex()}\n".encode())

    def telling(job: int, stop: threading.Event | None = None) -> list[Outcome]:
        begun = [made.template.address_of(point).hex() for point in made.template.points.job(job)]
        told.write("".join(f"?{each}\n" for each in begun).encode())
        return Sweep.evaluate(made, job, stop)

    child = os.fork()
    if child:
        os.setpgid(child, child)
        return child
    try:
        made.evaluate, in_folder.RowStore = telling, Telling  # type: ignore[assignment,method-assign,misc]
        with locked(folder):
            in_folder.run_in(made, folder, engines.Engine(workers=2))
            in_folder.gather(made, folder)
        os._exit(0)
    except BaseException:
        traceback.print_exc()
        os._exit(1)


@pytest.mark.slow
@pytest.mark.hostile
def test_kills_change_nothing(tmp_path: Path) -> None:
    slow = write_plan({**PLAN, "set": {**RUN, "run.duration": "2 s"}}, tmp_path / "slow.toml")
    out, log = tmp_path / "killed", tmp_path / "log"
    beside = {
        **os.environ,
        "PYTHONPATH": os.pathsep.join((str(Path(__file__).parents[1]), os.environ.get("PYTHONPATH", ""))),
    }
    words = [sys.executable, __file__, str(slow), str(out), str(log)]
    done = subprocess.run(words, capture_output=True, text=True, check=False, env=beside)
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""
    assert int(done.stdout) > KILLS // 2

    stored: set[str] = set()
    for line in log.read_text(encoding="ascii").split():
        assert line[1:] not in stored
        if line.startswith("+"):
            stored.add(line[1:])
    kept = rows(out)
    assert len({address for address, _ in kept}) == len(kept) == CASES
    assert stored <= {address.hex() for address, _ in kept}
    assert leftovers(out) == []

    finish(slow, tmp_path / "whole")
    assert content(out) == content(tmp_path / "whole")


@pytest.mark.slow
@pytest.mark.many
@pytest.mark.parametrize(("engine", "kills"), [("threads", sized(4, 2)), ("processes", 2)])
@pytest.mark.hostile
def test_kills_of_the_command_change_nothing(
    begin: Begin, engine: str, kills: int, plan: Path, whole: Path, tmp_path: Path
) -> None:
    chance = random.Random(2)
    for _ in range(kills):
        before, stored = rows(tmp_path), chance.randint(0, 5)
        process = begin("sweep", plan, "--out", tmp_path, "--engine", engine)
        wait_for(
            lambda stored=stored, process=process: log_size(tmp_path) > 10_000 * stored or process.poll() == 0
        )  # type: ignore[misc]
        kill(process)
        assert set(before) <= set(rows(tmp_path))
    finish(plan, tmp_path)
    assert content(tmp_path) == content(whole)
    assert rows(tmp_path) == rows(whole)
    assert leftovers(tmp_path) == []


@pytest.mark.hostile
def test_what_a_killed_start_leaves_does_not_hinder(few: Path, tmp_path: Path) -> None:
    """A store that is not made yet, and temporary files of the plan and the product."""
    (tmp_path / "figures").mkdir()
    for name in ("rows.sqlite", ".plan.json.abc.part", ".sweep.nc.abc.part", "figures/.rms.png.abc.part"):
        (tmp_path / name).touch()
    finish(few, tmp_path)
    assert len(rows(tmp_path)) == 3
    assert leftovers(tmp_path) == []


@pytest.mark.deep
@pytest.mark.hostile
def test_a_killed_worker_of_a_cluster_changes_nothing(
    begin: Begin, cluster: Cluster, plan: Path, whole: Path, tmp_path: Path
) -> None:
    process = begin("sweep", plan, "--out", tmp_path, "--scheduler", cluster.address)
    wait_for(lambda: log_size(tmp_path) > 30_000, process)
    os.kill(cluster.workers[0], signal.SIGKILL)
    words = process.communicate(timeout=120)
    assert process.returncode == 0, words
    assert content(tmp_path) == content(whole)


@pytest.mark.deep
@pytest.mark.hostile
def test_a_killed_worker_process_changes_nothing(
    begin: Begin, plan: Path, whole: Path, tmp_path: Path
) -> None:
    process = begin("sweep", plan, "--out", tmp_path, "--engine", "processes")
    wait_for(lambda: log_size(tmp_path) > 30_000, process)
    workers_of(process)[0].kill()
    words = process.communicate(timeout=120)
    assert process.returncode == 0, words
    assert content(tmp_path) == content(whole)


@pytest.mark.slow
def test_worker_processes_serve_one_sweep_after_the_other(monkeypatch: pytest.MonkeyPatch) -> None:
    """They start with the first, and end with the block; short cases come in batches, each once."""
    monkeypatch.setattr(processes, "LASTING", 100.0)
    made, me = Sweep(load_sweep(FEW)), psutil.Process()
    before = set(workers_of(me))
    with engines.Engine("processes", workers=1).lasting() as engine:
        kept, found = [], []
        for jobs in ([0, 1, 2], list(range(3)) * 40):
            batches = list(engine.outcomes(made, jobs))
            found.append([outcome.number for batch in batches for outcome in batch])
            kept.append(set(workers_of(me)) - before)
    assert sorted(found[0]) == [0, 1, 2]
    assert sorted(found[1]) == sorted([0, 1, 2] * 40)
    assert len(batches) < 20
    assert len(kept[0]) == 1
    assert kept[0] == kept[1]
    wait_for(lambda: not any(each.is_running() and each.status() != psutil.STATUS_ZOMBIE for each in kept[0]))


@pytest.mark.slow
def test_a_sweep_left_half_way_leaves_no_work_to_the_next() -> None:
    """Its workers end, one killed before; what they had waits in nobody's way."""
    long, short, me = Sweep(load_sweep(NEVER)), Sweep(load_sweep(FEW)), psutil.Process()
    before, stop = set(workers_of(me)), threading.Event()
    with engines.Engine("processes", workers=2).lasting() as engine:
        threading.Timer(1.0, stop.set).start()
        assert list(engine.outcomes(long, range(3), stop)) == []
        for worker in set(workers_of(me)) - before:
            worker.kill()
        found = [each.number for batch in engine.outcomes(short, [0, 1, 2]) for each in batch]
    assert sorted(found) == [0, 1, 2]


@pytest.mark.slow
def test_worker_processes_end_with_their_parent(begin: Begin, plan: Path, tmp_path: Path) -> None:
    process = begin("sweep", plan, *ENDLESS, "--out", tmp_path, "--engine", "processes")
    wait_for(lambda: len(workers_of(process)) > 1, process)
    workers = workers_of(process)
    process.kill()
    process.wait()
    wait_for(lambda: all(not w.is_running() or w.status() == psutil.STATUS_ZOMBIE for w in workers))


# Ctrl-C


@pytest.mark.slow
@pytest.mark.many
@pytest.mark.parametrize("engine", ["threads", "processes"])
@pytest.mark.hostile
def test_ctrl_c_says_how_to_go_on(begin: Begin, engine: str, plan: Path, whole: Path, tmp_path: Path) -> None:
    process = begin("sweep", plan, "--out", tmp_path, "--engine", engine, "--workers", 1)
    wait_for(lambda: log_size(tmp_path) > 30_000, process)
    os.killpg(process.pid, signal.SIGINT)  # as a terminal does: workers get it too
    _, words = process.communicate(timeout=120)
    assert process.returncode == 130
    assert (
        words.strip() == f"Interrupted. Finished cases are kept: gearplay resume {tmp_path} continues there."
    )
    kept = rows(tmp_path)
    assert 0 < len(kept) < CASES
    assert leftovers(tmp_path) == []
    assert do("resume", tmp_path) == 0
    assert content(tmp_path) == content(whole)


@pytest.mark.slow
@pytest.mark.parametrize("engine", ["threads", "processes"])
@pytest.mark.hostile
def test_ctrl_c_does_not_wait_for_long_cases(begin: Begin, engine: str, plan: Path, tmp_path: Path) -> None:
    process = begin("sweep", plan, *ENDLESS, "--out", tmp_path, "--engine", engine)
    wait_for((tmp_path / "rows.sqlite").exists, process)
    if engine == "processes":
        wait_for(lambda: len(workers_of(process)) > 1, process)
    process.send_signal(signal.SIGINT)
    _, words = process.communicate(timeout=120)
    assert process.returncode == 130
    assert "Traceback" not in words


# Beside others


@pytest.mark.slow
def test_two_processes_in_one_folder_are_refused(
    begin: Begin, plan: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    first = begin("sweep", plan, *ENDLESS, "--out", tmp_path)
    wait_for((tmp_path / "rows.sqlite").exists, first)
    assert do("sweep", plan, "--out", tmp_path) == 2
    assert do("resume", tmp_path) == 2
    said = capsys.readouterr().err.splitlines()
    words = "must not be in use by another process. Wait for it, or choose another folder."
    assert said == [f'out = "{shown_path(tmp_path)}": {words}'] * 2


@pytest.mark.deep
def test_shards_at_once_cooperate(begin: Begin, plan: Path, whole: Path, tmp_path: Path) -> None:
    both = [begin("sweep", plan, "--out", tmp_path, "--shard", f"{part}/2") for part in (1, 2)]
    for process in both:
        words, complaint = process.communicate(timeout=120)
        assert process.returncode == 0, complaint
        assert f"{CASES // 2} cases run. gearplay resume {tmp_path} gathers all shards." in words
    finish(plan, tmp_path)
    assert content(tmp_path) == content(whole)


@pytest.mark.parametrize(
    ("held", "asked", "code"), [("1-of-2", "1/2", 2), ("1-of-2", "2/2", 0), ("1-of-2", "", 2), ("", "1/2", 2)]
)
def test_who_may_be_in_a_folder_at_once(held: str, asked: str, code: int, few: Path, tmp_path: Path) -> None:
    with locked(tmp_path, part=held):
        assert do("sweep", few, "--out", tmp_path, *(["--shard", asked] if asked else [])) == code


def test_shards_go_on_where_a_whole_sweep_was_stopped(
    few: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(engines, "HELD", 0.0)  # each case at once
    stop = threading.Event()
    one = engines.Engine(workers=1)
    with pytest.raises(KeyboardInterrupt):
        sweep.sweep(few, folder=tmp_path, engine=one, stop=stop, progress=lambda *_: stop.set())
    assert len(rows(tmp_path)) == 1
    ran = 0
    for part in (1, 2):
        assert do("sweep", few, "--out", tmp_path, "--shard", f"{part}/2", "--json") == 0
        ran += json.loads(capsys.readouterr().out)["ran"]
    assert ran == 2
    assert len(rows(tmp_path)) == 3


def test_sweep__folder__has_the_options_of_the_command(few: Path, tmp_path: Path) -> None:
    """Another plan is refused until the old result may be replaced; a report is written where it is requested."""
    finish(few, tmp_path)
    assert not (tmp_path / "report.html").exists()
    other = {**FEW, "axes": [{**SPEED, "count": 2}]}
    with pytest.raises(InputError, match="must hold the same plan"):
        sweep.sweep(other, folder=tmp_path)
    assert len(rows(tmp_path)) == 3
    found = sweep.sweep(other, folder=tmp_path, overwrite=True, report=True)
    assert found.ds.sizes == {"speed": 2}
    assert (tmp_path / "report.html").exists()
    assert len(rows(tmp_path)) == 2
    assert leftovers(tmp_path) == []
    with pytest.raises(InputError, match="overwrite = true: must not be given for one shard"):
        sweep.sweep(other, folder=tmp_path, overwrite=True, engine=engines.Engine(shard=(1, 2)))
    part = sweep.sweep(other, folder=tmp_path / "part", engine=engines.Engine(shard=(1, 2)))
    assert sorted(part.ds.status.values.tolist()) == [-1, 0]


def test_a_stop_ends_the_case_in_hand() -> None:
    """A case of an hour is not waited for."""
    stop = threading.Event()
    long = {"run.duration": 3600.0, "run.sampling": 100.0, "run.max_steps": 10**12, "run.max_wall_time": 1e6}
    reduce = [{"kind": "statistic", "name": "rms", "signal": "ax", "at": "ring"}]
    threading.Timer(0.5, stop.set).start()
    with pytest.raises(KeyboardInterrupt):
        sweep.sweep("han2021", {"meshes.0.backlash": [1e-4]}, set=long, reduce=reduce, stop=stop)


def test_another_number_of_shards_goes_on_from_the_old_ones(
    few: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert do("sweep", few, "--out", tmp_path, "--shard", "1/3", "--json") == 0
    ran = json.loads(capsys.readouterr().out)["ran"]
    for part in (1, 2):
        assert do("sweep", few, "--out", tmp_path, "--shard", f"{part}/2", "--json") == 0
        ran += json.loads(capsys.readouterr().out)["ran"]
    assert ran == len(rows(tmp_path)) == 3


def test_a_shard_does_not_forget_for_others(
    few: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert do("sweep", few, "--out", tmp_path, "--shard", "1/2") == 0
    assert do("sweep", few, "--out", tmp_path, "--shard", "2/2", "--overwrite") == 2
    assert "--overwrite = true: must not be given with --shard" in capsys.readouterr().err
    assert len(rows(tmp_path)) == 2


# A disk that is full, a folder that cannot be written, files that are damaged


def test_a_folder_that_cannot_be_written(
    few: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def complaint(out: Path) -> str:
        assert do("sweep", few, "--out", out) == 2
        return capsys.readouterr().err.removesuffix("\n")

    file = tmp_path / "file"
    file.write_text("mine")
    for out in (file, file / "below"):
        assert "must be a folder that can be written" in complaint(out)
    assert file.read_text() == "mine"

    def closed(*_: object) -> int:
        raise PermissionError(13, "Permission denied")

    def read_only(*_: object, **__: object) -> sqlite3.Connection:
        raise sqlite3.OperationalError("attempt to write a readonly database")

    with monkeypatch.context() as patch:
        patch.setattr("gearplay.vocabulary.file_lock.os.open", closed)
        words = complaint(tmp_path / "new")
    assert words.endswith("must be a folder that can be written (Permission denied). Choose another place.")
    with monkeypatch.context() as patch:
        patch.setattr("gearplay.work.rows.sqlite3.connect", read_only)
        words = complaint(tmp_path / "newer")
    assert "(attempt to write a readonly database)" in words
    assert "\n" not in words


def cut(path: Path) -> None:
    path.write_bytes(path.read_bytes()[:-5000])


def fill(path: Path) -> None:
    path.write_bytes(random.Random(3).randbytes(20_000))


def rename(path: Path) -> None:
    with closing(sqlite3.connect(path)) as connection:
        connection.execute("alter table rows rename column row to line")


@pytest.mark.slow
@pytest.mark.parametrize("damage", [cut, fill, rename])
def test_a_damaged_store_is_named_and_left_alone(
    damage: Callable[[Path], None], few: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    finish(few, tmp_path)
    product, store = content(tmp_path), tmp_path / "rows.sqlite"
    damage(store)
    damaged = store.read_bytes()
    capsys.readouterr()
    for words in (["sweep", few, "--out", tmp_path], ["resume", tmp_path, "--shard", "1/2"]):
        assert do(*words) == 2
        (said,) = capsys.readouterr().err.splitlines()
        assert said.startswith(
            f'out = "{shown_path(tmp_path)}": its rows.sqlite must be a sweep\'s readable store ('
        )
    assert store.read_bytes() == damaged
    assert content(tmp_path) == product
    assert do("sweep", few, "--out", tmp_path, "--overwrite") == 0
    assert content(tmp_path) == product


@pytest.mark.slow
def test_an_interrupted_overwrite_leaves_the_old_result_and_goes_on(
    few: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    from gearplay.sweeps.running import folder as running

    finish(few, tmp_path)
    product, kept = content(tmp_path), (tmp_path / "rows.sqlite").read_bytes()
    gather = running.gather

    def interrupted(*words: Any) -> Any:
        raise KeyboardInterrupt

    monkeypatch.setattr(running, "gather", interrupted)
    assert do("sweep", few, "--out", tmp_path, "--overwrite") == 130
    assert "is as it was; the same command goes on" in capsys.readouterr().err
    assert content(tmp_path) == product
    assert (tmp_path / "rows.sqlite").read_bytes() == kept
    monkeypatch.setattr(running, "gather", gather)
    (tmp_path / "sweep.nc").write_bytes(b"old")
    assert do("sweep", few, "--out", tmp_path, "--overwrite", "--json") == 0
    assert json.loads(capsys.readouterr().out)["ran"] == 0  # all of it was kept
    assert content(tmp_path) == product
    assert not (tmp_path / ".new").exists()


@pytest.mark.slow
@pytest.mark.hostile
@pytest.mark.parametrize("damage", [fill, lambda path: path.with_name("plan.json").write_bytes(b"{")])
def test_an_overwrite_that_cannot_go_on_begins_anew(
    damage: Callable[[Path], None], few: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupted(*words: Any) -> Any:
        raise KeyboardInterrupt

    for place in (tmp_path, tmp_path / ".new"):
        with monkeypatch.context() as patched:
            patched.setattr(in_folder, "gather", interrupted)
            assert do("sweep", few, "--out", tmp_path, "--overwrite") == 130
        damage(place / "rows.sqlite")
        assert do("sweep", few, "--out", tmp_path, "--overwrite") == 0
        assert len(rows(tmp_path)) == 3


@pytest.mark.slow
@pytest.mark.hostile
@pytest.mark.parametrize("at", [".of", "plan.json", "sweep.nc"])
def test_resume__finishes_an_interrupted_replacement(
    at: str, few: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    finish(few, tmp_path)
    product, move = content(tmp_path), os.replace

    def killed(source: Path, target: Path) -> None:
        if target == tmp_path / at:
            raise KeyboardInterrupt
        move(source, target)

    with monkeypatch.context() as patched:
        patched.setattr(os, "replace", killed)
        assert do("sweep", few, "--out", tmp_path, "--overwrite") == 130
    capsys.readouterr()
    assert do("resume", tmp_path, "--json") == 0
    assert json.loads(capsys.readouterr().out)["ran"] == 0
    assert content(tmp_path) == product
    assert not [each for each in (".new", ".of") if (tmp_path / each).exists()]


def test_resume_makes_no_folder(tmp_path: Path) -> None:
    assert do("resume", tmp_path / "nowhere") == 2
    assert not (tmp_path / "nowhere").exists()


def test_a_row_that_was_changed_is_run_again(
    few: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Its number is another one, its length the same: without a digest nobody would see."""
    finish(few, tmp_path)
    product = content(tmp_path)
    with closing(sqlite3.connect(tmp_path / "rows.sqlite", isolation_level=None)) as connection:
        (address, row) = connection.execute("select address, row from rows").fetchone()
        changed = bytes([row[0] ^ 1]) + row[1:]
        connection.execute("update rows set row = ? where address = ?", (changed, address))
    (tmp_path / "sweep.nc").unlink()
    capsys.readouterr()
    assert do("resume", tmp_path, "--json") == 0
    assert json.loads(capsys.readouterr().out)["ran"] >= 1
    assert content(tmp_path) == product


@pytest.mark.parametrize("damaged", [b'{"case": ', b"\xff\xfe", b"[1]", b"", b"[" * 100_000])
def test_a_damaged_plan_is_named(
    damaged: bytes, few: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "plan.json").write_bytes(damaged)
    for words in (["sweep", few, "--out", tmp_path], ["resume", tmp_path]):
        assert do(*words) == 2
        (said,) = capsys.readouterr().err.splitlines()
        assert said.startswith(f'out = "{shown_path(tmp_path)}": its plan.json must be a plan that')
    assert (tmp_path / "plan.json").read_bytes() == damaged


# Cases that fail


@pytest.mark.slow
def test_failed_cases_are_rows_and_run_again_when_asked(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A pair that cannot be made (a pinion of 58 teeth in a ring of 56), and runs that reach their limit of steps."""
    import xarray as xr

    teeth = [
        {"name": "pinion", "path": "rotors.pinion.teeth", "values": [20, 58, 21]},
        {"name": "ring", "path": "rotors.ring.teeth", "values": [60, 56, 62]},
        {"name": "steps", "path": "run.max_steps", "values": [1_000_000, 1]},
    ]
    plan, out = write_plan({**FEW, "axes": teeth}, tmp_path / "plan.toml"), tmp_path / "out"
    assert do("sweep", plan, "--out", out, "--json") == 4
    document = json.loads(capsys.readouterr().out)
    assert (document["cases"], document["ran"]) == (18, 18)
    with xr.open_dataset(out / "sweep.nc", engine="h5netcdf") as found:
        status = found.status.load()
        refused = found.isel(pinion=1, ring=1)
        assert (status.sel(steps=1) != 0).all()
        assert (refused.status == REFUSED).all()
        assert "must be more than the 58 teeth of pinion" in str(refused.reason.values[0])
        assert "limit on steps" in str(found.reason.values[0, 0, 1])
        assert (found.rms.notnull() == (status == 0)).all()
        assert ((found.reason == "") == (status == 0)).all()
        meanings = dict(zip(status.flag_values, status.flag_meanings.split(), strict=True))
        assert meanings[REFUSED] == "refused"
    failed = int((status != 0).sum())
    assert document["failed"] == failed
    assert 10 <= failed < 18
    before = content(out)
    for words, ran in (([], 0), (["--retry"], failed), (["--retry", "--shard", "1/1"], failed)):
        assert do("resume", out, "--json", *words) == (0 if "--shard" in words else 4)
        assert json.loads(capsys.readouterr().out)["ran"] == ran
        assert content(out) == before
        assert len(rows(out)) == 18


def test_corners_of_a_plan_may_be_refused_and_lengths_may_differ(tmp_path: Path) -> None:
    """The first and last cases are those that a plan's addresses are tried with."""
    teeth = [
        {"name": "pinion", "path": "rotors.pinion.teeth", "values": [58, 20]},
        {"name": "ring", "path": "rotors.ring.teeth", "values": [56, 60]},
    ]
    found = sweep.sweep({**FEW, "axes": teeth}).ds
    assert found.status.values[0].tolist()[0] == found.sel(pinion=58, ring=56).status == REFUSED
    assert found.sel(pinion=20, ring=60).status == 0
    lengths = [{"name": "duration", "path": "run.duration", "values": [0.01, 0.02]}]
    history = {"kind": "history", "name": "path", "signal": "x", "at": "ring"}
    found = sweep.sweep({**FEW, "axes": lengths, "reduce": [history]}, folder=tmp_path).ds
    assert found.status.values.tolist() == [REDUCED, 0]
    assert "must keep the 20 numbers of the base case" in str(found.reason.values[0])


# Plans and folders


@pytest.mark.slow
def test_a_folder_keeps_to_one_plan(few: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out, other = tmp_path / "out", ["--set", "run.duration=0.03 s"]
    finish(few, out)
    before = rows(out)
    assert do("sweep", few, "--out", out, *other) == 2
    said = capsys.readouterr().err
    words = "must hold the same plan. Choose another folder, or say --overwrite."
    assert said == f'out = "{shown_path(out)}": {words}\n'
    assert rows(out) == before
    assert do("sweep", few, "--out", out, *other, "--overwrite", "--json") == 0
    assert json.loads(capsys.readouterr().out)["ran"] == 3
    assert not set(rows(out)) & set(before)


@pytest.mark.slow
def test_a_case_file_goes_into_the_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A sweep is resumed wherever it is called from; a case file that was changed meanwhile is another plan."""
    case = tmp_path / "mine.toml"
    case.write_text(to_toml(load_case("han2021")), encoding="utf-8")
    write_plan({**FEW, "case": "mine.toml"}, tmp_path / "plan.toml")
    monkeypatch.chdir(tmp_path)
    assert do("sweep", "plan.toml", "--out", "out") == 0
    monkeypatch.chdir("/")
    assert do("resume", tmp_path / "out") == 0
    case.write_text(to_toml(load_case("han2021", ["meshes.0.backlash=50um"])), encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    assert do("sweep", "plan.toml", "--out", "out") == 2


def test_a_dry_run_writes_nothing(
    few: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert do("sweep", few, "--dry-run") == 0
    words = capsys.readouterr().out
    assert "3 cases, about" in words
    assert words.rstrip().endswith("MB. Nothing was written.")
    assert do("sweep", few, "--dry-run", "--json", "--workers", 3) == 0
    document = json.loads(capsys.readouterr().out)
    assert (document["cases"], document["pilots"], document["workers"]) == (3, 3, min(3, worker_count()))
    assert document["seconds"] > 0.0
    assert document["bytes"] > 3 * 8
    assert list(tmp_path.iterdir()) == []


@pytest.mark.slow
def test_json_is_one_document(few: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert do("sweep", few, "--out", tmp_path, "--json") == 0
    printed = capsys.readouterr()
    document = json.loads(printed.out)
    assert [document[key] for key in ("title", "cases", "ran", "failed", "reasons")] == ["", 3, 3, 0, []]
    assert document["out"] == str(tmp_path / "sweep.nc")
    assert printed.err == ""
    assert do("sweep", few, "--out", tmp_path, "--shard", "0/3", "--json") == 2
    assert json.loads(capsys.readouterr().out)["faults"][0]["path"] == "--shard"


TONE = {**RMS, "kind": "line", "order": 1}
AXIS = {"name": "gap", "path": "meshes.0.backlash", "values": ["50 um"]}
DRAWN = {"name": "gap", "path": "meshes.0.backlash", "mean": "50 um"}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"membres": 2}, "membres: unknown field. Did you mean 'members'?"),
        ({"axes": [{**AXIS, "valeus": [1]}]}, "axes.0.valeus: unknown field. Did you mean 'values'?"),
        ({"axes": [{"name": "gap", "path": "meshes.0.backlash"}]}, "axes.0.values"),
        ({"axes": [{**AXIS, "values": []}]}, "axes.0.values"),
        ({"axes": [{**AXIS, "low": 1e-5, "high": 1e-4, "count": 2}]}, "axes.0.values"),
        ({"axes": [AXIS, {**AXIS, "path": "run.seed", "values": [1]}]}, "axes.1.name"),
        ({"axes": [AXIS, {**AXIS, "name": "other"}]}, "meshes.0.backlash belongs to gap too"),
        ({"axes": [{**AXIS, "name": "rms"}]}, "reduce.0.name"),
        ({"axes": [{**AXIS, "path": "meshes.0.backlsh"}]}, "Did you mean 'backlash'?"),
        ({"axes": [{**AXIS, "path": "meshes.7.backlash"}]}, "axes.0.values.0: meshes.7"),
        ({"axes": [{**AXIS, "values": ["50 um", "50 kg"]}]}, "axes.0.values.1: meshes.0.backlash"),
        ({"axes": [{**AXIS, "values": ["50 um", -1e-4]}]}, "axes.0.values.1: meshes.0.backlash"),
        ({"axes": [{**AXIS, "values": ["50 um", 5e-5]}]}, "axes.0.values.1 = 5e-05: must not be a value that gap"),
        ({"axes": [{**SPEED, "high": "20 rpm"}]}, 'axes.0.high = "20 rpm": must not be a value that speed'),
        ({"axes": [{**AXIS, "mode": "scale"}]}, "must be a plain number, as a factor"),
        ({"axes": [{**AXIS, "path": "title", "mode": "scale", "values": [2]}]}, "title = "),
        ({"axes": [{**AXIS, "name": "rms_amplitude"}], "reduce": [TONE]}, 'reduce = "rms_amplitude"'),
        ({"reduce": [TONE, {**RMS, "name": "rms_frequency"}]}, 'reduce = "rms_frequency"'),
        ({"reduce": [{**RMS, "kind": "level", "band": [2, 1]}]}, "reduce.0.band"),
        ({"axes": [{**SPEED, "low": "20 um"}]}, "axes.0.low: rotors.pinion.drive.speed"),
        ({"axes": [{**SPEED, "scale": "log", "low": 0.0}]}, "axes.0.low"),
        ({"set": {"run.durtion": 1.0}}, "set: run.durtion: unknown field. Did you mean 'duration'?"),
        ({"set": {"run.duration": "1 m"}}, "set: run.duration"),
        ({"case": "han2012"}, "Did you mean 'han2021'?"),
        ({"case": "nowhere/case.toml"}, "nowhere/case.toml"),
        ({"reduce": []}, "reduce"),
        ({"reduce": [{**RMS, "at": "rng"}]}, "reduce.rms.at"),
        ({"reduce": [{**RMS, "signal": "contact_state"}]}, "must have the signal contact_state. Choose from: pinion-ring."),
        ({"reduce": [{**RMS, "signal": "axx"}]}, "reduce.rms.signal"),
        ({"reduce": [{**RMS, "kind": "statistics"}]}, "reduce.0.kind"),
        ({"reduce": [{"kind": "jam", "name": "jam", "mesh": "nowhere"}]}, "reduce.jam.mesh"),
        ({"reduce": [{"kind": "line", "name": "line", "signal": "ax", "at": "ring"}]}, "reduce.0.order"),
        ({"members": 0}, "members"),
        (
            {
                "design": {
                    "count": 9,
                    "parameters": [{**DRAWN, "distribution": "normal", "deviation": "60 um"}],
                }
            },
            "design.parameters.0: the draws of gap reach meshes.0.backlash = -",
        ),
        (
            {
                "design": {
                    "count": 9,
                    "parameters": [{**DRAWN, "distribution": "normal", "deviation": "5 um", "low": "150 um"}],
                }
            },
            'design.parameters.0 = "gap": must leave at least 0.001 of its distribution between low and high',
        ),
    ],
)  # fmt: skip
def test_plans_at_fault_are_told_before_anything_runs(
    change: dict[str, Any], words: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    plan = write_plan({**FEW, **change}, tmp_path / "plan.toml")
    assert do("sweep", plan, "--out", tmp_path / "out") == 2
    assert words in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_plans_and_cases_are_told_apart(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    plan = write_plan(FEW, tmp_path / "plan.toml")
    case = tmp_path / "case.toml"
    case.write_text(to_toml(load_case("han2021")), encoding="utf-8")

    def told() -> str:
        return capsys.readouterr().err

    assert do("check", plan) == 2
    assert "must be a case, but this is a sweep plan. Run it with gearplay sweep, or name its case." in told()
    assert do("sweep", case) == 2
    assert "must be a sweep plan, but this is a case. Name it in a sweep plan: case = FILE." in told()
    assert do("calibrate", case) == 2
    assert (
        told()
        == "plan: must be a calibration plan, but this is a case. Name it in a calibration plan: case = FILE.\n"
    )
    assert do("calibrate", plan) == 2
    assert (
        told() == "plan: must be a calibration plan, but this is a sweep plan. Run it with gearplay sweep.\n"
    )
    assert do("dataset", plan, "--out", tmp_path / "set") == 2
    assert (
        told()
        == "plan: must be a plan of a data set, but this is a sweep plan. Run it with gearplay sweep.\n"
    )
    assert do("sweep", plan, "--set", "axes.0.count=3", "--out", tmp_path / "set") == 2
    rule = "must be a field of the case, and axes is one of the plan. Change it in the plan's file."
    assert told() == f'--set = "axes.0.count": {rule}\n'
    assert do("measure", "han2021", "--rig", case, "--out", tmp_path / "a.h5") == 2
    assert "must be a rig, but this is a case. Choose another file.\n" in told()
    rig = tmp_path / "rig.toml"
    rig.write_text("[collector]\nbits = 12\n", encoding="utf-8")
    assert do("run", rig) == 2
    assert told().endswith(": must be a case, but this is a rig. Name it as the rig of a measurement.\n")


@pytest.mark.parametrize(
    ("words", "field"),
    [
        (["--tls-ca", "ca.pem"], '--tls = "ca.pem": must be given together with --scheduler'),
        (["--shard", "0/3"], '--shard = "0/3"'),
        (["--shard", "4/3"], '--shard = "4/3"'),
        (["--shard", "a/b"], '--shard = "a/b"'),
        (["--engine", "thread"], 'engine = "thread"'),
        (["--set", "run.durtion=1"], "set: run.durtion"),
        (["--workers", "0"], "--workers"),
    ],
)
def test_options_at_fault(
    words: list[str], field: str, few: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert do("sweep", few, "--out", tmp_path / "out", *words) == 2
    assert field in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_missing_files_are_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert do("sweep", "none.toml") == 2
    assert 'plan = "none.toml": no such file' in capsys.readouterr().err
    assert do("sweep", "han2021-mpa") == 2
    assert "Did you mean 'han2021-map'?" in capsys.readouterr().err
    for folder in (tmp_path, tmp_path / "none"):
        assert do("resume", folder) == 2
        assert "must be a sweep's folder, with its plan.json" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


@pytest.mark.slow
@pytest.mark.parametrize(
    ("address", "more", "words"),
    [
        ("tcp://127.0.0.1:9", [], "0.3 s"),
        ("nonsense", [], "missing port"),
        ("http://127.0.0.1:9", [], "http"),
        ("tls://127.0.0.1:9", ["--tls-ca", "none.pem"], "none.pem"),
        ("tls://127.0.0.1:9", [], "ssl_context"),
    ],
)
def test_a_scheduler_that_cannot_be_reached_is_one_sentence(
    address: str,
    more: list[str],
    words: str,
    few: Path,
    tmp_path: Path,
    capfd: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """And no client is made, which would wait for half a minute and complain when it is collected."""

    def client(*_: object, **__: object) -> None:
        raise RuntimeError("a client was made")

    assert on_cluster.TIMEOUT <= 10.0
    monkeypatch.setattr(on_cluster, "TIMEOUT", 0.3)
    monkeypatch.setattr("distributed.Client", client)
    assert do("sweep", few, "--out", tmp_path, "--scheduler", address, *more) == 2
    (said,) = capfd.readouterr().err.splitlines()
    assert said.startswith(
        f'scheduler = "{address}": must be the address of a Dask scheduler that can be reached ('
    )
    assert words in said


if __name__ == "__main__":
    kill_again_and_again(*sys.argv[1:])
