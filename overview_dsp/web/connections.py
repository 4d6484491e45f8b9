"""Limits on the number and the speed of connections.

A browser opens six connections and a WebSocket. Idle or slow connections must not keep other users
out. At the limit, a new connection therefore replaces the one that has been idle longest.

Thread: the server's.
"""

from __future__ import annotations

import asyncio
from typing import Any

import h11
from uvicorn.protocols.http.h11_impl import H11Protocol
from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol

MAX_CONNECTIONS = 64
MAX_PER_ADDRESS = 24
MAX_CROWD = 1024
"""Limit for a live timeline, also per address: a whole stadium may share one address."""

REQUEST_TIMEOUT_S = 10.0
"""Maximum time for a request's line and headers."""

READ_TIMEOUT_S = 20.0
"""Maximum time without reading a response (a paused film is requested again)."""

BODY_TIMEOUT_S = 2.0
"""Maximum time to read the rest of a request that was answered early."""

MAX_HEADER = 16 * 1024
"""Bytes of a request's line and headers."""


class _Deadline:
    """Closes a transport unless it is cancelled in time."""

    def __init__(self, loop: asyncio.AbstractEventLoop) -> None:
        self._loop = loop
        self._handle: asyncio.TimerHandle | None = None

    def set(self, transport: asyncio.Transport, seconds: float) -> None:
        """Close `transport` after `seconds`, unless a deadline is set already."""
        if self._handle is None:
            self._handle = self._loop.call_later(seconds, transport.abort)

    def cancel(self) -> None:
        """Cancel the deadline."""
        if self._handle is not None:
            self._handle.cancel()
            self._handle = None


def address_of(connection: Any) -> str:
    """Return the address of the client."""
    return connection.client[0] if connection.client else ""


def is_open(connection: Any) -> bool:
    """Return whether the connection is open."""
    return not connection.transport.is_closing()


class _SlowReaderLimit(asyncio.Protocol):
    """Protocol that closes a connection if the client doesn't read for `READ_TIMEOUT_S`."""

    loop: asyncio.AbstractEventLoop
    transport: asyncio.Transport

    def __init__(self, *arguments: Any, **named: Any) -> None:
        super().__init__(*arguments, **named)
        self._reading = _Deadline(self.loop)

    def pause_writing(self) -> None:
        """Start the deadline for a slow reader."""
        super().pause_writing()
        self._reading.set(self.transport, READ_TIMEOUT_S)

    def resume_writing(self) -> None:
        """Cancel the deadline: the client reads again."""
        super().resume_writing()
        self._reading.cancel()

    def connection_lost(self, exc: Exception | None) -> None:
        """Cancel the deadline."""
        super().connection_lost(exc)
        self._reading.cancel()


class HttpConnection(_SlowReaderLimit, H11Protocol):
    """HTTP/1.1 connection with limits."""

    def __init__(self, *arguments: Any, crowd: bool = False, **named: Any) -> None:
        super().__init__(*arguments, **named)
        self._limit = MAX_CROWD if crowd else MAX_CONNECTIONS
        self._limit_per_address = MAX_CROWD if crowd else MAX_PER_ADDRESS
        self._request = _Deadline(self.loop)
        self._idle_since: float | None = None  # None: a request is being answered

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """Enforce the limits, then start the deadline for a request."""
        super().connection_made(transport)
        others = [one for one in self.connections if one is not self and is_open(one)]
        same = [one for one in others if address_of(one) == address_of(self)]
        group = same if len(same) >= self._limit_per_address else others
        if group is same or len(others) >= self._limit:
            known = [one for one in group if isinstance(one, HttpConnection)]
            idle = [one for one in known if one._idle_since is not None]
            if not idle:
                transport.abort()
                return
            min(idle, key=lambda one: one._idle_since or 0.0).transport.abort()
        self._start_deadline()

    def data_received(self, data: bytes) -> None:
        """Start or cancel the deadline for a request."""
        super().data_received(data)
        self._start_deadline()

    def on_response_complete(self) -> None:
        """Start the deadline for the next request."""
        super().on_response_complete()
        self._start_deadline()

    def _start_deadline(self) -> None:
        answered = self.cycle is not None and self.cycle.response_complete
        idle = self.conn.their_state is h11.IDLE and not self.transport.is_closing()
        if not idle:
            self._idle_since = None
        elif self._idle_since is None:
            self._idle_since = self.loop.time()
        if self.transport.is_closing():
            self._request.cancel()
        elif idle:
            self._request.set(self.transport, REQUEST_TIMEOUT_S)
        elif self.conn.their_state is h11.SEND_BODY and answered:
            self._request.set(self.transport, BODY_TIMEOUT_S)
        else:
            self._request.cancel()

    def handle_websocket_upgrade(self, event: h11.Request) -> None:
        """Pass the connection to the WebSocket protocol."""
        self._request.cancel()
        super().handle_websocket_upgrade(event)

    def connection_lost(self, exc: Exception | None) -> None:
        """Cancel the deadline."""
        self._request.cancel()
        super().connection_lost(exc)


class WebSocketConnection(_SlowReaderLimit, WebSocketsSansIOProtocol):
    """WebSocket connection with limits; uvicorn closes it after an unanswered ping."""
