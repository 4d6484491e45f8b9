"""Three clocks: the page's, the host's, and the engine's samples.

An event is stamped by the page when the finger moved; the network delays each by another amount.
So that a movement keeps its course, every event waits until it is as old as the slowest one of the
last seconds was when it came: then its sample is where the finger was, only later.

Thread: the server's.
"""

from __future__ import annotations

from collections import deque

from overview_dsp.signal.engine.engine import Engine

PINGS_KEPT = 40
"""The quickest of these gives the clocks' offset: ten seconds, in which clocks drift by little."""

DELAY_KEPT_S = 2.0
MAX_DELAY_S = 0.1
"""No event waits longer: what comes later than that is late."""

LOOKS_KEPT_S = 1.0
STALLED_AFTER_S = 0.5


class PageClock:
    """What a page's clock shows, by pings: half a round trip is taken for each way."""

    def __init__(self) -> None:
        self._pings: deque[tuple[float, float]] = deque(maxlen=PINGS_KEPT)

    def note(self, sent_s: float, page_s: float, received_s: float) -> None:
        """A ping left at `sent_s`, was answered at `page_s` of the page, and came back."""
        if received_s >= sent_s:
            self._pings.append((received_s - sent_s, page_s - 0.5 * (sent_s + received_s)))

    @property
    def known(self) -> bool:
        """Whether a ping has been answered."""
        return bool(self._pings)

    @property
    def round_trip_s(self) -> float | None:
        """Of the last ping."""
        return self._pings[-1][0] if self._pings else None

    def host_time(self, page_s: float) -> float:
        """A moment of the page's clock on the host's; off by at most half the shortest trip."""
        return page_s - min(self._pings)[1]


class _Highest:
    """The highest value of the last seconds."""

    def __init__(self, kept_s: float) -> None:
        self._kept_s = kept_s
        self._values: deque[tuple[float, float]] = deque()

    def note(self, now_s: float, value: float) -> None:
        """One more."""
        # only those that may yet be the highest are kept: the first one is
        while self._values and self._values[-1][1] <= value:
            self._values.pop()
        self._values.append((now_s, value))
        while self._values[0][0] < now_s - self._kept_s:
            self._values.popleft()

    @property
    def value(self) -> float:
        """It; 0 before the first."""
        return self._values[0][1] if self._values else 0.0


class Delay:
    """How long events wait, so that late and early ones keep their distance."""

    def __init__(self) -> None:
        self._age = _Highest(DELAY_KEPT_S)

    def note(self, now_s: float, age_s: float) -> float:
        """An event came `age_s` after it happened; how old all are made to be."""
        self._age.note(now_s, min(max(age_s, 0.0), MAX_DELAY_S))
        return self.seconds

    @property
    def seconds(self) -> float:
        """How old events are when they act."""
        return self._age.value


class SampleClock:
    """Which sample belongs to a moment: the engine counts by blocks, this is the line above them.

    A sample of this clock isn't processed yet when its moment comes, and is in the next block.
    """

    def __init__(self, engine: Engine) -> None:
        self._engine = engine
        self._rate = engine.sample_rate
        self._ahead = _Highest(LOOKS_KEPT_S)
        self._last = (-1, 0.0)

    def look(self, now_s: float) -> None:
        """Read the engine's count; often."""
        sample = self._engine.sample_time
        if sample < self._last[0]:  # the engine has begun anew
            self._ahead = _Highest(LOOKS_KEPT_S)
        if sample != self._last[0]:
            self._last = (sample, now_s)
        self._ahead.note(now_s, sample - self._rate * now_s)

    def runs(self, now_s: float) -> bool:
        """Whether samples are being processed."""
        return now_s - self._last[1] < STALLED_AFTER_S

    def sample_at(self, time_s: float) -> int:
        """The sample of a moment of the host's clock."""
        return round(self._rate * time_s + self._ahead.value)

    def time_of(self, sample: int) -> float:
        """The moment of a sample."""
        return (sample - self._ahead.value) / self._rate
