"""The passivity controller: a torque that gives the hand no energy, whatever the delay.

The surface's torque is friction: it may brake the knob, and never turns it. What it asks for is a
damping of the knob; that damping is changed (as in Hannaford, Ryu 2002) by three rules. With the
speed as last known and `hold`, how long a torque sent now acts unrevised (the loop's delay, the
speed's age, the time to the next command):

1. It brakes, or is 0: a friction that lags behind a hand that has turned back would push it.
2. torque <= 3/4 * inertia * |speed| / hold: a delayed damping d swings if d * hold / inertia
   passes 3/2, d may change with time (Yoneyama, "On the 3/2 stability theorem", J. Math. Analysis
   and Applications 125, 1987). A hand that holds on adds inertia.
3. torque * way <= credit: should the hand turn back at this moment, the torque would give so much
   before it could be taken back, and the ledger must have it. `way` is what a hand could do in
   `hold`. Where more was given than put in (credit < 0), the surface has no torque; damping is
   added until that is paid back, where the hand is sure to go on for so long.

The passivity observer: the energy that a hand has put into a knob, and that its motor gave.

    work = torque * (angle - angle before)

of each report: > 0 is given, < 0 put in (Hannaford, Ryu, "Time-domain passivity control of haptic
interfaces", IEEE Trans. Robotics and Automation 18(1), 2002). Torque and angle are both as the
device reports them of one instant, so the sum is true whatever the delay: it only comes late. Of
the torques at both ends of a step the one counts that is worse for the balance.

`credit` is put in - given, held to a limit: what was taken long ago is no leave to push now (Ryu,
Preusche, Hannaford, Hirzinger, "Time domain passivity control with reference energy following",
IEEE Trans. Control Systems Technology 13(5), 2005). From nothing it rises by what the knob's own
friction takes from a hand that goes on in one direction, or no torque would ever begin.
"""

from __future__ import annotations

from overview_dsp.devices.force_feedback.motion import Motion

MARGIN = 0.75
"""Rule 2's factor: half of what would swing."""

QUICKEST = 300.0
"""How fast a hand speeds a knob up, rad/s2."""


class PassivityController:
    """Torques that are wanted in, torques that may be had out.

    Attributes
    ----------
    refused, lessened, damped : int
        Steps in which a push was refused, a brake lessened, or damping added.
    goes_on : bool
        Whether the hand is sure to keep its direction while a torque sent now acts.
    """

    def __init__(self, inertia: float, ceiling: float) -> None:
        """`inertia` of the knob, kg m2; `ceiling`, N m, is never passed."""
        self.refused = self.lessened = self.damped = 0
        self.goes_on = False
        self._inertia = inertia
        self._ceiling = ceiling
        self._direction = 0.0
        self._turned_at = -1e300
        self._lasted = 1e300

    def step(
        self, wanted: float, motion: Motion, credit: float, delay_s: float, now_s: float
    ) -> float:
        """The torque to send (N m, along the angle); `wanted` is too.

        `credit` is the ledger's (J), `delay_s` the loop's up to the next command.
        """
        speed = abs(motion.speed)
        if speed == 0.0:
            self.goes_on = False
            if wanted != 0.0:
                self.refused += 1
            return 0.0
        direction = 1.0 if motion.speed > 0.0 else -1.0
        if direction != self._direction:
            self._direction, self._lasted = direction, now_s - self._turned_at
            self._turned_at = now_s
        brake = -wanted * direction
        if brake < 0.0:
            self.refused += 1
            brake = 0.0
        hold = delay_s + motion.age_s
        self.goes_on = self._sure(now_s - self._turned_at, hold)
        way = (speed + 0.5 * QUICKEST * hold) * hold
        highest = min(self._ceiling, MARGIN * self._inertia * speed / hold)
        if credit >= 0.0:
            highest = min(highest, credit / way)
        elif self.goes_on:
            self.damped += 1
            brake = -credit / way
        else:
            highest = 0.0
        if brake > highest:
            self.lessened += 1
            brake = highest
        return -direction * brake

    def _sure(self, since: float, hold: float) -> bool:
        # a hand that goes to and fro takes about as long each way
        return since > hold and (since + 2.0 * hold < self._lasted or since > 3.0 * self._lasted)


ENOUGH_J = 2e-5
"""Credit that the knob's own friction brings at most: 2 mN m on a hundredth of a radian."""


class PassivityObserver:
    """Torques and angles in, energies out.

    Attributes
    ----------
    put_in, given, rubbed : float
        Taken by the motor, given by it, taken by the knob's own friction and counted so far, J.
    credit : float
        What may be given now, J; negative = more was given than put in.
    """

    def __init__(self, limit: float, friction: float, resolution: float) -> None:
        """`limit` of the credit, J; `friction`, N m, at least; `resolution` of the angles, rad."""
        self.put_in = self.given = self.rubbed = self.credit = 0.0
        self._limit = limit
        self._friction = friction
        self._resolution = resolution
        self._last: tuple[float, float] | None = None
        self._dragged = 0.0

    def add(self, torque: float, angle: float, goes_on: bool) -> None:
        """The device applies `torque` (N m, along the angle) and is at `angle` (rad).

        `goes_on`: whether the hand is sure to keep its direction.
        """
        if self._last is None:
            self._last, self._dragged = (torque, angle), angle
            return
        turned = angle - self._last[1]
        work = max(torque * turned, self._last[0] * turned)
        if work > 0.0:
            self.given += work
        else:
            self.put_in -= work
        # what is dragged along with some play doesn't move with the angle's noise
        way = abs(angle - self._dragged) - self._resolution
        if way > 0.0:
            self._dragged += way if angle > self._dragged else -way
            if goes_on:
                rubbed = min(self._friction * way, max(0.0, ENOUGH_J - self.credit))
                self.rubbed += rubbed
                self.credit += rubbed
        self.credit = min(self.credit - work, self._limit)
        self._last = (torque, angle)

    def interrupt(self) -> None:
        """The device was lost: what it did until its next report isn't known."""
        self._last = None
