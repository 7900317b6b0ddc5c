"""Where the points of a sweep are evaluated: threads, processes, or an existing Dask cluster. Results do not depend on it."""

import queue
import threading
from collections.abc import Generator, Iterable
from itertools import islice
from pathlib import Path
from typing import Any

from gearplay.solver.simulate import prepare, worker_count
from gearplay.study.sweeps.evaluate import Outcome, Sweep, evaluate_many
from gearplay.vocabulary.errors import Fault, InputError, SimulationError
from gearplay.vocabulary.optional import load_optional

RETRIES = 3
"""How often work that a dying process took with it is begun again."""


def run_threads(sweep: Sweep, jobs: Iterable[int], *, workers: int | None = None) -> Generator[list[Outcome]]:
    """Evaluate jobs on threads, the default: the kernels run side by side, and nothing is copied.

    Yields the outcomes of each job as it is done. Closing the iterator ends every run at its next chunk.
    """
    prepare(sweep.template.base)
    waiting, lock, stop = iter(jobs), threading.Lock(), threading.Event()
    done: queue.SimpleQueue[list[Outcome] | BaseException | None] = queue.SimpleQueue()
    room = threading.Semaphore(1000)  # a consumer that cannot keep up must not fill the memory

    def work() -> None:
        try:
            while not stop.is_set():
                with lock:
                    job = next(waiting, None)
                if job is None:
                    break
                outcomes = sweep.evaluate(int(job), stop)
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
            found = done.get()
            if found is None:
                left -= 1
            elif isinstance(found, BaseException):
                raise found
            else:
                room.release()
                yield found
    finally:
        stop.set()
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
    waiting, again = iter(jobs), 0
    pending: dict[Any, list[int]] = {}
    lost: list[list[int]] = []
    while True:
        pool = ProcessPoolExecutor(count, mp_context=get_context("spawn"))
        try:
            while True:
                while len(pending) < 2 * count:
                    batch = lost.pop() if lost else [int(i) for i in islice(waiting, 1)]
                    if not batch:
                        break
                    pending[pool.submit(evaluate_many, document, batch)] = batch
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

    Raises `InputError` where the scheduler cannot be reached.
    """
    distributed = load_optional("distributed", "cluster")
    settings = None
    if security:
        settings = distributed.Security(require_encryption=True, **{k: str(v) for k, v in security.items()})
    try:
        client = distributed.Client(address, security=settings, set_as_default=False, timeout="15s")
    except (OSError, ValueError, TimeoutError) as error:
        words = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise InputError(
            Fault("scheduler", address, f"must be reached ({words})", "Start it, or correct the address")
        ) from None
    document, waiting = sweep.plan.model_dump_json(), iter(jobs)
    with client:
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
            _, outcomes = next(pending)
            in_flight += submit() - 1
            yield outcomes
