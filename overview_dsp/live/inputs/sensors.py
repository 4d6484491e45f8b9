"""Sensor inputs, whose threads read a port and decode its data; a motor knob is one of them."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable
from typing import Any

from overview_dsp.devices.force_feedback import watchdog
from overview_dsp.devices.force_feedback.board_loop import BoardLoop
from overview_dsp.devices.force_feedback.motion import MeanTorque
from overview_dsp.devices.force_feedback.motor_loop import MotorLoop
from overview_dsp.devices.sensors.frames import KNOB_MOTION
from overview_dsp.devices.sensors.profile import MOTOR_COLUMNS, Sensor
from overview_dsp.devices.sensors.source import FAULTS, SensorSource
from overview_dsp.devices.sensors.touch_detection import Event, TouchRules
from overview_dsp.errors import InputError
from overview_dsp.live.inputs.threaded import ThreadedInput
from overview_dsp.live.ports.port import WAIT_S, Port, PortLostError
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


RENDER_EVERY_S = 0.1
"""Interval at which a board gets the engine's surface, if that has changed."""

LOWEST_RATE_HZ = 200
"""Lowest report rate of a motor with full force."""


class MotorInput(SensorInput):
    """Input that plays a motor knob into a running engine and brakes it as the disk is braked.

    A board that renders the surface itself sends its own kind of frames, and receives the surface.
    Any other board receives torques.

    Thread: as `SensorInput`; the port's thread reads the disk's torque and writes to the motor.
    """

    WAIT_S = 0.002  # longest step of the loop

    def __init__(
        self,
        engine: Engine,
        device: str,
        sensor: Sensor,
        baud: int | None = None,
        open_port: Callable[[str, int], Port] = SerialPort,
    ) -> None:
        """Open the port and start, as `SensorInput`.

        InputError: the port can't be opened, or the profile has no motor.
        """
        self._loop: MotorLoop | BoardLoop = MotorLoop(sensor)
        self._torque = MeanTorque()
        self._sent = self._blocked = 0
        self._was_alive = False
        self._started_at = time.monotonic()
        self._rendered_at = -1e300
        super().__init__(engine, device, sensor, baud, open_port)

    @property
    def status_text(self) -> str:
        """Status of the sensor and of the force."""
        return f"{super().status_text}; {self._loop.status_text(time.monotonic())}"

    def report(self) -> dict[str, Any]:
        """Return the sensor's report; `force` has the loop's report and counts rejected writes."""
        now = time.monotonic()
        rate = self._sent / max(now - self._started_at, 1e-3)
        force = {**self._loop.report(now), "per_s": round(rate, 1), "blocked": self._blocked}
        return {**super().report(), "force": force}

    # --- the port's thread ----------------------------------------------------------------------

    def _process(self, data: bytes) -> None:
        super()._process(data)
        now = time.monotonic()
        if data:
            self._choose_loop()
            self._loop.receive(self._source.samples, now)
        frame = self._next_frame(now)
        if self._was_alive and not self._loop.alive:
            self._write_release()
            self.say_once(
                f"no data from the motor for {1e3 * watchdog.SILENT_S:g} ms; torque off, disk "
                "released (further interruptions are only counted)"
            )
        self._was_alive = self._loop.alive
        rate = self._loop.watchdog.hz
        if self._loop.alive and rate is not None and rate < LOWEST_RATE_HZ:
            self.say_once(
                f"the motor sends fewer than {LOWEST_RATE_HZ} reports per second, which makes its "
                "force weak; change motor.downsample or baud="
            )
        if frame and self._port is not None:
            self._sent += 1
            self._blocked += not self._port.write(frame)

    def _choose_loop(self) -> None:
        for _, reading in self._source.samples:
            if KNOB_MOTION[0] in reading and not isinstance(self._loop, BoardLoop):
                self._loop = BoardLoop(self._sensor, self._baud)
                self._rendered_at = -1e300
            elif MOTOR_COLUMNS[0] in reading and not isinstance(self._loop, MotorLoop):
                self._loop = MotorLoop(self._sensor)

    def _next_frame(self, now: float) -> bytes:
        """Return the bytes to send; may be empty."""
        held = self._engine.active_input
        holds_disk = held is not None and held[0] == self.SOURCE
        if isinstance(self._loop, MotorLoop):
            torque = self._torque.update(self._engine.torque_integral, now)
            return self._loop.step(torque if holds_disk else 0.0, now)
        if now - self._rendered_at >= RENDER_EVERY_S:
            self._rendered_at = now
            surface = self._engine.surface
            self._loop.render(surface, self._engine.preset.values)
            if surface.bristles is not None or surface.detents is not None:
                self.say_once(
                    "the knob's board only makes viscous friction; sticking and pulling surfaces "
                    "brake as they do at 1 rad/s"
                )
        return self._loop.step(holds_disk or held is None, now)

    def _close_port(self) -> None:
        if self._port is not None:
            with contextlib.suppress(PortLostError):
                self._port.write(self._loop.end())
        super()._close_port()

    def _lose(self) -> None:
        self._loop.disconnected()  # first: whoever sees a closed port reads a status without force
        super()._lose()
