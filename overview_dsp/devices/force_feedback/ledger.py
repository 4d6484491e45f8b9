"""The passivity observer: the energy that a hand has put into a knob, and that its motor gave.

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

ENOUGH_J = 2e-5
"""Credit that the knob's own friction brings at most: 2 mN m on a hundredth of a radian."""


class EnergyLedger:
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
