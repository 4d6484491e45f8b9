"""One source among several on a running engine: what the others do, and its own events, stamped."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable
from typing import NamedTuple

from overview_dsp.devices.sensors.touching import Event
from overview_dsp.live.event_clock import EventClock
from overview_dsp.signal.engine.engine import Engine
from overview_dsp.units import HALF_TURN

STALLED_S = 0.5
"""An engine that has stood still for so long has lost its output."""

YIELDING = ("serial", "osc", "midi")
"""Sources that a turned device takes over from: what holds there may never let go by itself."""


class Found(NamedTuple):
    """What a source finds: theta2 (rad) of another one that holds the disk, or None; where the disk
    is, as theta2 (rad); whether that other one yields to a turn."""

    elsewhere: float | None
    position: float
    yields: bool


class SourceWriter:
    """Writes the ring of one source.

    Thread: its input's, the only one that writes that source.
    """

    def __init__(
        self, engine: Engine, source: str, now: Callable[[], float] = time.monotonic
    ) -> None:
        """`source`: one of `gestures.SOURCES`; `now`: a clock, s."""
        self._engine = engine
        self._source = source
        self._now = now
        self.restart()
        self._ran = (-1, now())

    def find(self) -> Found:
        """How the disk is, as of the last block."""
        held = self._engine.holder
        position = self._engine.meters.cursor * HALF_TURN
        if held is None or held[0] == self._source:
            return Found(None, position, False)
        return Found(held[1], position, held[0] in YIELDING)

    def _runs(self) -> bool:
        """Whether the engine takes events: while its output is lost they would be stale."""
        now, sample = self._now(), self._engine.sample_time
        last, since = self._ran
        if sample == last:
            return now - since < STALLED_S
        if now - since >= STALLED_S or sample < last:  # or it has begun anew
            self.restart()
        self._ran = (sample, now)
        return True

    def restart(self) -> None:
        """What came until now says nothing of when things will come."""
        self._clock = EventClock(self._engine.sample_rate)
        self._saw = False

    def saw(self, time_s: float) -> None:
        """Something of `time_s`, of the source's own clock, has just come."""
        if self._runs():
            self._saw = True
            self._clock.saw(time_s, self._engine.sample_time)

    def write(self, events: Iterable[Event]) -> None:
        """Hand events over, each at its time; where the engine stands still, only what lets go."""
        runs, sample = self._runs(), self._engine.sample_time
        for event in events:
            if not runs:
                self.let_go(None if event.touching else event)
                continue
            stamp = self._clock.stamp(event.time_s, sample) if self._saw else None
            if event.again:
                self._push(event.theta2, False, stamp)
            self._push(event.theta2, event.touching, stamp)

    def let_go(self, event: Event | None) -> bool:
        """Hand over a release, as soon as possible; whether there was one."""
        if event is not None:
            self._push(event.theta2, False, None)
        return event is not None

    def _push(self, theta2: float, touching: bool, stamp: int | None) -> None:
        self._engine.control(theta2, touching, stamp, self._source)

    @property
    def waits_s(self) -> tuple[float, float]:
        """How long events wait for their sample, s: median and 99 % point of the latest."""
        return self._clock.added_latency_s
