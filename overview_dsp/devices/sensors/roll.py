"""Roll to theta2: face up 0, face down pi, by either wrist.

theta2 is the size of the roll angle, so that a turn to the left and one to the right go the same
way and nothing jumps where the angle's sign does. Where the device points up or down (pitch beyond
85 degrees) a small tilt is any roll: theta2 is held there, and joins the true one again, no faster
than 400 degrees a second, once it is flatter than 82.
"""

from __future__ import annotations

import math

from overview_dsp.devices.sensors.units import Vector

STEEP = math.cos(math.radians(85.0))
FLAT = math.cos(math.radians(82.0))
JOIN_RAD_S = math.radians(400.0)


class Roll:
    """theta2 from where up is.

    Attributes
    ----------
    roll : float
        rad, -pi to pi, right-handed about x; also while `theta2` is held.
    pitch : float
        rad; how far x points up.
    steep : bool
        theta2 is held.
    """

    def __init__(self) -> None:
        """Face up."""
        self.roll = self.pitch = 0.0
        self.steep = False
        self._theta2: float | None = None
        self._offset = 0.0

    def jumped(self) -> None:
        """The next angle may be elsewhere: join it slowly."""
        self.steep = True

    def step(self, elapsed_s: float, up: Vector) -> float:
        """theta2 (rad, 0 to pi) after `elapsed_s` more; `up` as `Orientation.step` says it."""
        self.roll = math.atan2(up[1], up[2])
        flatness = math.hypot(up[1], up[2])
        self.pitch = math.atan2(up[0], flatness)
        true = abs(self.roll)
        if flatness < (FLAT if self.steep else STEEP):
            self.steep = True
            self._theta2 = true if self._theta2 is None else self._theta2
            return self._theta2
        if self.steep and self._theta2 is not None:
            self._offset = self._theta2 - true
        self.steep = False
        most = JOIN_RAD_S * elapsed_s
        self._offset -= max(-most, min(most, self._offset))
        self._theta2 = max(0.0, min(math.pi, true + self._offset))
        return self._theta2
