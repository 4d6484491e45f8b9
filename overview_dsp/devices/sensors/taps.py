"""Tap-tap: two short pulses on the device."""

from __future__ import annotations

PULSE = 10.0
"""m/s² beyond gravity that is a pulse: a hand that turns fast stays below 5."""

ONE_S = 0.08
"""A pulse rings so long."""

APART_S = 0.5
"""Two pulses within this are a tap-tap."""


class TapTap:
    """Finds tap-taps in the size of the acceleration."""

    def __init__(self) -> None:
        """Nothing has been hit."""
        self._ringing_until = self._first = -1e300

    def step(self, time_s: float, beyond_gravity: float) -> bool:
        """Whether a tap-tap is complete; `beyond_gravity` is |a| - g, m/s², of any sign."""
        if abs(beyond_gravity) < PULSE:
            return False
        begins = time_s > self._ringing_until
        self._ringing_until = time_s + ONE_S
        if not begins:
            return False
        if time_s - self._first <= APART_S:
            self._first = -1e300
            return True
        self._first = time_s
        return False
