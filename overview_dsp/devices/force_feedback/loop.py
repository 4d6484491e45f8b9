"""The motor's loop: reports and the disk's torque in, commands out; opens no device."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any

from overview_dsp.devices.force_feedback.commander import TARGET_STEP, Commander
from overview_dsp.devices.force_feedback.delay import LoopDelay
from overview_dsp.devices.force_feedback.ledger import EnergyLedger
from overview_dsp.devices.force_feedback.motion import Motion, SpeedEstimator
from overview_dsp.devices.force_feedback.passivity import PassivityController
from overview_dsp.devices.force_feedback.rate import Rate
from overview_dsp.devices.force_feedback.report_check import ReportCheck
from overview_dsp.devices.force_feedback.watchdog import Watchdog
from overview_dsp.devices.sensors.profile import MOTOR_COLUMNS, Sensor
from overview_dsp.devices.sensors.stream import Sample
from overview_dsp.errors import InputError

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
    ledger : EnergyLedger
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
        letter = str(sensor.values["motor.letter"])
        self._commander = Commander(letter, round(sensor.number("motor.downsample")))
        self._controller = PassivityController(sensor.number("motor.inertia"), ceiling)
        resolution = math.radians(sensor.number("motor.resolution_deg"))
        self._friction = sensor.number("motor.friction_nm")
        self._probe = 0
        self._speed = SpeedEstimator(resolution)
        self._delay = LoopDelay(REPORTED_STEP)
        self._watchdog = Watchdog()
        self._check = ReportCheck(ceiling / self._per_target + TARGET_STEP)
        self.ledger = EnergyLedger(ceiling * CREDIT_RAD, self._friction, resolution)
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
            "put_in_mj": round(1e3 * self.ledger.put_in, 4),
            "given_mj": round(1e3 * self.ledger.given, 4),
            "rubbed_mj": round(1e3 * self.ledger.rubbed, 4),
            "refused": controller.refused,
            "lessened": controller.lessened,
            "damped": controller.damped,
        }


def require_motor(sensor: Sensor) -> None:
    """InputError unless the profile has a motor and says what it needs."""
    where = sensor.source or sensor.name
    if sensor.values["motor.protocol"] == "none":
        raise InputError(
            f"{where}: motor.protocol is none, and --force needs a motor; choose --sensor "
            'simplefoc, or a file with [motor] and protocol = "simplefoc"'
        )
