"""Jobs of the page: many clients, full queue, cancellation, limits, killed server and worker."""

import asyncio
import contextlib
import json
import os
import resource
import signal
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import httpx
import pytest
import websockets

from depth import FULL, sized
from gearplay.web.frames import unpack_frame
from serving import Server, Visit, together

CLIENTS = sized(50, 10)


def brief_case(server: Server, **run: Any) -> dict[str, Any]:
    case: dict[str, Any] = httpx.get(f"{server.url}/api/cases/han2021", timeout=20).json()["case"]
    case["run"] |= {"duration": 0.02, "transient": 0.0, "sampling": 5000.0} | run
    return case


def long_case(server: Server) -> dict[str, Any]:
    """Return a case that keeps a worker for minutes."""
    case = brief_case(server, duration=1500.0, sampling=1000.0)
    case["rotors"]["ring"]["load"]["torque"] = 5.0
    return case


class Client:
    """A page without a browser."""

    def __init__(self, server: Server) -> None:
        self.server = server

    async def __aenter__(self) -> "Client":
        self.socket = await websockets.connect(
            f"ws://127.0.0.1:{self.server.port}/wire", origin=self.server.url, max_size=None, open_timeout=60
        )  # type: ignore[arg-type]
        return self

    async def __aexit__(self, *_: Any) -> None:
        await self.socket.close()

    async def say(self, **words: Any) -> None:
        await self.socket.send(json.dumps(words))

    async def hear(self) -> dict[str, Any]:
        """Return the next word that is neither progress nor state; a result with its frame."""
        while True:
            words = json.loads(await asyncio.wait_for(self.socket.recv(), 120))
            if words["type"] in ("progress", "state"):
                continue
            if words["type"] == "result":
                frame = await asyncio.wait_for(self.socket.recv(), 60)
                words["frame"] = unpack_frame(frame)
            return dict(words)

    async def run(self, number: int, case: dict[str, Any]) -> tuple[dict[str, Any], int]:
        """Run a case, again while the queue is full, or results of this page are still being kept; return how often, too."""
        full = 0
        while True:
            await self.say(kind="run", id=number, case=case, models=["coupled"])
            words = await self.hear()
            if words["type"] != "full":
                return words, full
            assert "queue is full" in words["error"].lower() or "may have 8 jobs" in words["error"]
            full += 1
            await asyncio.sleep(0.05)


def memory(process: int) -> float:
    """Return the resident memory of a process and its children [bytes]."""
    total = 0.0
    for each in [process, *children(process)]:
        status = Path(f"/proc/{each}/status").read_text(encoding="utf-8")
        total += 1024.0 * float(status.split("VmRSS:")[1].split()[0])
    return total


def children(process: int) -> list[int]:
    return [
        int(each)
        for each in Path(f"/proc/{process}/task/{process}/children").read_text(encoding="utf-8").split()
    ]


@pytest.mark.slow
def test_clients__many_at_once_with_many_runs_each(tmp_path: Path) -> None:
    """No error, a full queue is said to be one, every answer is the client's own, and the memory comes back."""
    server = Server(tmp_path)
    try:
        case = brief_case(server)

        async def client(at: int, rounds: int) -> int:
            full = 0
            async with Client(server) as made:
                for number in range(rounds):
                    backlash = 1e-6 * (50 + at) + 1e-9 * number
                    mine = case | {"meshes": [case["meshes"][0] | {"backlash": backlash}]}
                    words, often = await made.run(number, mine)
                    assert words["type"] == "result", words
                    assert words["id"] == number
                    assert words["frame"]["case"]["meshes"][0]["backlash"] == pytest.approx(
                        backlash, rel=1e-12
                    )
                    full += often
            return full

        async def all_of(rounds: int) -> list[int]:
            return list(await asyncio.gather(*(client(at, rounds) for at in range(CLIENTS))))

        # 50 clients, 32 places; what every library keeps is kept after a while.
        assert sum(together(lambda: all_of(sized(10, 3)))) > 0 or not FULL
        before = memory(server.process.pid)
        together(lambda: all_of(sized(20, 4)))
        time.sleep(1.0)
        assert memory(server.process.pid) < 1.05 * before
        end = time.monotonic() + 20.0  # the last are still being kept
        while len(list(tmp_path.glob("*.frame"))) > 100:
            assert time.monotonic() < end
            time.sleep(0.1)
    finally:
        server.stop()


@pytest.mark.slow
def test_unstorable_result__is_displayed_and_reported(tmp_path: Path) -> None:
    """At the limit of a file's size writes fail as on a full disk; with room again results are kept."""
    server = Server(tmp_path)
    try:
        case = brief_case(server)

        async def run(number: int) -> set[str]:
            """Return the kinds of what comes back, until nothing comes any more."""
            heard = set()
            async with Client(server) as made:
                await made.say(kind="run", id=number, case=case, models=["coupled"])
                with contextlib.suppress(TimeoutError):
                    while True:
                        words = await asyncio.wait_for(made.socket.recv(), 300 if "frame" not in heard else 2)
                        if isinstance(words, bytes):
                            assert unpack_frame(words)["case"]
                            heard.add("frame")
                            continue
                        told = json.loads(words)
                        heard.add(told["type"])
                        if told["type"] == "unkept":
                            assert told["error"] == (
                                "This is shown, but not kept among the results: "
                                "the server's folder must be writable (File too large)."
                            )
            return heard - {"progress", "state"}

        case["title"] = "first"
        assert together(lambda: run(1)) == {"result", "frame"}
        while (
            '"result":null' in httpx.get(server.url, timeout=20).text
        ):  # the motion that comes with the page
            time.sleep(0.2)
        before = set(tmp_path.iterdir())
        unlimited = resource.prlimit(server.process.pid, resource.RLIMIT_FSIZE)
        resource.prlimit(server.process.pid, resource.RLIMIT_FSIZE, (1000, unlimited[1]))
        case["title"] = "second"
        assert together(lambda: run(2)) == {"result", "frame", "unkept"}
        assert set(tmp_path.iterdir()) == before
        resource.prlimit(server.process.pid, resource.RLIMIT_FSIZE, unlimited)
        assert together(lambda: run(3)) == {"result", "frame"}
        assert len(httpx.get(f"{server.url}/api/results", timeout=20).json()) == len(before) + 1
    finally:
        server.stop()


def test_cancelling_a_job_in_hand_and_one_that_waits(server: Server) -> None:
    case = brief_case(server, duration=1500.0, sampling=1000.0)
    case["rotors"]["ring"]["load"]["torque"] = 5.0  # pressed: some hundred thousand steps a second of motion

    async def go() -> None:
        async with Client(server) as made:
            for number in range(4):
                await made.say(kind="run", id=number, case=case)
            await asyncio.sleep(0.5)
            for number in (3, 0, 1, 2):
                await made.say(kind="cancel", id=number)
            assert sorted([(await made.hear())["type"] for _ in range(4)]) == ["cancelled"] * 4
            words, _ = await made.run(9, brief_case(server))
            assert words["type"] == "result"

    together(go)


def test_page__its_jobs_end_when_it_disconnects(server: Server) -> None:
    """Left alone its six jobs would hold both workers for minutes, longer than the next page waits."""
    case = long_case(server)

    async def go() -> None:
        async with Client(server) as gone:
            for number in range(6):
                await gone.say(kind="run", id=number, case=case)
            await asyncio.sleep(0.3)
        async with Client(server) as made:
            words, _ = await made.run(1, brief_case(server))
            assert words["type"] == "result"

    together(go)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ({"kind": "run", "id": 1}, "case"),
        ({"kind": "run", "id": 1, "case": {"rotors": {}}}, "rotors"),
        ({"kind": "dance", "id": 1}, "kind: must be one of"),
        ({"kind": "run"}, "must be JSON with an id"),
        ({"kind": "bifurcation", "id": 1, "count": 5, "keep": 5, "settle": 1}, "case"),
        ({"kind": "map", "id": 1, "case": "han2021"}, "case"),
    ],
)
def test_a_bad_message_gets_one_sentence(server: Server, words: dict[str, Any], said: str) -> None:
    async def go() -> dict[str, Any]:
        async with Client(server) as made:
            await made.say(**words)
            return await made.hear()

    answer = together(go)
    assert answer["type"] == "error"
    assert said in answer["error"]
    assert "Traceback" not in answer["error"]


def test_a_run_beyond_the_page_s_size_is_refused(server: Server) -> None:
    async def go() -> dict[str, Any]:
        async with Client(server) as made:
            await made.say(kind="run", id=1, case=brief_case(server, duration=1000.0, sampling=1e5))
            return await made.hear()

    answer = together(go)
    assert "must give at most 2000000 samples" in answer["error"]


def test_a_client_cannot_speak_to_a_worker(server: Server) -> None:
    """Whatever a job holds, a worker takes it for a job, and is free again afterwards."""

    async def go() -> None:
        async with Client(server) as made:
            for number in range(4):
                await made.say(kind="map", id=number, stop=True, case=brief_case(server))
                assert (await made.hear())["type"] == "error"
            words, _ = await made.run(9, brief_case(server))
            assert words["type"] == "result"

    together(go)


def test_a_cancel_right_after_is_heard(server: Server) -> None:
    case = long_case(server)

    async def go() -> None:
        async with Client(server) as made:
            for number in range(12):
                await made.say(kind="run", id=number, case=case)
                await made.say(kind="cancel", id=number)
                assert (await made.hear())["type"] == "cancelled"

    together(go)


@pytest.mark.deep
def test_a_link_that_breaks_before_its_result(visit: Callable[..., Visit]) -> None:
    """The head of a result came, its numbers did not: the page asks again when the server is back."""
    made = visit().ready()
    made.page.evaluate(
        """() => {
          const { wire } = window.gearplay.state;
          const { take } = wire;
          wire.take = function (data) {
            take.call(wire, data);
            if (typeof data !== "string" || JSON.parse(data).type !== "result") return;
            wire.take = take;
            wire.socket.onmessage = null;
            wire.socket.close();
          };
        }"""
    )

    def move() -> None:
        field = made.page.locator('input[data-path="meshes.0.backlash"]')
        field.fill("131")
        field.press("Tab")

    made.after(move)
    backlash = made.page.evaluate("window.gearplay.state.result.case.meshes[0].backlash")
    assert backlash == pytest.approx(131e-6)


@pytest.mark.slow
@pytest.mark.hostile
def test_a_worker_that_is_killed_is_replaced(server: Server) -> None:
    case = long_case(server)

    async def go() -> None:
        async with Client(server) as made:
            await made.say(kind="run", id=1, case=case)
            while json.loads(await asyncio.wait_for(made.socket.recv(), 60))["type"] != "progress":
                pass
            for each in children(server.process.pid):
                os.kill(each, signal.SIGKILL)
            words = await made.hear()
            assert words["type"] == "error"
            assert "The worker ended" in words["error"]
            words, _ = await made.run(2, brief_case(server))
            assert words["type"] == "result"

    together(go)


@pytest.mark.deep
@pytest.mark.hostile
def test_killed_server__is_reported_and_keeps_its_results(chromium: Any, tmp_path: Path) -> None:
    server = Server(tmp_path)
    made = Visit(chromium, server.url).ready()
    try:
        kept = made.page.evaluate("window.gearplay.state.result.key")
        made.page.click("#tab-bifurcation")
        made.page.fill("#bifurcation-form [name=count]", "900")
        made.page.click("#bifurcation-form button")
        made.until("!document.getElementById('job').hidden")
        server.kill()
        made.until("!document.getElementById('gone').hidden", 3.0)
        assert "connects again" in made.page.text_content("#gone")
        assert made.page.locator("#orbit svg").count() > 0, "drawn, by plotly.js or before it came"
        assert made.page.evaluate("document.getElementById('stale').hidden")
        made.page.evaluate("document.querySelector('[data-slider]').dispatchEvent(new Event('input'))")
        assert not made.page.evaluate("document.getElementById('stale').hidden"), (
            "not of the case as it stands"
        )
        made.page.select_option("#case", "external-pair")
        made.until("document.getElementById('message').textContent.includes('The server is gone')")
        assert made.page.input_value("#case") == "han2021"
        made.complaints[:] = [each for each in made.complaints if "ERR_CONNECTION" not in each]
        server.start(server.port)
        made.until("Boolean(window.gearplay.state.job)")  # the diagram is asked for again
        made.until(
            "document.getElementById('gone').hidden && document.getElementById('link-state').textContent === 'connected'"
        )
        assert httpx.get(f"{server.url}/api/results/{kept}", timeout=20).status_code == 200
        keys = [each["key"] for each in httpx.get(f"{server.url}/api/results", timeout=20).json()]
        assert kept in keys
    finally:
        made.close()
        server.stop()
