"""Conversion from page clocks to engine samples.

A page stamps each event with the time of the movement. The network delays each event differently.
Every event therefore waits until it is as old as the slowest event of the last seconds, which keeps
the timing of a movement.

Thread: the server's.
"""

from __future__ import annotations

from collections import deque

from overview_dsp.signal.engine.engine import Engine

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
    def is_synchronised(self) -> bool:
        """True after the first answered ping."""
        return bool(self._pings)

    @property
    def round_trip_s(self) -> float | None:
        """Round trip of the last ping; None before the first."""
        return self._pings[-1][0] if self._pings else None

    def host_time(self, page_s: float) -> float:
        """Convert a page time to the host's clock; the error is at most half a round trip."""
        return page_s - min(self._pings)[1]


class _RecentMaximum:
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


class Delay:
    """Common age of events, which keeps the intervals between them."""

    def __init__(self) -> None:
        self._age = _RecentMaximum(DELAY_WINDOW_S)

    def add(self, now_s: float, age_s: float) -> float:
        """Add the age of an event on arrival; return the common age."""
        self._age.add(now_s, min(max(age_s, 0.0), MAX_DELAY_S))
        return self._age.value


class SampleClock:
    """Conversion between times and samples of an engine that counts in blocks.

    The sample of the current time is not yet processed; it lies in the next block.
    """

    def __init__(self, engine: Engine) -> None:
        self._engine = engine
        self._rate = engine.sample_rate
        self._offset = _RecentMaximum(CLOCK_WINDOW_S)
        self._last = (-1, 0.0)

    def update(self, now_s: float) -> None:
        """Read the engine's sample count; call it often."""
        sample = self._engine.sample_time
        if sample < self._last[0]:  # the engine was reset
            self._offset = _RecentMaximum(CLOCK_WINDOW_S)
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
