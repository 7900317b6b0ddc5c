"""Persistent worker processes for the jobs of tasks."""

import os
import signal
import sys
import threading
from collections.abc import Generator, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from multiprocessing import get_context
from multiprocessing.connection import Connection
from types import TracebackType
from typing import Any

from gearplay.vocabulary.errors import SimulationError
from gearplay.work.task import PAUSE, RETRIES, Piece, Task, run_batch

SILENCED = "ignore::UserWarning:multiprocessing.resource_tracker"
"""A command that exits at once leaves its semaphores to the tracker, whose warning does not concern the user."""
AHEAD = 2
"""Batches submitted for each process: one running, one waiting."""
LASTING = 0.1
"""Duration that a batch of short jobs should have [s]: passing one on costs a millisecond."""
LONGEST = 0.5
"""Longest duration of a batch whose jobs are longer than those before [s]: its finished jobs are passed on then."""
MOST = 64
"""The most jobs of a batch."""


class Processes:
    """Worker processes: slower to start than threads, but independent of each other's interpreter lock and crashes.

    They start with the first task and end with the ``with`` block, or with this process however that ends. Processes of a task
    that is left unfinished end with it; the next task starts others.
    """

    def __init__(self, count: int) -> None:
        self.count = count
        self._pool: ProcessPoolExecutor | None = None
        self._life: tuple[Connection, ...] = ()

    def __enter__(self) -> "Processes":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """End the processes."""
        self._leave()

    def _leave(self) -> None:
        if self._pool is not None:
            self._pool.shutdown(wait=False, cancel_futures=True)
            for end in self._life:
                end.close()
            self._pool, self._life = None, ()

    def _submit(self, task: Task[Piece], batch: list[int]) -> "Future[tuple[int, list[Piece], float]]":
        if self._pool is None:
            if SILENCED not in sys.warnoptions:
                sys.warnoptions.append(SILENCED)
            context = get_context("spawn")
            self._life = context.Pipe(duplex=False)
            self._pool = ProcessPoolExecutor(
                self.count, mp_context=context, initializer=_live_with, initargs=self._life[:1]
            )
        make, text = task.remake
        with _without_interrupts():
            return self._pool.submit(run_batch, make, text, batch, LONGEST)

    def outcomes(
        self, task: Task[Piece], jobs: Sequence[int], stop: threading.Event | None = None
    ) -> Generator[list[Piece]]:
        """Yield the pieces of jobs as batches finish; end when stopped.

        Raises `SimulationError` where processes die again and again.
        """
        begun, again, size = 0, 0, 1
        pending: dict[Future[Any], list[int]] = {}
        left: list[list[int]] = []  # batches to be submitted again, as a whole or in part
        try:
            while not (stop is not None and stop.is_set()):
                try:
                    while len(pending) < AHEAD * self.count and (left or begun < len(jobs)):
                        if not left:  # the last ones are shared by all
                            share = -(-(len(jobs) - begun) // (AHEAD * self.count))
                            left.append([int(job) for job in jobs[begun : begun + min(size, share)]])
                            begun += len(left[-1])
                        pending[self._submit(task, left[-1])] = left[-1]
                        left.pop()
                    if not pending:
                        return
                    finished, _ = wait(pending, timeout=PAUSE, return_when=FIRST_COMPLETED)
                    for future in finished:
                        done, pieces, seconds = future.result()
                        rest = pending.pop(future)[done:]
                        left += [rest] if rest else []
                        size = max(1, min(MOST, int(LASTING * done / max(seconds, 1e-9))))
                        yield pieces
                except BrokenProcessPool:
                    again += 1
                    if again > RETRIES:
                        raise SimulationError(
                            f"sweep: worker processes died {again} times. Use fewer workers, or shorten run.duration."
                        ) from None
                    left += [[job] for batch in pending.values() for job in batch]
                    pending.clear()
                    self._leave()
        finally:
            if pending:
                self._leave()


@contextmanager
def _without_interrupts() -> Iterator[None]:
    """Block Ctrl-C for processes that are started meanwhile, and for the start itself; this process gets it afterwards.

    A mask alone is not enough: another thread takes the signal, and Python still raises in the main one.
    """
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    received: list[int] = []
    main = threading.current_thread() is threading.main_thread()
    handler = signal.signal(signal.SIGINT, lambda signum, _: received.append(signum)) if main else None
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
        if main:
            signal.signal(signal.SIGINT, handler if handler is not None else signal.SIG_DFL)
        if received:
            signal.raise_signal(signal.SIGINT)


def _live_with(life: Connection) -> None:
    """In a worker: leave Ctrl-C to the parent, and end as soon as that has ended or closed the pipe."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with, args=(life,), daemon=True).start()


def _end_with(life: Connection) -> None:
    life.poll(None)
    os._exit(0)
