"""WebSocket session of one page: its requests, messages and stored results (schema: docs/page.md)."""

import asyncio
import contextlib
import json
from collections.abc import Coroutine
from typing import Any

from starlette.websockets import WebSocket, WebSocketDisconnect

from gearplay.model.toml_files import LARGEST_FILE
from gearplay.vocabulary.errors import InputError
from gearplay.web.pool import Job, JobError, Pool, QueueFullError
from gearplay.web.store import Store

LARGEST_BODY = 2 * LARGEST_FILE  # of a request, or a message
MOST_OWN = 8  # jobs of one page, waiting or in hand
MOST_UNSENT = 16  # results that one page has not read yet
MOST_UNKEPT = 8  # results of one page on their way to the disk; the next result waits for it
KEPT = ("run", "bifurcation", "map", "lost_motion")
DONE = (*KEPT, "average")
"""Jobs that a page may request; the results of `KEPT` are stored."""
FULL = "The queue is full. Try again in a moment."
LIMITS = {"run": 150.0, "average": 60.0}  # s; of the others:
LIMIT = 600.0


class Wire:
    """Connection to one page over a WebSocket."""

    def __init__(self, socket: WebSocket, pool: Pool, store: Store) -> None:
        self.socket, self.pool, self.store = socket, pool, store
        self.jobs: dict[int, Job] = {}
        self.unsent = 0
        """Results on their way to a page that reads slowly."""
        self.tasks: set[asyncio.Task[None]] = set()
        self.sending = asyncio.Lock()
        self.storing = asyncio.Semaphore(MOST_UNKEPT)

    async def serve(self) -> None:
        """Serve the page until it disconnects; then cancel its pending jobs."""
        greeting = self._keep(self._greet())
        try:
            while True:
                text = await self.socket.receive_text()
                await self._take(text)
        except (WebSocketDisconnect, KeyError, RuntimeError):
            pass
        finally:
            greeting.cancel()
            for job in list(self.jobs.values()):
                await self.pool.cancel(job)

    async def _take(self, text: str) -> None:
        try:
            sent = json.loads(text) if len(text) <= LARGEST_BODY else None
        except (ValueError, RecursionError):
            sent = None
        if not isinstance(sent, dict) or not isinstance(sent.get("id"), int):
            await self._refuse("error", None, "message: must be JSON with an id.")
            return
        number, kind = sent["id"], sent.get("kind")
        if kind == "cancel":
            if number in self.jobs:
                await self.pool.cancel(self.jobs[number])
            return
        if kind not in DONE:
            await self._refuse("error", number, f"kind: must be one of {', '.join(DONE)} or cancel.")
            return
        if number in self.jobs or len(self.jobs) >= MOST_OWN or self.unsent >= MOST_UNSENT:
            await self._refuse("full", number, f"A page may have {MOST_OWN} jobs, each with its own id.")
            return
        wanted = {key: value for key, value in sent.items() if key != "id"}

        def report(message: dict[str, Any]) -> None:
            if not self.sending.locked():  # a page that reads slowly gets fewer messages
                done = message.get("progress", 0.0)
                self._keep(self._say({"type": "progress", "id": number, "done": done}))

        try:
            job = self.pool.submit(wanted, report, limit=LIMITS.get(kind, LIMIT))
        except QueueFullError:
            await self._refuse("full", number, FULL)
            return
        self.jobs[number] = job
        self._keep(self._await(number, job, wanted))

    async def _greet(self) -> None:
        """Send whether jobs can run at once, and if not, as soon as they can."""
        if not self.pool.ready.is_set():
            await self._say({"type": "state", "ready": False})
            await self.pool.ready.wait()
        await self._say({"type": "state", "ready": True})

    def _keep(self, work: Coroutine[Any, Any, None]) -> "asyncio.Task[None]":
        """Start a background task and hold a reference, as asyncio may drop a task without one."""
        task = asyncio.create_task(work)
        self.tasks.add(task)
        task.add_done_callback(self.tasks.discard)
        return task

    async def _await(self, number: int, job: Job, words: dict[str, Any]) -> None:
        """Send the result of a job and store it concurrently; the job ends for the page before the result is sent."""
        try:
            frame = await job.done
        except JobError as error:
            kind = "cancelled" if error.cancelled else "error"
            self.jobs.pop(number, None)
            await self._refuse(kind, number, str(error))
            return
        finally:
            self.jobs.pop(number, None)
        self.unsent += 1
        try:
            key = Store.key_of(words)
            if words["kind"] not in KEPT:
                await self._send(number, key, frame)
            elif words["kind"] == "run":  # the next move waits for it, and not for the disk
                await self.storing.acquire()
                storing = self._keep(self._store(number, key, frame))
                storing.add_done_callback(lambda _: self.storing.release())
                await self._send(number, key, frame)
            else:  # may be requested as a file as soon as it is shown
                await self._store(number, key, frame)
                await self._send(number, key, frame)
        finally:
            self.unsent -= 1

    async def _store(self, number: int, key: str, frame: bytes) -> None:
        """Store a result, or send the reason why it is only shown."""
        try:
            await asyncio.to_thread(self.store.save, key, frame)
        except (InputError, OSError) as error:  # with a message that names no path of the server
            why = error.faults[0].rule if isinstance(error, InputError) else "must be writable"
            words = f"This is shown, but not kept among the results: the server's folder {why}."
            await self._refuse("unkept", number, words)

    async def _send(self, number: int, key: str, frame: bytes) -> None:
        with contextlib.suppress(RuntimeError, WebSocketDisconnect):
            async with self.sending:
                await self.socket.send_text(json.dumps({"type": "result", "id": number, "key": key}))
                await self.socket.send_bytes(frame)

    async def _refuse(self, kind: str, number: int | None, words: str) -> None:
        await self._say({"type": kind, "id": number, "error": words})

    async def _say(self, words: dict[str, Any]) -> None:
        with contextlib.suppress(RuntimeError, WebSocketDisconnect):
            async with self.sending:
                await self.socket.send_text(json.dumps(words))
