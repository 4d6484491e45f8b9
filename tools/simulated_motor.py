"""Simulation of a motor knob: physics, firmware, delay of the wire, and a user's fingers.

    inertia * angle'' = motor + user - damping * angle' - friction * sign(angle')

Physics and firmware run at 10 kHz. The firmware has the part of SimpleFOC's Commander that a host
needs, and ends the torque when the host is silent. The work of motor and user is summed step by
step from the true angle, so that the energies in a host's report can be compared with it.

This module imports nothing of the package. It is deterministic and uses no real clock.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable

DT = 1e-4
SILENT_S = 0.04
LONGEST_LINE = 20


class Delay:
    """A wire with a delay."""

    def __init__(self, seconds: float) -> None:
        self._seconds = seconds
        self._pending: deque[tuple[float, bytes]] = deque()

    def put(self, now: float, data: bytes) -> None:
        if data:
            self._pending.append((now + self._seconds, data))

    def take(self, now: float) -> bytes:
        out = b""
        while self._pending and self._pending[0][0] <= now:
            out += self._pending.popleft()[1]
        return out


class Motor:
    """The knob and its board; `letter` is the motor's letter in its Commander."""

    def __init__(
        self,
        inertia: float = 5e-5,
        friction: float = 3e-4,
        damping: float = 1e-5,
        counts: int = 4096,
        nm_per_unit: float = 0.003,
        limit: float = 12.0,
        letter: str = "M",
        watchdog: bool = True,
    ) -> None:
        self.dt = DT
        self.inertia, self.friction, self.damping = inertia, friction, damping
        self.nm_per_unit, self.limit, self.letter = nm_per_unit, limit, letter
        self.step_rad = 2.0 * math.pi / counts
        self.watchdog = watchdog
        self.angle = self.speed = self.time = 0.0
        self.absorbed = self.returned = self.user_work = 0.0
        self.silences = 0
        self.begin()

    def begin(self) -> None:
        """Reset to the state after power-on: no reports and no power."""
        self.target = 0.0
        self.enabled, self.torque_mode, self.verbose = False, False, True
        self.variables, self.downsample = "0000000", 0
        self._line = bytearray()
        self._loops = 0
        self._received_at = -1e300

    @property
    def torque(self) -> float:
        """Present torque of the motor, N m."""
        if not (self.enabled and self.torque_mode):
            return 0.0
        return self.nm_per_unit * max(-self.limit, min(self.limit, self.target))

    # --- the firmware ----------------------------------------------------------------------------

    def loop(self, received: bytes) -> bytes:
        """Run the board's loop once with the received bytes; return the bytes to send."""
        out = ""
        for byte in received:
            self._line.append(byte)
            if byte == 10:
                out += self._execute(self._line.decode("latin-1").strip())
                self._line.clear()
            elif len(self._line) >= LONGEST_LINE:
                self._line.clear()
        if self.watchdog and self.time - self._received_at > SILENT_S and self.target != 0.0:
            self.target = 0.0
            self.silences += 1
        self._loops += 1
        if self.downsample and self._loops % self.downsample == 0 and "1" in self.variables:
            out += self._monitor()
        return out.encode()

    def _monitor(self) -> str:
        seen = math.floor(self.angle / self.step_rad) * self.step_rad
        values = (self.target, 0.0, 0.0, 0.0, 0.0, self.speed, seen)
        chosen = [f"{one:.4f}" for one, on in zip(values, self.variables, strict=True) if on == "1"]
        return "\t".join(chosen) + "\r\n"

    def _execute(self, line: str) -> str:
        if line.startswith("@"):
            self.verbose = line[1:2] != "0"
            return "Verb:on!\r\n" if self.verbose else ""
        if not line.startswith(self.letter):
            return ""
        self._received_at = self.time
        what, value = line[1:3], line[1:]
        answer = ""
        if value[:1] in "-+0123456789" and value:
            self.target = _number(value)
            answer = f"Target: {self.target:.3f}"
        elif what == "MS":
            self.variables = (value[2:9] + "0000000")[:7]
            answer = "Monitor | " + self.variables
        elif what == "MD":
            self.downsample = int(_number(value[2:]))
            answer = f"Monitor | downsample: {self.downsample}"
        elif what[:1] == "C":
            self.torque_mode = value[1:2] == "0"
            answer = "Motion:" + ("torque" if self.torque_mode else "other")
        elif what[:1] == "E":
            self.enabled = value[1:2] == "1"
            answer = f"Status: {int(self.enabled)}"
        else:
            answer = "err"
        return answer + "\r\n" if self.verbose else ""

    # --- the physics -----------------------------------------------------------------------------

    def step(self, user_torque: float) -> None:
        """Advance the physics by 0.1 ms, with the user's torque (N m)."""
        motor = self.torque
        pull = motor + user_torque - self.damping * self.speed
        speed = self.speed + self.dt * pull / self.inertia
        stopped = self.dt * self.friction / self.inertia
        speed = math.copysign(max(0.0, abs(speed) - stopped), speed)
        turned = 0.5 * self.dt * (speed + self.speed)
        self.user_work += user_torque * turned
        work = motor * turned
        if work > 0.0:
            self.returned += work
        else:
            self.absorbed -= work
        self.speed = speed
        self.angle += turned
        self.time += self.dt


def _number(text: str) -> float:
    # as atof of C: a text that is not a number is 0
    try:
        return float(text)
    except ValueError:
        return 0.0


class Fingers:
    """Fingers on the knob: a spring and a damper towards a target angle.

    `path` returns the target (rad from the start of the touch) at a time (s), or None for no touch.
    """

    def __init__(
        self, path: Callable[[float], float | None], stiffness: float = 0.1, damping: float = 4e-3
    ) -> None:
        self._path, self._stiffness, self._damping = path, stiffness, damping
        self._held_at: float | None = None
        self._before = 0.0

    def torque(self, motor: Motor) -> float:
        target = self._path(motor.time)
        if target is None:
            self._held_at = None
            return 0.0
        if self._held_at is None:
            self._held_at, self._before = motor.angle - target, target
        speed, self._before = (target - self._before) / motor.dt, target
        bent = self._held_at + target - motor.angle
        return self._stiffness * bent + self._damping * (speed - motor.speed)


def sweep(hertz: float = 0.25, reach: float = 3.0, rest: float = 1.0) -> Callable[[float], float]:
    """Return a path that repeatedly turns forward and back, after a rest."""
    return lambda t: 0.5 * reach * (1.0 - math.cos(2.0 * math.pi * hertz * max(0.0, t - rest)))


def jiggle(
    hertz: float = 8.0, reach: float = 0.3, rest: float = 1.0, about: float = 1.5
) -> Callable[[float], float]:
    """Return a path that oscillates about an angle (rad), faster than the delay allows."""
    return lambda t: (
        about * min(1.0, t / rest) + reach * math.sin(2.0 * math.pi * hertz * max(0.0, t - rest))
    )


def hold(angle: float = 1.5, rest: float = 1.0) -> Callable[[float], float]:
    """Return a path to an angle that is then held."""
    return lambda t: angle * 0.5 * (1.0 - math.cos(math.pi * min(1.0, t / rest)))


def flick(
    reach: float = 0.8, every: float = 2.0, rest: float = 1.0
) -> Callable[[float], float | None]:
    """Return a path that throws the knob forward and back: 0.2 s of touch, then release."""

    def path(t: float) -> float | None:
        if t < rest:
            return 0.0
        number, since = divmod(t - rest, every)
        signed = reach if int(number) % 2 == 0 else -reach
        return signed * (since / 0.2) ** 2 if since <= 0.2 else None

    return path


MOVEMENTS = {"sweep": sweep, "jiggle": jiggle, "hold": hold, "flick": flick}


class Session:
    """A motor, a user's fingers and a wire, driven by an external clock."""

    def __init__(self, motor: Motor, fingers: Fingers, delay_s: float) -> None:
        self.motor, self.fingers = motor, fingers
        self._to_board, self._to_host = Delay(delay_s), Delay(delay_s)

    def exchange(self, until: float, received: bytes) -> bytes:
        """Run until `until` (s) with the host's bytes; return those that reach the host."""
        motor = self.motor
        self._to_board.put(motor.time, received)
        while motor.time < until:
            self._to_host.put(motor.time, motor.loop(self._to_board.take(motor.time)))
            motor.step(self.fingers.torque(motor))
        return self._to_host.take(motor.time)
