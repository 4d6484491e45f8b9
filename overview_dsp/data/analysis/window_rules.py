"""What finds the events of a part of a series: the rules of the whole, on its own samples."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from datetime import datetime, timedelta

import numpy as np
from numpy.typing import NDArray

from overview_dsp.data.analysis import curve_maps
from overview_dsp.data.analysis.extrema import lows_and_highs
from overview_dsp.data.analysis.series_events import Series, find_part_events
from overview_dsp.data.analysis.series_labels import Calendar
from overview_dsp.data.timeline.event import Event
from overview_dsp.data.timeline.gaps import Gaps, cut_gaps
from overview_dsp.data.timeline.intensity import LONG
from overview_dsp.data.timeline.model import Intensity, Timeline

MOST_SAMPLES = 2048
"""Samples looked at; of more, the lowest and the highest of equal runs and the largest steps."""

_NONE = np.empty(0)


@dataclass(frozen=True, eq=False)
class PartRules:
    """The samples of a part (`timeline.fine_events.Rules`).

    Parameters
    ----------
    series
        Those of the whole, or the lowest and highest of runs of them.
    start_s, end_s
        The part, on the whole's axis.
    curve
        The whole's values at all samples, where `series` has only some; else None.
    gaps
        Of the whole.
    """

    series: Series
    start_s: float
    end_s: float
    curve: Intensity | None = None
    gaps: Gaps = ()

    def cut(self, start_s: float, end_s: float) -> PartRules:
        """Return the same for a part of this one."""
        return replace(self, start_s=self.start_s + start_s, end_s=self.start_s + end_s)

    def found(self, duration_s: float) -> Iterator[Event]:
        """Give what is found, what matters most first; each of another sample."""
        series = self._all() or self.part()
        yield from find_part_events(_thinned(series), duration_s)

    def part(self) -> Series:
        """Return the samples of the part that `series` has, on an axis that begins with it."""
        series = self.series
        first, stop = np.searchsorted(series.time_s, (self.start_s, self.end_s))
        stop += int(stop < len(series.time_s) and series.time_s[stop] == self.end_s)
        return replace(
            series,
            time_s=series.time_s[first:stop] - self.start_s,
            value=series.value[first:stop],
            step=series.step[first:stop],
            calendar=self._calendar(),
            splits=(),
        )

    def _calendar(self) -> Calendar:
        calendar, start = self.series.calendar, self.series.calendar.start
        if start is None:
            return calendar
        return Calendar(start + timedelta(seconds=self.start_s), calendar.dates_only)

    def _all(self) -> Series | None:
        """All samples of the part, from the curve; None if that isn't there or has too many."""
        if self.curve is None:
            return None
        part = self.curve.cut(self.start_s, self.end_s)
        if part is None or part.count > LONG:
            return None
        time_s = np.asarray(part.time_s)[1:-1]  # the ends are interpolated
        value = np.asarray(part.value, dtype=np.float64)[1:-1]
        series = replace(self.series, calendar=self._calendar())
        gaps, _ = cut_gaps(self.gaps, (), self.start_s, self.end_s)
        return _of(time_s, value, gaps, series, _NONE)


def rules_of(curve: Intensity, relative: bool, timeline: Timeline) -> PartRules:
    """Return the rules for a series that is the curve of values, such as one a file keeps.

    Parameters
    ----------
    curve
        The values at all samples.
    relative
        Steps are per cent.
    timeline
        Whose series it is: its gaps, splits and calendar count.
    """
    time_s = np.asarray(curve.time_s[:])
    calendar = Calendar(timeline.start, only_dates(timeline.start, time_s))
    like = Series(_NONE, _NONE, _NONE, relative, curve.unit, calendar)
    splits = np.array([event.time_s for event in timeline.events if event.kind == "split"])
    value = np.asarray(curve.value, dtype=np.float64)
    series = _of(time_s, value, timeline.gaps, like, splits)
    return PartRules(series, 0.0, timeline.duration_s)


def only_dates(start: datetime | None, time_s: NDArray[np.float64]) -> bool:
    """Return whether all samples are at midnight."""
    if start is None or (start.hour, start.minute, start.second) != (0, 0, 0):
        return False
    return not np.any(np.mod(np.round(time_s, 6), 86_400.0))


def _of(
    time_s: NDArray[np.float64],
    value: NDArray[np.float64],
    gaps: Gaps,
    like: Series,
    splits: NDArray[np.float64],
) -> Series:
    """A series of samples with their steps: none over a gap, nor to a share split."""
    ends = np.concatenate(([end for _, end in gaps], splits))
    after = np.unique(np.searchsorted(time_s, ends))  # a gap may end between two samples
    over = after[(after > 0) & (after < len(time_s))] - 1
    step = curve_maps.steps(value, over, like.relative)
    return replace(like, time_s=time_s, value=value, step=step, every=True)


def _thinned(part: Series) -> Series:
    if len(part.value) <= MOST_SAMPLES:
        return part
    run = -(-2 * len(part.value) // MOST_SAMPLES)
    size = np.nan_to_num(np.abs(part.step))
    kept = np.zeros(len(size), np.bool_)
    kept[lows_and_highs(part.value, run)] = True
    kept[np.argpartition(size, len(size) - 32)[-32:]] = True
    return replace(
        part, time_s=part.time_s[kept], value=part.value[kept], step=part.step[kept], every=False
    )
