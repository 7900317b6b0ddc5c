"""Persistent worker processes for the points of a sweep."""

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

from gearplay.sweeps.running.cluster import PAUSE, RETRIES
from gearplay.sweeps.running.evaluate import Outcome, Sweep, evaluate_some
from gearplay.vocabulary.errors import SimulationError

Some = tuple[int, list[Outcome]]
"""How many jobs of a batch were done, and what came out."""
UNSAID = "ignore::UserWarning:multiprocessing.resource_tracker"
"""A command that leaves at once lets the tracker hand back its semaphores, which is no word to the user."""
AHEAD = 2
"""Batches that each process has, or finds when it is done."""
LASTING = 0.1
"""How long a batch of short cases should take [s]: handing one over costs a millisecond."""
LONGEST = 0.5
"""How long a batch may take whose cases are longer than those before [s]: what is done then is handed over."""
MOST = 64
"""The most jobs of a batch."""


class Processes:
    """Worker processes: slower to start than threads, but none waits for another's Python, or falls with another.

    They start with the first sweep and end with the ``with`` block, or with this process however that ends; those of a sweep
    that is left half-way end with it, and the next one starts others.
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
        """End the processes, whatever they are doing."""
        self._leave()

    def _leave(self) -> None:
        if self._pool is not None:
            self._pool.shutdown(wait=False, cancel_futures=True)
            for end in self._life:
                end.close()
            self._pool, self._life = None, ()

    def _submit(self, document: str, batch: list[int]) -> "Future[Some]":
        if self._pool is None:
            if UNSAID not in sys.warnoptions:
                sys.warnoptions.append(UNSAID)
            context = get_context("spawn")
            self._life = context.Pipe(duplex=False)
            self._pool = ProcessPoolExecutor(
                self.count, mp_context=context, initializer=_live_with, initargs=self._life[:1]
            )
        with _deaf():
            return self._pool.submit(evaluate_some, document, batch, LONGEST)

    def outcomes(
        self, sweep: Sweep, jobs: Sequence[int], stop: threading.Event | None = None
    ) -> Generator[list[Outcome]]:
        """Yield the outcomes of jobs, some at a time; no more once stopped.

        Raises `SimulationError` where processes die again and again.
        """
        document, begun, again, size = sweep.plan.model_dump_json(), 0, 0, 1
        pending: dict[Future[Some], list[int]] = {}
        left: list[list[int]] = []  # begun, and to be begun again
        try:
            while not (stop is not None and stop.is_set()):
                try:
                    while len(pending) < AHEAD * self.count and (left or begun < len(jobs)):
                        if not left:  # the last ones are shared by all
                            share = -(-(len(jobs) - begun) // (AHEAD * self.count))
                            left.append([int(job) for job in jobs[begun : begun + min(size, share)]])
                            begun += len(left[-1])
                        pending[self._submit(document, left[-1])] = left[-1]
                        left.pop()
                    if not pending:
                        return
                    finished, _ = wait(pending, timeout=PAUSE, return_when=FIRST_COMPLETED)
                    for future in finished:
                        done, outcomes = future.result()
                        rest = pending.pop(future)[done:]
                        left += [rest] if rest else []
                        size = _fitting(outcomes, done)
                        yield outcomes
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


def _fitting(outcomes: Sequence[Outcome], jobs: int) -> int:
    """Return how many jobs make a batch of the right length, by one that is done."""
    each = sum(outcome.seconds for outcome in outcomes) / jobs
    return max(1, min(MOST, int(LASTING / max(each, 1e-9))))


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
