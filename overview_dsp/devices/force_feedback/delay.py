"""How long a torque takes to be applied and reported: measured by the device's own reports."""

from __future__ import annotations

from collections import deque

UNKNOWN_S = 0.05
"""Before anything was measured."""

FORGOTTEN_S = 0.5
"""A torque that wasn't reported for so long was lost on the wire."""

EASE = 0.01
"""Of a shorter delay than the one held, how much counts: a longer one counts at once."""


class LoopDelay:
    """Targets sent and reported in, the loop's delay out.

    Attributes
    ----------
    measured : bool
        Whether any delay was.
    """

    def __init__(self, resolution: float) -> None:
        """`resolution`: reported targets are right to this."""
        self.measured = False
        self._held = UNKNOWN_S
        self._resolution = resolution
        self._waiting: deque[tuple[float, float]] = deque()
        self._sent = self._applied = 0.0

    def sent(self, now_s: float, target: float) -> None:
        """`target` was sent."""
        if abs(target - self._sent) > self._resolution:
            self._waiting.append((now_s, target))
            self._sent = target
        while self._waiting and now_s - self._waiting[0][0] > FORGOTTEN_S:
            self._waiting.popleft()

    def reported(self, now_s: float, target: float) -> None:
        """The device says that it applies `target`."""
        if abs(target - self._applied) <= self._resolution:
            return
        self._applied = target
        for index, (sent_at, waiting) in enumerate(self._waiting):
            if abs(waiting - target) <= self._resolution:
                for _ in range(index + 1):
                    self._waiting.popleft()
                took = now_s - sent_at
                if not self.measured or took > self._held:
                    self._held, self.measured = took, True
                else:
                    self._held += EASE * (took - self._held)
                return

    @property
    def waits(self) -> bool:
        """Whether a target is under way."""
        return bool(self._waiting)

    def seconds(self, now_s: float) -> float:
        """From sending a target to hearing that it is applied, s: about the longest of late.

        At least how long the oldest target that wasn't reported has waited.
        """
        waited = now_s - self._waiting[0][0] if self._waiting else 0.0
        return max(self._held, waited)
