"""Where the points of a sweep are evaluated: threads, processes, or an existing Dask cluster. Results do not depend on it."""

import os
import queue
import signal
import sys
import threading
import time
from collections.abc import Generator, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import islice
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

from gearplay.solver.compiling import prepare
from gearplay.sweeps.running.cluster import PAUSE, RETRIES, run_dask
from gearplay.sweeps.running.evaluate import Outcome, Sweep, evaluate_many
from gearplay.vocabulary.cores import worker_count
from gearplay.vocabulary.errors import Fault, InputError, SimulationError

UNSAID = "ignore::UserWarning:multiprocessing.resource_tracker"
"""A command that leaves at once lets the tracker hand back its semaphores, which is no word to the user."""
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


def run_processes(
    sweep: Sweep, jobs: Iterable[int], *, workers: int | None = None
) -> Generator[list[Outcome]]:
    """Evaluate jobs in processes of their own: slower to start, safe from what brings one process down.

    Raises `SimulationError` where processes die again and again.
    """
    from concurrent.futures import FIRST_COMPLETED, ProcessPoolExecutor, wait
    from concurrent.futures.process import BrokenProcessPool
    from multiprocessing import get_context

    if UNSAID not in sys.warnoptions:
        sys.warnoptions.append(UNSAID)
    count, document = workers or worker_count(), sweep.plan.model_dump_json()
    waiting, again, context = iter(jobs), 0, get_context("spawn")
    pending: dict[Any, list[int]] = {}
    lost: list[list[int]] = []
    life, end = context.Pipe(duplex=False)
    with life, end:
        while True:
            pool = ProcessPoolExecutor(count, mp_context=context, initializer=_live_with, initargs=(life,))
            try:
                while True:
                    while len(pending) < 2 * count:
                        lost = lost or [[int(i)] for i in islice(waiting, 1)]
                        if not lost:
                            break
                        with _deaf():
                            future = pool.submit(evaluate_many, document, lost[-1])
                        pending[future] = lost.pop()
                    if not pending:
                        return
                    finished, _ = wait(pending, timeout=0.5, return_when=FIRST_COMPLETED)
                    for future in finished:
                        outcomes = future.result()
                        del pending[future]
                        yield outcomes
            except BrokenProcessPool:
                again += 1
                if again > RETRIES:
                    raise SimulationError(
                        f"sweep: worker processes died {again} times. Use fewer workers, or shorten run.duration."
                    ) from None
                lost += list(pending.values())
                pending.clear()
            finally:
                pool.shutdown(wait=False, cancel_futures=True)


@contextmanager
def _deaf() -> Iterator[None]:
    """Keep Ctrl-C from processes that are started meanwhile, and from the start itself; this one hears of it afterwards.

    A mask alone would not do: another thread takes the signal, and Python raises in the main one all the same.
    """
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    heard: list[int] = []
    main = threading.current_thread() is threading.main_thread()
    handler = signal.signal(signal.SIGINT, lambda signum, _: heard.append(signum)) if main else None
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
        if main:
            signal.signal(signal.SIGINT, handler if handler is not None else signal.SIG_DFL)
        if heard:
            signal.raise_signal(signal.SIGINT)


def _live_with(life: Connection) -> None:
    """In a worker: leave Ctrl-C to the parent, and end as soon as that has ended or closed the pipe."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with, args=(life,), daemon=True).start()


def _end_with(life: Connection) -> None:
    life.poll(None)
    os._exit(0)


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

    def __post_init__(self) -> None:
        if self.kind not in ("threads", "processes"):
            raise InputError(Fault("engine", self.kind, "must be threads or processes", "Choose one"))

    def outcomes(
        self, made: Sweep, jobs: Sequence[int], stop: threading.Event | None = None
    ) -> Generator[list[Outcome]]:
        """Yield the outcomes of jobs as they are done; threads end their cases early once stopped."""
        if self.scheduler is not None:
            return run_dask(made, jobs, address=self.scheduler, security=dict(self.security or {}), stop=stop)
        if self.kind == "processes":
            return run_processes(made, jobs, workers=self.workers)
        return run_threads(made, jobs, workers=self.workers, stop=stop)
