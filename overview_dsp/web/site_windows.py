"""The parts that a page can zoom to: each level a third as long, half overlapping.

A page can't make a surface; it is given those of these windows. Any moment lies in the middle half
of one of each level, so that a zoom about it finds what led to it and what came of it.
"""

from __future__ import annotations

from dataclasses import dataclass

from overview_dsp.data.timeline import Timeline
from overview_dsp.data.timeline.zooming import NARROWEST_S

RATIO = 3


@dataclass(frozen=True)
class Part:
    """A window (s) of a level; level 0 is the whole."""

    level: int
    start_s: float
    end_s: float


def site_windows(timeline: Timeline, levels: int) -> list[Part]:
    """The whole, then the windows of each level in order of time."""
    whole = timeline.duration_s
    parts = [Part(0, 0.0, whole)]
    for level in range(1, levels + 1):
        width = whole / RATIO**level
        if width < NARROWEST_S:
            break
        count = 2 * RATIO**level - 1
        for i in range(count):
            start = min(i * width / 2.0, whole - width)
            end = whole if i == count - 1 else start + width
            parts.append(Part(level, start, end))
    return parts
