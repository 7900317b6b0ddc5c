"""Executors of a sweep: threads, processes, or an existing Dask cluster; results do not depend on the choice."""

import queue
import threading
import time
from collections.abc import Generator, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING

from gearplay.solver.compiling import prepare
from gearplay.sweeps.running.cluster import PAUSE, run_dask
from gearplay.sweeps.running.evaluate import Outcome, Sweep
from gearplay.vocabulary.cores import worker_count
from gearplay.vocabulary.errors import Fault, InputError

if TYPE_CHECKING:
    from gearplay.sweeps.running.processes import Processes

KINDS = ("threads", "processes")
HANDED = 0.02
"""How long a thread keeps finished cases before it hands them over [s]."""


def run_threads(
    sweep: Sweep, jobs: Iterable[int], *, workers: int | None = None, stop: threading.Event | None = None
) -> Generator[list[Outcome]]:
    """Evaluate jobs on threads, the default: the kernels run side by side, and nothing is copied.

    Yields the outcomes of finished jobs, those of some of them at a time: a thread that hands over more often waits more often
    for the one that takes. Closing the iterator, or ``stop``, ends every run at its next chunk.
    """
    prepare(sweep.template.base)
    waiting, lock, ended = iter(jobs), threading.Lock(), threading.Event()
    done: queue.SimpleQueue[list[Outcome] | BaseException | None] = queue.SimpleQueue()
    room = threading.Semaphore(100)  # a consumer that cannot keep up must not fill the memory

    def work() -> None:
        held: list[Outcome] = []
        try:
            handed = time.monotonic()
            while not ended.is_set():
                with lock:
                    job = next(waiting, None)
                if job is None:
                    break
                held += sweep.evaluate(int(job), ended)
                if held and time.monotonic() - handed > HANDED:
                    room.acquire()
                    done.put(held)
                    held, handed = [], time.monotonic()
        except BaseException as error:
            done.put(error)
        finally:
            done.put(held)
            done.put(None)

    threads = [threading.Thread(target=work, daemon=True) for _ in range(workers or worker_count())]
    for thread in threads:
        thread.start()
    left = len(threads)
    try:
        while left:
            try:
                found = done.get(timeout=None if stop is None else PAUSE)
            except queue.Empty:
                if stop is not None and stop.is_set():
                    return
                continue
            if found is None:
                left -= 1
            elif isinstance(found, BaseException):
                raise found
            else:
                room.release()
                yield found
    finally:
        ended.set()
        room.release(len(threads))
        for thread in threads:
            thread.join()


@dataclass(frozen=True)
class Engine:
    """Where a sweep runs; none of it changes the result.

    Parameters
    ----------
    kind
        "threads" or "processes".
    workers
        How many of them; the cores if not given.
    scheduler
        Address of an existing Dask cluster, in place of both.
    security
        Its TLS files.
    shard
        (i, n) runs the i-th of n parts.

    Raises
    ------
    InputError
        For another kind.

    Examples
    --------
    >>> Engine("processes", workers=2).kind
    'processes'

    """

    kind: str = "threads"
    workers: int | None = None
    scheduler: str | None = None
    security: Mapping[str, Path] | None = None
    shard: tuple[int, int] | None = None
    _kept: "Processes | None" = field(
        default=None, init=False, repr=False
    )  # processes that are there already

    def __post_init__(self) -> None:
        if self.kind not in KINDS:
            raise InputError(Fault("engine", self.kind, "must be threads or processes", "Choose one"))

    @contextmanager
    def lasting(self) -> Iterator["Engine"]:
        """Yield an engine whose processes, if it has any, serve all sweeps of a ``with`` block: they take seconds to start."""
        if self.kind != "processes" or self.scheduler is not None:
            yield self
            return
        from gearplay.sweeps.running.processes import Processes

        with Processes(self.workers or worker_count()) as kept:
            engine = replace(self)
            object.__setattr__(engine, "_kept", kept)  # past the freeze
            yield engine

    def outcomes(
        self, made: Sweep, jobs: Sequence[int], stop: threading.Event | None = None
    ) -> Generator[list[Outcome]]:
        """Yield the outcomes of jobs as they are done; threads end their cases early once stopped."""
        if self.scheduler is not None:
            yield from run_dask(
                made, jobs, address=self.scheduler, security=dict(self.security or {}), stop=stop
            )
        elif self.kind == "threads":
            yield from run_threads(made, jobs, workers=self.workers, stop=stop)
        elif self._kept is not None:
            yield from self._kept.outcomes(made, jobs, stop)
        else:
            with self.lasting() as engine:
                yield from engine.outcomes(made, jobs, stop)
