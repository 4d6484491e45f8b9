"""Ticks of the calendar or of the clock: where one is on a timeline, or in a part of it.

Those of a whole timeline are the finest of century, decade, year, month, week, day, hour, quarter
of an hour and minute that give at most `MOST_TICKS`; one that begins a coarser span too is a tick
of that (1 January: `year`), but weeks stay weeks. Timelines without a calendar get days, hours and
so on from their beginning. A part has finer steps too, down to a microsecond, so that hardly a part
is without a tick; they are those of the whole's calendar or clock, or the minutes of its match.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from datetime import datetime, timedelta

from overview_dsp.data.timeline.event import Event
from overview_dsp.data.timeline.match_minutes import Half

MOST_TICKS = 26
"""Most ticks: a mark every four hundredths of a turn can still be counted."""

KINDS = (
    "century", "decade", "year", "month", "week", "day", "hour", "quarter_hour", "minute", "second",
)  # fmt: skip
"""All kinds of ticks, coarse to fine."""

_US = 1_000_000
_DAY_S = 86_400.0
_SPANS = (("day", _DAY_S), ("hour", 3600.0), ("quarter_hour", 900.0), ("minute", 60.0))
_CALENDAR_S = {
    "week": 604_800.0, "month": 2.63e6, "year": 3.156e7, "decade": 3.156e8, "century": 3.156e9,
}  # fmt: skip
"""Spans whose ticks aren't a whole number of steps from midnight, and about how long they are."""

_WHOLE_S = (60.0, 900.0, 3600.0, _DAY_S)
_SUBSECOND_S = tuple(m * 10.0**power for power in range(-6, 0) for m in (1.0, 2.0, 5.0))
_DATED_S = (*_SUBSECOND_S, 1.0, 5.0, 15.0, 60.0, 300.0, 900.0, 3600.0, 21_600.0, _DAY_S)
# none more than three times the one before it: nine ticks or more, whatever the part
_CLOCK_S = (
    *_SUBSECOND_S, 1.0, 2.0, 5.0, 15.0, 30.0, 60.0, 120.0, 300.0, 900.0, 1800.0, 3600.0, 10_800.0,
    21_600.0, 43_200.0, *(m * _DAY_S * 10**power for power in range(9) for m in (1.0, 2.0, 5.0)),
)  # fmt: skip
_MONTHS = (
    "January", "February", "March", "April", "May", "June", "July", "August", "September",
    "October", "November", "December",
)  # fmt: skip


def ticks(start: datetime | None, duration_s: float) -> tuple[Event, ...]:
    """Return the ticks strictly inside a timeline.

    Parameters
    ----------
    start
        The moment of time 0 (its own clock counts, whatever zone it is in), or None.
    duration_s
        Length in s.
    """
    return _chosen(_WHOLE_S, start, 0.0, duration_s)


def part_ticks(
    start: datetime | None, from_s: float, duration_s: float, halves: Sequence[Half] = ()
) -> tuple[Event, ...]:
    """Return the ticks strictly inside a part of a timeline, on an axis that begins with the part.

    Parameters
    ----------
    start
        The moment at which the part begins, or None where there is no calendar.
    from_s
        Where the part begins on the whole timeline, s: what ticks without a calendar count from.
    duration_s
        Length of the part, s.
    halves
        Those of a match, on the whole timeline: its minutes are the ticks then.
    """
    if halves and start is None:
        return _match_minutes(halves, from_s, duration_s)
    return _chosen(_CLOCK_S if start is None else _DATED_S, start, from_s, duration_s)


def _chosen(
    steps_s: Iterable[float], start: datetime | None, from_s: float, duration_s: float
) -> tuple[Event, ...]:
    """The finest ticks that are few enough."""
    for step_s in steps_s:
        if duration_s / step_s <= MOST_TICKS + 2:
            found = list(_even(step_s, start, from_s, duration_s))
            if len(found) <= MOST_TICKS:
                return tuple(found)
    for unit, about_s in _CALENDAR_S.items() if start is not None else ():
        if duration_s / about_s <= MOST_TICKS + 2:
            assert start is not None
            found = list(_calendar(unit, start.replace(tzinfo=None), duration_s))
            if len(found) <= MOST_TICKS:
                return tuple(found)
    return ()


def _even(
    step_s: float, start: datetime | None, from_s: float, duration_s: float
) -> Iterator[Event]:
    """Ticks at whole numbers of steps from midnight, or from the beginning of the whole."""
    step_us = round(step_s * _US)
    event: Callable[[int, float], Event]
    if start is None:
        offset_s, event = from_s, _plain
    else:
        midnight = start.replace(hour=0, minute=0, second=0, microsecond=0, tzinfo=None)
        offset_s = (start.replace(tzinfo=None) - midnight).total_seconds()

        def event(at_us: int, time_s: float) -> Event:
            moment = midnight + timedelta(microseconds=at_us)
            kind = _kind(step_s, moment)
            return Event(time_s, kind, _label(kind, moment))

    for count in range(math.floor(offset_s * _US / step_us), 1 << 62):
        at_us = count * step_us
        time_s = at_us / _US - offset_s
        if time_s >= duration_s:
            return
        if time_s > 0.0:
            try:
                yield event(at_us, time_s)
            except OverflowError:  # past the calendar's end
                return


def _match_minutes(halves: Sequence[Half], from_s: float, duration_s: float) -> tuple[Event, ...]:
    """The finest ticks that are few enough, each half's from its beginning."""
    for step_s in _CLOCK_S:
        if duration_s / step_s <= MOST_TICKS + 2:
            found = [
                event for half in halves for event in _of_half(half, step_s, from_s, duration_s)
            ]
            if len(found) <= MOST_TICKS:
                return tuple(found)
    return ()


def _of_half(half: Half, step_s: float, from_s: float, duration_s: float) -> Iterator[Event]:
    step_us = round(step_s * _US)
    begin_s = half.begin_s - from_s
    for count in range(max(0, math.floor(-begin_s * _US / step_us)), 1 << 62):
        at_us = count * step_us
        time_s = begin_s + at_us / _US
        if time_s >= min(duration_s, half.end_s - from_s):
            return
        if time_s > 0.0:
            minutes, rest = divmod(at_us, 60 * _US)
            shown = half.minute_text(minutes, begun=bool(rest))
            if rest:
                yield Event(time_s, "second", f"{shown}:{_seconds(rest)}")
            else:
                kind = "minute" if (half.first + minutes) % 15 else "quarter_hour"
                yield Event(time_s, kind, f"minute {shown}, {half.name}")


def _plain(at_us: int, time_s: float) -> Event:
    for kind, size_s in _SPANS:
        number, rest = divmod(at_us, round(size_s * _US))
        if not rest:
            words = {"quarter_hour": f"{number * 15} minutes"}.get(kind, f"{kind} {number}")
            return Event(time_s, kind, words)
    minutes, rest = divmod(at_us, 60 * _US)
    return Event(time_s, "second", f"{minutes}:{_seconds(rest)}")


def _seconds(microseconds: int) -> str:
    whole, rest = divmod(microseconds, _US)
    return f"{whole:02d}" + (f".{rest:06d}".rstrip("0") if rest else "")


def _calendar(unit: str, start: datetime, duration_s: float) -> Iterator[Event]:
    moment = _floor(unit, start)
    while (following := _next(unit, moment)) is not None:
        moment = following
        time_s = (moment - start).total_seconds()
        if time_s >= duration_s:
            return
        kind = _dated_kind(unit, moment)
        yield Event(time_s, kind, _label(kind, moment))


def _floor(unit: str, at: datetime) -> datetime:
    if unit in ("century", "decade"):
        size = 100 if unit == "century" else 10
        return datetime(max(1, at.year - at.year % size), 1, 1)
    if unit == "year":
        return datetime(at.year, 1, 1)
    if unit == "month":
        return datetime(at.year, at.month, 1)
    # a week: not before the calendar's first day, which was a Monday
    return datetime(at.year, at.month, at.day) - timedelta(days=at.weekday())


def _next(unit: str, at: datetime) -> datetime | None:
    """The next tick; None after the calendar's end."""
    try:
        if unit in ("century", "decade", "year"):
            size = {"century": 100, "decade": 10, "year": 1}[unit]
            return datetime(at.year - at.year % size + size, 1, 1)
        if unit == "month":
            return datetime(at.year + at.month // 12, at.month % 12 + 1, 1)
        return at + timedelta(days=7)
    except (ValueError, OverflowError):
        return None


def _dated_kind(unit: str, at: datetime) -> str:
    """The coarsest span that begins here, years at the most for months; weeks stay weeks."""
    if unit == "decade" and at.year % 100 == 0:
        return "century"
    if unit == "month" and at.month == 1:
        return "year"
    return unit


def _kind(step_s: float, at: datetime) -> str:
    """The coarsest span that begins here, at a tick of a day or less."""
    if (at.hour, at.minute, at.second, at.microsecond) == (0, 0, 0, 0):
        if at.day == 1:
            return "year" if at.month == 1 else "month"
        return "week" if step_s == _DAY_S and not at.weekday() else "day"
    if at.second or at.microsecond:
        return "second"
    if at.minute == 0:
        return "hour"
    return "quarter_hour" if at.minute % 15 == 0 else "minute"


def _label(kind: str, at: datetime) -> str:
    if kind in ("century", "decade"):
        return f"{at.year}s"
    if kind == "year":
        return f"{at.year}"
    if kind == "month":
        return f"{_MONTHS[at.month - 1]} {at.year}"
    if kind == "week":
        return f"week of {at.date().isoformat()}"
    if kind == "day":
        return f"{at.date().isoformat()}"
    clock = at.time().isoformat("minutes")
    return f"{clock}:{_seconds(at.second * _US + at.microsecond)}" if kind == "second" else clock
