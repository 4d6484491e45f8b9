"""From a sensor's clock to the engine's samples."""

from __future__ import annotations

import math
from collections import deque

LATEST = 256
"""Arrivals that are looked at."""

IN_TIME = 0.95
"""Part of the events that is to come before its sample."""

LONGEST_WAIT_S = 0.012
"""Beyond the median: what bursts of a USB serial adapter (16 ms) and blocks of 1024 frames need. A
machine that is held up longer makes those events late, instead of all."""


class EventClock:
    """Stamps events so that the disk moves as evenly as the sensor did.

    A block of audio takes what has come by its start; without stamps, the samples of a sensor would
    be bunched there. So each is stamped as late as most need to arrive: the sensor's time plus the
    95 % point of (the engine's time at arrival - the sensor's time). Both clocks' drift, the blocks
    and the port's bursts are in it. The rest applies when it comes, and is counted by the engine as
    late.
    """

    def __init__(self, sample_rate: float) -> None:
        """For an engine at `sample_rate`."""
        self._rate = sample_rate
        self._behind: deque[float] = deque(maxlen=LATEST)
        self._offset = 0.0
        self._last = 0
        self._waits: deque[float] = deque(maxlen=4 * LATEST)

    def saw(self, time_s: float, now: int) -> None:
        """A sample of the sensor's `time_s` arrived when the engine was at sample `now`."""
        self._behind.append(now - time_s * self._rate)
        order = sorted(self._behind)
        usual = order[len(order) // 2] + LONGEST_WAIT_S * self._rate
        self._offset = min(order[min(len(order) - 1, int(IN_TIME * len(order)))], usual)

    def stamp(self, time_s: float, now: int) -> int:
        """The sample at which an event of the sensor's `time_s` applies; never goes back."""
        self._last = max(self._last, math.ceil(time_s * self._rate + self._offset))
        self._waits.append(max(0, self._last - now) / self._rate)
        return self._last

    @property
    def added_latency_s(self) -> tuple[float, float]:
        """How long events wait for their sample, s: median and 99 % point of the latest."""
        if not self._waits:
            return 0.0, 0.0
        order = sorted(self._waits)
        return order[len(order) // 2], order[min(len(order) - 1, int(0.99 * len(order)))]
