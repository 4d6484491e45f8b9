"""Conversion of match minutes (`38`, `90+3`) into times on a timeline of consecutive periods.

A list of minutes has no length of stoppage time. Unless the list has the end of a half, it lasts 45
minutes (15 in extra time), or until its last listed minute if that is later. The next half starts
then, so `45+2` and `46` are different times.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from overview_dsp.data.readers.football.match_timeline import SHOOT_OUT, concatenate_periods
from overview_dsp.data.readers.tables.table import CellLocation
from overview_dsp.data.timeline.time_parsing import match_minute
from overview_dsp.errors import InputError, quoted

STARTS = {1: 0, 2: 45, 3: 90, 4: 105}
"""Minute of the match clock at the start of each period."""

ENDS = {1: 45, 2: 90, 3: 105, 4: 120}
"""Minute of the match clock at the end of each period, without stoppage time."""

MAX_MINUTE = 150
MIDDLE_S = 30.0
"""Time from the middle of a minute to its end, s."""

MAX_ADDED = 60
_RANGE = f"0 to {MAX_MINUTE}, such as 38 or 90+3"


@dataclass(frozen=True)
class Minute:
    """Time on the match clock.

    `base`, `added`: minute and minute of stoppage time: 90 and 3 for `90+3`; `added` is None
    without a plus.
    `seconds`: seconds after the minute, if the list has seconds; minutes then count from 0.
    Otherwise lists count minutes from 0 or from 1.
    `period`: period, 1 to 5, if the list has it.
    """

    base: int
    added: int | None = None
    seconds: float | None = None
    period: int | None = None

    def __str__(self) -> str:
        added = f"+{self.added}" if self.added is not None else ""
        return f"{self.base}{added}'"

    @property
    def on_clock(self) -> int:
        """Minutes since kick-off, including stoppage time."""
        return self.base + (self.added or 0)


def parse_minute(text: str, location: str | CellLocation) -> Minute:
    """Return the Minute of `38`, `38'`, `90+3`, `45+2'` or `12:34`; InputError for other texts."""
    parts = match_minute(text)
    if parts is None:
        raise _error(location, text, f"isn't a minute; minutes must be {_RANGE}")
    base, added, seconds = parts
    check_minute(base, added, location)
    return Minute(base, added, seconds)


def check_minute(base: int, added: int | None, location: str | CellLocation) -> None:
    """Raise InputError if a minute is out of range."""
    if not 0 <= base <= MAX_MINUTE:
        raise _error(location, base, f"is out of range; minutes must be {_RANGE}")
    if added is not None and not 0 <= added <= MAX_ADDED:
        raise _error(
            location, added, f"is out of range; stoppage time must be 0 to {MAX_ADDED} minutes"
        )


def _error(location: str | CellLocation, value: object, note: str) -> InputError:
    if isinstance(location, CellLocation):
        return location.error(value, note)
    return InputError(f"{location}: {quoted(value)} {note}")


@dataclass(frozen=True)
class Clock:
    """Periods of a match on the timeline.

    `begins_s`, `lengths_s`: start on the timeline and length of each period, s.
    `extra_time`: true if minutes above 90 without a plus are extra time, false for stoppage time.
    `back_s`: time from an event to the end of its minute, s: 30 is the middle of the minute.
    `restarts`: true if the clock of each period starts at 0.
    """

    begins_s: Mapping[int, float]
    lengths_s: Mapping[int, float]
    extra_time: bool
    back_s: float
    restarts: bool = False

    @classmethod
    def from_minutes(
        cls,
        minutes: Iterable[Minute],
        *,
        extra_time: bool | None = None,
        back_s: float = 0.0,
        ends: Mapping[int, Minute] | None = None,
    ) -> Clock:
        """Return the consecutive periods of a match.

        `minutes`: minutes of all events.
        `extra_time`: whether the match had extra time. None: derived from the minutes. There is
        extra time if a minute has period 3 or 4, or is above 105 without a plus. In a list that
        writes stoppage time with a plus, a minute above 90 is enough.
        `back_s`: as `Clock`.
        `ends`: minutes at which periods ended, if the list has them. Without seconds, the end is in
        the middle of the minute.
        """
        listed = [minute for minute in minutes if minute.period != SHOOT_OUT]
        ends = ends or {}
        known = [*listed, *ends.values()]
        # periods 2 to 4 count from 0 if most of their minutes are before their start
        later = [m.base < STARTS[m.period] for m in known if m.period in (2, 3, 4)]
        restarts = 2 * sum(later) > len(later)
        if extra_time is None:
            bases = [m.base for m in known if m.period is None]
            limit = ENDS[2] if any(m.added is not None for m in known) else ENDS[3]
            extra_time = (
                any(base > limit for base in bases)
                or any(m.added is not None and m.base in (ENDS[3], ENDS[4]) for m in known)
                or not {3, 4}.isdisjoint((*ends, *(m.period for m in known)))
            )
        clock = cls({}, {}, extra_time, back_s, restarts)
        lengths = {
            p: 60.0 * (ENDS[p] - STARTS[p]) for p in ((1, 2, 3, 4) if extra_time else (1, 2))
        }
        for minute in listed:
            period = clock.period_of(minute)
            lengths[period] = max(lengths.get(period, 0.0), clock._seconds(minute, period))
        for period, minute in ends.items():
            is_whole = minute.seconds is None
            nominal = ENDS[period] - (STARTS[period] if restarts else 0)
            if is_whole and minute.added is None and minute.base == nominal:
                continue  # the nominal end, not the time of the whistle
            length_s = clock._seconds(minute, period) - (MIDDLE_S if is_whole else 0.0)
            if length_s > 0.0:
                lengths[period] = length_s
        begins, _ = concatenate_periods(lengths)
        return cls(begins, lengths, extra_time, back_s, restarts)

    def period_of(self, minute: Minute) -> int:
        """Return the period of a minute, 1 to 4."""
        if minute.period is not None:
            return min(minute.period, 4)
        if minute.base <= ENDS[1]:
            return 1
        if minute.base <= ENDS[2] or not self.extra_time:
            return 2
        return 3 if minute.base <= ENDS[3] else 4

    def time_s(self, minute: Minute) -> float:
        """Return the time of a minute on the timeline, s, limited to its period."""
        period = self.period_of(minute)
        seconds = self._seconds(minute, period)
        if minute.seconds is None:
            seconds -= self.back_s
        return self.begins_s[period] + min(max(seconds, 0.0), self.lengths_s[period])

    @property
    def duration_s(self) -> float:
        """Duration of the match, s."""
        return sum(self.lengths_s.values())

    def _seconds(self, minute: Minute, period: int) -> float:
        """Return the time from the start of the period, s."""
        start = 0 if self.restarts else STARTS[period]
        return 60.0 * (minute.on_clock - start) + (minute.seconds or 0.0)
