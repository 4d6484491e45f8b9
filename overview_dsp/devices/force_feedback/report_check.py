"""What a motor can't have done: a line of text has no check, a wrong digit is another number."""

from __future__ import annotations

FASTEST = 150.0
"""rad/s: no hand turns a knob so fast."""

SLACK_S = 0.01
"""Reports may come so much closer together than they were made."""

IN_A_ROW = 5
"""So many jumped reports that agree with each other are a device that began again."""


class ReportCheck:
    """Reports in, whether to believe them out.

    Attributes
    ----------
    refused : int
        Reports that weren't believed.
    restarted : bool
        Whether the latest one believed is the first of a device that began again.
    """

    def __init__(self, highest: float) -> None:
        """`highest` target that is ever sent."""
        self.refused = 0
        self.restarted = False
        self._highest = highest
        self._last: tuple[float, float] | None = None
        self._other: tuple[float, float] | None = None
        self._agreeing = 0

    def forget(self) -> None:
        """The device is gone: the next angle is a first one."""
        self._last = self._other = None

    def plausible(self, time_s: float, target: float, angle: float) -> bool:
        """Whether `target` was ever asked for, and the angle (rad) be reached by `time_s`."""
        self.restarted = False
        if abs(target) > self._highest:
            self.refused += 1
            return False
        here = (time_s, angle)
        if self._last is None or _reached(self._last, here):
            self._last, self._other = here, None
            return True
        near = self._other is not None and _reached(self._other, here)
        self._agreeing = self._agreeing + 1 if near else 1
        self._other = here
        if self._agreeing < IN_A_ROW:
            self.refused += 1
            return False
        self._last, self._other, self.restarted = here, None, True
        return True


def _reached(before: tuple[float, float], after: tuple[float, float]) -> bool:
    return abs(after[1] - before[1]) <= FASTEST * (after[0] - before[0] + SLACK_S)
