"""A sensor on a serial port as a source: its own thread reads, decodes and hands events over."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

from overview_dsp.devices.sensors.profile import Sensor
from overview_dsp.devices.sensors.source import Diagnostics, SensorSource
from overview_dsp.devices.sensors.touch_detection import Event, TouchRules
from overview_dsp.errors import InputError
from overview_dsp.live.inputs.threaded import ThreadedInput
from overview_dsp.live.ports.port import WAIT_S, Port
from overview_dsp.live.ports.serial import SerialPort, find_again, identity_of
from overview_dsp.signal.engine.engine import Engine
from overview_dsp.units import HALF_TURN

MOST = 16_384
"""Bytes read at a time; of more, the latest."""

BEHIND_S, BEHIND_READS = 0.1, 5
"""Who finds more waiting after each read, for so long and so often, doesn't keep up: what waits is
given up. Once may be a machine that had other things to do."""

SILENT_S = 0.3
"""A sensor of which nothing is understood for so long lets go."""


class SensorInput(ThreadedInput):
    """Plays a sensor into a running engine, as source `serial`.

    Thread: as `ThreadedInput`.
    """

    SOURCE = "serial"
    KIND = "serial:"
    GONE = "unplugged"
    WAIT_S = WAIT_S  # for bytes to come, before what time alone changes is looked after

    _source: SensorSource

    def __init__(
        self,
        engine: Engine,
        device: str,
        sensor: Sensor,
        baud: int | None = None,
        open_port: Callable[[str, int], Port] = SerialPort,
        silent_s: float = SILENT_S,
    ) -> None:
        """Open the port and begin; `open_port` is called again when it is lost.

        What says nothing that is understood for `silent_s` lets go.

        Raises
        ------
        InputError
            The port can't be opened.
        """
        self._sensor = sensor
        self._baud = baud if baud is not None else round(sensor.number("stream.baud"))
        self._open_port = open_port
        self._silent_s = silent_s
        self._identity = identity_of(device)
        port = open_port(device, self._baud)
        super().__init__(engine, self.SOURCE, port, device)
        self._source = SensorSource(sensor, TouchRules.of(self._preset))
        self._diagnostics = Diagnostics()
        self._understood_at = self._heard_at
        self._kept_up_at, self._behind = self._heard_at, 0
        self._silent = False
        self._missing = ""
        self._begin()

    # --- the session's thread -------------------------------------------------------------------

    def take_messages(self) -> tuple[str, ...]:
        """What a person should know, new since the last call."""
        decoded = tuple(f"{self._name}: {one}" for one in self._source.take_messages())
        return decoded + super().take_messages()

    @property
    def words(self) -> str:
        """A line for the play screen: what it is, its angle, the counters that aren't zero."""
        report = self._source.report()
        counters = {**vars(self._source.counters), "received_bytes": 0}
        angle = report["theta2_rad"]
        position = "" if angle is None else f", {180.0 * angle / HALF_TURN:.0f}°"
        hold = ", holding" if self._source.holding else ""
        state = self.GONE if self._port is None else report["format"] or "listening"
        return self._line(f"{state}{position}{hold}", counters)

    def _counted(self) -> dict[str, Any]:
        return self._source.report()

    # --- the port's thread ----------------------------------------------------------------------

    def _read(self, port: Port) -> None:
        self._take(b"".join(port.receive(self.WAIT_S)))
        self._keep_up(port)

    def _take(self, data: bytes) -> None:
        now = time.monotonic()
        counters = self._source.counters
        if data:
            self._heard_at = now
        if len(data) > MOST:
            counters.overrun_bytes += len(data) - MOST
            data = data[-MOST:]
        before, understood = self._source.angle, counters.readings - counters.repeated
        elsewhere, position, yields = self._writer.find()
        events = self._source.feed(data, now, elsewhere, position, yields) if data else []
        turn = self._source.angle
        if turn is not None and turn is not before:
            self._writer.saw(turn.time_s)
        self._writer.write(events)
        self._messages.extend(self._diagnostics.new(counters))
        if counters.readings - counters.repeated > understood:
            self._understood_at, self._silent = now, False
        elif now - self._understood_at > self._silent_s and not self._silent:
            self._silent = True
            self._fall_silent(now - self._heard_at > self._silent_s)

    def _keep_up(self, port: Port) -> None:
        now = time.monotonic()
        self._behind += 1
        if not port.waiting:
            self._kept_up_at, self._behind = now, 0
        elif now - self._kept_up_at > BEHIND_S and self._behind >= BEHIND_READS:
            self._kept_up_at, self._behind = now, 0
            while port.waiting and time.monotonic() - now < BEHIND_S:
                self._source.counters.overrun_bytes += sum(map(len, port.receive(0.0)))

    def _fall_silent(self, silent: bool) -> None:
        if self._let_go():
            what = "silent" if silent else "nothing new understood"
            self._messages.append(f"{what} for {self._silent_s:g} s; the disk is let go")

    def _release(self) -> Event | None:
        return self._source.release()

    def _lose(self) -> None:
        super()._lose()
        self._missing = ""

    def _open_again(self) -> Port | None:
        try:
            device = find_again(self._where, self._identity)
            port = self._open_port(device, self._baud)
        except InputError as error:
            why = str(error).removeprefix(f"{self._name}: ")
            if why != self._missing and "no such port" not in why:
                self._messages.append(f"{why} (waiting)")
            self._missing = why
            return None
        self._source = SensorSource(
            self._sensor, TouchRules.of(self._preset), self._source.counters
        )
        self._where = device
        self._understood_at = self._kept_up_at = time.monotonic()
        self._behind = 0
        return port


class NamedInput(SensorInput):
    """A sensor that isn't on a serial port: a pad, a phone's app, a radio.

    Thread: as `ThreadedInput`.
    """

    GONE = "gone"

    def __init__(
        self,
        engine: Engine,
        kind: str,
        where: str,
        sensor: Sensor,
        open_port: Callable[[str], Port],
        silent_s: float = SILENT_S,
    ) -> None:
        """As `SensorInput`; `kind` is what `--input` puts before where it is."""
        self.KIND = f"{kind}:"
        super().__init__(engine, where, sensor, None, lambda name, _: open_port(name), silent_s)
