"""WebSocket `/control`: control events from a page, status messages to it.

The host sends ``{"status": {...}}`` 25 times per second. Its fields are `cursor` and `touching` of
the disk, `torque_nm`, `reference_torque_nm`, the tactor's `envelope`, `active` (whether this page
controls the disk), `others` that touch (`name`, `position` 0 to 1, `active`), `window` (s) and the
name of the `preset`. The latencies are `round_trip_ms`, `event_to_sample_ms` (from the page's event
to its sample) and `output_ms` (from the sample to the device).

An invalid message or too many messages close the connection. The host releases an input when its
connection ends, or after 500 ms without an event while it touches. A page therefore repeats its
last event.

Thread: the server's.
"""

from __future__ import annotations

import asyncio
import time
from typing import TYPE_CHECKING

from starlette.websockets import WebSocket, WebSocketDisconnect

from overview_dsp.errors import InputError
from overview_dsp.web.messages import Events, Mark, Name, Pong, Show, decode_message
from overview_dsp.web.remote_inputs import SILENCE_TIMEOUT_S, RemoteInput

if TYPE_CHECKING:
    from overview_dsp.web.session import HostSession

CHECK_INTERVAL_S = 0.02
STATUS_INTERVAL_S = 0.04
PING_INTERVAL_S = 0.25
MAX_EVENTS_PER_SECOND = 2000.0
"""Twice the maximum rate of an input; as many may arrive at once."""

MAX_MESSAGES_PER_SECOND = 500.0
MALFORMED, TOO_MANY = 1007, 1008  # codes with which a connection is closed


class _RateLimit:
    """Limit on events per second; the events of one second may arrive at once."""

    def __init__(self, per_second: float) -> None:
        self._per_second = self._available = per_second
        self._updated = time.monotonic()

    def take(self, count: int = 1) -> bool:
        now = time.monotonic()
        earned = (now - self._updated) * self._per_second
        self._available = min(self._per_second, self._available + earned)
        self._updated = now
        self._available -= count
        return self._available >= 0.0


async def serve_input(websocket: WebSocket, session: HostSession) -> None:
    """Serve one page until its connection ends."""
    await websocket.accept()
    remote = session.inputs.join()
    reporting = asyncio.create_task(_report(websocket, session, remote))
    try:
        await _listen(websocket, session, remote)
    except InputError as error:
        await websocket.close(MALFORMED, str(error)[:100])
    except WebSocketDisconnect:
        pass
    finally:
        session.inputs.leave(remote)
        reporting.cancel()
        await asyncio.gather(reporting, return_exceptions=True)


async def _listen(websocket: WebSocket, session: HostSession, remote: RemoteInput) -> None:
    events, messages = _RateLimit(MAX_EVENTS_PER_SECOND), _RateLimit(MAX_MESSAGES_PER_SECOND)
    while True:
        received = await websocket.receive()
        if received["type"] != "websocket.receive":
            return
        text = received.get("text")
        if text is None:
            raise InputError("a message must be text")
        message = decode_message(text)
        count = len(message.events) if isinstance(message, Events) else 1
        if not (messages.take() and events.take(count)):
            session.inputs.release(remote)
            reason = f"more than {MAX_EVENTS_PER_SECOND:.0f} events per second"
            await websocket.close(TOO_MANY, reason)
            return
        if isinstance(message, Events):
            session.inputs.move(remote, message.events)
        elif isinstance(message, Pong):
            remote.clock.add(message.host_s, message.page_s, time.monotonic())
        elif isinstance(message, Name):
            remote.name = message.name
        elif isinstance(message, Mark):
            session.player.queue_command("mark", *message.name.split())
        elif isinstance(message, Show):
            session.show(message.start_s, message.end_s)


async def _report(websocket: WebSocket, session: HostSession, remote: RemoteInput) -> None:
    """Update clocks, release a silent input, and send pings and status."""
    inputs = session.inputs
    next_ping = next_status = 0.0
    try:
        while True:
            now = time.monotonic()
            inputs.update_clock()
            if inputs.is_silent(remote):
                inputs.release(remote)
                reason = f"no event arrived for {SILENCE_TIMEOUT_S * 1e3:.0f} ms"
                await websocket.send_json({"released": reason})
            if now >= next_ping:
                next_ping = now + PING_INTERVAL_S
                await websocket.send_json({"ping": time.monotonic()})
            if now >= next_status:
                next_status = now + STATUS_INTERVAL_S
                status = {**session.status(), **inputs.status(remote)}
                await websocket.send_json({"status": status})
            await asyncio.sleep(CHECK_INTERVAL_S)
    except (WebSocketDisconnect, RuntimeError):  # the connection was closed
        return
