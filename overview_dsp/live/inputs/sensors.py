"""Sensor inputs, whose threads read a serial or another port and decode its data."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

from overview_dsp.devices.sensors.profile import Sensor
from overview_dsp.devices.sensors.source import FAULTS, SensorSource
from overview_dsp.devices.sensors.touch_detection import Event, TouchRules
from overview_dsp.errors import InputError
from overview_dsp.live.inputs.threaded import ThreadedInput
from overview_dsp.live.ports.port import WAIT_S, Port
from overview_dsp.live.ports.serial import SerialPort, find_device_again, usb_identity
from overview_dsp.signal.engine.engine import Engine
from overview_dsp.units import HALF_TURN

MAX_BYTES = 16_384
"""Maximum number of bytes used per read; of more, only the latest are used."""

BEHIND_S, BEHIND_READS = 0.1, 5
"""Time and number of reads after which a reader is too slow if bytes wait after each of them. The
waiting bytes are then discarded. A single busy moment of the machine has no effect."""

SILENT_S = 0.3
"""Time without a decoded reading after which the disk is released."""


class SensorInput(ThreadedInput):
    """Input that plays a sensor into a running engine, as source `serial`.

    Thread: as `ThreadedInput`.
    """

    SOURCE = "serial"
    KIND = "serial:"
    WAIT_S = WAIT_S  # longest wait for bytes

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
        """Open the port and start; `open_port` is called again when the port is lost.

        The disk is released after `silent_s` without a decoded reading.

        InputError: the port can't be opened.
        """
        self._sensor = sensor
        self._baud = baud if baud is not None else round(sensor.number("stream.baud"))
        self._open_port = open_port
        self._silent_s = silent_s
        self._identity = usb_identity(device)
        port = open_port(device, self._baud)
        super().__init__(engine, self.SOURCE, port, device)
        self._source = SensorSource(sensor, TouchRules.of(self._preset))
        self._decoded_at = self._received_at
        self._kept_up_at, self._behind = self._received_at, 0
        self._silent = False
        self._last_error = ""
        self._start()

    # --- the session's thread -------------------------------------------------------------------

    def take_messages(self) -> tuple[str, ...]:
        """Return messages for the user, added since the last call."""
        decoded = tuple(f"{self._name}: {one}" for one in self._source.take_messages())
        return decoded + super().take_messages()

    @property
    def status_text(self) -> str:
        """Line for the play screen: format, angle, and the counters that aren't zero."""
        report = self._source.report()
        counters = {**vars(self._source.counters), "received_bytes": 0}
        angle = report["theta2_rad"]
        position = "" if angle is None else f", {180.0 * angle / HALF_TURN:.0f}°"
        touch = ", touching" if self._source.holding else ""
        state = self.GONE if self._port is None else report["format"] or "listening"
        return self._line(f"{state}{position}{touch}", counters)

    def _source_report(self) -> dict[str, Any]:
        return self._source.report()

    # --- the port's thread ----------------------------------------------------------------------

    def _read(self, port: Port) -> None:
        self._process(b"".join(port.receive(self.WAIT_S)))
        now = time.monotonic()
        self._behind += 1
        if not port.waiting:
            self._kept_up_at, self._behind = now, 0
        elif now - self._kept_up_at > BEHIND_S and self._behind >= BEHIND_READS:
            self._kept_up_at, self._behind = now, 0
            while port.waiting and time.monotonic() - now < BEHIND_S:
                self._source.counters.overrun_bytes += sum(map(len, port.receive(0.0)))

    def _process(self, data: bytes) -> None:
        now = time.monotonic()
        counters = self._source.counters
        if data:
            self._received_at = now
        if len(data) > MAX_BYTES:
            counters.overrun_bytes += len(data) - MAX_BYTES
            data = data[-MAX_BYTES:]
        before, decoded = self._source.angle, counters.readings - counters.repeated
        disk = self._writer.disk_state()
        events = self._source.feed(data, now, disk) if data else []
        turn = self._source.angle
        if turn is not None and turn is not before:
            self._writer.observe(turn.time_s)
        self._writer.write(events)
        for name, message in FAULTS.items():
            if getattr(counters, name):
                self.say_once(f"{message} (later ones are only counted)")
        if counters.readings - counters.repeated > decoded:
            self._decoded_at, self._silent = now, False
        elif now - self._decoded_at > self._silent_s and not self._silent:
            self._silent = True
            if self._write_release():
                silent = now - self._received_at > self._silent_s
                reason = "no data" if silent else "no new reading decoded"
                self.say(f"{reason} for {self._silent_s:g} s; disk released")

    def _release(self) -> Event | None:
        return self._source.release()

    def _lose(self) -> None:
        super()._lose()
        self._last_error = ""

    def _open_again(self) -> Port | None:
        try:
            device = find_device_again(self._address, self._identity)
            port = self._open_port(device, self._baud)
        except InputError as error:
            reason = str(error).removeprefix(f"{self._name}: ")
            if reason != self._last_error and "no such port" not in reason:
                self.say(f"{reason} (waiting)")
            self._last_error = reason
            return None
        self._source = SensorSource(
            self._sensor, TouchRules.of(self._preset), self._source.counters
        )
        self._address = device
        self._decoded_at = self._kept_up_at = time.monotonic()
        self._behind = 0
        return port


class NamedInput(SensorInput):
    """Sensor input without a serial port: a game pad, a phone's app, a Bluetooth sensor.

    Thread: as `ThreadedInput`.
    """

    def __init__(
        self,
        engine: Engine,
        kind: str,
        address: str,
        sensor: Sensor,
        open_port: Callable[[str], Port],
        silent_s: float = SILENT_S,
    ) -> None:
        """Start as `SensorInput`; `--input` names this one `KIND:ADDRESS`."""
        self.KIND = f"{kind}:"
        super().__init__(engine, address, sensor, None, lambda name, _: open_port(name), silent_s)
