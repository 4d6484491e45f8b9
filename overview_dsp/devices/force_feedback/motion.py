"""Estimates for the motor's loop: speed of the knob, mean torque of the disk.

The speed follows from angles of limited resolution. Of all lines through the latest angle that pass
within the resolution of the angles before, the middle one counts. The window is as long as there is
such a line and its slope isn't known well (after Janabi-Sharifi, Hayward, Chen, "Discrete-time
adaptive windowing for velocity estimation", IEEE Trans. Control Systems Technology 8(6), 2000). So
the window is short while the speed is high or changes, and long at low speed. Where a line of speed
0 fits too, the speed is 0.

A motor needs the mean torque of the disk since the last update. A goal passes in three
milliseconds, less than a block of audio: single values would miss it, the mean includes all of it.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

LONGEST_S = 0.05
WELL_KNOWN = 0.2
"""Relative range of speeds at which the window ends; a longer one would only add delay."""

MAX_ANGLES = 100


@dataclass(frozen=True)
class Motion:
    """`speed` (rad/s), and its mean age (`age_s`)."""

    speed: float = 0.0
    age_s: float = 0.0


class SpeedEstimator:
    """Speed from angles with times."""

    def __init__(self, resolution: float) -> None:
        """Take each angle as correct to `resolution`, rad, either way."""
        self._resolution = resolution
        self._latest: deque[tuple[float, float]] = deque(maxlen=MAX_ANGLES)

    def add(self, time_s: float, angle: float) -> None:
        """Add an angle (rad)."""
        if self._latest and time_s <= self._latest[-1][0]:
            self._latest.pop()  # of two at one time the later one counts
        self._latest.append((time_s, angle))

    def clear(self) -> None:
        """Forget all angles, because the next ones have another origin."""
        self._latest.clear()

    def motion(self) -> Motion:
        """Return the motion at the latest angle."""
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
        return Motion(0.0 if low <= 0.0 <= high else 0.5 * (low + high), 0.5 * span)


STALE_S = 0.05
"""Time after which an engine that hasn't advanced has lost its output: its torque is then 0."""


class MeanTorque:
    """Mean torque from the torque's integral."""

    def __init__(self) -> None:
        self._latest: tuple[float, float] | None = None
        self._moved_at = 0.0
        self._torque = 0.0

    def update(self, integral: tuple[float, float], now_s: float) -> float:
        """Return the mean torque (N m) of the latest blocks, at `now_s` of any monotonic clock.

        `integral`: processed time (s) and the torque's integral (N m s), of the engine.
        """
        time_s, total = integral
        if self._latest is None or time_s < self._latest[0]:  # the first update, or a reset
            self._latest, self._moved_at, self._torque = integral, now_s, 0.0
        elif time_s > self._latest[0]:
            self._torque = (total - self._latest[1]) / (time_s - self._latest[0])
            self._latest, self._moved_at = integral, now_s
        elif now_s - self._moved_at > STALE_S:
            self._torque = 0.0
        return self._torque
