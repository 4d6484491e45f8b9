"""Passivity controller and observer: the motor gives the hand no energy, whatever the delay.

The surface's torque is friction: it may brake the knob and never turns it. It requests a damping of
the knob, which three rules change (as in Hannaford, Ryu 2002). `hold` is the time for which a
torque sent now acts unrevised: the loop's delay, the speed's age, and the time to the next command.

1. The torque brakes, or is 0. A friction that lags would push the hand after it turns back.
2. torque <= 3/4 * inertia * |speed| / hold. A delayed damping d oscillates if d * hold / inertia
   passes 3/2, where d may change with time (Yoneyama, "On the 3/2 stability theorem", J. Math.
   Analysis and Applications 125, 1987). A hand on the knob adds inertia.
3. torque * distance <= credit. If the hand turned back now, the torque would give this energy
   before it could be revised, so the credit must cover it. `distance` is what a hand can turn in
   `hold`.
   Where the motor gave more than it absorbed (credit < 0), the surface has no torque. Damping is
   then added until the balance is restored, while the direction is stable for as long as `hold`.

The passivity observer measures the energy that a hand puts into a knob and that its motor gives:

    work = torque * (angle - angle before)

of each report: > 0 is given, < 0 absorbed (Hannaford, Ryu, "Time-domain passivity control of haptic
interfaces", IEEE Trans. Robotics and Automation 18(1), 2002). A report has torque and angle of one
instant, so the sum is correct whatever the delay, and only late. Of the torques at both ends of a
step the less favourable one counts.

`credit` is the absorbed minus the given energy, up to a limit: energy absorbed long ago doesn't
permit a push now (Ryu, Preusche, Hannaford, Hirzinger, "Time domain passivity control with
reference energy following", IEEE Trans. Control Systems Technology 13(5), 2005). From 0 it rises by
the energy that the knob's own friction takes from a hand with a stable direction. Without that rise
there would never be a first torque.
"""

from __future__ import annotations

from overview_dsp.devices.force_feedback.motion import Motion

MARGIN = 0.75  # factor of rule 2: half of the torque that would oscillate
HIGHEST_HAND_ACCELERATION = 300.0  # highest acceleration of a knob by a hand, rad/s2


class PassivityController:
    """Limits requested torques to passive ones.

    `rejected`, `limited`, `damped` count steps in which a push was rejected, a brake was limited,
    or damping was added. `direction_stable`: whether the hand keeps its direction while a torque
    sent now acts.
    """

    def __init__(self, inertia: float, ceiling: float) -> None:
        """Control a knob of `inertia`, kg m2, with torques of at most `ceiling`, N m."""
        self.rejected = self.limited = self.damped = 0
        self.direction_stable = False
        self._inertia = inertia
        self._ceiling = ceiling
        self._direction = 0.0
        self._turned_at = -1e300
        self._previous_stroke_s = 1e300

    def step(
        self, requested: float, motion: Motion, credit: float, delay_s: float, now_s: float
    ) -> float:
        """Return the torque to send (N m, along the angle) for the `requested` one.

        `credit` is the observer's (J), `delay_s` the loop's delay up to the next command.
        """
        speed = abs(motion.speed)
        if speed == 0.0:
            self.direction_stable = False
            self.rejected += requested != 0.0
            return 0.0
        direction = 1.0 if motion.speed > 0.0 else -1.0
        if direction != self._direction:
            self._direction, self._previous_stroke_s = direction, now_s - self._turned_at
            self._turned_at = now_s
        brake = -requested * direction
        if brake < 0.0:
            self.rejected += 1
            brake = 0.0
        hold = delay_s + motion.age_s
        # strokes of a hand that moves back and forth have similar durations
        since, previous = now_s - self._turned_at, self._previous_stroke_s
        self.direction_stable = since > hold and (
            since + 2.0 * hold < previous or since > 3.0 * previous
        )
        distance = (speed + 0.5 * HIGHEST_HAND_ACCELERATION * hold) * hold
        highest = min(self._ceiling, MARGIN * self._inertia * speed / hold)
        if credit >= 0.0:
            highest = min(highest, credit / distance)
        elif self.direction_stable:
            self.damped += 1
            brake = -credit / distance
        else:
            highest = 0.0
        if brake > highest:
            self.limited += 1
            brake = highest
        return -direction * brake


FRICTION_CREDIT_J = 2e-5
"""Largest credit from the knob's own friction: 2 mN m over a hundredth of a radian."""


class PassivityObserver:
    """Energy balance from torques and angles, J.

    `absorbed`, `returned`: energies that the motor absorbed and gave. `friction_loss`: energy that
    the knob's own friction took and that was credited. `credit`: energy that the motor may give
    now; negative = it gave more than it absorbed.
    """

    def __init__(self, limit: float, friction: float, resolution: float) -> None:
        """Set the limit of the credit, J, the least friction, N m, and the angles' resolution."""
        self.absorbed = self.returned = self.friction_loss = self.credit = 0.0
        self._limit = limit
        self._friction = friction
        self._resolution = resolution
        self._last: tuple[float, float] | None = None
        self._play_angle = 0.0

    def add(self, torque: float, angle: float, direction_stable: bool) -> None:
        """Add a report: the device applies `torque` (N m, along the angle) at `angle` (rad).

        `direction_stable` is that of the controller.
        """
        if self._last is None:
            self._last, self._play_angle = (torque, angle), angle
            return
        turned = angle - self._last[1]
        work = max(torque * turned, self._last[0] * turned)
        if work > 0.0:
            self.returned += work
        else:
            self.absorbed -= work
        # an angle that follows with some play doesn't move with noise
        distance = abs(angle - self._play_angle) - self._resolution
        if distance > 0.0:
            self._play_angle += distance if angle > self._play_angle else -distance
            if direction_stable:
                loss = min(self._friction * distance, max(0.0, FRICTION_CREDIT_J - self.credit))
                self.friction_loss += loss
                self.credit += loss
        self.credit = min(self.credit - work, self._limit)
        self._last = (torque, angle)

    def interrupt(self) -> None:
        """Skip the step to the next report, because the device was disconnected."""
        self._last = None
