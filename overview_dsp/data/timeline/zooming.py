"""Zooming about a moment: which window comes next."""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from dataclasses import dataclass, replace

from overview_dsp.data.timeline.model import Timeline
from overview_dsp.data.timeline.moments import ZOOM_LEAD

NARROWEST_S = 0.5
"""No window is narrower, s (or the whole, where that is shorter)."""


@dataclass(frozen=True)
class Zoom:
    """A window of a timeline, and the ones that can be reached from it; never beyond the ends.

    Parameters
    ----------
    timeline
        The whole.
    start_s, end_s
        The window on it, 0 <= start_s < end_s <= duration_s; InputError otherwise.
    """

    timeline: Timeline
    start_s: float
    end_s: float

    def __post_init__(self) -> None:
        self.timeline.require_window(self.start_s, self.end_s)

    @classmethod
    def whole(cls, timeline: Timeline) -> Zoom:
        """All of a timeline."""
        return cls(timeline, 0.0, timeline.duration_s)

    @property
    def window(self) -> tuple[float, float]:
        """(start_s, end_s)."""
        return self.start_s, self.end_s

    @property
    def width_s(self) -> float:
        """Length of the window, s."""
        return self.end_s - self.start_s

    def scaled(self, factor: float, moment_s: float, at: float) -> Zoom:
        """`factor` times as much detail, with a moment at `at` (0 to 1), as `around`."""
        narrowest = min(NARROWEST_S, self.timeline.duration_s)
        return self.around(moment_s, max(self.width_s / factor, narrowest), at)

    def around(self, moment_s: float, width_s: float, at: float = ZOOM_LEAD) -> Zoom:
        """A window of `width_s` with a moment at `at` (0 to 1) of it, or as near as it can."""
        whole = self.timeline.duration_s
        width = min(width_s, whole)
        start = min(max(moment_s - width * at, 0.0), whole - width)
        return replace(self, start_s=start, end_s=min(start + width, whole))

    def next_event_s(self, moment_s: float) -> float | None:
        """When the first event after a moment is, s; None after the last."""
        times = [event.time_s for event in self.timeline.events]
        index = bisect_right(times, moment_s)
        return times[index] if index < len(times) else None

    def previous_event_s(self, moment_s: float) -> float | None:
        """When the last event before a moment is, s; None before the first."""
        times = [event.time_s for event in self.timeline.events]
        index = bisect_left(times, moment_s)
        return times[index - 1] if index else None

    def showing(self, moment_s: float) -> Zoom:
        """This window if a moment lies in it, else one as wide about the moment."""
        if self.start_s <= moment_s <= self.end_s:
            return self
        return self.around(moment_s, self.width_s)
