"""Sweeps on a cluster: no workers, a scheduler that dies, TLS."""

import json
import logging
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from io import StringIO
from pathlib import Path
from typing import Any

import pytest

from cli.test_sweep import FEW, PLAN, content, finish, rows, write_plan
from gearplay.work.cluster import _without_logs

pytestmark = [pytest.mark.hostile, pytest.mark.deep]
PART = """
import asyncio, json, sys
from distributed import Scheduler, Security, Worker

async def main(address, files):
    security = Security(require_encryption=True, **files) if files else None
    words = dict(host="127.0.0.1", protocol="tls" if files else "tcp", security=security)
    if address:
        async with Worker(address, nthreads=1, memory_limit=0, dashboard=False, **words) as made:
            print(made.address, flush=True)
            await made.finished()
    else:
        async with Scheduler(port=0, dashboard=False, **words) as made:
            print(made.address, flush=True)
            await made.finished()

if __name__ == "__main__":
    asyncio.run(main(sys.argv[1], json.loads(sys.argv[2])))
"""
Start = Callable[..., subprocess.Popen[str]]


@pytest.fixture
def start() -> Iterator[Start]:
    """Yield a function that starts a program; all end with the test at the latest."""
    begun: list[subprocess.Popen[str]] = []

    def start(*words: object) -> subprocess.Popen[str]:
        command = [sys.executable, *map(str, words)]
        pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
        begun.append(subprocess.Popen(command, text=True, start_new_session=True, **pipes))
        return begun[-1]

    yield start
    for process in begun:
        if process.poll() is None:
            process.kill()
        process.communicate()


def scheduler(start: Start, files: dict[str, str] | None = None) -> tuple[subprocess.Popen[str], str]:
    process = start("-c", PART, "", json.dumps(files or {}))
    assert process.stdout is not None
    return process, process.stdout.readline().strip()


def worker(start: Start, address: str, files: dict[str, str] | None = None) -> subprocess.Popen[str]:
    return start("-c", PART, address, json.dumps(files or {}))


def sweep(start: Start, plan: Path, out: Path, address: str, *more: object) -> subprocess.Popen[str]:
    words = ("sweep", plan, "--out", out, "--scheduler", address, *more)
    return start("-m", "gearplay.cli.main", *words)


@pytest.fixture(scope="module")
def few(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_plan(FEW, tmp_path_factory.mktemp("few") / "few.toml")


def test_cluster__without_workers_is_reported(start: Start, few: Path, tmp_path: Path) -> None:
    _, address = scheduler(start)
    process = sweep(start, few, tmp_path / "out", address)
    assert process.stderr is not None
    assert process.stderr.readline() == f"The cluster at {address} has no worker; the sweep waits for one.\n"
    worker(start, address)
    said, words = process.communicate(timeout=180)
    assert process.returncode == 0, (said, words)
    assert "no worker" not in words  # it is said once
    finish(few, tmp_path / "whole")
    assert content(tmp_path / "out") == content(tmp_path / "whole")


def test_ctrl_c_while_no_worker_comes(start: Start, few: Path, tmp_path: Path) -> None:
    _, address = scheduler(start)
    process = sweep(start, few, tmp_path / "out", address)
    assert process.stderr is not None
    process.stderr.readline()
    process.send_signal(signal.SIGINT)
    _, words = process.communicate(timeout=30)
    assert process.returncode == 130
    assert "Finished cases are kept" in words
    assert "Traceback" not in words


@pytest.mark.parametrize(
    "name",
    ["distributed.batched", "distributed.client", "distributed.comm.tcp", "tornado.application", "asyncio"],
)
def test_the_library_logs_no_connection_that_is_lost(name: str) -> None:
    """A message that was on its way would be told with a traceback, now and then."""
    logger, heard = logging.getLogger(name), StringIO()
    logger.addHandler(handler := logging.StreamHandler(heard))
    try:
        with _without_logs():
            logger.error("closed")
        assert heard.getvalue() == ""
        logger.error("said again")
        assert heard.getvalue() == "said again\n"
    finally:
        logger.removeHandler(handler)


def test_a_scheduler_that_dies_is_one_sentence(start: Start, tmp_path: Path) -> None:
    plan = write_plan(PLAN, tmp_path / "plan.toml")
    scheduling, address = scheduler(start)
    worker(start, address)
    process = sweep(start, plan, tmp_path / "out", address)
    end = time.monotonic() + 120.0
    while not _stored(tmp_path / "out") and time.monotonic() < end:
        time.sleep(0.1)
    scheduling.kill()
    _, words = process.communicate(timeout=60)
    assert process.returncode == 3, words
    lines = [line for line in words.splitlines() if not line.startswith("Compiling")]
    assert len(lines) == 1, words
    assert "gearplay resume" in lines[0] or "mend the cluster, then run again" in lines[0]
    assert rows(tmp_path / "out")


def _stored(folder: Path) -> bool:
    log = folder / "rows.sqlite-wal"
    return log.exists() and log.stat().st_size > 20_000


def certificate(folder: Path) -> dict[str, str]:
    """Return the files of a certificate that vouches for itself."""
    folder.mkdir()
    key, made = folder / "key.pem", folder / "certificate.pem"
    words = ["req", "-x509", "-newkey", "rsa:2048", "-nodes", "-days", "2", "-subj", "/CN=localhost"]
    subprocess.run(["openssl", *words, "-keyout", key, "-out", made], check=True, capture_output=True)
    return {"key": str(key), "made": str(made)}


def test_a_cluster_behind_tls(start: Start, few: Path, tmp_path: Path) -> None:
    ours, theirs = certificate(tmp_path / "ours"), certificate(tmp_path / "theirs")
    files: dict[str, str] = {"tls_ca_file": ours["made"]}
    for role in ("scheduler", "worker", "client"):
        files |= {f"tls_{role}_cert": ours["made"], f"tls_{role}_key": ours["key"]}
    _, address = scheduler(start, files)
    assert address.startswith("tls://")
    worker(start, address, files)

    def asked(held: dict[str, str] | None, name: str) -> tuple[int, str]:
        more: list[Any] = []
        if held is not None:
            more = ["--tls-ca", ours["made"], "--tls-cert", held["made"], "--tls-key", held["key"]]
        process = sweep(start, few, tmp_path / name, address, *more)
        _, words = process.communicate(timeout=180)
        return process.returncode, words

    code, words = asked(ours, "out")
    assert code == 0, words
    finish(few, tmp_path / "whole")
    assert content(tmp_path / "out") == content(tmp_path / "whole")
    for held in (None, theirs):  # without, and with a certificate that nobody vouches for
        code, words = asked(held, "refused")
        assert code == 2, words
        assert "must be the address of a Dask scheduler that can be reached" in words
        assert "Traceback" not in words
