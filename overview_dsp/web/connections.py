"""Connections that are too many or too slow are closed, before they cost anything.

A browser opens six and a WebSocket. Waiting for requests that never come, or for readers that never
read, would let anyone in the network keep the owner out. So a new connection takes the place of the
one that has been waiting longest for a request, where there are too many.

Thread: the server's.
"""

from __future__ import annotations

import asyncio
from typing import Any

import h11
from uvicorn.protocols.http.h11_impl import H11Protocol
from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol

MAX_CONNECTIONS = 64
MAX_OF_AN_ADDRESS = 24
CROWD = 1024
"""Connections, of one address too, where a match is followed: a stadium is behind one address."""

REQUEST_WITHIN_S = 10.0
"""A request's line and headers arrive in so long."""

READ_WITHIN_S = 20.0
"""Who doesn't read an answer for so long is gone (a paused film is asked for again)."""

LINGER_S = 2.0
"""The rest of a request that was answered before it was whole is read for so long."""

MAX_HEADER = 16 * 1024
"""Bytes of a request's line and headers."""


class _Deadline:
    """Closes a transport unless it is cancelled in time."""

    def __init__(self, loop: asyncio.AbstractEventLoop) -> None:
        self._loop = loop
        self._handle: asyncio.TimerHandle | None = None

    def set(self, transport: asyncio.Transport, seconds: float) -> None:
        """Close `transport` in so many seconds, if that isn't planned yet."""
        if self._handle is None:
            self._handle = self._loop.call_later(seconds, transport.abort)

    def cancel(self) -> None:
        """It may live."""
        if self._handle is not None:
            self._handle.cancel()
            self._handle = None


def address_of(connection: Any) -> str:
    """Who is at the other end."""
    return connection.client[0] if connection.client else ""


def is_open(connection: Any) -> bool:
    """Whether nobody has closed it yet."""
    return not connection.transport.is_closing()


class HttpConnection(H11Protocol):
    """uvicorn's HTTP/1.1, with limits."""

    def __init__(self, *arguments: Any, crowd: bool = False, **named: Any) -> None:
        super().__init__(*arguments, **named)
        self._most = CROWD if crowd else MAX_CONNECTIONS
        self._most_of_one = CROWD if crowd else MAX_OF_AN_ADDRESS
        self._request = _Deadline(self.loop)
        self._reading = _Deadline(self.loop)
        self._idle_since: float | None = None  # None: a request is being answered

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """Free a connection, or abort this one; then wait a little for a request."""
        super().connection_made(transport)
        others = [one for one in self.connections if one is not self and is_open(one)]
        same = [one for one in others if address_of(one) == address_of(self)]
        crowd = same if len(same) >= self._most_of_one else others
        if crowd is same or len(others) >= self._most:
            idle = [one for one in crowd if isinstance(one, HttpConnection) and one.is_idle]
            if not idle:
                transport.abort()
                return
            min(idle, key=lambda one: one._idle_since or 0.0).transport.abort()
        self._expect()

    @property
    def is_idle(self) -> bool:
        """Whether it waits for a request."""
        return self._idle_since is not None

    def data_received(self, data: bytes) -> None:
        """Wait for the rest of a request's headers only so long."""
        super().data_received(data)
        self._expect()

    def on_response_complete(self) -> None:
        """The next request may have begun already."""
        super().on_response_complete()
        self._expect()

    def _expect(self) -> None:
        answered = self.cycle is not None and self.cycle.response_complete
        idle = self.conn.their_state is h11.IDLE and not self.transport.is_closing()
        if not idle:
            self._idle_since = None
        elif self._idle_since is None:
            self._idle_since = self.loop.time()
        if self.transport.is_closing():
            self._request.cancel()
        elif idle:
            self._request.set(self.transport, REQUEST_WITHIN_S)
        elif self.conn.their_state is h11.SEND_BODY and answered:
            self._request.set(self.transport, LINGER_S)
        else:
            self._request.cancel()

    def handle_websocket_upgrade(self, event: h11.Request) -> None:
        """Leave the connection to the WebSocket."""
        self._request.cancel()
        super().handle_websocket_upgrade(event)

    def pause_writing(self) -> None:
        """Wait for a slow reader only so long."""
        super().pause_writing()
        self._reading.set(self.transport, READ_WITHIN_S)

    def resume_writing(self) -> None:
        """It reads again."""
        super().resume_writing()
        self._reading.cancel()

    def connection_lost(self, exc: Exception | None) -> None:
        """Forget it."""
        self._request.cancel()
        super().connection_lost(exc)
        self._reading.cancel()


class WebSocketConnection(WebSocketsSansIOProtocol):
    """uvicorn's WebSocket, with limits; who doesn't answer a ping is closed by uvicorn itself."""

    def __init__(self, *arguments: Any, **named: Any) -> None:
        super().__init__(*arguments, **named)
        self._reading = _Deadline(self.loop)

    def pause_writing(self) -> None:
        """Wait for a slow reader only so long."""
        super().pause_writing()
        self._reading.set(self.transport, READ_WITHIN_S)

    def resume_writing(self) -> None:
        """It reads again."""
        super().resume_writing()
        self._reading.cancel()

    def connection_lost(self, exc: Exception | None) -> None:
        """Forget it."""
        self._reading.cancel()
        super().connection_lost(exc)
