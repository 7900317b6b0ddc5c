"""Access to the page: hosts, origins and rebound names on every route, in a real browser; injections."""

import contextlib
import json
import socket
import threading
from collections.abc import Callable, Iterator
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any

import pytest

from depth import some
from serving import Server, Visit

pytestmark = pytest.mark.hostile

Open = Callable[..., Visit]
ROUTES = (
    "/",
    "/plotly.js",
    "/static/main.js",
    "/api/about",
    "/api/cases/han2021",
    "/api/results",
    "/api/results/" + 32 * "0",
)
POSTS = ("/api/case", "/api/export/toml")


def ask(
    port: int,
    route: str,
    *,
    method: str = "GET",
    host: str | None,
    origin: str | None = None,
    more: str = "",
    body: str = "",
    connection: str = "close",
) -> tuple[int, str]:
    """Send one request as bytes, so that no library mends it; return the status and the answer."""
    lines = [f"{method} {route} HTTP/1.1", f"Connection: {connection}", f"Content-Length: {len(body)}"]
    lines += [f"Host: {host}"] if host is not None else []
    lines += [f"Origin: {origin}"] if origin is not None else []
    lines += [more] if more else []
    with socket.create_connection(("127.0.0.1", port), timeout=20) as made:
        made.sendall(("\r\n".join(lines) + "\r\n\r\n" + body).encode("latin-1"))
        answer = b""
        while part := made.recv(65536):
            answer += part
    text = answer.decode("latin-1")
    return int(text.split(" ")[1]), text


def hosts(port: int) -> dict[str | None, bool]:
    """Return hosts and whether they are ours."""
    return {
        f"127.0.0.1:{port}": True,
        f"localhost:{port}": True,
        f"[::1]:{port}": True,
        "127.0.0.1": False,
        f"127.0.0.1:{port + 1}": False,
        f"evil.test:{port}": False,
        f"127.0.0.1:{port}.evil.test": False,
        f"localhost.evil.test:{port}": False,
        f"127.0.0.1:{port}@evil.test": False,
        f"0.0.0.0:{port}": False,
        "": False,
        None: False,
    }


def origins(port: int) -> dict[str | None, bool]:
    """Return origins and whether they are ours; None is fine for what only reads."""
    return {
        f"http://127.0.0.1:{port}": True,
        f"http://localhost:{port}": True,
        f"https://127.0.0.1:{port}": False,
        f"http://127.0.0.1:{port + 1}": False,
        "http://evil.test": False,
        f"http://127.0.0.1:{port}.evil.test": False,
        "null": False,
        "": False,
        None: True,
    }


@pytest.mark.slow
@pytest.mark.parametrize("route", ROUTES + POSTS)
def test_every_host_and_origin_on_every_route(server: Server, route: str) -> None:
    method = "POST" if route in POSTS else "GET"
    for host, ours in hosts(server.port).items():
        for origin, fine in origins(server.port).items():
            status, text = ask(
                server.port,
                route,
                method=method,
                host=host,
                origin=origin,
                body="{}" if method == "POST" else "",
            )
            allowed = ours and fine and not (method == "POST" and origin is None)
            assert (status not in (400, 403) or (allowed and method == "POST")) == allowed or (
                host is None and status == 400
            ), (host, origin, status)
            if not allowed:
                assert status in (400, 403)
                assert "Refused" in text or status == 400
                assert "han2021" not in text


@pytest.mark.parametrize("origin", ["http://evil.test", "null", None, "http://127.0.0.1:1"])
def test_a_websocket_of_another_origin_is_refused(server: Server, origin: str | None) -> None:
    words = "Upgrade: websocket\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13"
    for host in (f"127.0.0.1:{server.port}", f"evil.test:{server.port}"):
        status, _ = ask(server.port, "/wire", host=host, origin=origin, more=words, connection="Upgrade")
        assert status == 403


@pytest.mark.parametrize("site", ["cross-site", "same-site"])
def test_requests_that_a_browser_marks_as_foreign_are_refused(server: Server, site: str) -> None:
    host = f"127.0.0.1:{server.port}"
    assert ask(server.port, "/api/about", host=host, more=f"Sec-Fetch-Site: {site}")[0] == 403
    assert (
        ask(server.port, "/", host=host, more=f"Sec-Fetch-Site: {site}\r\nSec-Fetch-Mode: navigate")[0] == 200
    )
    assert (
        ask(server.port, "/api/about", host=host, more=f"Sec-Fetch-Site: {site}\r\nSec-Fetch-Mode: navigate")[
            0
        ]
        == 403
    )


def test_a_header_given_twice_is_refused(server: Server) -> None:
    host = f"127.0.0.1:{server.port}"
    assert ask(server.port, "/api/about", host=host, more="Host: evil.test")[0] in (400, 403)
    assert (
        ask(server.port, "/api/about", host=host, origin=f"http://{host}", more="Origin: http://evil.test")[0]
        == 403
    )


def test_answers_carry_the_strict_policy(server: Server) -> None:
    for route in ROUTES:
        text = ask(server.port, route, host=f"127.0.0.1:{server.port}")[1].lower()
        assert "content-security-policy: default-src 'none'; script-src 'self';" in text
        assert "unsafe-inline" not in text.split("\r\n\r\n")[0]
        assert "unsafe-eval" not in text.split("\r\n\r\n")[0]
        assert "x-content-type-options: nosniff" in text
        assert "cross-origin-resource-policy: same-origin" in text


@pytest.mark.parametrize(
    "route",
    ["/static/../app.py", "/static/..%2fapp.py", "/static/%2e%2e/app.py", "/static//etc/passwd", "/api/results/..%2f..%2fetc",
     "/api/cases/..%2f..%2fpyproject", "/api/results/" + 31 * "0", "/api/export/..%2fx"],
)  # fmt: skip
def test_no_path_of_the_client_s_choice(server: Server, route: str) -> None:
    status, text = ask(server.port, route, host=f"127.0.0.1:{server.port}")
    assert status in (400, 404, 405)
    assert "import" not in text
    assert "root:" not in text


@contextlib.contextmanager
def other_site(page: str) -> Iterator[int]:
    """Serve one page on another port."""

    class Handler(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            self.send_response(200)
            self.send_header("content-type", "text/html")
            self.end_headers()
            self.wfile.write(page.encode("utf-8"))

        def log_message(self, *_: Any) -> None:
            return

    made = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
    threading.Thread(target=made.serve_forever, daemon=True).start()
    try:
        yield made.server_address[1]
    finally:
        made.shutdown()
        made.server_close()


ATTACK = """<script>
window.got = []; window.done = 0;
const base = %s;
const note = (what) => window.got.push(what);
const end = () => { window.done += 1; };
fetch(base + "/api/about").then((r) => r.text()).then((t) => note("read " + t)).catch(() => {}).finally(end);
fetch(base + "/api/results", {mode: "no-cors"}).then((r) => { if (r.type !== "opaque") note("plain"); })
  .catch(() => {}).finally(end);
fetch(base + "/api/case", {method: "POST", body: '{"case": {}}'}).then((r) => note("posted " + r.status))
  .catch(() => {}).finally(end);
const socket = new WebSocket(base.replace("http", "ws") + "/wire");
socket.onopen = () => { note("socket"); end(); }; socket.onerror = end;
const script = document.createElement("script"); script.src = base + "/static/main.js";
script.onload = () => { note("script"); end(); }; script.onerror = end; document.head.append(script);
const image = new Image(); image.src = base + "/static/icon.svg";
image.onload = () => { note("image"); end(); }; image.onerror = end;
const frame = document.createElement("iframe"); frame.src = base + "/";
frame.onload = () => { try { if (frame.contentDocument?.getElementById("case")) note("frame"); } catch { } end(); };
document.documentElement.append(frame);
</script>"""


def attack(chromium: Any, url: str) -> list[str]:
    """Open a page that attacks and return what it got."""
    made = Visit(chromium, url)
    try:
        made.until("window.done >= 7", 20.0)
        return list(made.page.evaluate("window.got"))
    finally:
        made.close()


@pytest.mark.slow
def test_another_site_in_the_browser_gets_nothing(chromium: Any, server: Server) -> None:
    with other_site(ATTACK % json.dumps(server.url)) as port:
        assert attack(chromium, f"http://localhost:{port}/") == []
        assert attack(chromium, f"http://127.0.0.1:{port}/") == []  # the same address, another port


@pytest.mark.slow
def test_a_rebound_name_gets_nothing(chromium: Any, server: Server) -> None:
    """A name of the attacker's that suddenly means this machine: the browser takes it for one site, the server does not."""
    path = chromium.browser_type
    import shutil

    where = next(
        found for name in ("chromium", "chromium-browser", "google-chrome") if (found := shutil.which(name))
    )
    browser = path.launch(
        executable_path=where, args=["--no-sandbox", "--host-resolver-rules=MAP evil.test 127.0.0.1"]
    )
    try:
        made = Visit(browser, f"http://evil.test:{server.port}/")
        assert "Refused: the Host is not this server's." in made.page.text_content("body")
        got = made.page.evaluate(
            "fetch('/api/about').then((r) => r.status + ' ' + r.type).catch((e) => String(e))"
        )
        assert got.startswith("403")
        opened = made.page.evaluate(
            "new Promise((end) => { const s = new WebSocket(`ws://${location.host}/wire`);"
            " s.onopen = () => end(true); s.onerror = () => end(false); })"
        )
        assert opened is False
        made.close()
    finally:
        browser.close()


def payloads() -> list[str]:
    """Return 60 texts that would run somewhere if they were not escaped."""
    call = "window.hit=1"
    tags = [
        f"<script>{call}</script>",
        f"<img src=x onerror={call}>",
        f"<svg onload={call}>",
        f"<body onload={call}>",
        f"<iframe srcdoc='<script>parent.{call}</script>'>",
        f"<input autofocus onfocus={call}>",
        f"<details open ontoggle={call}>",
        f"<video><source onerror={call}></video>",
        f"<a href='javascript:{call}'>x</a>",
        f"<math><mtext><img src=x onerror={call}>",
        f"<style>@import 'javascript:{call}'</style>",
        f"<object data='javascript:{call}'>",
        f"<marquee onstart={call}>",
        f"<form><button formaction='javascript:{call}'>x",
        f"<svg><script>{call}</script></svg>",
        f"<select autofocus onfocus={call}>",
        f"<template><script>{call}</script></template>",
        f"<base href='javascript:{call}//'>",
        f"<embed src='javascript:{call}'>",
        f"<link rel=stylesheet href='javascript:{call}'>",
    ]
    breaks = ["{}", '">{}', "'-->{}"]
    return [each.format(tag.replace("{", "{{").replace("}", "}}")) for tag in tags for each in breaks]


@pytest.mark.slow
def test_nothing_that_is_typed_or_loaded_runs(visit: Open) -> None:
    """60 payloads as title, names of rotors, find text, link and messages: shown, or refused, never run."""
    made = visit().ready()
    page = made.page
    base = page.evaluate("window.gearplay.state.base")
    assert len(payloads()) == 60
    for at, payload in enumerate(some(payloads())):
        page.fill("#find", payload)
        case = json.loads(json.dumps(base)) | {"title": payload[:200]}
        if at % 3 == 0:
            case["rotors"] = {
                ("ring" if name == "ring" else payload): rotor for name, rotor in case["rotors"].items()
            }
            case["meshes"][0]["driver"] = payload
        page.evaluate(
            "(text) => { const b = btoa(String.fromCharCode(...new TextEncoder().encode(text))); location.hash = '#case=' +"
            " b.replaceAll('+', '-').replaceAll('/', '_').replace(/=+$/, ''); }",
            json.dumps(case),
        )
        if at % 3 == 0:  # a name that is none
            made.until("!document.getElementById('message').hidden")
        else:
            made.until(f"document.getElementById('title').textContent === {json.dumps(payload[:200])}")
            made.until(
                "!window.gearplay.state.running"
                " && window.gearplay.state.result.title === document.getElementById('title').textContent"
            )
        assert page.evaluate("window.hit") is None, payload
    page.fill("#find", "")
    assert page.evaluate("document.querySelectorAll('script:not([type=\"application/json\"])').length") == 2
    made.complaints[:] = [each for each in made.complaints if "status of 400" not in each]


def test_uploads_and_messages_are_bounded(server: Server) -> None:
    host = f"127.0.0.1:{server.port}"
    for length in (600_000, 6_000_000):  # beyond what the network holds on its way, too
        body = json.dumps({"toml": "#" * length})
        status, text = ask(
            server.port, "/api/case", method="POST", host=host, origin=f"http://{host}", body=body
        )
        assert status == 413
        assert "Shorten it" in text
    deep = "[" * 100_000
    assert (
        ask(server.port, "/api/case", method="POST", host=host, origin=f"http://{host}", body=deep)[0] == 400
    )
