"""The server: address, access, uvicorn."""

import asyncio
import re
import secrets
import socket
from collections.abc import Callable
from dataclasses import dataclass
from ipaddress import ip_address
from pathlib import Path

from gearplay.vocabulary.errors import InputError
from gearplay.vocabulary.optional import load_optional

SHORTEST_TOKEN = 16
TOKEN = re.compile(rf"[A-Za-z0-9_-]{{{SHORTEST_TOKEN},}}")
LOOPBACK = ("127.0.0.1", "localhost", "[::1]")


@dataclass(frozen=True)
class Address:
    """Address the server listens on, accepted values of the Host header, and the access token."""

    host: str
    port: int
    names: frozenset[str]
    token: str | None
    proxied: frozenset[str] = frozenset()  # of the names, those that an https proxy may serve

    @property
    def url(self) -> str:
        """The address to open."""
        shown = f"[{self.host}]" if ":" in self.host else self.host
        query = f"?token={self.token}" if self.token else ""
        return f"http://{shown}:{self.port}/{query}"


def address_of(host: str, port: int, token: str | None, names: tuple[str, ...] = ()) -> Address:
    """Validate the address to listen on; beyond loopback a token is required.

    ``names`` are further accepted names of the host.

    Raises `InputError` for an invalid address, or one beyond loopback without a token.

    >>> address_of("127.0.0.1", 8000, None).url
    'http://127.0.0.1:8000/'
    """
    if not 0 <= port <= 65535:
        raise InputError.of("--port", port, "must be from 0 to 65535", "Choose 0 for any that is free")
    try:
        local = host == "localhost" or ip_address(host).is_loopback
    except ValueError:
        rule = "must be an IP address of this machine, or localhost"
        raise InputError.of("--host", host, rule, "Leave it out to serve this machine only") from None
    if not local and token is None:
        cure = f"Add for example --token {secrets.token_urlsafe(18)}"
        raise InputError.of("--token", "none", "is required for an address that others can reach", cure)
    if token is not None and not TOKEN.fullmatch(token):
        rule = f"must be {SHORTEST_TOKEN} or more letters, digits, - and _"
        raise InputError.of("--token", "(hidden)", rule, f"Use for example {secrets.token_urlsafe(18)}")
    called = {f"[{host}]" if ":" in host else host, *names, *(LOOPBACK if local else ())}
    bare = called if port == 80 else names  # a proxy passes on the name without our port
    known = frozenset(name.lower() for name in (*bare, *(f"{name}:{port}" for name in called)))
    proxied = frozenset(name.lower() for name in (*names, *(f"{name}:{port}" for name in names)))
    return Address(host, port, known, token, proxied)


def serve(
    host: str,
    port: int,
    token: str | None,
    folder: Path,
    *,
    names: tuple[str, ...] = (),
    workers: int = 2,
    ready: Callable[[Address], None] = lambda _: None,
) -> None:
    """Serve the page until interrupted; results are kept in ``folder``.

    ``ready`` is called with the address, including the port taken, once connections are accepted.

    Raises `InputError` where the address is invalid or taken, or a library is missing.
    """
    for module in ("starlette", "uvicorn", "websockets", "plotly"):
        load_optional(module, "web")
    import uvicorn

    from gearplay.web.access import Guard
    from gearplay.web.app import make_app
    from gearplay.web.connection import Connection, raise_limit_on_files
    from gearplay.web.pool import Pool

    address_of(host, port, token, names)
    raise_limit_on_files()
    listening = _listen(host, port)
    address = address_of(host, int(listening.getsockname()[1]), token, names)
    app = Guard(make_app(folder, Pool(size=workers)), address.names, address.token, address.proxied)
    server = uvicorn.Server(
        uvicorn.Config(
            app,
            log_level="warning",
            access_log=False,
            http=Connection,
            ws="websockets-sansio",
            ws_max_size=1024 * 1024,
            ws_per_message_deflate=False,  # of floats it would halve the bytes in 10 ms
            server_header=False,
            date_header=False,
            timeout_graceful_shutdown=2,
        )
    )

    async def run() -> None:
        started = asyncio.create_task(server.serve(sockets=[listening]))
        while not server.started and not started.done():
            await asyncio.sleep(0.02)
        if not started.done():
            ready(address)
        await started

    asyncio.run(run())


def _listen(host: str, port: int) -> socket.socket:
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    made = socket.socket(family, socket.SOCK_STREAM)
    made.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        made.bind((host, port))
    except OSError as error:
        made.close()
        rule = f"must be free to listen on ({error.strerror})"
        raise InputError.of("--port", port, rule, "Choose another, or 0 for any") from None
    made.listen(128)
    return made
