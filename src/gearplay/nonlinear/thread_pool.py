"""Pool of threads for many runs, with progress and cancellation."""

import threading
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from typing import TypeVar

from gearplay.solver.deadline import in_request
from gearplay.vocabulary.progress import Tick

Job = TypeVar("Job")


def share_out(
    jobs: Iterable[Job],
    work: Callable[[Job, Callable[[], None]], None],
    *,
    total: int,
    threads: int,
    stop: threading.Event,
    progress: Tick | None = None,
) -> None:
    """Call ``work(job, tick)`` for every job on threads; ``tick()`` reports one of ``total`` parts as done. Ctrl-C sets ``stop``.

    >>> found, stop = [], threading.Event()
    >>> share_out([3, 1], lambda job, tick: (found.append(job), tick())[1], total=2, threads=1, stop=stop)
    >>> found
    [3, 1]
    """
    done, lock = 0, threading.Lock()

    def tick() -> None:
        nonlocal done
        with lock:
            done += 1
            if progress is not None:
                progress(float(done), float(total))

    with ThreadPoolExecutor(max(1, threads)) as pool:
        try:
            calls = [in_request(partial(work, job, tick)) for job in jobs]
            list(pool.map(lambda call: call(), calls))
        except KeyboardInterrupt:
            stop.set()
            raise
