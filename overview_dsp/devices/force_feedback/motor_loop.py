"""The motor's loop: reports and the disk's torque in, commands out; opens no device.

SimpleFOC's Commander: a line a command, `M` (or another letter) for the motor.

| sent | means |
|---|---|
| `@0` | answer nothing: at 500 targets a second answers would fill the wire |
| `MC0` | motion control: torque |
| `M0` | target 0 |
| `MMS1000001` | report the target and the shaft's angle |
| `MMD10` | at every tenth call of `motor.monitor()` |
| `ME1`, `ME0` | enable, disable the motor |
| `M-0.0123` | target: A, or V in voltage mode |

Reports are lines of the target and the angle (rad), with a tab between. No command has more than
the 19 characters and the end of a line that its buffer holds.

Source: https://docs.simplefoc.com/commander_motor, src/communication/Commander.cpp and commands.h
of https://github.com/simplefoc/Arduino-FOC (library versions 2.1 and later).

How long a torque takes to be applied and reported: measured by the device's own reports.

What a motor can't have done: a line of text has no check, a wrong digit is another number.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterable
from typing import Any

from overview_dsp.devices.force_feedback.motion import Motion, Rate, SpeedEstimator
from overview_dsp.devices.force_feedback.passivity import PassivityController, PassivityObserver
from overview_dsp.devices.force_feedback.watchdog import Watchdog
from overview_dsp.devices.sensors.profile import MOTOR_COLUMNS, Sensor
from overview_dsp.devices.sensors.stream import Sample
from overview_dsp.errors import InputError

DECIMALS = 4
"""Of a reported number (`monitor_decimals`), and so of a target sent."""

TARGET_STEP = 10.0**-DECIMALS


class Commander:
    """Lines for one motor."""

    def __init__(self, letter: str, downsample: int) -> None:
        """The motor's `letter`, and at which of its calls it reports."""
        self._letter = letter
        self._downsample = downsample

    def begin(self) -> bytes:
        """Torque control at 0, reports, and power."""
        letter = self._letter
        lines = ("@0", f"{letter}C0", f"{letter}0", f"{letter}MS1000001",
                 f"{letter}MD{self._downsample}", f"{letter}E1")  # fmt: skip
        return "".join(line + "\n" for line in lines).encode()

    def target(self, value: float) -> bytes:
        """A target, to 4 decimals."""
        # adding 0 turns -0 into 0
        return f"{self._letter}{round(value, DECIMALS) + 0.0:.{DECIMALS}f}\n".encode()

    def end(self) -> bytes:
        """No torque and no power."""
        return f"{self._letter}0\n{self._letter}E0\n".encode()


UNKNOWN_S = 0.05
"""Before anything was measured."""

FORGOTTEN_S = 0.5
"""A torque that wasn't reported for so long was lost on the wire."""

EASE = 0.01
"""Of a shorter delay than the one held, how much counts: a longer one counts at once."""


class LoopDelay:
    """Targets sent and reported in, the loop's delay out.

    Attributes
    ----------
    measured : bool
        Whether any delay was.
    """

    def __init__(self, resolution: float) -> None:
        """`resolution`: reported targets are right to this."""
        self.measured = False
        self._held = UNKNOWN_S
        self._resolution = resolution
        self._waiting: deque[tuple[float, float]] = deque()
        self._sent = self._applied = 0.0

    def sent(self, now_s: float, target: float) -> None:
        """`target` was sent."""
        if abs(target - self._sent) > self._resolution:
            self._waiting.append((now_s, target))
            self._sent = target
        while self._waiting and now_s - self._waiting[0][0] > FORGOTTEN_S:
            self._waiting.popleft()

    def reported(self, now_s: float, target: float) -> None:
        """The device says that it applies `target`."""
        if abs(target - self._applied) <= self._resolution:
            return
        self._applied = target
        for index, (sent_at, waiting) in enumerate(self._waiting):
            if abs(waiting - target) <= self._resolution:
                for _ in range(index + 1):
                    self._waiting.popleft()
                took = now_s - sent_at
                if not self.measured or took > self._held:
                    self._held, self.measured = took, True
                else:
                    self._held += EASE * (took - self._held)
                return

    @property
    def waits(self) -> bool:
        """Whether a target is under way."""
        return bool(self._waiting)

    def seconds(self, now_s: float) -> float:
        """From sending a target to hearing that it is applied, s: about the longest of late.

        At least how long the oldest target that wasn't reported has waited.
        """
        waited = now_s - self._waiting[0][0] if self._waiting else 0.0
        return max(self._held, waited)


FASTEST = 150.0
"""rad/s: no hand turns a knob so fast."""

SLACK_S = 0.01
"""Reports may come so much closer together than they were made."""

IN_A_ROW = 5
"""So many jumped reports that agree with each other are a device that began again."""


class ReportCheck:
    """Reports in, whether to believe them out.

    Attributes
    ----------
    refused : int
        Reports that weren't believed.
    restarted : bool
        Whether the latest one believed is the first of a device that began again.
    """

    def __init__(self, highest: float) -> None:
        """`highest` target that is ever sent."""
        self.refused = 0
        self.restarted = False
        self._highest = highest
        self._last: tuple[float, float] | None = None
        self._other: tuple[float, float] | None = None
        self._agreeing = 0

    def forget(self) -> None:
        """The device is gone: the next angle is a first one."""
        self._last = self._other = None

    def plausible(self, time_s: float, target: float, angle: float) -> bool:
        """Whether `target` was ever asked for, and the angle (rad) be reached by `time_s`."""
        self.restarted = False
        if abs(target) > self._highest:
            self.refused += 1
            return False
        here = (time_s, angle)
        if self._last is None or _reached(self._last, here):
            self._last, self._other = here, None
            return True
        near = self._other is not None and _reached(self._other, here)
        self._agreeing = self._agreeing + 1 if near else 1
        self._other = here
        if self._agreeing < IN_A_ROW:
            self.refused += 1
            return False
        self._last, self._other, self.restarted = here, None, True
        return True


def _reached(before: tuple[float, float], after: tuple[float, float]) -> bool:
    return abs(after[1] - before[1]) <= FASTEST * (after[0] - before[0] + SLACK_S)


PERIOD_S = 0.002
"""Between commands: 500 a second."""

BEGIN_EVERY_S = 0.5
"""A motor that doesn't report is begun with again so often: boards restart when a port opens."""

REPORTED_STEP = 0.6 * TARGET_STEP
"""Targets that differ by less are the same one, rounded."""

CREDIT_RAD = 0.5
"""The ledger's credit is at most the ceiling along this way."""


class MotorLoop:
    """One motor.

    Attributes
    ----------
    ledger : PassivityObserver
    commands : int
        Torques sent so far.
    torque : float
        The latest, N m along the shaft's angle.
    """

    def __init__(self, sensor: Sensor) -> None:
        """For a profile with a motor; InputError if it has none, or says too little of it."""
        require_motor(sensor)
        self._per_target = sensor.number("motor.nm_per_unit")
        # the disk's torque is that of a hand that turns the timeline forward
        self._forward = -1.0 if sensor.values["motor.reverse"] else 1.0
        self._scale = sensor.number("motor.scale")
        ceiling = sensor.number("motor.ceiling_nm")
        letter = str(sensor.values["motor.command_letter"])
        self._commander = Commander(letter, round(sensor.number("motor.downsample")))
        self._controller = PassivityController(sensor.number("motor.inertia"), ceiling)
        resolution = math.radians(sensor.number("motor.resolution_deg"))
        self._friction = sensor.number("motor.friction_nm")
        self._probe = 0
        self._speed = SpeedEstimator(resolution)
        self._delay = LoopDelay(REPORTED_STEP)
        self._watchdog = Watchdog()
        self._check = ReportCheck(ceiling / self._per_target + TARGET_STEP)
        self.ledger = PassivityObserver(ceiling * CREDIT_RAD, self._friction, resolution)
        self.commands = 0
        self.torque = 0.0
        self._was_alive = False
        self._due = self._begin_at = -1e300
        self._heard_at = -1e300
        self._motion = Motion()
        self._rate = Rate()

    def hear(self, samples: Iterable[Sample], now_s: float) -> None:
        """The device's reports that came together by `now_s`."""
        for time_s, reading in samples:
            target, angle = (reading[name] for name in MOTOR_COLUMNS)
            if not self._check.plausible(time_s, target, angle):
                continue
            if self._check.restarted:
                self.ledger.interrupt()
                self._speed.clear()
            self.ledger.add(target * self._per_target, angle, self._controller.goes_on)
            self._delay.reported(now_s, target)
            self._speed.add(time_s, angle)
            self._watchdog.heard(now_s)
            self._heard_at = now_s
            self._rate.add(now_s)

    def step(self, torque: float, now_s: float) -> bytes:
        """What to send, at most every 2 ms; `torque` is the disk's (N m).

        Call it as often as possible: it keeps the silence's time too.
        """
        alive = self._watchdog.alive(now_s)
        if now_s < self._due and alive == self._was_alive:
            return b""
        self._due = max(self._due + PERIOD_S, now_s)
        sent = b""
        if alive != self._was_alive and not alive:
            self.ledger.interrupt()
        self._was_alive = alive
        if not alive:
            self.torque = 0.0
            if now_s - self._begin_at >= BEGIN_EVERY_S:
                self._begin_at = now_s
                sent = self._commander.begin()
            return sent + self._send(now_s)
        known = self._speed.motion()
        self._motion = Motion(known.speed, known.age_s + now_s - self._heard_at)
        wanted = -self._forward * self._scale * torque if math.isfinite(torque) else 0.0
        self.torque = self._controller.step(
            wanted,
            self._motion,
            self.ledger.credit,
            self._delay.seconds(now_s) + PERIOD_S,
            now_s,
        )
        return self._send(now_s)

    def _send(self, now_s: float) -> bytes:
        # towards 0, so that no rounding passes the ceiling
        steps = math.trunc(self.torque / (self._per_target * TARGET_STEP))
        if steps == 0 and self._asks:
            # the smallest torque there is, against the turn: how long does it take?
            if not self._delay.waits:
                self._probe = 0 if self._probe else -round(math.copysign(1.0, self._motion.speed))
            steps = self._probe
        target = steps * TARGET_STEP
        self._delay.sent(now_s, target)
        self.commands += 1
        return self._commander.target(target)

    @property
    def _asks(self) -> bool:
        """Whether the wire's delay isn't known yet, in a hand that moves.

        The controller takes it for long until then, and a hand that jiggles would never be braked.
        """
        smallest = self._per_target * TARGET_STEP
        moves = self._was_alive and self._motion.speed != 0.0
        return moves and not self._delay.measured and smallest <= self._friction

    def end(self) -> bytes:
        """What to send last."""
        self.torque = 0.0
        return self._commander.end()

    def lost(self) -> None:
        """The port is gone: nothing is known until the device speaks again."""
        self.ledger.interrupt()
        self._delay = LoopDelay(REPORTED_STEP)
        self._speed.clear()
        self._watchdog.forget()
        self._check.forget()
        self._was_alive = False
        self._begin_at = -1e300
        self.torque = 0.0

    @property
    def reports_per_s(self) -> float | None:
        """How often the device reports; None while that isn't known."""
        return self._rate.hz if self._was_alive else None

    @property
    def alive(self) -> bool:
        """Whether the device spoke as of the latest step."""
        return self._was_alive

    def words(self, now_s: float) -> str:
        """How it stands, for a person."""
        if not self._was_alive:
            return "no force: the motor doesn't report"
        ledger = self.ledger
        return (
            f"force {1e3 * self.torque:+.2f} mN·m, loop {1e3 * self._delay.seconds(now_s):.0f} ms, "
            f"hand {1e3 * ledger.put_in:.1f} mJ in, {1e3 * ledger.given:.1f} mJ back, "
            f"{self._watchdog.silences} silences"
        )

    def report(self, now_s: float) -> dict[str, Any]:
        """How it stands, for a line of JSON."""
        controller = self._controller
        return {
            "alive": self._was_alive,
            "torque_nm": round(self.torque, 6),
            "speed_rad_s": round(self._motion.speed, 4),
            "loop_delay_ms": round(1e3 * self._delay.seconds(now_s), 2),
            "commands": self.commands,
            "reports_per_s": None if self._rate.hz is None else round(self._rate.hz, 1),
            "silences": self._watchdog.silences,
            "implausible": self._check.refused,
            "absorbed_mj": round(1e3 * self.ledger.put_in, 4),
            "returned_mj": round(1e3 * self.ledger.given, 4),
            "friction_mj": round(1e3 * self.ledger.rubbed, 4),
            "refused": controller.refused,
            "lessened": controller.lessened,
            "damped": controller.damped,
        }


def require_motor(sensor: Sensor) -> None:
    """InputError unless the profile has a motor and says what it needs."""
    where = sensor.source or sensor.name
    if sensor.values["motor.protocol"] == "none":
        raise InputError(
            f"{where}: motor.protocol is none, and force needs a motor; choose "
            'sensor=simplefoc, or a file with [motor] and protocol = "simplefoc"'
        )
