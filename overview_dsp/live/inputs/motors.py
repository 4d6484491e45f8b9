"""A motor knob on a serial port: a sensor, to which the disk's torque is given back."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable
from typing import Any

from overview_dsp.devices.force_feedback.board_loop import BoardLoop
from overview_dsp.devices.force_feedback.loop import MotorLoop
from overview_dsp.devices.force_feedback.motion import MeanTorque
from overview_dsp.devices.force_feedback.watchdog import SILENT_S
from overview_dsp.devices.sensors.frames import KNOB_MOTION
from overview_dsp.devices.sensors.profile import MOTOR_COLUMNS, Sensor
from overview_dsp.live.inputs.sensors import SensorInput
from overview_dsp.live.ports.port import Port, PortLostError
from overview_dsp.live.ports.serial import SerialPort
from overview_dsp.signal.engine.engine import Engine

RENDER_S = 0.1
"""How often a board is asked to render what the engine plays, if that has changed."""

SLOWEST_HZ = 200
"""Reports a second."""


class MotorInput(SensorInput):
    """Plays a motor knob into a running engine and brakes it as the disk is braked.

    A board that runs the surface itself says so by its frames, and is given the surface; any other
    gets torques.

    Thread: as `SensorInput`; the port's thread reads the disk's torque and writes to the motor.
    """

    WAIT_S = 0.002  # the loop's longest step

    def __init__(
        self,
        engine: Engine,
        device: str,
        sensor: Sensor,
        baud: int | None = None,
        open_port: Callable[[str, int], Port] = SerialPort,
    ) -> None:
        """Open the port and begin, as `SensorInput`.

        Raises
        ------
        InputError
            The port can't be opened, or the profile has no motor.
        """
        self._loop: MotorLoop | BoardLoop = MotorLoop(sensor)
        self._torque = MeanTorque()
        self._sent = self._blocked = 0
        self._was_alive = False
        self._began_at = time.monotonic()
        self._rendered_at = -1e300
        super().__init__(engine, device, sensor, baud, open_port)

    @property
    def words(self) -> str:
        """As `SensorInput.words`, and the force."""
        return f"{super().words}; {self._loop.words(time.monotonic())}"

    def report(self) -> dict[str, Any]:
        """As `SensorInput.report`, with `force`: the loop's, and what the port didn't accept."""
        now = time.monotonic()
        rate = self._sent / max(now - self._began_at, 1e-3)
        force = {**self._loop.report(now), "per_s": round(rate, 1), "blocked": self._blocked}
        return {**super().report(), "force": force}

    # --- the port's thread ----------------------------------------------------------------------

    def _take(self, data: bytes) -> None:
        super()._take(data)
        now = time.monotonic()
        if data:
            self._choose_loop()
            self._loop.hear(self._source.heard, now)
        sent = self._next(now)
        if self._was_alive and not self._loop.alive:
            self._let_go()
            self._say_once(
                f"the motor said nothing for {1e3 * SILENT_S:g} ms: no torque, and the disk is let "
                "go; silences are counted"
            )
        self._was_alive = self._loop.alive
        rate = self._loop.reports_per_s
        if rate is not None and rate < SLOWEST_HZ:
            self._say_once(
                f"the motor reports less than {SLOWEST_HZ} times a second, which makes its force "
                "weak (motor.downsample, baud=)"
            )
        if sent and self._port is not None:
            self._sent += 1
            self._blocked += not self._port.write(sent)

    def _choose_loop(self) -> None:
        for _, reading in self._source.heard:
            if KNOB_MOTION[0] in reading and not isinstance(self._loop, BoardLoop):
                self._loop = BoardLoop(self._sensor, self._baud)
                self._rendered_at = -1e300
            elif MOTOR_COLUMNS[0] in reading and not isinstance(self._loop, MotorLoop):
                self._loop = MotorLoop(self._sensor)

    def _next(self, now: float) -> bytes:
        """What to send."""
        held = self._engine.active_input
        mine = held is not None and held[0] == self.SOURCE
        torque = self._torque.look(self._engine.torque_integral, now)
        if isinstance(self._loop, MotorLoop):
            return self._loop.step(torque if mine else 0.0, now)
        if now - self._rendered_at >= RENDER_S:
            self._rendered_at = now
            self._render(self._loop)
        return self._loop.step(mine or held is None, now)

    def _render(self, loop: BoardLoop) -> None:
        surface = self._engine.surface
        loop.render(surface, self._engine.preset.values)
        if surface.bristles is not None or surface.detents is not None:
            self._say_once(
                "the knob's board makes viscous friction: what sticks or pulls brakes there as it "
                "does at 1 rad/s"
            )

    def _close_port(self) -> None:
        if self._port is not None:
            with contextlib.suppress(PortLostError):
                self._port.write(self._loop.end())
        super()._close_port()

    def _lose(self) -> None:
        super()._lose()
        self._loop.lost()
