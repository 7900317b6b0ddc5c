"""Connections to the page: half-open ones, requests cut short, large bodies, ten thousand requests."""

import asyncio
import contextlib
import json
import resource
import socket
import time
from collections.abc import Iterator
from http.client import HTTPResponse
from pathlib import Path
from typing import Any

import httpx
import pytest
import websockets

from depth import sized
from serving import Server, together
from web.test_jobs import Client, brief_case, memory

pytestmark = pytest.mark.hostile
HALF_OPEN = sized(1000, 100)
RUNS = sized(300, torture=10_000)
GROWTH = 20e6
"""Memory [bytes] that a server may take more after many runs than after the first."""


@pytest.fixture(scope="module")
def own(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Server]:
    """Serve for this module alone; at its end no traceback may have been logged."""
    made = Server(tmp_path_factory.mktemp("own"))
    yield made
    made.stop()


@pytest.fixture
def files() -> Iterator[None]:
    """Let this process have enough connections."""
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (max(soft, min(hard, 4096)), hard))
    yield
    resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))


def sent(server: Server, content: bytes, *, read: bool = True) -> bytes:
    """Send bytes and hang up; return what was answered."""
    with socket.create_connection(("127.0.0.1", server.port), timeout=20) as made:
        made.sendall(content)
        with contextlib.suppress(ConnectionError):
            return made.recv(65536) if read else b""
    return b""


def head(server: Server, route: str, *more: str, method: str = "POST") -> bytes:
    host = f"127.0.0.1:{server.port}"
    lines = [f"{method} {route} HTTP/1.1", f"Host: {host}", f"Origin: http://{host}", *more]
    return ("\r\n".join(lines) + "\r\n\r\n").encode("latin-1")


@pytest.mark.slow
def test_half_open_connections_are_dropped(own: Server, files: None) -> None:
    """Those that say nothing, half a head, or half a body for long; all others are answered meanwhile."""
    starts = [b"", b"GET / HTTP/1.1\r\nHost: ", head(own, "/", method="GET")[:-2]]
    held = []
    for at in range(HALF_OPEN):
        made = socket.create_connection(("127.0.0.1", own.port), timeout=20)
        made.sendall(starts[at % len(starts)])
        held.append(made)
    assert httpx.get(own.url, timeout=10).status_code == 200
    try:
        for made in held:
            made.settimeout(40.0)  # 15 on a machine that does nothing else
            with contextlib.suppress(ConnectionError):
                assert made.recv(1) == b""
    finally:
        for made in held:
            made.close()


@pytest.mark.slow
def test_a_connection_that_is_used_is_kept(own: Server) -> None:
    with socket.create_connection(("127.0.0.1", own.port), timeout=20) as made:
        for _ in range(3):
            made.sendall(head(own, "/api/about", method="GET"))
            answer = HTTPResponse(made)
            answer.begin()
            assert answer.status == 200
            answer.read()
            time.sleep(0.5)


@pytest.mark.slow
def test_requests_cut_short_or_at_fault_leave_no_traceback(tmp_path: Path) -> None:
    server = Server(tmp_path)
    try:
        cut = head(server, "/api/case", "Content-Length: 1000") + b'{"toml": "'
        for route in ("/api/case", "/api/export/csv"):
            chunked = head(server, route, "Transfer-Encoding: chunked")
            sent(server, head(server, route, "Content-Length: 1000") + b"{", read=False)
            assert b"400" in sent(server, chunked + b"zz\r\n")
            assert b"400" in sent(server, chunked + b"4\r\n{...\r\n-1\r\n")
            sent(server, chunked + b"ffffffffffffffffffff\r\n{", read=False)
        for size in range(0, len(cut), max(1, len(cut) // 40)):
            sent(server, cut[:size], read=False)
        sent(server, b"\x16\x03\x01" + bytes(200))
        sent(server, b"GET / HTTP/9.9\r\n\r\n")
        wanted = json.dumps({"case": brief_case(server)}).encode()
        for size in (0, 100, len(wanted)):  # gone before its answer
            sent(
                server,
                head(server, "/api/export/csv", f"Content-Length: {len(wanted)}") + wanted[:size],
                read=False,
            )
        time.sleep(1.0)
        assert httpx.get(server.url, timeout=10).status_code == 200
    finally:
        server.stop()  # looks for tracebacks


def test_export__too_large_a_case_is_refused(own: Server) -> None:
    body = json.dumps({"case": {"title": "x" * 6_000_000}}).encode()
    found = httpx.post(f"{own.url}/api/export/csv", content=body, headers={"origin": own.url}, timeout=30)
    assert found.status_code == 413
    assert "may have at most" in found.json()["error"]
    assert (
        httpx.post(f"{own.url}/api/export/exe", content=b"{}", headers={"origin": own.url}).status_code == 400
    )


@pytest.mark.slow
def test_one_run_after_the_other_is_never_refused(own: Server, tried: Any) -> None:
    """A client that sends as soon as it has its answer; and the server does not grow."""
    case = brief_case(own, duration=0.002)

    async def runs(count: int) -> None:
        async with Client(own) as made:
            for number in range(count):
                await made.say(kind="run", id=number, case=case, models=["coupled"])
                words = await made.hear()
                assert words["type"] == "result", words

    together(lambda: runs(min(RUNS, 30)))
    before = memory(own.process.pid)
    together(lambda: runs(RUNS))
    assert memory(own.process.pid) < before + GROWTH
    tried(RUNS)


def test_as_many_jobs_as_a_page_may_have_at_once(own: Server) -> None:
    """Eight at a time, each new one sent when an answer comes."""
    case = brief_case(own, duration=0.002)

    async def runs() -> None:
        async with Client(own) as made:
            for number in range(8):
                await made.say(kind="run", id=number, case=case, models=["coupled"])
            for number in range(8, 40):
                assert (await made.hear())["type"] == "result"
                await made.say(kind="run", id=number, case=case, models=["coupled"])

    together(runs)


@pytest.mark.slow
def test_server__on_all_addresses_requires_a_token(tmp_path: Path) -> None:
    """It really listens on 0.0.0.0: another address of this machine reaches it, by the name that it was given."""
    token, other = "a-token-of-enough-letters", "127.0.0.2"
    server = Server(tmp_path, "--host", "0.0.0.0", "--token", token, "--name", "mybox")
    try:
        url, host = f"http://{other}:{server.port}", f"mybox:{server.port}"
        assert httpx.get(url, headers={"host": host}).status_code == 403
        assert httpx.get(f"{url}/?token=wrong", headers={"host": host}).status_code == 403
        assert (
            httpx.get(f"{url}/?token={token}", headers={"host": f"elsewhere:{server.port}"}).status_code
            == 403
        )
        entered = httpx.get(f"{url}/?token={token}", headers={"host": host})
        assert entered.status_code == 200
        assert "HttpOnly; SameSite=Strict" in entered.headers["set-cookie"]
        for cookie, status in ((token, 200), ("wrong", 403)):
            headers = {"host": host, "Cookie": f"gearplay-token={cookie}"}
            assert httpx.get(f"{url}/api/about", headers=headers).status_code == status

        async def wire(cookie: str) -> str:
            headers = {"Cookie": cookie}
            address, origin = f"ws://{host}/wire", f"http://{host}"
            async with websockets.connect(
                address, host=other, port=server.port, origin=origin, additional_headers=headers
            ) as made:  # type: ignore[arg-type]
                return str(json.loads(await asyncio.wait_for(made.recv(), 60))["type"])

        assert together(lambda: wire(f"gearplay-token={token}")) == "state"
        with pytest.raises(websockets.exceptions.InvalidStatus):
            together(lambda: wire("gearplay-token=wrong"))
        assert token not in server.said()
    finally:
        server.stop()
