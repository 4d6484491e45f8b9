"""Inputs whose port is read on a thread of its own: begun, lost, found again, ended.

`SourceWriter` writes the events of one source among several, and `EventClock` maps the times of
its device to samples of the engine.
"""

from __future__ import annotations

import math
import threading
import time
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable, Iterable, Mapping
from typing import Any, NamedTuple

from overview_dsp.devices.sensors.touching import Event, TouchRules
from overview_dsp.live.inputs.input import Input
from overview_dsp.live.ports.port import Port, PortLostError
from overview_dsp.signal.engine.engine import Engine
from overview_dsp.units import HALF_TURN

LATEST = 256
"""Arrivals that are looked at."""

IN_TIME = 0.95
"""Part of the events that is to come before its sample."""

LONGEST_WAIT_S = 0.012
"""Beyond the median: what bursts of a USB serial adapter (16 ms) and blocks of 1024 frames need. A
machine that is held up longer makes those events late, instead of all. Twice that beyond the least:
once what had piled up is worked off, nothing waits for it."""


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
        longest = LONGEST_WAIT_S * self._rate
        usual = min(order[len(order) // 2] + longest, order[0] + 2.0 * longest)
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
        held = self._engine.active_input
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


RETRY_S = 1.0


class ThreadedInput(Input, ABC):
    """Plays what a port brings into a running engine, as one source.

    Thread: control; the port is read in a thread of its own, the only writer of that source.
    """

    KIND = ""  # what messages put before the port's name
    GONE = "gone"  # what a port is that was lost

    _source: Any  # what makes events of what is read, by `rules`

    def __init__(self, engine: Engine, source: str, port: Port, where: str) -> None:
        """Before `_begin`. `source`: one of `gestures.SOURCES`; `where`: the open port's name."""
        self._engine = engine
        self._preset = engine.preset
        self._where = where
        self._port: Port | None = port  # None while it is lost
        self._writer = SourceWriter(engine, source)
        self._messages: deque[str] = deque()
        self._said: set[str] = set()
        self._heard_at = time.monotonic()
        self._lost = 0
        self._over = threading.Event()
        self._failure: Exception | None = None

    def _begin(self) -> None:
        self._thread = threading.Thread(target=self._run, name=self._name, daemon=True)
        self._thread.start()

    @property
    def _name(self) -> str:
        return self.KIND + self._where

    # --- the session's thread -------------------------------------------------------------------

    def poll(self, engine: Engine) -> None:
        """Take over a changed preset's rules; the thread does the rest.

        Raises
        ------
        Exception
            What ended the thread, if anything did.
        """
        if self._failure is not None:
            raise self._failure
        if engine.preset is not self._preset:
            self._preset = engine.preset
            self._source.rules = TouchRules.of(self._preset)

    def is_over(self, engine: Engine) -> bool:
        """Never: what is gone is waited for."""
        return False

    def close(self) -> None:
        """Let go and give the port back."""
        self._over.set()
        self._thread.join(2.0)

    def take_messages(self) -> tuple[str, ...]:
        """What a person should know, new since the last call."""
        new = [self._messages.popleft() for _ in range(len(self._messages))]
        return tuple(f"{self._name}: {one}" for one in new)

    def _line(self, state: str, counters: Mapping[str, int]) -> str:
        """A line for the play screen: a state, and the counters that aren't zero."""
        counted = ", ".join(
            f"{value} {name.replace('_', ' ')}" for name, value in counters.items() if value
        )
        return f"{self._name}: {state}; {counted or 'nothing yet'}"

    def report(self) -> dict[str, Any]:
        """Everything counted, and how long events wait for their sample, ms."""
        median, highest = self._writer.waits_s
        return {
            "port": self._where,
            "connected": self._port is not None,
            "connections_lost": self._lost,
            **self._counted(),
            "wait_p50_ms": round(1e3 * median, 2),
            "wait_p99_ms": round(1e3 * highest, 2),
        }

    @abstractmethod
    def _counted(self) -> dict[str, Any]:
        """What `report` says of the hand."""

    # --- the port's thread ----------------------------------------------------------------------

    @abstractmethod
    def _read(self, port: Port) -> None:
        """Wait a little for something to come, and hand it over; PortLostError."""

    @abstractmethod
    def _release(self) -> Event | None:
        """Let the hand go: its last event, if it held on."""

    @abstractmethod
    def _open_again(self) -> Port | None:
        """The lost port, if it is back, with everything that reads it as new."""

    def _run(self) -> None:
        try:
            while not self._over.is_set():
                if self._port is None:
                    self._over.wait(RETRY_S)
                    self._find_again()
                    continue
                try:
                    self._read(self._port)
                except PortLostError:
                    self._lose()
        except Exception as error:  # shown by the session, which polls
            self._failure = error
        self._let_go()
        self._close_port()

    def _close_port(self) -> None:
        if self._port is not None:
            self._port.close()

    def _let_go(self) -> bool:
        return self._writer.let_go(self._release())

    def _lose(self) -> None:
        self._let_go()
        self._close_port()
        self._port = None
        self._lost += 1
        self._messages.append(f"{self.GONE}; the disk is let go, waiting for it to come back")

    def _find_again(self) -> None:
        if (port := self._open_again()) is not None:
            self._writer.restart()
            self._heard_at = time.monotonic()
            self._port = port
            self._messages.append("is back")

    def _say_once(self, line: str) -> None:
        if line not in self._said:
            self._said.add(line)
            self._messages.append(line)
