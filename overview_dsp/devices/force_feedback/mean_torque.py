"""The disk's torque as a motor needs it: the mean since the last look.

A goal passes in three milliseconds, shorter than a block of audio: single values would miss it,
the mean holds all of its impulse.
"""

from __future__ import annotations

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
