"""Whether a gyroscope and gravity show the same turning; if not, what is wrong with the file.

Over a third of a second gravity's direction turns by an angle that the accelerometer shows, and
the gyroscope's path across gravity can't be shorter. Degrees taken for radians make it 57 times as
long, radians taken for degrees 57 times too short, a wrong axis or sign leads elsewhere.
"""

from __future__ import annotations

import math
import statistics
from collections import deque

from overview_dsp.devices.sensors.orientation import unit
from overview_dsp.devices.sensors.units import GRAVITY, Vector

WINDOW_S = 0.3
LEAST = math.radians(20.0)
"""Less may be a push: a hand's own acceleration tilts what looks like gravity."""

CALM = 0.1
"""Accelerations that differ from gravity by more of it say nothing of up, and end the window."""

WINDOWS = 7
FAR_TOO_LONG, FAR_TOO_SHORT = 15.0, 0.2
ELSEWHERE = 0.8
"""Of the angle that gravity turned: a sensor that is right is off by a few hundredths of it."""


class GyroscopeCheck:
    """Samples in, a complaint out, if there is one."""

    def __init__(self) -> None:
        """Nothing has turned."""
        self._start: Vector | None = None
        self._led: Vector = (0.0, 0.0, 1.0)
        self._path = self._since = 0.0
        self._time = 0.0
        self._ratios: deque[float] = deque(maxlen=WINDOWS)
        self._misses: deque[float] = deque(maxlen=WINDOWS)

    def step(self, time_s: float, acceleration: Vector, turning: Vector) -> str:
        """What is wrong, in words, or nothing."""
        elapsed_s, self._time = time_s - self._time, time_s
        calm = abs(math.hypot(*acceleration) / GRAVITY - 1.0) < CALM
        if self._start is None or not calm or elapsed_s > WINDOW_S:
            self._begin(acceleration if calm else None)
            return ""
        x, y, z = self._led
        p, q, r = turning
        step = (q * z - r * y, r * x - p * z, p * y - q * x)
        self._led = unit(
            (x - step[0] * elapsed_s, y - step[1] * elapsed_s, z - step[2] * elapsed_s)
        )
        self._path += math.hypot(*step) * elapsed_s
        self._since += elapsed_s
        if self._since < WINDOW_S:
            return ""
        self._compare(unit(acceleration))
        self._begin(acceleration)
        return self._verdict()

    def _begin(self, acceleration: Vector | None) -> None:
        self._start = None if acceleration is None else unit(acceleration)
        self._led = self._start or (0.0, 0.0, 1.0)
        self._path = self._since = 0.0

    def _compare(self, end: Vector) -> None:
        assert self._start is not None
        angle = _between(self._start, end)
        if angle > LEAST:
            self._ratios.append(self._path / angle)
            self._misses.append(_between(self._led, end) / angle)

    def _verdict(self) -> str:
        if len(self._ratios) < WINDOWS:
            return ""
        if min(self._ratios) > FAR_TOO_LONG:
            return "the gyroscope turns far more than gravity does: is it in deg/s, not rad/s?"
        if max(self._ratios) < FAR_TOO_SHORT:
            return "the gyroscope turns far less than gravity does: is it in rad/s, not deg/s?"
        if statistics.median(self._misses) > ELSEWHERE:
            return "the gyroscope turns another way than gravity does: is an axis or a sign wrong?"
        return ""


def _between(a: Vector, b: Vector) -> float:
    """The angle between two unit vectors, rad."""
    cosine = a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
    return math.acos(max(-1.0, min(1.0, cosine)))
