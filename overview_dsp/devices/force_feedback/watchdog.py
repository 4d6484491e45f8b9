"""Silence: within 50 ms of the last word from a motor there is no torque any more."""

from __future__ import annotations

SILENT_S = 0.04
"""Silence so long ends the torque; of the 50 ms the rest is for the step and the wire."""

STEADY_S = 0.1
"""Heard for so long without a silence, a motor gets torque (again)."""


class Watchdog:
    """Words heard in, whether there may be torque out."""

    def __init__(self) -> None:
        """Nothing was heard yet."""
        self.silences = 0
        self._heard_at = self._since = -1e300
        self._alive = False

    def forget(self) -> None:
        """The device is gone: whatever speaks next begins anew."""
        self._heard_at = self._since = -1e300
        self._alive = False

    def heard(self, now_s: float) -> None:
        """The device said something that was understood."""
        if now_s - self._heard_at > SILENT_S:
            self._since = now_s
        self._heard_at = now_s
        if now_s - self._since >= STEADY_S:
            self._alive = True

    def alive(self, now_s: float) -> bool:
        """Whether there may be torque."""
        if self._alive and now_s - self._heard_at > SILENT_S:
            self._alive = False
            self.silences += 1
        return self._alive
