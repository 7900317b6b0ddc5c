"""Jobs of a task on an existing Dask cluster."""

import asyncio
import logging
import sys
import threading
import time
from collections.abc import Generator, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from itertools import islice
from pathlib import Path
from typing import Any

from gearplay.vocabulary.errors import GearplayError, InputError, SimulationError
from gearplay.vocabulary.optional import load_optional
from gearplay.work.task import PAUSE, RETRIES, Piece, Task, run_batch

TIMEOUT = 10.0
"""Longest wait for a scheduler's response [s]."""
UNATTENDED = 5.0
"""Time without a result [s] after which the number of workers is checked."""
BATCH = 8
"""Jobs that are submitted together."""
LOGGERS = ("distributed", "tornado", "asyncio")
"""Packages whose loggers report a lost connection."""


def run_dask(
    task: Task[Piece],
    jobs: Iterable[int],
    *,
    address: str,
    security: dict[str, Path],
    stop: threading.Event | None,
) -> Generator[list[Piece]]:
    """Run jobs on the Dask cluster whose scheduler is at ``address``; no port is opened here.

    ``security`` holds paths of ``tls_ca_file``, ``tls_client_cert`` and ``tls_client_key``, passed through.

    Raises `InputError` where the scheduler cannot be reached, `SimulationError` where the cluster fails later.
    """
    distributed = load_optional("distributed", "cluster")
    waiting = iter(jobs)
    with _without_logs(), _reach(distributed, address, security) as client:
        pending = distributed.as_completed(loop=client.loop, with_results=True)
        in_flight = 0

        def submit() -> int:
            chunk = [int(i) for i in islice(waiting, BATCH)]
            if not chunk:
                return 0
            pending.add(client.submit(run_batch, *task.remake, chunk, pure=False, retries=RETRIES))
            return 1

        for _ in range(4 * max(1, sum(client.nthreads().values()))):
            in_flight += submit()
        while in_flight:
            if not _wait_for(pending, client, address, stop):
                return
            pieces = _next_of(pending)
            in_flight += submit() - 1
            yield pieces


@contextmanager
def _without_logs() -> Iterator[None]:
    """Silence the library and its dependencies: a lost scheduler is reported in one sentence.

    Each pending operation would log a traceback of its own when the scheduler is lost; a sweep uses only the outcomes and
    the client's status. Loggers are silenced one by one, as the library gives some a level.
    """
    known = [
        logging.getLogger(name)
        for name in list(logging.root.manager.loggerDict)
        if name.split(".")[0] in LOGGERS
    ]
    before = [logger.level for logger in known]
    for logger in known:
        logger.setLevel(logging.CRITICAL + 1)
    try:
        yield
    finally:
        for logger, level in zip(known, before, strict=True):
            logger.setLevel(level)


def _wait_for(pending: Any, client: Any, address: str, stop: threading.Event | None) -> bool:
    """Wait for results; return False where it was stopped. A cluster without workers is reported once.

    Raises `SimulationError` where the scheduler has gone.
    """
    begun, reported = time.monotonic(), False
    while not pending.has_ready():
        if stop is not None and stop.is_set():
            return False
        if client.status != "running":
            raise SimulationError(
                f"sweep: the scheduler at {address} has gone. Finished cases are kept: start it again, then gearplay resume."
            )
        if not reported and time.monotonic() - begun > UNATTENDED:
            reported = True
            if not _workers_of(client):
                sys.stderr.write(f"The cluster at {address} has no worker; the sweep waits for one.\n")
        time.sleep(PAUSE)
    return True


def _workers_of(client: Any) -> int:
    """Return the number of threads of a cluster, 1 where it is unknown."""
    try:
        return sum(client.nthreads().values())
    except Exception:  # the scheduler has just gone, which `_wait_for` reports
        return 1


def _next_of(pending: Any) -> Any:
    try:
        _, result = next(pending)
    except GearplayError:
        raise
    except Exception as error:
        result = error
    if isinstance(result, BaseException):  # a future that was cancelled has its exception as result
        raise SimulationError(
            f"sweep: the cluster failed ({_first_line(result)}). Finished cases are kept: mend the cluster, then run again."
        ) from None
    return result[1]


def _reach(distributed: Any, address: str, security: dict[str, Path]) -> Any:
    """Return a client of the scheduler at ``address``.

    Its identity is requested first: a `Client` that fails to start waits half a minute and logs an error when it is collected.
    """

    async def greet(settings: Any) -> None:
        arguments = settings.get_connection_args("client") if settings is not None else {}
        scheduler = distributed.rpc(address, timeout=TIMEOUT, connection_args=arguments)
        try:
            await asyncio.wait_for(scheduler.identity(), TIMEOUT)
        finally:
            await scheduler.close_rpc()

    try:
        files = {name: str(path) for name, path in security.items()}
        for path in files.values():
            Path(path).open("rb").close()  # or the library reports a missing context instead
        settings = distributed.Security(require_encryption=True, **files) if files else None
        with ThreadPoolExecutor(1) as thread:  # a notebook has a loop of its own running here
            thread.submit(asyncio.run, greet(settings)).result()
        return distributed.Client(address, security=settings, set_as_default=False, timeout=TIMEOUT)
    except Exception as error:  # anything may answer there
        rule = f"must be the address of a Dask scheduler that can be reached ({_first_line(error)})"
        raise InputError.of("scheduler", address, rule, "Start it, or correct the address") from None


def _first_line(error: BaseException) -> str:
    if isinstance(error, TimeoutError) and not str(error):
        return f"no answer within {TIMEOUT:g} s"
    return str(error).splitlines()[0].rstrip(".") if str(error) else type(error).__name__
