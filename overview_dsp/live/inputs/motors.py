"""Motor knob on a serial port: a sensor input that also sends the disk's torque to the motor."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable
from typing import Any

from overview_dsp.devices.force_feedback.board_loop import BoardLoop
from overview_dsp.devices.force_feedback.motion import MeanTorque
from overview_dsp.devices.force_feedback.motor_loop import MotorLoop
from overview_dsp.devices.force_feedback.watchdog import SILENT_S
from overview_dsp.devices.sensors.frames import KNOB_MOTION
from overview_dsp.devices.sensors.profile import MOTOR_COLUMNS, Sensor
from overview_dsp.live.inputs.sensors import SensorInput
from overview_dsp.live.ports.port import Port, PortLostError
from overview_dsp.live.ports.serial import SerialPort
from overview_dsp.signal.engine.engine import Engine

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
                f"no data from the motor for {1e3 * SILENT_S:g} ms; torque off, disk released "
                "(further interruptions are only counted)"
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
