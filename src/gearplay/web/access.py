"""Access control: exact hosts and origins on HTTP and WebSocket, a token beyond loopback, strict headers.

A page on another site can make a browser send requests here, and by rebinding its name can even pass for this host. So the
Host must be one of ours, whatever names an Origin must name ours, and a WebSocket must have one.
"""

import contextlib
import hmac
from collections.abc import Awaitable, Callable, MutableMapping
from http.cookies import CookieError, SimpleCookie
from typing import Any
from urllib.parse import parse_qs

from starlette.requests import ClientDisconnect

Scope = MutableMapping[str, Any]
Message = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[Message]]
Send = Callable[[Message], Awaitable[None]]
App = Callable[[Scope, Receive, Send], Awaitable[None]]

# The styles that plotly.js sets as text, by their hashes, and no others: an empty one, that of its measure of text, an exponent's
# size, and how the cells of a map are drawn.
STYLES = (
    "'unsafe-hashes'",
    "'sha256-47DEQpj8HBSa+/TImW+5JCeuQeRkm5NMpJWZG3hSuFU='",
    "'sha256-ji27qzEtxXZW+7dun6UwjHXJ18e6WAin1VvNtkzIE/o='",
    "'sha256-S+l+cz1wXqs2B0FcjqqT7NvjwGmhD1UjJswXjlSkj0s='",
    "'sha256-AR/cKIZjWPcPmBUPDA6oti9XBiTbJvz0Cro2J1VzzS8='",
)
POLICY = "; ".join(
    (
        "default-src 'none'",
        "script-src 'self'",
        f"style-src 'self' {' '.join(STYLES)}",
        "img-src 'self' data: blob:",
        "connect-src 'self'",
        "font-src 'self'",
        "base-uri 'none'",
        "form-action 'none'",
        "frame-ancestors 'none'",
        "object-src 'none'",
    )
)
HEADERS = (
    (b"content-security-policy", POLICY.encode("ascii")),
    (b"x-content-type-options", b"nosniff"),
    (b"referrer-policy", b"no-referrer"),
    (b"cross-origin-opener-policy", b"same-origin"),
    (b"cross-origin-resource-policy", b"same-origin"),
    (b"x-frame-options", b"DENY"),
)
COOKIE = "gearplay-token"


class Guard:
    """ASGI middleware in front of everything.

    ``hosts`` are the accepted values of Host, in lower case (``127.0.0.1:8000``); those of them in ``proxied`` may be
    served through an https proxy.
    ``token`` is required, once in the query (``?token=...``) and then in a cookie, unless it is None.
    """

    def __init__(
        self, app: App, hosts: frozenset[str], token: str | None = None, proxied: frozenset[str] = frozenset()
    ) -> None:
        self.app, self.hosts, self.token = app, hosts, token
        self.origins = frozenset(
            (*(f"http://{host}" for host in hosts), *(f"https://{host}" for host in proxied))
        )

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request on, or refuse it."""
        with contextlib.suppress(ClientDisconnect):  # the client has disconnected
            await self._pass_on(scope, receive, send)

    async def _pass_on(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] == "lifespan":
            await self.app(scope, receive, send)
            return
        reason = self.refusal(scope)
        if reason is not None:
            await _refuse(scope, receive, send, reason)
            return
        given = _token_in_query(scope)

        async def send_with_headers(message: Message) -> None:
            if message["type"] == "http.response.start":
                headers = [*message.get("headers", []), *HEADERS]
                if self.token is not None and given is not None:
                    cookie = f"{COOKIE}={self.token}; HttpOnly; SameSite=Strict; Path=/"
                    headers.append((b"set-cookie", cookie.encode("latin-1")))
                message = {**message, "headers": headers}
            await send(message)

        await self.app(scope, receive, send_with_headers)

    def refusal(self, scope: Scope) -> str | None:
        """Return why a request is refused, or None."""
        headers = _headers(scope)
        if headers is None:
            return "a header is given twice"
        host, origin = headers.get("host"), headers.get("origin")
        if host is None or host.lower() not in self.hosts:
            return "the Host is not this server's"
        if origin is not None and origin not in self.origins:
            return "the Origin is not this page"
        if origin is None and (scope["type"] == "websocket" or scope.get("method") not in ("GET", "HEAD")):
            return "an Origin is required"
        site = headers.get("sec-fetch-site")
        opens_page = headers.get("sec-fetch-mode") == "navigate" and scope["path"] == "/"
        if site not in (None, "same-origin", "none") and not opens_page:
            return "the request comes from another site"
        if self.token is not None and not self._knows_token(scope, headers):
            return "the token is missing or wrong"
        return None

    def _knows_token(self, scope: Scope, headers: dict[str, str]) -> bool:
        given = _token_in_query(scope)
        if given is None:
            try:
                held = SimpleCookie(headers.get("cookie", "")).get(COOKIE)
            except CookieError:
                return False
            given = held.value if held is not None else ""
        return hmac.compare_digest(given.encode("utf-8"), (self.token or "").encode("utf-8"))


def _headers(scope: Scope) -> dict[str, str] | None:
    """Return the headers that decide, or None where one of them comes twice."""
    found: dict[str, str] = {}
    for name, value in scope["headers"]:
        key = name.decode("latin-1").lower()
        if key in ("host", "origin", "sec-fetch-site", "sec-fetch-mode") and key in found:
            return None
        found[key] = value.decode("latin-1")
    return found


def _token_in_query(scope: Scope) -> str | None:
    values = parse_qs(scope.get("query_string", b"").decode("latin-1")).get("token")
    return values[0] if values else None


async def _refuse(scope: Scope, receive: Receive, send: Send, reason: str) -> None:
    if scope["type"] == "websocket":
        await receive()
        await send({"type": "websocket.close", "code": 1008, "reason": reason})
        return
    body = f"Refused: {reason}.".encode()
    headers = [(b"content-type", b"text/plain; charset=utf-8"), *HEADERS]
    await send({"type": "http.response.start", "status": 403, "headers": headers})
    await send({"type": "http.response.body", "body": body})
