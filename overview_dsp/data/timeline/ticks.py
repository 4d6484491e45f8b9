"""Ticks of calendar or clock on a timeline, or in a window of it.

The ticks of a timeline are the finest of century, decade, year, month, week, day, hour, quarter of
an hour and minute with at most `MOST_TICKS`. A tick that also begins a coarser span has the kind of
that span (1 January: `year`), except weeks. Without a calendar, days, hours and so on count from
the beginning. Windows have finer steps, too, down to a microsecond, on the calendar or clock of the
timeline. In a match, they are its minutes as displayed, with `45+2` for added time.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from datetime import datetime, timedelta
from functools import partial

from overview_dsp.data.timeline.event import Event
from overview_dsp.data.timeline.time_parsing import MONTHS

MOST_TICKS = 26  # maximum number of ticks that can still be counted by touch
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
"""Spans of the calendar without fixed length, and their approximate length."""

_MONTHS_IN = {"month": 1, "year": 12, "decade": 120, "century": 1200}
_WHOLE_S = (60.0, 900.0, 3600.0, _DAY_S)
_SUBSECOND_S = tuple(m * 10.0**power for power in range(-6, 0) for m in (1.0, 2.0, 5.0))
_DATED_S = (*_SUBSECOND_S, 1.0, 5.0, 15.0, 60.0, 300.0, 900.0, 3600.0, 21_600.0, _DAY_S)
# each at most three times the one before it, so that any window has nine ticks or more
_CLOCK_S = (
    *_SUBSECOND_S, 1.0, 2.0, 5.0, 15.0, 30.0, 60.0, 120.0, 300.0, 900.0, 1800.0, 3600.0, 10_800.0,
    21_600.0, 43_200.0, *(m * _DAY_S * 10**power for power in range(9) for m in (1.0, 2.0, 5.0)),
)  # fmt: skip

_MINUTES = ((0, 45), (45, 90), (90, 105), (105, 120))
_HALF_NAMES = ("first half", "second half", "extra time", "extra time, second half")
_SHORT_S = 120.0
"""Tolerance for the length of a half, s."""

_LATE_S = 60.0  # latest beginning of a match on its timeline, s
_MATCH_KINDS = frozenset({"goal", "own_goal", "near_miss", "yellow_card", "red_card", "foul"})
_MATCH_LABELS = ("kick-off", "half-time")


@dataclass(frozen=True)
class Half:
    """Half of a match: its span on the timeline, s, and its first and last minute."""

    begin_s: float
    end_s: float
    first: int
    last: int
    name: str

    @property
    def nominal_s(self) -> float:
        """Beginning of the added time, s."""
        return self.begin_s + 60.0 * (self.last - self.first)

    def minute_text(self, minutes: int, has_seconds: bool = False) -> str:
        """Return the minute as displayed in a match: `62`, `90+3`.

        With `has_seconds`, seconds follow: 30 s after minute 45 of the first half is `45+0:30`.
        """
        minute = self.first + minutes
        added = minute > self.last or (has_seconds and minute == self.last)
        return f"{self.last}+{minute - self.last}" if added else str(minute)


def halves_of(events: Sequence[Event]) -> tuple[Half, ...]:
    """Return the halves of a whole match, empty if its sorted events do not define them.

    They are between its events of kind `period`: two, three or four, of full length.
    """
    periods = [event for event in events if event.kind == "period"]
    if not any(e.kind in _MATCH_KINDS for e in events) and not any(
        e.label in _MATCH_LABELS for e in periods
    ):
        return ()  # not a match
    edges = sorted({event.time_s for event in periods})
    if not 2 <= len(edges) - 1 <= len(_MINUTES) or edges[0] > _LATE_S:
        return ()
    halves = tuple(
        Half(begin, end, first, last, name)
        for (begin, end), (first, last), name in zip(
            itertools.pairwise(edges), _MINUTES, _HALF_NAMES, strict=False
        )
    )
    return halves if all(h.end_s >= h.nominal_s - _SHORT_S for h in halves) else ()


def ticks(start: datetime | None, duration_s: float) -> tuple[Event, ...]:
    """Return the ticks strictly inside a timeline; `start` (its local time counts) may be None."""
    return _chosen(_WHOLE_S, start, 0.0, duration_s)


def window_ticks(
    start: datetime | None, from_s: float, duration_s: float, halves: Sequence[Half] = ()
) -> tuple[Event, ...]:
    """Return the ticks strictly inside a window, on a time axis that begins with it.

    `start`: moment at which the window begins, None without a calendar.
    `from_s`: its beginning on the timeline, s; ticks without a calendar count from 0.
    `halves`: halves of a match on the timeline, whose minutes become ticks.
    """
    if halves and start is None:
        found = ((s, partial(_match_minutes, halves, s, from_s, duration_s)) for s in _CLOCK_S)
        return _finest(found, duration_s)
    return _chosen(_CLOCK_S if start is None else _DATED_S, start, from_s, duration_s)


def _chosen(
    steps_s: Iterable[float], start: datetime | None, from_s: float, duration_s: float
) -> tuple[Event, ...]:
    found = [(s, partial(_even, s, start, from_s, duration_s)) for s in steps_s]
    if start is not None:
        plain = start.replace(tzinfo=None)
        found += [(s, partial(_calendar, u, plain, duration_s)) for u, s in _CALENDAR_S.items()]
    return _finest(found, duration_s)


def _finest(
    ticks_of: Iterable[tuple[float, Callable[[], Iterable[Event]]]], duration_s: float
) -> tuple[Event, ...]:
    """Return the finest ticks that are few enough, from pairs of approximate step and function."""
    for step_s, make in ticks_of:
        if duration_s / step_s <= MOST_TICKS + 2 and len(found := tuple(make())) <= MOST_TICKS:
            return found
    return ()


def _even(
    step_s: float, start: datetime | None, from_s: float, duration_s: float
) -> Iterator[Event]:
    """Yield ticks at whole numbers of steps from midnight, or from the beginning."""
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

    for at_us, time_s in _multiples(step_s, offset_s, duration_s):
        try:
            yield event(at_us, time_s)
        except OverflowError:  # past the calendar's end
            return


def _multiples(step_s: float, offset_s: float, end_s: float) -> Iterator[tuple[int, float]]:
    """Yield whole numbers of steps, us, and their times after an offset, s, from 0 to an end."""
    step_us = round(step_s * _US)
    for count in range(max(0, math.floor(offset_s * _US / step_us)), 1 << 62):
        time_s = count * step_us / _US - offset_s
        if time_s >= end_s:
            return
        if time_s > 0.0:
            yield count * step_us, time_s


def _match_minutes(
    halves: Sequence[Half], step_s: float, from_s: float, duration_s: float
) -> Iterator[Event]:
    for half in halves:
        end_s = min(duration_s, half.end_s - from_s)
        for at_us, time_s in _multiples(step_s, from_s - half.begin_s, end_s):
            minutes, rest = divmod(at_us, 60 * _US)
            shown = half.minute_text(minutes, has_seconds=bool(rest))
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
    for moment in _begins(unit, start):
        time_s = (moment - start).total_seconds()
        if time_s >= duration_s:
            return
        kind = unit
        if unit == "decade" and moment.year % 100 == 0:
            kind = "century"
        elif unit == "month" and moment.month == 1:
            kind = "year"
        yield Event(time_s, kind, _label(kind, moment))


def _begins(unit: str, start: datetime) -> Iterator[datetime]:
    """Yield the beginnings of spans after a start, up to the end of the calendar."""
    months = _MONTHS_IN.get(unit)
    # never before the first day of the calendar, which is a Monday
    monday = datetime(start.year, start.month, start.day) - timedelta(days=start.weekday())
    try:
        for count in itertools.count(1):
            if months is None:
                yield monday + timedelta(weeks=count)
            else:
                month = ((12 * start.year + start.month - 1) // months + count) * months
                yield datetime(month // 12, month % 12 + 1, 1)
    except (ValueError, OverflowError):
        return


def _kind(step_s: float, at: datetime) -> str:
    """Return the coarsest span that begins here, for ticks of a day or less."""
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
        return f"{MONTHS[at.month - 1].title()} {at.year}"
    if kind == "week":
        return f"week of {at.date().isoformat()}"
    if kind == "day":
        return f"{at.date().isoformat()}"
    clock = at.time().isoformat("minutes")
    return f"{clock}:{_seconds(at.second * _US + at.microsecond)}" if kind == "second" else clock
