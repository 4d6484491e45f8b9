"""The motor knob of `simulated_knob.py`: its physics, its firmware, its wire's delay, its hand.

    inertia * angle'' = motor + hand - damping * angle' - friction * sign(angle')

stepped at 10 kHz, which is also how often the firmware loops. The firmware speaks as much of
SimpleFOC's Commander as a host needs, and ends the torque itself when the host is silent. The
work of motor and hand is summed step by step, from the true angle: what a host reckons can be held
to it.

Imports nothing of the package. Deterministic; knows no real clock.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable

DT = 1e-4
SILENT_S = 0.04
LONGEST_LINE = 20


class Delay:
    """A wire on which bytes take their time."""

    def __init__(self, seconds: float) -> None:
        self._seconds = seconds
        self._under_way: deque[tuple[float, bytes]] = deque()

    def put(self, now: float, data: bytes) -> None:
        if data:
            self._under_way.append((now + self._seconds, data))

    def take(self, now: float) -> bytes:
        out = b""
        while self._under_way and self._under_way[0][0] <= now:
            out += self._under_way.popleft()[1]
        return out


class Motor:
    """The knob and its board. `letter`: the motor's in its Commander."""

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
        self.put_in = self.given = self.hand_work = 0.0
        self.silences = 0
        self.begin()

    def begin(self) -> None:
        """As after power-on: silent, and without power."""
        self.target = 0.0
        self.enabled, self.torque_mode, self.verbose = False, False, True
        self.variables, self.downsample = "0000000", 0
        self._line = bytearray()
        self._loops = 0
        self._heard_at = -1e300

    @property
    def torque(self) -> float:
        """What the motor gives now, N m."""
        if not (self.enabled and self.torque_mode):
            return 0.0
        return self.nm_per_unit * max(-self.limit, min(self.limit, self.target))

    # --- the firmware ----------------------------------------------------------------------------

    def loop(self, received: bytes) -> bytes:
        """One turn of the board's loop: bytes in, bytes out."""
        out = ""
        for byte in received:
            self._line.append(byte)
            if byte == 10:
                out += self._obey(self._line.decode("latin-1").strip())
                self._line.clear()
            elif len(self._line) >= LONGEST_LINE:
                self._line.clear()
        if self.watchdog and self.time - self._heard_at > SILENT_S and self.target != 0.0:
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

    def _obey(self, line: str) -> str:
        if line.startswith("@"):
            self.verbose = line[1:2] != "0"
            return "Verb:on!\r\n" if self.verbose else ""
        if not line.startswith(self.letter):
            return ""
        self._heard_at = self.time
        what, value = line[1:3], line[1:]
        said = ""
        if value[:1] in "-+0123456789" and value:
            self.target = _number(value)
            said = f"Target: {self.target:.3f}"
        elif what == "MS":
            self.variables = (value[2:9] + "0000000")[:7]
            said = "Monitor | " + self.variables
        elif what == "MD":
            self.downsample = int(_number(value[2:]))
            said = f"Monitor | downsample: {self.downsample}"
        elif what[:1] == "C":
            self.torque_mode = value[1:2] == "0"
            said = "Motion:" + ("torque" if self.torque_mode else "other")
        elif what[:1] == "E":
            self.enabled = value[1:2] == "1"
            said = f"Status: {int(self.enabled)}"
        else:
            said = "err"
        return said + "\r\n" if self.verbose else ""

    # --- the physics -----------------------------------------------------------------------------

    def step(self, hand_torque: float) -> None:
        """On by 0.1 ms, with a hand's torque (N m)."""
        motor = self.torque
        pull = motor + hand_torque - self.damping * self.speed
        speed = self.speed + self.dt * pull / self.inertia
        stopped = self.dt * self.friction / self.inertia
        speed = math.copysign(max(0.0, abs(speed) - stopped), speed)
        turned = 0.5 * self.dt * (speed + self.speed)
        self.hand_work += hand_torque * turned
        work = motor * turned
        if work > 0.0:
            self.given += work
        else:
            self.put_in -= work
        self.speed = speed
        self.angle += turned
        self.time += self.dt


def _number(text: str) -> float:
    # as C's atof: what is no number is 0
    try:
        return float(text)
    except ValueError:
        return 0.0


class Hand:
    """Fingers on the knob: a spring and a damper to where they want to be.

    `path` gives that place (rad from where they took hold) for a time (s), or None while they let
    go.
    """

    def __init__(
        self, path: Callable[[float], float | None], stiffness: float = 0.1, damping: float = 4e-3
    ) -> None:
        self._path, self._stiffness, self._damping = path, stiffness, damping
        self._held_at: float | None = None
        self._before = 0.0

    def torque(self, motor: Motor) -> float:
        place = self._path(motor.time)
        if place is None:
            self._held_at = None
            return 0.0
        if self._held_at is None:
            self._held_at, self._before = motor.angle - place, place
        moving, self._before = (place - self._before) / motor.dt, place
        bent = self._held_at + place - motor.angle
        return self._stiffness * bent + self._damping * (moving - motor.speed)


def sweep(hertz: float = 0.25, reach: float = 3.0, rest: float = 1.0) -> Callable[[float], float]:
    """There and back, again and again, after a rest."""
    return lambda t: 0.5 * reach * (1.0 - math.cos(2.0 * math.pi * hertz * max(0.0, t - rest)))


def jiggle(
    hertz: float = 8.0, reach: float = 0.3, rest: float = 1.0, about: float = 1.5
) -> Callable[[float], float]:
    """To and fro about a place (rad), faster than any delay is short."""
    return lambda t: (
        about * min(1.0, t / rest) + reach * math.sin(2.0 * math.pi * hertz * max(0.0, t - rest))
    )


def hold(place: float = 1.5, rest: float = 1.0) -> Callable[[float], float]:
    """Turned to a place and held there."""
    return lambda t: place * 0.5 * (1.0 - math.cos(math.pi * min(1.0, t / rest)))


def flick(
    reach: float = 0.8, every: float = 2.0, rest: float = 1.0
) -> Callable[[float], float | None]:
    """Thrown forward and back in turn: held for a fifth of a second, then let go."""

    def path(t: float) -> float | None:
        if t < rest:
            return 0.0
        number, since = divmod(t - rest, every)
        way = reach if int(number) % 2 == 0 else -reach
        return way * (since / 0.2) ** 2 if since <= 0.2 else None

    return path


HANDS = {"sweep": sweep, "jiggle": jiggle, "hold": hold, "flick": flick}


class Session:
    """A motor, its hand and its wire, in step with a clock that someone else keeps."""

    def __init__(self, motor: Motor, hand: Hand, delay_s: float) -> None:
        self.motor, self.hand = motor, hand
        self._there, self._back = Delay(delay_s), Delay(delay_s)

    def exchange(self, until: float, received: bytes) -> bytes:
        """Run on to `until` (s) with what the host sent by now; what has reached it by then."""
        motor = self.motor
        self._there.put(motor.time, received)
        while motor.time < until:
            self._back.put(motor.time, motor.loop(self._there.take(motor.time)))
            motor.step(self.hand.torque(motor))
        return self._back.take(motor.time)
