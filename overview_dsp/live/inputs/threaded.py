"""Base class of inputs whose port is read in a thread of its own, and is opened again when lost.

`SourceWriter` writes the events of one source among several, and `EventClock` converts the times of
its device to samples of the engine.
"""

from __future__ import annotations

import math
import threading
import time
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable, Iterable, Mapping
from typing import Any

from overview_dsp.devices.messages import Messages
from overview_dsp.devices.sensors.touch_detection import DiskState, Event, TouchRules
from overview_dsp.live.inputs.input import Input
from overview_dsp.live.ports.port import Port, PortLostError
from overview_dsp.signal.engine.engine import Engine
from overview_dsp.units import HALF_TURN

ARRIVALS_KEPT = 256
"""Number of latest arrivals that the delay is estimated from."""

ON_TIME_SHARE = 0.95
"""Fraction of the events that should arrive before their sample."""

LONGEST_WAIT_S = 0.012
"""Maximum delay beyond the median, enough for the bursts of a USB serial adapter (16 ms) and for
blocks of 1024 frames. A longer interruption delays only its own events. The delay is also at most
twice this beyond the minimum, so that it becomes short again after an interruption."""


class EventClock:
    """Clock that stamps events so that the disk moves as evenly as the sensor did.

    An audio block applies at its start all events that have arrived. Without stamps, the samples of
    a sensor would all be applied there. So an event is applied at the sensor's time plus a delay,
    the 95th percentile of (engine time at arrival - sensor time). This includes the drift of both
    clocks, the blocks and the bursts of the port. An event that arrives after its sample is applied
    at once, and the engine counts it as late.
    """

    def __init__(self, sample_rate: float, on_time_share: float = ON_TIME_SHARE) -> None:
        """Convert to samples of an engine at `sample_rate`."""
        self._rate, self._on_time_share = sample_rate, on_time_share
        self._delays: deque[float] = deque(maxlen=ARRIVALS_KEPT)
        self._offset = 0.0
        self._last = 0
        self._waits: deque[float] = deque(maxlen=4 * ARRIVALS_KEPT)

    def observe(self, time_s: float, now: int) -> None:
        """Use the arrival of the sensor's `time_s` at the engine's sample `now`."""
        self._delays.append(now - time_s * self._rate)
        delays = sorted(self._delays)
        longest = LONGEST_WAIT_S * self._rate
        highest = min(delays[len(delays) // 2] + longest, delays[0] + 2.0 * longest)
        self._offset = min(_quantile(delays, self._on_time_share), highest)

    def stamp(self, time_s: float, now: int) -> int:
        """Return the sample at which an event of the sensor's `time_s` applies; never decreases."""
        self._last = max(self._last, math.ceil(time_s * self._rate + self._offset))
        self._waits.append(max(0, self._last - now) / self._rate)
        return self._last

    @property
    def added_latency_s(self) -> tuple[float, float]:
        """Wait of the latest events for their sample: median and 99th percentile, s."""
        if not self._waits:
            return 0.0, 0.0
        waits = sorted(self._waits)
        return _quantile(waits, 0.5), _quantile(waits, 0.99)


MAX_SLEW = 1e-4
"""Largest rate at which the samples of time tags follow the output's clock, which drifts less."""


class TagClock:
    """Clock that gives each time the same distance from its sample, whatever the block.

    A tag that is sent a block and 10 ms ahead is in time. The map from times to samples follows the
    latest blocks so slowly that the spacing of tags is kept to a sample.
    """

    def __init__(self, sample_rate: float) -> None:
        """Convert to samples of an engine at `sample_rate`."""
        self._rate = sample_rate
        self._seen: deque[float] = deque(maxlen=ARRIVALS_KEPT)
        self._offset = self._at_s = 0.0

    def observe(self, now_s: float, sample: int) -> None:
        """Use that the engine has reached `sample` at the time `now_s`."""
        most = MAX_SLEW * self._rate * (now_s - self._at_s) if self._seen else math.inf
        self._seen.append(sample - now_s * self._rate)
        self._offset += min(max(max(self._seen) - self._offset, -most), most)
        self._at_s = now_s

    def stamp(self, time_s: float) -> int:
        """Return the sample of a time."""
        return math.ceil(time_s * self._rate + self._offset)


def _quantile(ordered: list[float], part: float) -> float:
    return ordered[min(len(ordered) - 1, int(part * len(ordered)))]


STALLED_S = 0.5
"""Time without progress after which the engine has lost its output."""

YIELDING = ("serial", "osc", "midi")
"""Sources that a turned device takes over from, because they may never release by themselves."""


class SourceWriter:
    """Writer of the control events of one source.

    Thread: that of its input, the only one that writes this source.
    """

    def __init__(
        self,
        engine: Engine,
        source: str,
        now: Callable[[], float] = time.monotonic,
        smooth_s: float | None = None,
    ) -> None:
        """Write `source`, one of `gestures.SOURCES`; `now` is a clock in s.

        With a `smooth_s` of 0, events apply at the next block. Other events apply at their own
        time plus a delay, to which `smooth_s` is added.
        """
        self._stamps = smooth_s != 0.0
        self._smooth_s = smooth_s or 0.0
        self._engine = engine
        self._source = source
        self._now = now
        self.restart()
        self._ran = (-1, now())

    def disk_state(self) -> DiskState:
        """Return the state of the disk at the last block."""
        held = self._engine.active_input
        position = self._engine.meters.cursor * HALF_TURN
        if held is None or held[0] == self._source:
            return DiskState(None, position)
        return DiskState(held[1], position, held[0] in YIELDING)

    def _runs(self) -> bool:
        """Return whether the engine runs; without an output events would be applied too late."""
        now, sample = self._now(), self._engine.sample_time
        last, since = self._ran
        if sample == last:
            return now - since < STALLED_S
        if now - since >= STALLED_S or sample < last:  # the output is back, or the engine restarted
            self.restart()
        self._ran = (sample, now)
        return True

    def restart(self) -> None:
        """Discard the observed arrivals, which don't predict later ones."""
        # for even movement, the highest of the delays is steadier
        self.tags = TagClock(self._engine.sample_rate)
        self.clock = EventClock(self._engine.sample_rate, 1.0 if self._smooth_s else ON_TIME_SHARE)
        self._observed = False

    def observe(self, time_s: float) -> None:
        """Use the arrival of data that the source's own clock stamped with `time_s`."""
        if self._runs() and self._stamps:
            self._observed = True
            self.clock.observe(time_s, self._engine.sample_time)

    def write(self, events: Iterable[Event]) -> None:
        """Write events, each for its time; without a running engine write only releases."""
        runs, sample = self._runs(), self._engine.sample_time
        for event in events:
            if not runs:
                self.release(None if event.touching else event)
                continue
            due_s = event.time_s + self._smooth_s
            stamp = self.clock.stamp(due_s, sample) if self._observed else None
            if event.scheduled_s is not None:
                stamp = self.tags.stamp(event.scheduled_s)
            if event.retouch:
                self._push(event.theta2, False, stamp)
            self._push(event.theta2, event.touching, stamp)

    def release(self, event: Event | None) -> bool:
        """Write a release that applies as soon as possible; return whether there was one."""
        if event is not None:
            self._push(event.theta2, False, None)
        return event is not None

    def _push(self, theta2: float, touching: bool, stamp: int | None) -> None:
        self._engine.control(theta2, touching, stamp, self._source)


RETRY_S = 1.0


class ThreadedInput(Messages, Input, ABC):
    """Input that plays the data of a port into a running engine, as one source.

    Thread: control; the port is read in a thread of its own, the only writer of that source.
    """

    KIND = ""  # prefix of the port's name in messages
    GONE = "disconnected"  # text for a port that was lost

    _source: Any  # converts what is read to events, by its `rules`

    def __init__(
        self, engine: Engine, source: str, port: Port, address: str, smooth_s: float | None = None
    ) -> None:
        """Prepare for `_start`; `source` is one of `gestures.SOURCES`, `address` the port's.

        `smooth_s` as in `SourceWriter`.
        """
        super().__init__()
        self._engine = engine
        self._preset = engine.preset
        self._address = address
        self._port: Port | None = port  # None while it is lost
        self._writer = SourceWriter(engine, source, smooth_s=smooth_s)
        self._received_at = time.monotonic()
        self._lost = 0
        self._over = threading.Event()
        self._failure: Exception | None = None

    def _start(self) -> None:
        self._thread = threading.Thread(target=self._run, name=self._name, daemon=True)
        self._thread.start()

    @property
    def _name(self) -> str:
        return self.KIND + self._address

    # --- the session's thread -------------------------------------------------------------------

    def poll(self, engine: Engine) -> None:
        """Use the rules of a changed preset; the thread does the rest.

        Exception: the thread has failed with it.
        """
        if self._failure is not None:
            raise self._failure
        if engine.preset is not self._preset:
            self._preset = engine.preset
            self._source.rules = TouchRules.of(self._preset)

    def is_over(self, engine: Engine) -> bool:
        """Return False: a lost port may return."""
        return False

    def close(self) -> None:
        """Release the disk and close the port."""
        self._over.set()
        self._thread.join(2.0)

    def take_messages(self) -> tuple[str, ...]:
        """Return messages for the user, added since the last call."""
        return tuple(f"{self._name}: {one}" for one in super().take_messages())

    def _line(self, state: str, counters: Mapping[str, int]) -> str:
        """Return a line for the play screen: a state, and the counters that aren't zero."""
        counted = ", ".join(
            f"{value} {name.replace('_', ' ')}" for name, value in counters.items() if value
        )
        return f"{self._name}: {state}; {counted or 'nothing yet'}"

    def report(self) -> dict[str, Any]:
        """Return all counters, and how long events wait for their sample, ms."""
        median, highest = self._writer.clock.added_latency_s
        return {
            "port": self._address, "connected": self._port is not None,
            "connections_lost": self._lost, **self._source_report(),
            "wait_p50_ms": round(1e3 * median, 2), "wait_p99_ms": round(1e3 * highest, 2),
        }  # fmt: skip

    @abstractmethod
    def _source_report(self) -> dict[str, Any]:
        """Return the part of `report` about the source."""

    # --- the port's thread ----------------------------------------------------------------------

    @abstractmethod
    def _read(self, port: Port) -> None:
        """Wait a short time for data, and write their events; PortLostError."""

    @abstractmethod
    def _release(self) -> Event | None:
        """End the source's touch, if any, and return the event for that."""

    @abstractmethod
    def _open_again(self) -> Port | None:
        """Return the lost port if it is available again, and reset its readers."""

    def _run(self) -> None:
        try:
            while not self._over.is_set():
                if self._port is None:
                    self._over.wait(RETRY_S)
                    self._reconnect()
                    continue
                try:
                    self._read(self._port)
                except PortLostError:
                    self._lose()
        except Exception as error:  # shown by the session, which polls
            self._failure = error
        self._write_release()
        self._close_port()

    def _close_port(self) -> None:
        if self._port is not None:
            self._port.close()

    def _write_release(self) -> bool:
        return self._writer.release(self._release())

    def _lose(self) -> None:
        self._write_release()
        self._close_port()
        self._port = None
        self._lost += 1
        self.say(f"{self.GONE}; disk released, waiting for the device")

    def _reconnect(self) -> None:
        if (port := self._open_again()) is not None:
            self._writer.restart()
            self._received_at = time.monotonic()
            self._port = port
            self.say("reconnected")
