"""Inputs of pages, combined into the engine's source `remote`.

The newest touch controls the disk until it ends; then the newest input that still touches takes
over. The end of a connection releases its input.

Thread: the server's, the only writer of the engine's `remote` ring.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass

from overview_dsp.signal.engine.engine import Engine
from overview_dsp.web.clocks import MAX_DELAY_S, Delay, PageClock, SampleClock
from overview_dsp.web.messages import RemoteEvent

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

    def __post_init__(self) -> None:
        self.clock = PageClock()
        self.delay = Delay()


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

    def is_active(self, remote: RemoteInput) -> bool:
        """Return whether this input is the active one among the pages."""
        return remote is self._active

    def others_touching(self, remote: RemoteInput) -> list[RemoteInput]:
        """Return the other inputs that touch."""
        return [one for one in self._inputs if one.touching and one is not remote]

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
        if remote.clock.is_synchronised:
            # a page's clock may be wrong
            event_s = min(max(remote.clock.host_time(event.time_s), now - 1.0), now)
        wait = remote.delay.add(now, now - event_s)
        due = min(max(event_s + wait, now), now + MAX_DELAY_S)
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
        if self._active is None:
            self._push(theta2, False, stamp)
        else:
            self._push(self._active.theta2, True, stamp)

    def _push(self, theta2: float, touching: bool, stamp: int) -> None:
        """Push an event into the ring; while the engine is stopped, only releases."""
        if touching and not self._samples.is_running(self._now()):
            return
        # the ring is read in order, so times must not decrease
        stamp = self._last_stamp = max(stamp, self._last_stamp)
        self._engine.control(theta2, touching, stamp, SOURCE)
