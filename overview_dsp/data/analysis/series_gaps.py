"""Gaps of a series: runs of missing values, and holes between samples.

A gap lasts from the last sample with a value to the next one. A hole is a step from one row to the
next that is much longer than usual:

- *evenly sampled* (95 % of steps within a tenth of the median): longer than 1.5 times the median;
- *unevenly sampled*: longer than 3 times the 99th percentile of the steps;
- *business days* (days by the calendar, none of them a Saturday or Sunday): weekends and holidays
  are not holes. Let h be the longest step of at most 14 days that occurs at least 1.5 times per
  year. A hole is longer than 7 days and longer than 2 h;
- *sessions* (several samples per day, none at night): the rules for days apply from day to day,
  those for samples within a day. Pauses on most days (a lunch break) are not holes.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from datetime import datetime

import numpy as np

from overview_dsp.arrays import FloatArray, IntArray
from overview_dsp.data.analysis.runs import runs

DAY_S = 86_400.0

_EVEN_SHARE, _EVEN_WITHIN, _EVEN_FACTOR = 95.0, 1.1, 1.5
_UNEVEN_SHARE, _UNEVEN_FACTOR = 99.0, 3.0
_HOLIDAYS_A_YEAR, _LONGEST_HOLIDAY, _SHORTEST_CLOSURE = 1.5, 14, 7
_SESSION_STEP_S = DAY_S / 4.0
_MOST_DAYS = 0.5


@dataclass(frozen=True)
class Holes:
    """Holes of a series, each by the index of the sample before it, and a text about the rule."""

    after: IntArray
    rule: str


def find_holes(time_s: FloatArray, start: datetime | None) -> Holes:
    """Find holes between the rows of a series; `start` is the calendar moment of time 0.

    Times are strictly increasing, two or more.
    """
    step = np.diff(time_s)
    found = None if start is None else _calendar_holes(time_s, step, start)
    if found is None:
        limit, rule = _limit(step)
        found = np.flatnonzero(step > limit), rule
    return Holes(*found)


def _calendar_holes(
    time_s: FloatArray, step: FloatArray, start: datetime
) -> tuple[IntArray, str] | None:
    """Return the holes of business days or of sessions, None for other series."""
    usual = float(np.median(step))
    midnight_s = start.hour * 3600.0 + start.minute * 60.0 + start.second + start.microsecond / 1e6
    # a margin: rounding may put times just before midnight
    day = np.floor((time_s + midnight_s + 1e-6) / DAY_S).astype(np.int64)
    days = day[np.diff(day, prepend=day[0] - 1) > 0]
    weekday = (days + start.weekday()) % 7
    working = bool((weekday < 5).all()) and len(np.unique(weekday)) >= 3
    if 0.9 * DAY_S <= usual <= 1.2 * DAY_S:
        return _business(np.diff(day)) if working else None
    return _sessions(step, day, working) if usual <= _SESSION_STEP_S else None


def _limit(step: FloatArray) -> tuple[float, str]:
    """Return the maximum usual step, and a description of the rule."""
    usual = float(np.median(step))
    if float(np.percentile(step, _EVEN_SHARE)) <= _EVEN_WITHIN * usual:
        return _EVEN_FACTOR * usual, f"a step longer than {_span(_EVEN_FACTOR * usual)} is a gap"
    common = float(np.percentile(step, _UNEVEN_SHARE))
    if len(step) < 100:  # a single hole would be the percentile itself
        common = min(common, float(np.percentile(step, 90.0)) * 2.0)
    limit = _UNEVEN_FACTOR * common
    return limit, f"samples are uneven: a step longer than {_span(limit)} is a gap"


def _business(days: IntArray) -> tuple[IntArray, str]:
    years = max(float(days.sum()) / 365.25, 0.25)
    holiday = 3
    for length in range(4, _LONGEST_HOLIDAY + 1):
        count = int(((days >= length) & (days <= _LONGEST_HOLIDAY)).sum())
        if count >= max(2.0, _HOLIDAYS_A_YEAR * years):
            holiday = length
    limit = max(_SHORTEST_CLOSURE, 2 * holiday)
    rule = f"business days: weekends and holidays are not gaps, a step over {limit} days is one"
    return np.flatnonzero(days > limit), rule


def _sessions(step: FloatArray, day: IntArray, working: bool) -> tuple[IntArray, str] | None:
    """Return the holes of a series with nights; None for other series."""
    over = np.diff(day)
    inside = step[over == 0]
    nights = step[over > 0]
    if len(nights) < 3 or len(inside) < len(nights) or not len(inside):
        return None
    limit, _ = _limit(inside)
    if float(np.median(nights)) <= limit:
        return None
    # pauses on most days, such as a lunch break
    pauses = np.sort(inside[inside > limit])[::-1]
    days = len(nights) + 1
    if len(pauses) >= _MOST_DAYS * days:
        limit = 1.5 * float(pauses[int(_MOST_DAYS * days) - 1])
    if working:
        after, _ = _business(over[over > 0])
        rule = "sessions: nights, weekends and holidays are not gaps"
    else:
        most = float(np.median(over[over > 0]))
        after = np.flatnonzero(over[over > 0] > 1.5 * most)
        rule = "sessions: nights are not gaps"
    across = np.flatnonzero(over > 0)[after]
    within = np.flatnonzero((over == 0) & (step > limit))
    rule = f"{rule}, a pause of more than {_span(limit)} within a day is one"
    return np.sort(np.concatenate((across, within))), rule


def find_gaps(
    time_s: FloatArray, value: FloatArray, holes: IntArray
) -> tuple[tuple[float, float], ...]:
    """Return the gaps of a series, merged: missing values (NaN), and holes as in `Holes.after`.

    A missing value makes no gap where the known ones beside it are as close as neighbours usually
    are: its row is for something else.
    """
    known = np.flatnonzero(~np.isnan(value))
    if not known.size:
        return ((float(time_s[0]), float(time_s[-1])),)
    open_step = np.isnan(value[:-1]) | np.isnan(value[1:])
    apart, rows = np.diff(time_s[known]), np.diff(known)
    if (rows == 1).any() and (rows > 1).any():
        usual = apart <= (1.0 + 1e-9) * np.median(apart[rows == 1])
        open_step[known[0] : known[-1]] &= ~np.repeat(usual, rows)
    open_step[holes] = True
    spans = []
    for begin, end in runs(open_step):
        # two gaps with a single known sample between them stay separate
        points = [begin, *(known[(known > begin) & (known < end)]).tolist(), end]
        spans += [(float(time_s[a]), float(time_s[b])) for a, b in itertools.pairwise(points)]
    return tuple(spans)


def _span(seconds: float) -> str:
    """Return a time span as text."""
    for unit, size in (("days", DAY_S), ("hours", 3600.0), ("minutes", 60.0)):
        if seconds >= 1.5 * size:
            return f"{seconds / size:.3g} {unit}"
    return f"{seconds:.3g} s"
