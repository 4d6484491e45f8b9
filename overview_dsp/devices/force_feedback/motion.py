"""How fast a knob turns, from angles that are known to a step only.

Of all lines through the latest angle that pass within the resolution of the angles before, the
middle one; the window is as long as there is such a line and its slope isn't known well (after
Janabi-Sharifi, Hayward, Chen, "Discrete-time adaptive windowing for velocity estimation", IEEE
Trans. Control Systems Technology 8(6), 2000). So it is short while the speed is high or changes,
and long at low speed. Where standing still is such a line too, the knob stands still.

How often something comes, over the latest second.

The disk's torque as a motor needs it: the mean since the last look.

A goal passes in three milliseconds, shorter than a block of audio: single values would miss it,
the mean holds all of its impulse.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

LONGEST_S = 0.05
WELL_KNOWN = 0.2
"""A speed's range, of the speed: a longer window would make it older for nothing."""

MOST = 100


@dataclass(frozen=True)
class Motion:
    """`speed` (rad/s), and how long ago it was so on average (`age_s`)."""

    speed: float = 0.0
    age_s: float = 0.0


class SpeedEstimator:
    """Angles with their times in, motion out."""

    def __init__(self, resolution: float) -> None:
        """`resolution`, rad: an angle is right to this, either way."""
        self._resolution = resolution
        self._latest: deque[tuple[float, float]] = deque(maxlen=MOST)

    def add(self, time_s: float, angle: float) -> None:
        """The knob was at `angle` (rad)."""
        if self._latest and time_s <= self._latest[-1][0]:
            self._latest.pop()  # two at one time: the later one
        self._latest.append((time_s, angle))

    def clear(self) -> None:
        """Forget every angle: they go on from another origin."""
        self._latest.clear()

    def motion(self) -> Motion:
        """As of the latest angle."""
        if len(self._latest) < 2:
            return Motion()
        points = reversed(self._latest)
        now, here = next(points)
        low, high, span = -1e300, 1e300, 0.0
        for then, angle in points:
            elapsed = now - then
            if elapsed > LONGEST_S and span > 0.0:
                break
            middle, reach = (here - angle) / elapsed, self._resolution / elapsed
            if middle - reach > high or middle + reach < low:
                break
            low, high, span = max(low, middle - reach), min(high, middle + reach), elapsed
            if high - low < WELL_KNOWN * 0.5 * abs(low + high):
                break
        if low <= 0.0 <= high:
            return Motion(0.0, 0.5 * span)
        return Motion(0.5 * (low + high), 0.5 * span)


WINDOW_S = 1.0


class Rate:
    """Moments in, their rate out.

    Attributes
    ----------
    hz : float or None
        Of the latest whole second; None before the first.
    """

    def __init__(self) -> None:
        """Nothing has come yet."""
        self.hz: float | None = None
        self._since: float | None = None
        self._count = 0

    def add(self, now_s: float) -> None:
        """It came."""
        if self._since is None:
            self._since = now_s
            return
        self._count += 1
        if now_s - self._since >= WINDOW_S:
            self.hz = self._count / (now_s - self._since)
            self._since, self._count = now_s, 0


STALE_S = 0.05
"""An engine that hasn't moved on for so long has lost its output: its torque is none."""


class MeanTorque:
    """Looks at the torque's integral in, mean torque out."""

    def __init__(self) -> None:
        """Nothing has been seen yet."""
        self._seen: tuple[float, float] | None = None
        self._moved_at = 0.0
        self._torque = 0.0

    def look(self, impulse: tuple[float, float], now_s: float) -> float:
        """The mean torque (N m) of the latest blocks.

        `impulse` is `Engine.impulse`: time processed (s) and the torque's integral (N m s);
        `now_s` is of any clock that goes forward.
        """
        time_s, integral = impulse
        if self._seen is None or time_s < self._seen[0]:  # the first look, or a reset
            self._seen, self._moved_at, self._torque = impulse, now_s, 0.0
        elif time_s > self._seen[0]:
            self._torque = (integral - self._seen[1]) / (time_s - self._seen[0])
            self._seen, self._moved_at = impulse, now_s
        elif now_s - self._moved_at > STALE_S:
            self._torque = 0.0
        return self._torque
