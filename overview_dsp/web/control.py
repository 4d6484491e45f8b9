"""`/control`: a page's hand over a WebSocket, and the reports sent to it.

Twenty-five times a second it gets ``{"status": {...}}``: `cursor` and `touching` of the disk,
`torque_nm` and `full_torque_nm`, the tactor's `envelope`, `holding` (whether the disk is this
page's), `others` that touch (`name`, `place` 0 to 1, `holding`), `window` (s), the name of the
`preset`, and of latency `round_trip_ms`, `event_to_sample_ms` (from the page's event to the sample
at which it acts) and `output_ms` (from there to the device, as it says).

A message that isn't one, or too many of them, end the connection; the end of a connection lets the
disk go, and so do 500 ms without an event from a hand that touches: a page repeats its last event.

Thread: the server's.
"""

from __future__ import annotations

import asyncio
import time
from typing import Any, Protocol

from starlette.websockets import WebSocket, WebSocketDisconnect

from overview_dsp.design.presets.model import Preset
from overview_dsp.errors import InputError
from overview_dsp.units import HALF_TURN
from overview_dsp.web.hands import SILENCE_S, Hand, RemoteHands
from overview_dsp.web.messages import Events, Name, Pong, Show, decode_message

LOOK_EVERY_S = 0.02
STATUS_EVERY_S = 0.04
PING_EVERY_S = 0.25
EVENTS_A_SECOND = 2000.0
"""Twice what a hand sends at most; as many may come at once."""

MESSAGES_A_SECOND = 500.0
MALFORMED, TOO_MANY = 1007, 1008


class Session(Protocol):
    """What sounds here."""

    hands: RemoteHands

    def show(self, start_s: float, end_s: float) -> None:
        """Put a part of the timeline under the hand; InputError if it isn't one."""

    def use(self, preset: Preset) -> None:
        """Change to a preset; InputError if it can't sound here."""

    def status(self) -> dict[str, Any]:
        """How the disk is."""


class _Allowance:
    """So many a second, and as many at once."""

    def __init__(self, a_second: float) -> None:
        self._a_second = self._left = a_second
        self._at = time.monotonic()

    def take(self, count: int = 1) -> bool:
        now = time.monotonic()
        self._left = min(self._a_second, self._left + (now - self._at) * self._a_second)
        self._at = now
        self._left -= count
        return self._left >= 0.0


async def serve_hand(websocket: WebSocket, session: Session) -> None:
    """One page's hand, until its connection is over."""
    await websocket.accept()
    hand = session.hands.join()
    reporting = asyncio.create_task(_report(websocket, session, hand))
    try:
        await _listen(websocket, session, hand)
    except InputError as error:
        await websocket.close(MALFORMED, str(error)[:100])
    except WebSocketDisconnect:
        pass
    finally:
        session.hands.leave(hand)
        reporting.cancel()
        await asyncio.gather(reporting, return_exceptions=True)


async def _listen(websocket: WebSocket, session: Session, hand: Hand) -> None:
    events, messages = _Allowance(EVENTS_A_SECOND), _Allowance(MESSAGES_A_SECOND)
    while True:
        received = await websocket.receive()
        if received["type"] != "websocket.receive":
            return
        text = received.get("text")
        if text is None:
            raise InputError("a message is text")
        message = decode_message(text)
        count = len(message.events) if isinstance(message, Events) else 1
        if not (messages.take() and events.take(count)):
            session.hands.release(hand)
            await websocket.close(TOO_MANY, f"more than {EVENTS_A_SECOND:.0f} events a second")
            return
        if isinstance(message, Events):
            session.hands.move(hand, message.events)
        elif isinstance(message, Pong):
            hand.clock.note(message.host_s, message.page_s, time.monotonic())
        elif isinstance(message, Name):
            hand.name = message.name
        elif isinstance(message, Show):
            session.show(message.start_s, message.end_s)


async def _report(websocket: WebSocket, session: Session, hand: Hand) -> None:
    """Follow the clocks, watch for silence, ping, report."""
    hands = session.hands
    next_ping = next_status = 0.0
    try:
        while True:
            now = time.monotonic()
            hands.look()
            if hands.silent(hand):
                hands.release(hand)
                why = f"nothing was heard of the hand for {SILENCE_S * 1e3:.0f} ms"
                await websocket.send_json({"released": why})
            if now >= next_ping:
                next_ping = now + PING_EVERY_S
                await websocket.send_json({"ping": time.monotonic()})
            if now >= next_status:
                next_status = now + STATUS_EVERY_S
                await websocket.send_json({"status": {**session.status(), **_of(hands, hand)}})
            await asyncio.sleep(LOOK_EVERY_S)
    except (WebSocketDisconnect, RuntimeError):  # closed meanwhile
        return


def _of(hands: RemoteHands, hand: Hand) -> dict[str, Any]:
    return {
        "holding": hands.holds(hand),
        "others": [
            {
                "name": one.name,
                "place": round(one.theta2 / HALF_TURN, 4),
                "holding": hands.holds(one),
            }
            for one in hands.others(hand)
        ],
        "round_trip_ms": _ms(hand.clock.round_trip_s),
        "event_to_sample_ms": _ms(hand.event_to_sample_s),
    }


def _ms(seconds: float | None) -> float | None:
    return None if seconds is None else round(seconds * 1e3, 2)
