"""Minutes as football counts them (`38`, `90+3`), onto a timeline of periods laid end to end.

A list of minutes doesn't say how long stoppage time was. A half lasts its 45 minutes (15 in extra
time) or until its last listed minute of stoppage time, whichever is longer, unless the list gives
its end; the next one follows. So `45+2` and `46` are two minutes, not two moments of one.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from overview_dsp.data.readers.football.match import SHOOT_OUT, lay_end_to_end
from overview_dsp.data.readers.tables.table import CellLocation
from overview_dsp.data.timeline.time_parsing import match_minute
from overview_dsp.errors import InputError, shown

STARTS = {1: 0, 2: 45, 3: 90, 4: 105}
"""Minute of the clock at which a period begins."""

ENDS = {1: 45, 2: 90, 3: 105, 4: 120}
"""Minute of the clock at which a period ends, without stoppage time."""

MAX_MINUTE = 150
_MIDDLE_S = 30.0
MAX_ADDED = 60
_RANGE = f"0 to {MAX_MINUTE}, such as 38 or 90+3"


@dataclass(frozen=True)
class Minute:
    """A moment of the match clock.

    Parameters
    ----------
    base, added
        `90+3` is 90 and 3; `added` is None without a plus.
    seconds
        Into the minute that begins at `base` (+ `added`), where the list gives seconds; then
        minutes count from 0, else they are a minute's number or its beginning, as a list has it.
    period
        1 to 5 where the list gives it.
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
        """Minutes since kick-off, stoppage time counted on."""
        return self.base + (self.added or 0)


def parse_minute(text: str, place: str | CellLocation) -> Minute:
    """Return the minute written as `38`, `38'`, `90+3`, `45+2'` or `12:34`; InputError if not."""
    found = match_minute(text)
    if found is None:
        raise _wrong(place, text, f"isn't a minute; minutes are {_RANGE}")
    base, added, seconds = found
    check_minute(base, added, place)
    return Minute(base, added, seconds)


def check_minute(base: int, added: int | None, place: str | CellLocation) -> None:
    """Refuse minutes no match has."""
    if not 0 <= base <= MAX_MINUTE:
        raise _wrong(place, base, f"is no minute; minutes are {_RANGE}")
    if added is not None and not 0 <= added <= MAX_ADDED:
        raise _wrong(place, added, f"minutes of stoppage time; that is 0 to {MAX_ADDED}")


def _wrong(place: str | CellLocation, value: object, note: str) -> InputError:
    if isinstance(place, CellLocation):
        return place.error(value, note)
    return InputError(f"{place}: {shown(value)} {note}")


@dataclass(frozen=True)
class Clock:
    """The periods of one match on the timeline.

    Parameters
    ----------
    begins_s, lengths_s
        By period: where it begins on the timeline and how long it is, s.
    extra_time
        Whether minutes above 90 without a plus are extra time, not stoppage time.
    back_s
        How far before the end of its minute an event is placed, s: 30 is the middle.
    restarts
        Whether the clock of every period begins at 0.
    """

    begins_s: Mapping[int, float]
    lengths_s: Mapping[int, float]
    extra_time: bool
    back_s: float
    restarts: bool = False

    @classmethod
    def laid(
        cls,
        minutes: Iterable[Minute],
        *,
        extra_time: bool | None = None,
        back_s: float = 0.0,
        ends: Mapping[int, Minute] | None = None,
    ) -> Clock:
        """Lay the periods of a match end to end.

        Parameters
        ----------
        minutes
            Of all its events.
        extra_time
            Whether the match had it; None = by the minutes: one above 105 without a plus, a
            period 3 or 4, or, in a list that writes stoppage time with a plus, one above 90.
        back_s
            As `Clock`.
        ends
            When periods ended, where the list gives them; a bare minute is its middle.
        """
        listed = [minute for minute in minutes if minute.period != SHOOT_OUT]
        ends = ends or {}
        every = [*listed, *ends.values()]
        restarts = _restarts(every)
        if extra_time is None:
            bases = [m.base for m in every if m.period is None]
            longest = ENDS[2] if any(m.added is not None for m in every) else ENDS[3]
            extra_time = (
                any(base > longest for base in bases)
                or any(m.added is not None and m.base in (ENDS[3], ENDS[4]) for m in every)
                or not {3, 4}.isdisjoint((*ends, *(m.period for m in every)))
            )
        rough = cls({}, {}, extra_time, back_s, restarts)
        lengths = {
            p: 60.0 * (ENDS[p] - STARTS[p]) for p in ((1, 2, 3, 4) if extra_time else (1, 2))
        }
        for minute in listed:
            period = rough.period_of(minute)
            lengths[period] = max(lengths.get(period, 0.0), rough._into(minute, period))
        for period, minute in ends.items():
            bare = minute.seconds is None
            if bare and minute.added is None and minute.base == ENDS[period]:
                continue  # the name of the whistle, not when it blew
            into = rough._into(minute, period) - (_MIDDLE_S if bare else 0.0)
            if into > 0.0:
                lengths[period] = into
        begins, _ = lay_end_to_end(lengths)
        return cls(begins, lengths, extra_time, back_s, restarts)

    def period_of(self, minute: Minute) -> int:
        """Return the period (1 to 4) a minute lies in."""
        if minute.period is not None:
            return min(minute.period, 4)
        if minute.base <= ENDS[1]:
            return 1
        if minute.base <= ENDS[2] or not self.extra_time:
            return 2
        return 3 if minute.base <= ENDS[3] else 4

    def time_s(self, minute: Minute) -> float:
        """Return where an event of that minute lies on the timeline, s, within its period."""
        period = self.period_of(minute)
        into = self._into(minute, period)
        if minute.seconds is None:
            into -= self.back_s
        return self.begins_s[period] + min(max(into, 0.0), self.lengths_s[period])

    @property
    def duration_s(self) -> float:
        """Length of the match, s."""
        return sum(self.lengths_s.values())

    def _into(self, minute: Minute, period: int) -> float:
        start = 0 if self.restarts else STARTS[period]
        return 60.0 * (minute.on_clock - start) + (minute.seconds or 0.0)


def _restarts(minutes: Sequence[Minute]) -> bool:
    """Return whether later periods count from 0: none of their minutes reaches their start."""
    later = [m for m in minutes if m.period in (2, 3, 4)]
    return bool(later) and all(m.base < STARTS[m.period or 1] for m in later)
