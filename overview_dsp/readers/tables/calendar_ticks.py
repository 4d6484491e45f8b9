"""Ticks of the calendar, so that a hand knows where it is.

The finest of century, decade, year, month, week, day, hour, quarter of an hour and minute that
gives at most `MOST` ticks; one that begins a coarser span too is a tick of that (1 January:
`year`), but weeks stay weeks. Series without a calendar get hours, minutes and so on from their
beginning.
"""

from __future__ import annotations

from collections.abc import Iterator
from datetime import datetime, timedelta

from overview_dsp.timeline.event import Event

MOST = 26
"""Most ticks: a mark every four hundredths of a turn can still be counted."""

KINDS = ("century", "decade", "year", "month", "week", "day", "hour", "quarter_hour", "minute")
"""All kinds of ticks, coarse to fine."""

_PLAIN = (("day", 86_400.0), ("hour", 3600.0), ("quarter_hour", 900.0), ("minute", 60.0))
_ABOUT_S = {
    "century": 3.156e9, "decade": 3.156e8, "year": 3.156e7, "month": 2.63e6, "week": 604_800.0,
    "day": 86_400.0, "hour": 3600.0, "quarter_hour": 900.0, "minute": 60.0,
}  # fmt: skip
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
    for unit in reversed(KINDS):
        if duration_s / _ABOUT_S[unit] > MOST + 2:
            continue
        if start is None:
            found = list(_plain(unit, duration_s))
        else:
            found = list(_calendar(unit, start.replace(tzinfo=None), duration_s))
        if len(found) <= MOST:
            return tuple(found)
    return ()


def _plain(unit: str, duration_s: float) -> Iterator[Event]:
    sizes = dict(_PLAIN)
    if unit not in sizes:
        return
    count = 1
    while (time_s := count * sizes[unit]) < duration_s:
        kind = next(name for name, size in _PLAIN if time_s % size == 0.0)
        number = round(time_s / sizes[kind])
        words = {"quarter_hour": f"{number * 15} minutes"}.get(kind, f"{kind} {number}")
        yield Event(time_s, kind, words)
        count += 1


def _calendar(unit: str, start: datetime, duration_s: float) -> Iterator[Event]:
    moment = _floor(unit, start)
    while (following := _next(unit, moment)) is not None:
        moment = following
        time_s = (moment - start).total_seconds()
        if time_s >= duration_s:
            return
        kind = _kind(unit, moment)
        yield Event(time_s, kind, _label(kind, moment))


def _floor(unit: str, at: datetime) -> datetime:
    day = at.replace(hour=0, minute=0, second=0, microsecond=0)
    if unit in ("century", "decade"):
        size = 100 if unit == "century" else 10
        return datetime(max(1, at.year - at.year % size), 1, 1)
    if unit == "year":
        return datetime(at.year, 1, 1)
    if unit == "month":
        return datetime(at.year, at.month, 1)
    if unit == "week":
        # not before the calendar's first day, which was a Monday
        return day - timedelta(days=day.weekday())
    if unit == "day":
        return day
    minute = {"hour": 0, "quarter_hour": at.minute - at.minute % 15}.get(unit, at.minute)
    return at.replace(minute=minute, second=0, microsecond=0)


def _next(unit: str, at: datetime) -> datetime | None:
    """The next tick; None after the calendar's end."""
    try:
        if unit in ("century", "decade", "year"):
            size = {"century": 100, "decade": 10, "year": 1}[unit]
            return datetime(at.year - at.year % size + size, 1, 1)
        if unit == "month":
            return datetime(at.year + at.month // 12, at.month % 12 + 1, 1)
        spans = {"week": 7 * 1440, "day": 1440, "hour": 60, "quarter_hour": 15, "minute": 1}
        return at + timedelta(minutes=spans[unit])
    except (ValueError, OverflowError):
        return None


def _kind(unit: str, at: datetime) -> str:
    """The coarsest span that begins here, years at the most for ticks of months and finer."""
    if unit == "century":
        return unit
    if unit == "decade":
        return "century" if at.year % 100 == 0 else unit
    midnight = (at.hour, at.minute) == (0, 0)
    if unit in ("year", "week"):  # months begin between weeks
        return unit
    if midnight and (at.month, at.day) == (1, 1):
        return "year"
    if midnight and at.day == 1:
        return "month"
    if unit == "day":
        return unit if at.weekday() else "week"
    if midnight:
        return "day"
    return "hour" if at.minute == 0 else unit


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
    return f"{at:%H:%M}" if at.year >= 1000 else at.time().isoformat("minutes")
