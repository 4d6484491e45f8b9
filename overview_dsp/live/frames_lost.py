"""How many frames an output should have delivered, by the clock, and did not."""

from __future__ import annotations

SLOT_S = 0.5
SLACK_S = 0.002


class FramesLost:
    """Counts gaps of an output; the count only grows.

    An output is a little behind the clock all the time, by what it has delivered last and when it
    is looked at; the least of half a second is nearly free of that. Where it rises by more than a
    block from one half second to the next, frames were lost. A device's own clock, which drifts
    away from the computer's, is none of it.

    Thread: one.
    """

    def __init__(self) -> None:
        self.count = 0
        self.restart()

    def restart(self) -> None:
        """A new output, or one that was paused: what is lost is counted from its next frame on."""
        self._before: float | None = None
        self._least: float | None = None
        self._until = 0.0

    def look(self, now_s: float, frames: int, sample_rate: float, block_size: int) -> None:
        """At `now_s` the output had delivered so many frames since its start; look often."""
        behind = now_s * sample_rate - frames
        if self._least is None:
            self._until = now_s + SLOT_S
        elif now_s >= self._until:
            slack = block_size + SLACK_S * sample_rate
            if self._before is not None and self._least - self._before > slack:
                self.count += round(self._least - self._before)
            self._before, self._least = self._least, None
            self._until = now_s + SLOT_S
        self._least = behind if self._least is None else min(self._least, behind)
