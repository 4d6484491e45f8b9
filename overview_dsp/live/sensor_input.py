"""A sensor on a serial port as a hand: its own thread reads, decodes and hands events over."""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable
from typing import Any, Protocol

from overview_dsp.engine.engine import Engine
from overview_dsp.errors import InputError
from overview_dsp.live.hand_writer import HandWriter
from overview_dsp.live.player import Input
from overview_dsp.live.port_lost import PortLostError
from overview_dsp.live.serial_port import SerialPort, find_again, identity_of
from overview_dsp.presets.model import Preset
from overview_dsp.sensors.diagnostics import Trouble
from overview_dsp.sensors.profile import Sensor
from overview_dsp.sensors.source import Hand
from overview_dsp.sensors.touching import TouchRules
from overview_dsp.units import HALF_TURN

MOST = 16_384
"""Bytes read at a time; of more, the latest."""

BEHIND_S, BEHIND_READS = 0.1, 5
"""Who finds more waiting after each read, for so long and so often, doesn't keep up: what waits is
given up. Once may be a machine that had other things to do."""

SILENT_S = 0.3
"""A sensor of which nothing is understood for so long lets go."""

RETRY_S = 1.0


class Port(Protocol):
    """Where bytes come from: a serial port, or a test's."""

    @property
    def waiting(self) -> int:
        """Bytes that have come and haven't been read."""

    def read(self) -> bytes:
        """What has come; PortLostError if nothing more will."""

    def close(self) -> None:
        """Give it back."""


class SensorInput(Input):
    """Plays a sensor into a running engine, as source `serial`.

    Thread: control; the port is read in a thread of its own, the only writer of that source.
    """

    SOURCE = "serial"

    def __init__(
        self,
        engine: Engine,
        device: str,
        sensor: Sensor,
        baud: int | None = None,
        open_port: Callable[[str, int], Port] = SerialPort,
    ) -> None:
        """Open the port and begin; `open_port` is called again when it is lost.

        Raises
        ------
        InputError
            The port can't be opened.
        """
        self._engine = engine
        self._device = device
        self._sensor = sensor
        self._baud = baud if baud is not None else round(sensor.number("stream.baud"))
        self._open_port = open_port
        self._identity = identity_of(device)
        self._port: Port | None = open_port(device, self._baud)
        self._preset: Preset = engine.preset
        self._hand = Hand(sensor, TouchRules.of(self._preset))
        self._trouble = Trouble()
        self._writer = HandWriter(engine, self.SOURCE)
        self._messages: deque[str] = deque()
        self._heard_at = self._understood_at = time.monotonic()
        self._kept_up_at, self._behind = self._heard_at, 0
        self._silent = False
        self._missing = ""
        self._lost = 0
        self._over = threading.Event()
        self._failure: Exception | None = None
        self._thread = threading.Thread(target=self._run, name=f"serial:{device}", daemon=True)
        self._thread.start()

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
            self._hand.rules = TouchRules.of(self._preset)

    def is_over(self, engine: Engine) -> bool:
        """Never: an unplugged sensor is waited for."""
        return False

    def close(self) -> None:
        """Let go and give the port back."""
        self._over.set()
        self._thread.join(2.0)

    def take_messages(self) -> tuple[str, ...]:
        """What a person should know, new since the last call."""
        said = self._hand.take_messages()
        while self._messages:
            said += (self._messages.popleft(),)
        return tuple(f"serial:{self._device}: {one}" for one in said)

    @property
    def words(self) -> str:
        """A line for the play screen: what it is, its angle, the counters that aren't zero."""
        report = self._hand.report()
        counted = ", ".join(
            f"{value} {name.replace('_', ' ')}"
            for name, value in vars(self._hand.counters).items()
            if value and name != "received_bytes"
        )
        angle = report["theta2_rad"]
        place = "" if angle is None else f", {180.0 * angle / HALF_TURN:.0f}°"
        hold = ", holding" if self._hand.holding else ""
        state = "unplugged" if self._port is None else report["told"] or "listening"
        return f"serial:{self._device}: {state}{place}{hold}; {counted or 'nothing yet'}"

    def report(self) -> dict[str, Any]:
        """Everything counted, and how long events wait for their sample, ms."""
        median, highest = self._writer.waits_s
        return {
            "port": self._device,
            "connected": self._port is not None,
            "connections_lost": self._lost,
            **self._hand.report(),
            "wait_p50_ms": round(1e3 * median, 2),
            "wait_p99_ms": round(1e3 * highest, 2),
        }

    # --- the port's thread ----------------------------------------------------------------------

    def _run(self) -> None:
        try:
            self._read()
        except Exception as error:  # shown by the session, which polls
            self._failure = error
        self._let_go()
        if self._port is not None:
            self._port.close()

    def _read(self) -> None:
        while not self._over.is_set():
            if self._port is None:
                self._over.wait(RETRY_S)
                self._find_again()
                continue
            try:
                self._take(self._port.read())
                self._keep_up(self._port)
            except PortLostError:
                self._lose()

    def _take(self, data: bytes) -> None:
        now = time.monotonic()
        counters = self._hand.counters
        if data:
            self._heard_at = now
        if len(data) > MOST:
            counters.overrun_bytes += len(data) - MOST
            data = data[-MOST:]
        before, understood = self._hand.turn, counters.readings - counters.repeated
        elsewhere, place, yields = self._writer.find()
        events = self._hand.feed(data, now, elsewhere, place, yields) if data else []
        turn = self._hand.turn
        if turn is not None and turn is not before:
            self._writer.saw(turn.time_s)
        self._writer.write(events)
        self._messages.extend(self._trouble.new(counters))
        if counters.readings - counters.repeated > understood:
            self._understood_at, self._silent = now, False
        elif now - self._understood_at > SILENT_S and not self._silent:
            self._silent = True
            self._fall_silent(now - self._heard_at > SILENT_S)

    def _keep_up(self, port: Port) -> None:
        now = time.monotonic()
        self._behind += 1
        if not port.waiting:
            self._kept_up_at, self._behind = now, 0
        elif now - self._kept_up_at > BEHIND_S and self._behind >= BEHIND_READS:
            self._kept_up_at, self._behind = now, 0
            while port.waiting and time.monotonic() - now < BEHIND_S:
                self._hand.counters.overrun_bytes += len(port.read())

    def _fall_silent(self, silent: bool) -> None:
        if self._let_go():
            what = "silent" if silent else "nothing new understood"
            self._messages.append(f"{what} for {SILENT_S:g} s; the disk is let go")

    def _let_go(self) -> bool:
        return self._writer.let_go(self._hand.release())

    def _lose(self) -> None:
        assert self._port is not None
        self._let_go()
        self._port.close()
        self._port = None
        self._lost += 1
        self._missing = ""
        self._messages.append("unplugged; the disk is let go, waiting for it to come back")

    def _find_again(self) -> None:
        try:
            device = find_again(self._device, self._identity)
            port = self._open_port(device, self._baud)
        except InputError as error:
            why = str(error).removeprefix(f"serial:{self._device}: ")
            if why != self._missing and "no such port" not in why:
                self._messages.append(f"{why} (waiting)")
            self._missing = why
            return
        self._hand = Hand(self._sensor, TouchRules.of(self._preset), self._hand.counters)
        self._writer.restart()
        self._device, self._port = device, port
        self._heard_at = self._understood_at = self._kept_up_at = time.monotonic()
        self._behind = 0
        self._messages.append("is back")
