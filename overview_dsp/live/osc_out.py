"""The disk's state to another program, by OSC, from a thread of its own."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable

from overview_dsp.devices.controllers.osc_report import OscReport
from overview_dsp.live.osc_port import OscSender
from overview_dsp.signal.engine.engine import Engine

EVERY_S = 0.01
AGAIN_S = 1.0
"""How long it waits after an error."""


class OscOut:
    """Sends what `OscReport` says, a hundred times a second.

    Thread: its own, the only one that takes the engine's strikes.
    """

    def __init__(
        self, engine: Engine, address: str, say: Callable[[str], None] = lambda line: None
    ) -> None:
        """Send to `HOST:PORT`, or to `PORT` of this machine, from now on; errors as `OscSender`.

        `say` is told of what a person should know, from this thread.
        """
        self._engine = engine
        self._address = address
        self._say = say
        self._sender = OscSender(address)
        self._report = OscReport()
        engine.take_strikes()  # only those from now on
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._run, name=f"osc out {address}", daemon=True)
        self._thread.start()

    def _run(self) -> None:
        said = set()
        while not self._over.wait(EVERY_S):
            try:
                self._send()
            except Exception as error:  # what it is can't be known: the next report may go
                line = f"osc out {self._address}: {type(error).__name__}: {error}; it goes on"
                if line not in said:
                    said.add(line)
                    self._say(line)
                self._over.wait(AGAIN_S)

    def _send(self) -> None:
        meters = self._engine.meters
        self._sender.send(
            self._report.due(
                time.monotonic(),
                meters.cursor,
                meters.torque,
                meters.touching,
                self._engine.take_struck_events(),
            )
        )

    def close(self) -> None:
        """Send no more."""
        self._over.set()
        self._thread.join(2.0)
        self._sender.close()
