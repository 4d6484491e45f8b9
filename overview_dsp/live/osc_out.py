"""The disk's state to another program, by OSC, from a thread of its own."""

from __future__ import annotations

import threading
import time

from overview_dsp.controllers.osc_report import OscReport
from overview_dsp.engine.engine import Engine
from overview_dsp.live.osc_port import OscSender
from overview_dsp.timeline.event import Event

EVERY_S = 0.01


class OscOut:
    """Sends what `OscReport` says, a hundred times a second.

    Thread: its own, the only one that takes the engine's strikes.
    """

    def __init__(self, engine: Engine, address: str) -> None:
        """Send to `HOST:PORT`, or to `PORT` of this machine, from now on; errors as `OscSender`."""
        self._engine = engine
        self._sender = OscSender(address)
        self._report = OscReport()
        engine.take_strikes()  # only those from now on
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._run, name=f"osc out {address}", daemon=True)
        self._thread.start()

    def _run(self) -> None:
        while not self._over.wait(EVERY_S):
            meters = self._engine.meters
            self._sender.send(
                self._report.due(
                    time.monotonic(), meters.cursor, meters.torque, meters.touching, self._struck()
                )
            )

    def _struck(self) -> list[tuple[Event, float]]:
        strikes = self._engine.take_strikes().of_events()
        events = self._engine.timeline.events
        return [
            (events[index], float(level))
            for index, level in zip(strikes.event, strikes.level, strict=True)
            if index < len(events)  # else of a window that has just changed
        ]

    def close(self) -> None:
        """Send no more."""
        self._over.set()
        self._thread.join(2.0)
        self._sender.close()
