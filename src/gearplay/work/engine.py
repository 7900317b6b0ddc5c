"""Executors of a task: threads, processes, or an existing Dask cluster; results do not depend on the choice."""

import queue
import threading
import time
from collections.abc import Generator, Iterable, Iterator, Mapping, Sequence
from contextlib import closing, contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING

from gearplay.vocabulary.cores import worker_count
from gearplay.vocabulary.errors import InputError
from gearplay.vocabulary.progress import Progress
from gearplay.work.cluster import run_dask
from gearplay.work.task import PAUSE, Jobs, Piece, Task

if TYPE_CHECKING:
    from gearplay.work.processes import Processes

KINDS = ("threads", "processes")
HELD = 0.02
"""Longest time that a thread keeps finished pieces before it passes them on [s]."""


def run_threads(
    task: Jobs[Piece],
    jobs: Iterable[int],
    *,
    workers: int | None = None,
    stop: threading.Event | None = None,
) -> Generator[list[Piece]]:
    """Run jobs on threads, the default: the kernels run in parallel, and nothing is copied.

    Yields the pieces of several finished jobs at a time: each transfer costs a wait for the consumer. Closing the iterator, or
    ``stop``, ends every job early.
    """
    waiting, lock, ended = iter(jobs), threading.Lock(), threading.Event()
    done: queue.SimpleQueue[list[Piece] | BaseException | None] = queue.SimpleQueue()
    space = threading.Semaphore(100)  # a consumer that cannot keep up must not fill the memory

    def work() -> None:
        held: list[Piece] = []
        try:
            passed_on = time.monotonic()
            while not ended.is_set():
                with lock:
                    job = next(waiting, None)
                if job is None:
                    break
                held += task.evaluate(int(job), ended)
                if held and time.monotonic() - passed_on > HELD:
                    space.acquire()
                    done.put(held)
                    held, passed_on = [], time.monotonic()
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
                space.release()
                yield found
    finally:
        ended.set()
        space.release(len(threads))
        for thread in threads:
            thread.join()


@dataclass(frozen=True)
class Engine:
    """Executor of a sweep: processes, threads or a cluster; the result does not depend on it.

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
    _kept: "Processes | None" = field(default=None, init=False, repr=False)  # running worker processes

    def __post_init__(self) -> None:
        if self.kind not in KINDS:
            raise InputError.of("engine", self.kind, "must be threads or processes", "Choose one")

    @contextmanager
    def lasting(self) -> Iterator["Engine"]:
        """Yield an engine whose processes, if any, serve all tasks of a ``with`` block: they take seconds to start."""
        if self.kind != "processes" or self.scheduler is not None or self._kept is not None:
            yield self
            return
        from gearplay.work.processes import Processes

        with Processes(self.workers or worker_count()) as kept:
            engine = replace(self)
            object.__setattr__(engine, "_kept", kept)  # past the freeze
            yield engine

    def share(self, jobs: Sequence[int]) -> Sequence[int]:
        """Return the jobs of the engine's shard, all without one."""
        return jobs if self.shard is None else jobs[self.shard[0] - 1 :: self.shard[1]]

    def outcomes(
        self, task: Task[Piece], jobs: Sequence[int], stop: threading.Event | None = None
    ) -> Generator[list[Piece]]:
        """Yield the pieces of jobs as they are done; threads end their jobs early once stopped."""
        if self.scheduler is not None:
            security = dict(self.security or {})
            yield from run_dask(task, jobs, address=self.scheduler, security=security, stop=stop)
        elif self.kind == "threads":
            yield from run_threads(task, jobs, workers=self.workers, stop=stop)
        else:
            with self.lasting() as engine:
                assert engine._kept is not None
                yield from engine._kept.outcomes(task, jobs, stop)

    def run(
        self,
        task: Task[Piece],
        jobs: Sequence[int],
        *,
        label: str,
        finished: int = 0,
        pieces: int = 1,
        progress: Progress | None = None,
        stop: threading.Event | None = None,
    ) -> Generator[list[Piece]]:
        """Yield the pieces of jobs and report progress, ``finished`` jobs done before; each job has so many ``pieces``.

        Raises `KeyboardInterrupt` once stopped.
        """
        done, total = finished, finished + len(jobs)
        with closing(self.outcomes(task, jobs, stop)) as found:
            for each in found:
                done += len(each) // pieces
                yield each
                if progress is not None:
                    progress(label, done, total)
                if stop is not None and stop.is_set():
                    raise KeyboardInterrupt
        if done < total and stop is not None and stop.is_set():
            raise KeyboardInterrupt
