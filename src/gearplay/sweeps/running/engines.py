"""Where the points of a sweep are evaluated: threads, processes, or an existing Dask cluster. Results do not depend on it."""

import asyncio
import os
import queue
import signal
import threading
from collections.abc import Generator, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import islice
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

from gearplay.solver.compiling import prepare
from gearplay.sweeps.running.evaluate import Outcome, Sweep, evaluate_many
from gearplay.vocabulary.cores import worker_count
from gearplay.vocabulary.errors import Fault, GearplayError, InputError, SimulationError
from gearplay.vocabulary.optional import load_optional

RETRIES = 3
"""How often work that a dying process took with it is begun again."""
PATIENCE = 10.0
"""How long a scheduler has to answer [s]."""
PAUSE = 0.1
"""How often a wait for outcomes looks whether it is to stop [s]."""


def run_threads(
    sweep: Sweep, jobs: Iterable[int], *, workers: int | None = None, stop: threading.Event | None = None
) -> Generator[list[Outcome]]:
    """Evaluate jobs on threads, the default: the kernels run side by side, and nothing is copied.

    Yields the outcomes of each job as it is done. Closing the iterator, or ``stop``, ends every run at its next chunk.
    """
    prepare(sweep.template.base)
    waiting, lock, ended = iter(jobs), threading.Lock(), threading.Event()
    done: queue.SimpleQueue[list[Outcome] | BaseException | None] = queue.SimpleQueue()
    room = threading.Semaphore(1000)  # a consumer that cannot keep up must not fill the memory

    def work() -> None:
        try:
            while not ended.is_set():
                with lock:
                    job = next(waiting, None)
                if job is None:
                    break
                outcomes = sweep.evaluate(int(job), ended)
                if outcomes:
                    room.acquire()
                    done.put(outcomes)
        except BaseException as error:
            done.put(error)
        finally:
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


def run_dask(
    sweep: Sweep,
    jobs: Iterable[int],
    *,
    address: str,
    security: dict[str, Path] | None = None,
    batch: int = 8,
) -> Generator[list[Outcome]]:
    """Evaluate jobs on the Dask cluster whose scheduler is at ``address``; no port is opened here.

    ``security`` holds paths of ``tls_ca_file``, ``tls_client_cert`` and ``tls_client_key``, passed through.

    Raises `InputError` where the scheduler cannot be reached, `SimulationError` where the cluster fails later.
    """
    distributed = load_optional("distributed", "cluster")
    document, waiting = sweep.plan.model_dump_json(), iter(jobs)
    with _reach(distributed, address, security) as client:
        pending = distributed.as_completed(loop=client.loop, with_results=True)
        in_flight = 0

        def submit() -> int:
            chunk = [int(i) for i in islice(waiting, batch)]
            if not chunk:
                return 0
            pending.add(client.submit(evaluate_many, document, chunk, pure=False, retries=RETRIES))
            return 1

        for _ in range(4 * max(1, sum(client.nthreads().values()))):
            in_flight += submit()
        while in_flight:
            outcomes = _next_of(pending)
            in_flight += submit() - 1
            yield outcomes


def _next_of(pending: Any) -> list[Outcome]:
    try:
        _, outcomes = next(pending)
    except GearplayError:
        raise
    except Exception as error:
        outcomes = error
    if isinstance(outcomes, BaseException):  # a future that was cancelled has its exception as result
        raise SimulationError(
            f"sweep: the cluster failed ({_first_line(outcomes)}). Finished cases are kept: see to it, then run again."
        ) from None
    return outcomes  # type: ignore[no-any-return]


def _reach(distributed: Any, address: str, security: dict[str, Path] | None) -> Any:
    """Return a client of the scheduler at ``address``.

    It is asked who it is first: a `Client` that fails to start waits half a minute and complains when it is collected.
    """

    async def greet(settings: Any) -> None:
        arguments = settings.get_connection_args("client") if settings is not None else {}
        scheduler = distributed.rpc(address, timeout=PATIENCE, connection_args=arguments)
        try:
            await asyncio.wait_for(scheduler.identity(), PATIENCE)
        finally:
            await scheduler.close_rpc()

    try:
        files = {name: str(path) for name, path in (security or {}).items()}
        for path in files.values():
            Path(path).open("rb").close()  # or the library complains of a context that is missing
        settings = distributed.Security(require_encryption=True, **files) if files else None
        with ThreadPoolExecutor(1) as aside:  # a notebook has a loop of its own running here
            aside.submit(asyncio.run, greet(settings)).result()
        return distributed.Client(address, security=settings, set_as_default=False, timeout=PATIENCE)
    except Exception as error:  # anything may answer there
        rule = f"must be the address of a Dask scheduler that can be reached ({_first_line(error)})"
        raise InputError(Fault("scheduler", address, rule, "Start it, or correct the address")) from None


def _first_line(error: BaseException) -> str:
    if isinstance(error, TimeoutError) and not str(error):
        return f"no answer within {PATIENCE:g} s"
    return str(error).splitlines()[0].rstrip(".") if str(error) else type(error).__name__


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
            return run_dask(made, jobs, address=self.scheduler, security=dict(self.security or {}))
        if self.kind == "processes":
            return run_processes(made, jobs, workers=self.workers)
        return run_threads(made, jobs, workers=self.workers, stop=stop)
