"""Loop of a motor: reports and the disk's torque to commands; opens no device.

SimpleFOC's Commander takes one command per line, with `M` (or another letter) for the motor.

| command | meaning |
|---|---|
| `@0` | no answers: at 500 targets per second they would fill the wire |
| `MC0` | motion control: torque |
| `M0` | target 0 |
| `MMS1000001` | report the target and the shaft's angle |
| `MMD10` | at every tenth call of `motor.monitor()` |
| `ME1`, `ME0` | enable, disable the motor |
| `M-0.0123` | target: A, or V in voltage mode |

Reports are lines with the target and the angle (rad), separated by a tab. A command has at most 19
characters and a line end, the size of the Commander's buffer.

Source: https://docs.simplefoc.com/commander_motor, src/communication/Commander.cpp and commands.h
of https://github.com/simplefoc/Arduino-FOC (library versions 2.1 and later).
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterable
from typing import Any

from overview_dsp.devices.force_feedback.motion import Motion, SpeedEstimator
from overview_dsp.devices.force_feedback.passivity import PassivityController, PassivityObserver
from overview_dsp.devices.force_feedback.watchdog import Watchdog
from overview_dsp.devices.sensors.profile import MOTOR_COLUMNS, Sensor
from overview_dsp.devices.sensors.stream import Sample
from overview_dsp.errors import InputError

DECIMALS = 4  # decimals of reported numbers (`monitor_decimals`) and of targets
TARGET_STEP = 10.0**-DECIMALS


class Commander:
    """Commands for one motor."""

    def __init__(self, letter: str, downsample: int) -> None:
        """Use the motor's `letter`; it reports at every `downsample`-th call."""
        self._letter = letter
        self._downsample = downsample

    def begin(self) -> bytes:
        """Return the commands for torque control at 0, reports, and power."""
        letter = self._letter
        lines = ("@0", f"{letter}C0", f"{letter}0", f"{letter}MS1000001",
                 f"{letter}MD{self._downsample}", f"{letter}E1")  # fmt: skip
        return "".join(line + "\n" for line in lines).encode()

    def target(self, value: float) -> bytes:
        """Return the command for a target, to 4 decimals."""
        # adding 0 turns -0 into 0
        return f"{self._letter}{round(value, DECIMALS) + 0.0:.{DECIMALS}f}\n".encode()

    def end(self) -> bytes:
        """Return the commands for no torque and no power."""
        return f"{self._letter}0\n{self._letter}E0\n".encode()


UNKNOWN_S = 0.05  # delay before the first measurement
FORGOTTEN_S = 0.5  # time after which a target without a report was lost on the wire
EASE = 0.01  # weight of a delay shorter than the present estimate; a longer one counts at once


class LoopDelay:
    """Delay of the loop by the device's own reports of targets, if `measured`.

    `pending`: time and value of each target that was sent and not reported yet.
    """

    def __init__(self, resolution: float) -> None:
        """Take targets as equal within `resolution`."""
        self.measured = False
        self._estimate = UNKNOWN_S
        self._resolution = resolution
        self.pending: deque[tuple[float, float]] = deque()
        self._sent = self._applied = 0.0

    def sent(self, now_s: float, target: float) -> None:
        """Note that `target` was sent."""
        if abs(target - self._sent) > self._resolution:
            self.pending.append((now_s, target))
            self._sent = target
        while self.pending and now_s - self.pending[0][0] > FORGOTTEN_S:
            self.pending.popleft()

    def reported(self, now_s: float, target: float) -> None:
        """Note that the device reported `target` as applied."""
        if abs(target - self._applied) <= self._resolution:
            return
        self._applied = target
        for index, (sent_at, pending) in enumerate(self.pending):
            if abs(pending - target) <= self._resolution:
                for _ in range(index + 1):
                    self.pending.popleft()
                delay = now_s - sent_at
                if not self.measured or delay > self._estimate:
                    self._estimate, self.measured = delay, True
                else:
                    self._estimate += EASE * (delay - self._estimate)
                return

    def seconds(self, now_s: float) -> float:
        """Return the time from sending a target to its report, s: about the longest recent one.

        It is at least the time since the oldest target without a report.
        """
        waited = now_s - self.pending[0][0] if self.pending else 0.0
        return max(self._estimate, waited)


FASTEST = 150.0  # highest speed of a knob by a hand, rad/s
SLACK_S = 0.01  # largest shortening of the time between two reports on the wire
IN_A_ROW = 5  # number of consistent reports after a jump that show a restart of the device


class ReportCheck:
    """Rejects impossible reports: lines of text have no check, so a digit may be wrong.

    `rejected` counts them. `restarted`: whether the latest accepted report is the first after a
    restart of the device.
    """

    def __init__(self, highest: float) -> None:
        """Reject targets beyond `highest`, the highest that is ever sent."""
        self.rejected = 0
        self.restarted = False
        self._highest = highest
        self._agreeing = 0
        self.reset()

    def reset(self) -> None:
        """Accept any next angle, because the device is disconnected."""
        self._last: tuple[float, float] | None = None
        self._other: tuple[float, float] | None = None

    def plausible(self, time_s: float, target: float, angle: float) -> bool:
        """Return whether `target` may have been sent, and the angle (rad) reached by `time_s`."""
        self.restarted = False
        if abs(target) > self._highest:
            self.rejected += 1
            return False
        here = (time_s, angle)
        if self._last is None or _is_reachable(self._last, here):
            self._last, self._other = here, None
            return True
        near = self._other is not None and _is_reachable(self._other, here)
        self._agreeing = self._agreeing + 1 if near else 1
        self._other = here
        if self._agreeing < IN_A_ROW:
            self.rejected += 1
            return False
        self._last, self._other, self.restarted = here, None, True
        return True


def _is_reachable(before: tuple[float, float], after: tuple[float, float]) -> bool:
    return abs(after[1] - before[1]) <= FASTEST * (after[0] - before[0] + SLACK_S)


PERIOD_S = 0.002  # time between commands: 500 per second

BEGIN_EVERY_S = 0.5
"""Time between attempts to start a motor without reports; boards restart when a port opens."""

REPORTED_STEP = 0.6 * TARGET_STEP  # largest difference between a target and its rounded report
CREDIT_RAD = 0.5  # angle over which the ceiling makes the limit of the observer's credit


class MotorLoop:
    """Loop of one motor.

    `commands` counts the torques sent; `torque` is the latest, N m along the shaft's angle;
    `alive`: whether the device was reporting at the latest step.
    """

    def __init__(self, sensor: Sensor) -> None:
        """Start the loop for a profile with a motor; InputError if the profile has no motor."""
        require_motor(sensor)
        self._per_target = sensor.number("motor.nm_per_unit")
        # the disk's torque is for a hand that turns the timeline forward
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
        self.watchdog = Watchdog()
        self._check = ReportCheck(ceiling / self._per_target + TARGET_STEP)
        self.observer = PassivityObserver(ceiling * CREDIT_RAD, self._friction, resolution)
        self.commands = 0
        self.torque = 0.0
        self.alive = False
        self._due = self._begin_at = -1e300
        self._received_at = -1e300
        self._motion = Motion()

    def receive(self, samples: Iterable[Sample], now_s: float) -> None:
        """Process the device's reports that arrived by `now_s`."""
        for time_s, reading in samples:
            target, angle = (reading[name] for name in MOTOR_COLUMNS)
            if not self._check.plausible(time_s, target, angle):
                continue
            if self._check.restarted:
                self.observer.interrupt()
                self._speed.clear()
            torque = target * self._per_target
            self.observer.add(torque, angle, self._controller.direction_stable)
            self._delay.reported(now_s, target)
            self._speed.add(time_s, angle)
            self.watchdog.message_received(now_s)
            self._received_at = now_s

    def step(self, torque: float, now_s: float) -> bytes:
        """Return the commands to send, at most every 2 ms; `torque` is the disk's (N m).

        It also detects a silent device, so it should be called as often as possible.
        """
        alive = self.watchdog.alive(now_s)
        if now_s < self._due and alive == self.alive:
            return b""
        self._due = max(self._due + PERIOD_S, now_s)
        if self.alive and not alive:
            self.observer.interrupt()
        self.alive = alive
        if not alive:
            self.torque = 0.0
            sent = b""
            if now_s - self._begin_at >= BEGIN_EVERY_S:
                self._begin_at = now_s
                sent = self._commander.begin()
            return sent + self._send(now_s)
        known = self._speed.motion()
        self._motion = Motion(known.speed, known.age_s + now_s - self._received_at)
        requested = -self._forward * self._scale * torque if math.isfinite(torque) else 0.0
        delay_s = self._delay.seconds(now_s) + PERIOD_S
        self.torque = self._controller.step(
            requested, self._motion, self.observer.credit, delay_s, now_s
        )
        return self._send(now_s)

    def _send(self, now_s: float) -> bytes:
        # rounded towards 0, so that the target never passes the ceiling
        steps = math.trunc(self.torque / (self._per_target * TARGET_STEP))
        if steps == 0 and self._needs_probe:
            # the smallest torque, against the turn, measures the delay
            if not self._delay.pending:
                self._probe = 0 if self._probe else -round(math.copysign(1.0, self._motion.speed))
            steps = self._probe
        target = steps * TARGET_STEP
        self._delay.sent(now_s, target)
        self.commands += 1
        return self._commander.target(target)

    @property
    def _needs_probe(self) -> bool:
        """True while the loop's delay is unknown (a long one is assumed) and the knob moves."""
        smallest = self._per_target * TARGET_STEP
        moves = self.alive and self._motion.speed != 0.0
        return moves and not self._delay.measured and smallest <= self._friction

    def end(self) -> bytes:
        """Return the last commands."""
        self.torque = 0.0
        return self._commander.end()

    def disconnected(self) -> None:
        """Forget the device's state, because its port is closed."""
        self.observer.interrupt()
        self._delay = LoopDelay(REPORTED_STEP)
        self._speed.clear()
        self.watchdog.reset()
        self._check.reset()
        self.alive = False
        self._begin_at = -1e300
        self.torque = 0.0

    def status_text(self, now_s: float) -> str:
        """Return a status text for display."""
        if not self.alive:
            return "no force: the motor doesn't report"
        observer = self.observer
        return (
            f"force {1e3 * self.torque:+.2f} mN·m, loop {1e3 * self._delay.seconds(now_s):.0f} ms, "
            f"{1e3 * observer.absorbed:.1f} mJ absorbed, "
            f"{1e3 * observer.returned:.1f} mJ returned, {self.watchdog.silences} silences"
        )

    def report(self, now_s: float) -> dict[str, Any]:
        """Return the state for a line of JSON."""
        controller = self._controller
        return {
            "alive": self.alive,
            "torque_nm": round(self.torque, 6),
            "speed_rad_s": round(self._motion.speed, 4),
            "loop_delay_ms": round(1e3 * self._delay.seconds(now_s), 2),
            "commands": self.commands,
            "reports_per_s": self.watchdog.hz,
            "silences": self.watchdog.silences,
            "implausible": self._check.rejected,
            "absorbed_mj": round(1e3 * self.observer.absorbed, 4),
            "returned_mj": round(1e3 * self.observer.returned, 4),
            "friction_mj": round(1e3 * self.observer.friction_loss, 4),
            "rejected": controller.rejected,
            "limited": controller.limited,
            "damped": controller.damped,
        }


def require_motor(sensor: Sensor) -> None:
    """Raise InputError unless the profile has a motor."""
    if sensor.values["motor.protocol"] == "none":
        raise InputError(
            f"{sensor.source or sensor.name}: motor.protocol is 'none'; force needs a motor: "
            'choose sensor=simplefoc, or a file with [motor] and protocol = "simplefoc"'
        )
