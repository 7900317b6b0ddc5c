"""Pool of worker processes with a bounded, cancellable queue and time limits; a worker that dies is replaced."""

import asyncio
import contextlib
import json
import struct
import sys
from collections import deque
from collections.abc import Callable, Coroutine
from dataclasses import dataclass, field
from typing import Any

Report = Callable[[dict[str, Any]], None]
"""Callback for a job's progress; it must not block, as other jobs wait for the caller."""
LONGEST_FRAME = 512 * 1024**2  # bytes
GRACE = 10.0  # s that a worker has to stop a job that is cancelled
WORDS, RESULT = b"w", b"r"
"""First byte of a worker's message: JSON, or a result."""


class QueueFullError(Exception):
    """Raised where the queue is full."""


@dataclass(eq=False)
class Job:
    """A job in the queue or in hand; ``done`` gets its result frame, or fails with `JobError`."""

    words: dict[str, Any]
    limit: float  # s
    report: Report
    done: "asyncio.Future[bytes]"
    worker: "Worker | None" = None
    cancelled: bool = False
    tried: bool = False  # a worker has begun it, or has died with it


class JobError(Exception):
    """Failure of a job, with a message for the user; ``cancelled`` where the user cancelled it."""

    def __init__(self, words: str, *, cancelled: bool = False) -> None:
        super().__init__(words)
        self.cancelled = cancelled


@dataclass(eq=False)
class Worker:
    """A worker process."""

    process: asyncio.subprocess.Process
    job: Job | None = None
    served: int = 0

    async def send(self, words: dict[str, Any]) -> None:
        """Hand over one frame."""
        payload = json.dumps(words).encode("utf-8")
        stdin = self.process.stdin
        assert stdin is not None
        stdin.write(struct.pack("<I", len(payload)) + payload)
        await stdin.drain()

    async def read(self) -> bytes:
        """Return the next frame; `asyncio.IncompleteReadError` where the process has ended."""
        stdout = self.process.stdout
        assert stdout is not None
        (length,) = struct.unpack("<I", await stdout.readexactly(4))
        if length > LONGEST_FRAME + 1:
            raise ConnectionError
        return await stdout.readexactly(length)


@dataclass
class Pool:
    """A few worker processes behind one bounded queue.

    ``size`` processes; at most ``bound`` jobs wait. A process is replaced after ``renew`` jobs, so that what libraries keep does
    not pile up.
    """

    size: int = 2
    bound: int = 32
    renew: int = 2000
    waiting: deque[Job] = field(default_factory=deque)
    workers: set[Worker] = field(default_factory=set)
    closing: bool = False
    ready: asyncio.Event = field(default_factory=asyncio.Event)  # the first worker has its kernels
    _wake: asyncio.Event = field(default_factory=asyncio.Event)
    _tasks: list["asyncio.Task[None]"] = field(default_factory=list)

    async def start(self) -> None:
        """Start the workers; they load the kernels in the background."""
        for _ in range(self.size):
            self._keep(self._keep_alive())

    def _keep(self, work: Coroutine[Any, Any, None]) -> None:
        task = asyncio.create_task(work)
        self._tasks.append(task)
        task.add_done_callback(self._tasks.remove)

    async def close(self) -> None:
        """End the workers; jobs that are left fail."""
        self.closing = True
        tasks = list(self._tasks)
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)
        for job in self.waiting:
            _fail(job, "The server is closing.")
        self.waiting.clear()

    def submit(self, words: dict[str, Any], report: Report, *, limit: float = 150.0) -> Job:
        """Put a job into the queue.

        Raises `QueueFullError` where as many wait as may.
        """
        if len(self.waiting) >= self.bound:
            raise QueueFullError
        job = Job(words, limit, report, asyncio.get_running_loop().create_future())
        self.waiting.append(job)
        self._wake.set()
        return job

    async def cancel(self, job: Job) -> None:
        """Take a job out of the queue, or stop it where it runs."""
        job.cancelled = True
        if job in self.waiting:
            self.waiting.remove(job)
            _fail(job, "Cancelled.", cancelled=True)
        elif job.worker is not None and job.worker.job is job:
            with contextlib.suppress(ConnectionError):
                await job.worker.send({"stop": True})
            self._keep(_kill_late(job, job.worker))

    async def _keep_alive(self) -> None:
        """Keep one worker alive and busy."""
        while True:
            try:
                worker = await _spawn()
            except OSError as fault:
                _report(fault)
                await asyncio.sleep(1.0)
                continue
            self.workers.add(worker)
            try:
                await worker.read()  # the ready message
                self.ready.set()
                while worker.served < self.renew:
                    await self._until_work(worker)
                    await self._serve(worker, self.waiting.popleft())
            except (asyncio.IncompleteReadError, ConnectionError):
                await asyncio.sleep(0.2)
            except Exception as fault:  # after any failure of a worker its keeper starts another
                _report(fault)
                await asyncio.sleep(0.2)
            finally:
                self.workers.discard(worker)
                self._rescue(worker.job)
                await _end(worker)

    async def _until_work(self, worker: Worker) -> None:
        """Wait until a job waits; `ConnectionError` where the worker has ended meanwhile."""
        while not self.waiting and worker.process.returncode is None:
            self._wake.clear()
            either = {asyncio.create_task(self._wake.wait()), asyncio.create_task(worker.process.wait())}
            try:
                await asyncio.wait(either, return_when=asyncio.FIRST_COMPLETED)
            finally:
                for each in either:
                    each.cancel()
        if worker.process.returncode is not None:
            raise ConnectionError

    def _rescue(self, job: Job | None) -> None:
        """Put the job of an ended worker back in front, once; a job that had begun fails."""
        if job is None or job.done.done():
            return
        if job.tried or job.cancelled or self.closing:
            ended = "The worker ended, perhaps for want of memory. Shorten the run."
            _fail(job, "Cancelled." if job.cancelled else ended, cancelled=job.cancelled)
            return
        job.tried = True
        self.waiting.appendleft(job)
        self._wake.set()

    async def _serve(self, worker: Worker, job: Job) -> None:
        worker.job, job.worker = job, worker
        worker.served += 1
        try:
            async with asyncio.timeout(job.limit):
                await worker.send({"job": job.words})
                while True:
                    frame = await worker.read()
                    if frame[:1] == RESULT:
                        if not job.done.done():
                            job.done.set_result(frame[1:])
                        break
                    words = json.loads(frame[1:])
                    if "error" in words:
                        _fail(job, words["error"], cancelled=bool(words.get("cancelled")))
                        break
                    job.tried = True
                    job.report(words)
        except TimeoutError:
            _fail(job, f"The limit of {job.limit:g} s was reached. Shorten the run.")
            raise ConnectionError from None  # ends the worker
        finally:
            if job.done.done():
                worker.job = None


def _fail(job: Job, words: str, *, cancelled: bool = False) -> None:
    if not job.done.done():
        job.done.set_exception(JobError(words, cancelled=cancelled))
        job.done.exception()  # mark it as retrieved: it is raised where the job is awaited


def _report(fault: Exception) -> None:
    """Log a fault in keeping a worker."""
    asyncio.get_running_loop().call_exception_handler(
        {"message": "gearplay: a worker had to be replaced", "exception": fault}
    )


async def _kill_late(job: Job, worker: Worker) -> None:
    """Kill a worker that does not stop within `GRACE` after cancellation."""
    await asyncio.sleep(GRACE)
    if worker.job is job and not job.done.done() and worker.process.returncode is None:
        worker.process.kill()


async def _spawn() -> Worker:
    process = await asyncio.create_subprocess_exec(
        sys.executable,
        "-m",
        "gearplay.web.worker",
        stdin=asyncio.subprocess.PIPE,
        stdout=asyncio.subprocess.PIPE,
        start_new_session=True,  # a Ctrl-C is for the server, which then ends its workers
    )
    return Worker(process)


async def _end(worker: Worker) -> None:
    process = worker.process
    if process.returncode is None:
        with contextlib.suppress(ProcessLookupError):
            process.kill()
    if process.stdout is not None:  # what is left in a full pipe hides its end
        with contextlib.suppress(ConnectionError):
            while await process.stdout.read(1024**2):
                continue
    await process.wait()
