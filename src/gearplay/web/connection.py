"""HTTP connection of the server: uvicorn's, with a time limit for requests."""

import asyncio
from typing import Any

import h11
from uvicorn.protocols.http.h11_impl import H11Protocol

HEAD_TIMEOUT = 10.0
"""Limit [s] from the first byte of a request, or from the connection, to the end of the request's head."""
BODY_TIMEOUT = 30.0
"""Limit [s] from there to the end of its body."""


class Connection(H11Protocol):
    """A connection that is closed if a request is incomplete after its time limit, or invalid."""

    _watch: asyncio.TimerHandle | None = None
    _waits_for_body = False

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """Start the time limit of the first request."""
        super().connection_made(transport)
        self._wait(HEAD_TIMEOUT)

    def connection_lost(self, exc: Exception | None) -> None:
        """Cancel the time limit of the request."""
        self._stop_waiting()
        super().connection_lost(exc)

    def data_received(self, data: bytes) -> None:
        """Pass data on; start, continue or stop the time limit of the rest of a request."""
        super().data_received(data)
        state = self.conn.their_state
        if self.transport.is_closing() or self.transport.get_protocol() is not self:  # a WebSocket by now
            self._stop_waiting()
        elif state is h11.IDLE:
            if self._watch is None:
                self._wait(HEAD_TIMEOUT)
        elif state is h11.SEND_BODY:
            if not self._waits_for_body:
                self._stop_waiting()
                self._waits_for_body = True
                self._wait(BODY_TIMEOUT)
        else:
            self._stop_waiting()

    def send_400_response(self, msg: str) -> None:
        """Refuse an invalid HTTP request; close the connection if a response has begun."""
        try:
            super().send_400_response(msg)
        except h11.LocalProtocolError:
            self.transport.close()

    def _wait(self, seconds: float) -> None:
        self._watch = self.loop.call_later(seconds, self._abort)

    def _stop_waiting(self) -> None:
        self._waits_for_body = False
        if self._watch is not None:
            self._watch.cancel()
            self._watch = None

    def _abort(self) -> None:
        self._watch = None
        if not self.transport.is_closing():
            self.transport.abort()


def raise_limit_on_files() -> None:
    """Raise the limit on connections to that of the system: half-open ones soon exhaust the usual 1024."""
    try:
        import resource
    except ImportError:  # a system without such limits
        return
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    most: Any = 65_536 if hard == resource.RLIM_INFINITY else min(hard, 65_536)
    if soft != resource.RLIM_INFINITY and soft < most:
        resource.setrlimit(resource.RLIMIT_NOFILE, (most, hard))
