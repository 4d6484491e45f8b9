"""A motor knob on a serial port: a sensor, to which the disk's torque is given back."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable
from typing import Any, Protocol

from overview_dsp.engine.engine import Engine
from overview_dsp.force_feedback.loop import MotorLoop
from overview_dsp.force_feedback.mean_torque import MeanTorque
from overview_dsp.force_feedback.watchdog import SILENT_S
from overview_dsp.live.port_lost import PortLostError
from overview_dsp.live.sensor_input import Port, SensorInput
from overview_dsp.live.serial_port import SerialPort
from overview_dsp.sensors.profile import Sensor

WAIT_S = 0.002
"""How long a read waits: the loop's longest step."""


SLOWEST_HZ = 200
"""Reports a second."""


class MotorPort(Port, Protocol):
    """A port that is written too."""

    def write(self, data: bytes) -> bool:
        """Send; whether all of it was accepted. PortLostError if the device is gone."""


def open_motor_port(device: str, baud: int) -> MotorPort:
    """A serial port that is read every 2 ms; InputError as `SerialPort`."""
    return SerialPort(device, baud, WAIT_S)


class MotorInput(SensorInput):
    """Plays a motor knob into a running engine and brakes it as the disk is braked.

    Thread: as `SensorInput`; the port's thread reads the disk's torque and writes to the motor.
    """

    def __init__(
        self,
        engine: Engine,
        device: str,
        sensor: Sensor,
        baud: int | None = None,
        open_port: Callable[[str, int], MotorPort] = open_motor_port,
    ) -> None:
        """Open the port and begin, as `SensorInput`.

        Raises
        ------
        InputError
            The port can't be opened, or the profile has no motor.
        """
        self._loop = MotorLoop(sensor)
        self._torque = MeanTorque()
        self._blocked = 0
        self._was_alive = False
        self._began_at = time.monotonic()
        self._motor: MotorPort | None = None

        def opened(device: str, baud: int) -> Port:
            self._motor = open_port(device, baud)
            return _EndedPort(self._motor, self._loop.end)

        super().__init__(engine, device, sensor, baud, opened)

    @property
    def words(self) -> str:
        """As `SensorInput.words`, and the force."""
        said = self._loop.report(time.monotonic())
        force = (
            f"force {1e3 * said['torque_nm']:+.2f} mN·m, loop {said['loop_delay_ms']:.0f} ms, "
            f"hand {said['put_in_mj']:.1f} mJ in, {said['given_mj']:.1f} mJ back, "
            f"{said['silences']} silences"
            if said["alive"]
            else "no force: the motor doesn't report"
        )
        return f"{super().words}; {force}"

    def report(self) -> dict[str, Any]:
        """As `SensorInput.report`, with `force`: the loop's, and what the port didn't accept."""
        now = time.monotonic()
        rate = self._loop.commands / max(now - self._began_at, 1e-3)
        force = {**self._loop.report(now), "per_s": round(rate, 1), "blocked": self._blocked}
        return {**super().report(), "force": force}

    # --- the port's thread ----------------------------------------------------------------------

    def _take(self, data: bytes) -> None:
        super()._take(data)
        now = time.monotonic()
        if data:
            self._loop.hear(self._source.heard, now)
        torque = self._torque.look(self._engine.impulse, now)
        held = self._engine.holder
        if held is None or held[0] != self.SOURCE:  # the disk is another source's, or nobody's
            torque = 0.0
        sent = self._loop.step(torque, now)
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
                "weak (motor.downsample, --baud)"
            )
        if not sent or self._motor is None:
            return
        self._blocked += not self._motor.write(sent)

    def _lose(self) -> None:
        super()._lose()
        self._loop.lost()
        self._motor = None


class _EndedPort:
    """A port that ends the motor's torque before it is given back."""

    def __init__(self, port: MotorPort, end: Callable[[], bytes]) -> None:
        self._port, self._end = port, end

    @property
    def waiting(self) -> int:
        return self._port.waiting

    def read(self) -> bytes:
        return self._port.read()

    def close(self) -> None:
        with contextlib.suppress(PortLostError):
            self._port.write(self._end())
        self._port.close()
