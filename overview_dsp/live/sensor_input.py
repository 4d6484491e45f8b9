"""A sensor on a serial port as a hand: its own thread reads, decodes and hands events over."""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable
from typing import Any, Protocol

from overview_dsp.engine import Engine
from overview_dsp.errors import InputError
from overview_dsp.live.event_clock import EventClock
from overview_dsp.live.player import Input
from overview_dsp.live.serial_port import PortLostError, SerialPort, find_again, identity_of
from overview_dsp.presets.model import Preset
from overview_dsp.sensors.hand import Hand
from overview_dsp.sensors.profile import Sensor
from overview_dsp.sensors.touching import Event, TouchRules
from overview_dsp.units import HALF_TURN

MOST = 16_384
"""Bytes read at a time; of more, the latest."""

SILENT_S = 0.3
"""A sensor that says nothing for so long lets go."""

RETRY_S = 1.0

STALLED_S = 0.5
"""An engine that has stood still for so long has lost its output."""


class Port(Protocol):
    """Where bytes come from: a serial port, or a test's."""

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
        self._clock = EventClock(engine.sample_rate)
        self._messages: deque[str] = deque()
        self._heard_at = time.monotonic()
        self._silent = False
        self._ran = (-1, self._heard_at)
        self._lost = 0
        self._theta2 = 0.0
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
        messages = []
        while self._messages:
            messages.append(self._messages.popleft())
        return (*messages, *(f"serial:{self._device}: {one}" for one in self._hand.take_messages()))

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
        median, highest = self._clock.added_latency_s
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
                data = self._port.read()
            except PortLostError:
                self._lose()
                continue
            self._take(data)

    def _take(self, data: bytes) -> None:
        now = time.monotonic()
        if not data:
            if now - self._heard_at > SILENT_S and not self._silent:
                self._silent = True
                if self._let_go():
                    self._messages.append(
                        f"serial:{self._device}: silent for {SILENT_S:g} s; the disk is let go"
                    )
            return
        self._heard_at, self._silent = now, False
        if len(data) > MOST:
            self._hand.counters.overrun_bytes += len(data) - MOST
            data = data[-MOST:]
        engine = self._engine
        held = engine.holder
        elsewhere = held[1] if held is not None and held[0] != self.SOURCE else None
        before = self._hand.turn
        events = self._hand.feed(data, now, elsewhere, engine.meters.cursor * HALF_TURN)
        sample = engine.sample_time
        turn = self._hand.turn
        runs = self._runs(sample, now)
        if turn is not None and turn is not before:
            self._clock.saw(turn.time_s, sample)
        if runs:
            for event in events:
                self._push(event, self._clock.stamp(event.time_s, sample))

    def _runs(self, sample: int, now: float) -> bool:
        """Whether the engine takes events: while its output is lost they would be stale."""
        last, since = self._ran
        if sample == last:
            return now - since < STALLED_S
        if now - since >= STALLED_S:
            self._clock = EventClock(self._engine.sample_rate)
        self._ran = (sample, now)
        return True

    def _push(self, event: Event, stamp: int | None) -> None:
        self._theta2 = event.theta2
        self._engine.control(event.theta2, event.touching, stamp, self.SOURCE)

    def _let_go(self) -> bool:
        event = self._hand.release()
        if event is not None:
            self._push(event, None)
        return event is not None

    def _lose(self) -> None:
        assert self._port is not None
        self._let_go()
        self._port.close()
        self._port = None
        self._lost += 1
        self._messages.append(
            f"serial:{self._device}: unplugged; the disk is let go, waiting for it to come back"
        )

    def _find_again(self) -> None:
        device = find_again(self._device, self._identity)
        try:
            port = self._open_port(device, self._baud)
        except InputError:
            return
        self._hand = Hand(self._sensor, TouchRules.of(self._preset), self._hand.counters)
        self._clock = EventClock(self._engine.sample_rate)
        self._device, self._port = device, port
        self._heard_at = time.monotonic()
        self._messages.append(f"serial:{device}: is back")
