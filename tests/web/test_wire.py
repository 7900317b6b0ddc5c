"""A page that does not read keeps nobody else waiting: neither other pages, nor the pool, nor the end of the server."""

import asyncio
import json
import sys
import time
from pathlib import Path
from typing import Any

import pytest

from gearplay.web import pool as pool_module
from gearplay.web.pool import Job, Pool, Worker
from gearplay.web.session import LARGEST_BODY, Wire
from gearplay.web.store import Store
from serving import together

WORKER = """
import json, os, struct, sys, time
def send(payload):
    sys.stdout.buffer.write(struct.pack("<I", len(payload)) + payload)
    sys.stdout.buffer.flush()
send(b"w" + json.dumps({"ready": True}).encode())
while len(head := sys.stdin.buffer.read(4)) == 4:
    words = json.loads(sys.stdin.buffer.read(struct.unpack("<I", head)[0]))
    if "job" in words:
        send(b"w" + json.dumps({"progress": 0.5}).encode())
        time.sleep(0.1)
        send(b"r" + bytes(3_000_000))
"""


class Page:
    """One that does not read keeps every send waiting, as a full transport does."""

    def __init__(self, *, reads: bool) -> None:
        self.reads, self.asked = reads, asyncio.Queue[str]()
        self.heard: list[str] = []
        self.errors: list[dict[str, Any]] = []

    async def receive_text(self) -> str:
        return await self.asked.get()

    async def send_text(self, text: str) -> None:
        if not self.reads:
            await asyncio.Event().wait()
        words = json.loads(text)
        self.heard.append(words["type"])
        if words["type"] == "error":
            self.errors.append(words)

    async def send_bytes(self, payload: bytes) -> None:
        self.heard.append("frame")

    def ask(self, number: int) -> None:
        self.asked.put_nowait(json.dumps({"kind": "run", "id": number, "of": number}))


def test_page__one_that_does_not_read_delays_no_other(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    async def spawn() -> Worker:
        words = (sys.executable, "-c", WORKER)
        return Worker(
            await asyncio.create_subprocess_exec(*words, stdin=-1, stdout=-1, start_new_session=True)
        )

    monkeypatch.setattr(pool_module, "_spawn", spawn)

    async def until(what: Any) -> None:
        end = time.monotonic() + 60.0
        while not what():
            assert time.monotonic() < end
            await asyncio.sleep(0.02)

    async def go() -> None:
        pool, store = Pool(size=1), Store(tmp_path)
        asleep, awake = Page(reads=False), Page(reads=True)
        await pool.start()
        serving = [asyncio.create_task(Wire(page, pool, store).serve()) for page in (asleep, awake)]  # type: ignore[arg-type]
        for number in range(3):
            asleep.ask(number)
        await until(lambda: len(list(tmp_path.glob("*.frame"))) == 3)  # its results are kept all the same
        awake.ask(7)
        await until(lambda: "frame" in awake.heard)
        assert "progress" in awake.heard
        await asyncio.wait_for(pool.close(), 30.0)
        for each in serving:
            each.cancel()

    together(go)


class SlowStore(Store):
    """A disk that takes its time."""

    def save(self, key: str, frame: bytes) -> None:
        time.sleep(0.05)


class ReadyPool(Pool):
    """Every job is done as soon as it is asked for."""

    def submit(self, words: dict[str, Any], tell: Any, *, limit: float) -> Job:
        done = asyncio.get_running_loop().create_future()
        done.set_result(b"")
        return Job(words, limit, tell, done)


def test_slow_disk__waiting_pages_are_served(tmp_path: Path) -> None:
    """Eight at a time, a new one with each answer: results on their way to the disk hold the next answer back, nothing more."""

    async def go() -> None:
        page = Page(reads=True)
        serving = asyncio.create_task(Wire(page, ReadyPool(), SlowStore(tmp_path)).serve())  # type: ignore[arg-type]
        for number in range(8):
            page.ask(number)
        for number in range(8, 80):
            while page.heard.count("frame") < number - 7:
                assert "full" not in page.heard
                await asyncio.sleep(0)
            page.ask(number)
        while page.heard.count("frame") < 80:
            assert "full" not in page.heard
            await asyncio.sleep(0)
        serving.cancel()

    together(go)


def test_a_worker_with_a_full_pipe_is_ended(monkeypatch: pytest.MonkeyPatch) -> None:
    """What nobody has read of it hides that it has ended."""

    async def go() -> None:
        words = "import sys; sys.stdout.buffer.write(bytes(10_000_000))"
        process = await asyncio.create_subprocess_exec(sys.executable, "-c", words, stdin=-1, stdout=-1)
        await asyncio.sleep(0.5)
        await asyncio.wait_for(pool_module._end(Worker(process)), 30.0)
        assert process.returncode is not None

    together(go)


def test_a_message_has_a_bound_of_its_own(tmp_path: Path) -> None:
    """Half of what a frame may have: one letter more is refused in words, and is no job."""
    whole = json.dumps({"kind": "nothing", "id": 1, "of": ""})
    fits = whole[:-2] + "x" * (LARGEST_BODY - len(whole)) + whole[-2:]

    async def go() -> None:
        page = Page(reads=True)
        serving = asyncio.create_task(Wire(page, Pool(), Store(tmp_path)).serve())  # type: ignore[arg-type]
        for text in (fits, fits + " "):
            page.asked.put_nowait(text)
        while len(page.errors) < 2:
            await asyncio.sleep(0.01)
        serving.cancel()
        assert [each["id"] for each in page.errors] == [1, None]

    assert len(fits) == LARGEST_BODY == 512 * 1024
    together(go)
