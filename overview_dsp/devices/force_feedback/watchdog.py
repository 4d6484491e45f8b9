"""Watchdog: the torque ends within 50 ms after the last report of a motor; rate of the reports."""

from __future__ import annotations

SILENT_S = 0.04
"""Time without a report after which the torque ends; step and wire need the rest of the 50 ms."""

STEADY_S = 0.1  # time of reports without a gap after which the motor gets torque (again)
WINDOW_S = 1.0


class Watchdog:
    """Decides from the times of reports whether a motor may have torque.

    `hz` is the rate of reports in the latest whole second without a gap, None before.
    """

    def __init__(self) -> None:
        self.silences = 0
        self.reset()

    def reset(self) -> None:
        """Forget all reports, because the device is disconnected."""
        self._latest_at = self._since = -1e300
        self._alive = False
        self.hz: float | None = None
        self._window_at, self._count = -1e300, 0

    def message_received(self, now_s: float) -> None:
        """Note a valid report of the device."""
        if now_s - self._latest_at > SILENT_S:
            self._since = self._window_at = now_s
            self.hz, self._count = None, -1
        self._count += 1
        if now_s - self._window_at >= WINDOW_S:
            self.hz = round(self._count / (now_s - self._window_at), 1)
            self._window_at, self._count = now_s, 0
        self._latest_at = now_s
        if now_s - self._since >= STEADY_S:
            self._alive = True

    def alive(self, now_s: float) -> bool:
        """Return whether there may be torque."""
        if self._alive and now_s - self._latest_at > SILENT_S:
            self._alive = False
            self.silences += 1
        return self._alive
