"""An input's thread in a time that a test makes go on: no machine is too slow for it."""

from __future__ import annotations

import functools
import threading

from overview_dsp.live.inputs import sensors, threaded
from overview_dsp.live.ports.port import PortLostError


class SteppedTime:
    """In place of `time` in the input's modules: it goes on when it is told."""

    def __init__(self):
        self.now = 1000.0

    def monotonic(self):
        return self.now


class SteppedPort:
    """Gives the input's thread what a test puts in; the test waits until that is worked off."""

    waiting = 0

    def __init__(self):
        self._changed = threading.Condition()
        self._given, self._reads = b"", False
        self.lost = self.closed = False

    def step(self, data=b""):
        """Have `data` read now; returns when all that follows from it is done."""
        with self._changed:
            assert self._changed.wait_for(lambda: self._reads, 30.0)
            self._given, self._reads = data, False
            self._changed.notify_all()
            assert self._changed.wait_for(lambda: self._reads, 30.0)

    def receive(self, wait_s):
        with self._changed:
            self._reads = True
            self._changed.notify_all()
            # now and then without a step, as a port: an input that is closed looks up
            self._changed.wait_for(lambda: not self._reads, 0.02)
            self._reads = False
            if self.lost:
                raise PortLostError("gone")
            data, self._given = self._given, b""
            return [data] if data else []

    def close(self):
        self.closed = True


def use(clock, monkeypatch):
    """Have the inputs opened from now on live in this time."""
    for module in (sensors, threaded):
        monkeypatch.setattr(module, "time", clock)
    timed = functools.partial(threaded.SourceWriter, now=clock.monotonic)
    monkeypatch.setattr(threaded, "SourceWriter", timed)
    monkeypatch.setattr(threaded, "RETRY_S", 0.01)  # a real wait
