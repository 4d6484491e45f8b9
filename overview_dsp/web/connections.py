"""Connections that are too many or too slow are closed, before they cost anything.

A browser opens six and a WebSocket. Waiting for requests that never come, or for readers that never
read, would let anyone in the network keep the owner out.

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


class HttpConnection(H11Protocol):
    """uvicorn's HTTP/1.1, with limits."""

    def __init__(self, *arguments: Any, **named: Any) -> None:
        super().__init__(*arguments, **named)
        self._request = _Deadline(self.loop)
        self._reading = _Deadline(self.loop)

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """Close at once what is too many; wait a little for a request."""
        super().connection_made(transport)
        whose = self.client[0] if self.client else ""
        clients = [getattr(one, "client", None) for one in self.connections]
        same = [client for client in clients if client is not None and client[0] == whose]
        if len(self.connections) > MAX_CONNECTIONS or len(same) > MAX_OF_AN_ADDRESS:
            transport.abort()
            return
        self._request.set(transport, REQUEST_WITHIN_S)

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
        if self.transport.is_closing():
            self._request.cancel()
        elif self.conn.their_state is h11.IDLE:
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
