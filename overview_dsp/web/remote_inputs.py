"""Inputs of pages, combined into the engine's source `remote`, and the conversion of their clocks.

The newest touch controls the disk until it ends; then the newest input that still touches takes
over. The end of a connection releases its input.

A page stamps each event with the time of the movement. The network delays each event differently.
Every event therefore waits until it is as old as the slowest event of the last seconds, which keeps
the timing of a movement.

Thread: the server's, the only writer of the engine's `remote` ring.
"""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from overview_dsp.signal.engine.engine import Engine
from overview_dsp.units import HALF_TURN
from overview_dsp.web.messages import RemoteEvent

MAX_PINGS = 40
"""The fastest of these gives the clock offset; they cover ten seconds, with little drift."""

DELAY_WINDOW_S = 2.0
MAX_DELAY_S = 0.1
"""Maximum wait of an event; older events are late."""

CLOCK_WINDOW_S = 1.0
STALLED_AFTER_S = 0.5


class PageClock:
    """Offset of a page's clock, measured by pings; each way takes half a round trip."""

    def __init__(self) -> None:
        self._pings: deque[tuple[float, float]] = deque(maxlen=MAX_PINGS)

    def add(self, sent_s: float, page_s: float, received_s: float) -> None:
        """Add a ping with the host's times of sending and receiving, and the page's time."""
        if received_s >= sent_s:
            self._pings.append((received_s - sent_s, page_s - 0.5 * (sent_s + received_s)))

    @property
    def round_trip_s(self) -> float | None:
        """Round trip of the last ping; None before the first answer."""
        return self._pings[-1][0] if self._pings else None

    def host_time(self, page_s: float) -> float:
        """Convert a page time to the host's clock; the error is at most half a round trip."""
        return page_s - min(self._pings)[1]


class RecentMaximum:
    """Maximum of the values of the last seconds."""

    def __init__(self, window_s: float) -> None:
        self._window_s = window_s
        self._values: deque[tuple[float, float]] = deque()

    def add(self, now_s: float, value: float) -> None:
        """Add a value."""
        # only values that can still become the maximum stay; the first is the maximum
        while self._values and self._values[-1][1] <= value:
            self._values.pop()
        self._values.append((now_s, value))
        while self._values[0][0] < now_s - self._window_s:
            self._values.popleft()

    @property
    def value(self) -> float:
        """The maximum; 0 before the first value."""
        return self._values[0][1] if self._values else 0.0


class SampleClock:
    """Conversion between times and samples of an engine that counts in blocks.

    The sample of the current time is not yet processed; it lies in the next block.
    """

    def __init__(self, engine: Engine) -> None:
        self._engine = engine
        self._rate = engine.sample_rate
        self._offset = RecentMaximum(CLOCK_WINDOW_S)
        self._last = (-1, 0.0)

    def update(self, now_s: float) -> None:
        """Read the engine's sample count; call it often."""
        sample = self._engine.sample_time
        if sample < self._last[0]:  # the engine was reset
            self._offset = RecentMaximum(CLOCK_WINDOW_S)
        if sample != self._last[0]:
            self._last = (sample, now_s)
        self._offset.add(now_s, sample - self._rate * now_s)

    def is_running(self, now_s: float) -> bool:
        """Return whether the engine processes samples."""
        return now_s - self._last[1] < STALLED_AFTER_S

    def sample_at(self, time_s: float) -> int:
        """Return the sample of a time of the host's clock."""
        return round(self._rate * time_s + self._offset.value)

    def time_of(self, sample: int) -> float:
        """Return the time of a sample."""
        return (sample - self._offset.value) / self._rate


SOURCE = "remote"
SILENCE_TIMEOUT_S = 0.5
"""An input that touches is released after this time without a message."""


@dataclass(eq=False)
class RemoteInput:
    """Input of one page, with its clock."""

    theta2: float = 0.0
    touching: bool = False
    last_message_s: float = 0.0
    touch_number: int = 0
    """Number of its last touch; the highest is the newest."""
    name: str = ""
    """Name that the page sent."""
    event_to_sample_s: float | None = None
    """Time from the page's event to its sample."""
    clock: PageClock = field(default_factory=PageClock)
    delay: RecentMaximum = field(default_factory=lambda: RecentMaximum(DELAY_WINDOW_S))
    """Common age of its events, which keeps the intervals between them."""


class RemoteInputs:
    """The inputs of all pages on one engine."""

    def __init__(self, engine: Engine, clock: Callable[[], float] = time.monotonic) -> None:
        self._engine = engine
        self._now = clock
        self._samples = SampleClock(engine)
        self._inputs: list[RemoteInput] = []
        self._active: RemoteInput | None = None
        self._touches = 0
        self._last_stamp = 0
        self.update_clock()

    def update_clock(self) -> None:
        """Update the engine's sample clock; call it often."""
        self._samples.update(self._now())

    def join(self) -> RemoteInput:
        """Add the input of a new page."""
        remote = RemoteInput(last_message_s=self._now())
        self._inputs.append(remote)
        return remote

    def leave(self, remote: RemoteInput) -> None:
        """Release and remove the input of a page."""
        self.release(remote)
        self._inputs.remove(remote)

    def is_silent(self, remote: RemoteInput) -> bool:
        """Return whether an input touches but has sent nothing for too long."""
        return remote.touching and self._now() - remote.last_message_s > SILENCE_TIMEOUT_S

    def status(self, remote: RemoteInput) -> dict[str, Any]:
        """Return the state of an input, and of the others that touch, for its page."""
        return {
            "active": remote is self._active,
            "others": [
                {
                    "name": one.name,
                    "position": round(one.theta2 / HALF_TURN, 4),
                    "active": one is self._active,
                }
                for one in self._inputs
                if one.touching and one is not remote
            ],
            "round_trip_ms": _ms(remote.clock.round_trip_s),
            "event_to_sample_ms": _ms(remote.event_to_sample_s),
        }

    def move(self, remote: RemoteInput, events: tuple[RemoteEvent, ...]) -> None:
        """Apply the events of an input in order."""
        now = remote.last_message_s = self._now()
        self.update_clock()
        for event in events:
            stamp = self._stamp(remote, event, now)
            self._apply(remote, event.theta2, event.touching, stamp)

    def release(self, remote: RemoteInput) -> None:
        """Release an input as soon as possible."""
        if remote.touching:
            self.update_clock()
            self._apply(remote, remote.theta2, False, self._engine.sample_time)

    def _stamp(self, remote: RemoteInput, event: RemoteEvent, now: float) -> int:
        """Return the sample of an event, within the near future."""
        event_s = now
        if remote.clock.round_trip_s is not None:
            # a page's clock may be wrong
            event_s = min(max(remote.clock.host_time(event.time_s), now - 1.0), now)
        remote.delay.add(now, min(max(now - event_s, 0.0), MAX_DELAY_S))
        due = min(max(event_s + remote.delay.value, now), now + MAX_DELAY_S)
        stamp = max(self._samples.sample_at(due), self._engine.sample_time)
        remote.event_to_sample_s = self._samples.time_of(stamp) - event_s
        return stamp

    def _apply(self, remote: RemoteInput, theta2: float, touching: bool, stamp: int) -> None:
        is_new = touching and not remote.touching
        remote.theta2, remote.touching = theta2, touching
        if is_new:
            self._touches += 1
            remote.touch_number = self._touches
            if self._active is not None:  # the disk steps to a new touch
                self._push(self._active.theta2, False, stamp)
            self._active = remote
        if remote is not self._active:
            return
        if touching:
            self._push(theta2, True, stamp)
            return
        touching_inputs = [one for one in self._inputs if one.touching]
        self._active = max(touching_inputs, key=lambda one: one.touch_number, default=None)
        self._push((self._active or remote).theta2, self._active is not None, stamp)

    def _push(self, theta2: float, touching: bool, stamp: int) -> None:
        """Push an event into the ring; while the engine is stopped, only releases."""
        if touching and not self._samples.is_running(self._now()):
            return
        # the ring is read in order, so times must not decrease
        stamp = self._last_stamp = max(stamp, self._last_stamp)
        self._engine.control(theta2, touching, stamp, SOURCE)


def _ms(seconds: float | None) -> float | None:
    return None if seconds is None else round(seconds * 1e3, 2)
