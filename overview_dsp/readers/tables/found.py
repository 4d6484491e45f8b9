"""A series that was read, whether in one piece or as a stream."""

from __future__ import annotations

from dataclasses import dataclass

from overview_dsp.errors import InputError
from overview_dsp.readers.tables.events import Series
from overview_dsp.timeline.gaps import Gaps
from overview_dsp.timeline.model import Intensity

MAX_GAPS = 200_000
"""Most gaps: beyond, rows without a value are the rule."""


@dataclass(frozen=True, eq=False)
class Found:
    """What becomes a Timeline.

    Parameters
    ----------
    series
        Samples in which events are found, and the calendar.
    intensity
        The mapped curve.
    words
        What it is.
    gaps, gap_rule
        Where there is no data, and by which rule steps between samples are gaps.
    missing, count
        Samples without a value, and all.
    duration_s
        The last sample's time.
    notes
        What was done on the way.
    """

    series: Series
    intensity: Intensity
    words: str
    gaps: Gaps
    gap_rule: str
    missing: int
    count: int
    duration_s: float
    notes: tuple[str, ...]


def require_few_gaps(gaps: int) -> None:
    """Refuse a series of more gaps than `MAX_GAPS`."""
    if gaps > MAX_GAPS:
        raise InputError(
            f"more than {MAX_GAPS} gaps; keep the rows that have a value, or name another column"
        )
