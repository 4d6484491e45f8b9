"""A log as a table of one column, to count its lines (`--map count`): their times.

A line's time is the first thing in its first 100 characters that is written like one:

| written | by |
|---|---|
| `2024-05-03T18:20:01.5Z`, `2024/05/03 18:20:01,500` | most programs |
| `10/Oct/2000:13:55:36 -0700` | web servers |
| `Fri May 3 18:20:00 2024 +0200` | `git log`, `date`, Apache's errors |
| `[03.05.24, 18:20:01]`, `5/3/24, 6:20 PM -` | exported chats, at the beginning of a line |
| `May  3 18:20:01` | syslog: without a year, which is counted from 2000 on |

A log is written in one of these ways, that of most lines of its head. Lines without such a time
(the rest of a message of several lines) are no rows of their own; of `git log` those that begin
with `Date:` are.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from itertools import islice

from overview_dsp.readers.source import Source
from overview_dsp.readers.tables.formats import delimited
from overview_dsp.readers.tables.table import CHUNK_ROWS, Chunk, Column

_REACH = 100
_SNIFFED = 50
_FIRST_YEAR = 2000
_NO_YEAR = f"its lines name no year: {_FIRST_YEAR} stands for the first"

_MONTHS = ("Jan", "Feb", "Mar", "Apr", "May", "Jun", "Jul", "Aug", "Sep", "Oct", "Nov", "Dec")
_MONTH = f"({'|'.join(_MONTHS)})"
_CLOCK = r"(\d\d:\d\d:\d\d)"
_ISO = re.compile(
    r"(\d{4})([-/])(\d\d)\2(\d\d)[T ](\d\d:\d\d(?::\d\d)?)(?:[.,](\d{1,9})\d*)?"
    r"(Z| ?[+-]\d\d:?\d\d)?",
    re.ASCII,
)
_WEB = re.compile(rf"(\d\d)/{_MONTH}/(\d{{4}}):{_CLOCK} ([+-]\d\d):?(\d\d)", re.ASCII)
_LONG = re.compile(
    rf"\b{_MONTH} +(\d{{1,2}}) {_CLOCK}(?:\.\d+)?(?: [A-Z]{{3,4}})? (\d{{4}})"
    r"(?: ([+-]\d\d):?(\d\d))?",
    re.ASCII,
)
_CHAT = re.compile(
    r"[^\w\[]?\[?(\d{1,2})([./-])(\d{1,2})\2(\d{4}|\d\d),? (\d{1,2}):(\d\d)(?::(\d\d))?"
    r"(?:\s?([AaPp])\.?[Mm]\b\.?)?(?=\]| -)"
)
_SHORT = re.compile(rf"{_MONTH} +(\d{{1,2}}) {_CLOCK}\b", re.ASCII)
_COMMIT = re.compile(r"commit [0-9a-f]{7,64}\b")


def _iso(line: str) -> str | None:
    found = _ISO.search(line[:_REACH])
    if found is None:
        return None
    year, _, month, day, clock, fraction, zone = found.groups()
    zone = (zone or "").strip()
    if len(zone) == 5:
        zone = f"{zone[:3]}:{zone[3:]}"
    clock = clock if clock.count(":") == 2 else f"{clock}:00"
    return f"{year}-{month}-{day}T{clock}{f'.{fraction}' if fraction else ''}{zone}"


def _web(line: str) -> str | None:
    found = _WEB.search(line[:_REACH])
    if found is None:
        return None
    day, month, year, clock, hours, minutes = found.groups()
    return f"{_date(year, month, day)}T{clock}{hours}:{minutes}"


def _long(line: str) -> str | None:
    found = _LONG.search(line[:_REACH])
    if found is None:
        return None
    month, day, clock, year, hours, minutes = found.groups()
    return f"{_date(year, month, day)}T{clock}{f'{hours}:{minutes}' if hours else ''}"


def _git(line: str) -> str | None:
    return (_long(line) or _iso(line)) if line.startswith("Date:") else None


def _chat(line: str) -> str | None:
    """Return day and month in the order of the file, which the whole column settles."""
    found = _CHAT.match(line)
    if found is None:
        return None
    one, mark, two, year, hour, minute, second, half = found.groups()
    hours = int(hour) % 12 + 12 * (half in "Pp") if half else int(hour)
    year = year if len(year) == 4 else f"20{year}"
    return f"{one}{mark}{two}{mark}{year} {hours:02}:{minute}:{second or '00'}"


def _short(line: str) -> str | None:
    found = _SHORT.match(line)
    return None if found is None else f"{_date('0000', found[1], found[2])}T{found[3]}"


def _date(year: str, month: str, day: str) -> str:
    return f"{year}-{_MONTHS.index(month) + 1:02}-{int(day):02}"


_WAYS = (_iso, _web, _long, _chat, _short)


def sniff(source: Source) -> bool:
    """Return whether rows are to be counted and the first line and most others have a time."""
    asked = (source.options.time or "").rpartition(":")[0]
    if not source.options.counts or (source.options.time and asked not in ("", "time")):
        return False  # a column of a table
    return is_log(source)


def is_log(source: Source) -> bool:
    """Return whether the first line and most others have a time, or it is what git says."""
    return _way_of(source) is not None


def _way_of(source: Source) -> Callable[[str], str | None] | None:
    if source.head_text is None or source.looks_like_json:
        return None
    lines = [line for line in source.head_text.splitlines() if line.strip()][:_SNIFFED]
    if lines and _COMMIT.match(lines[0]):
        return _git if any(map(_git, lines)) else None
    for way in _WAYS:
        times = [way(line) for line in lines]
        if times and times[0] is not None and 2 * times.count(None) <= len(times):
            return way
    return None


class LogTable:
    """The times of a log's lines, streamed."""

    kind = "log"
    row_word = "line"
    columns = (Column.of("time"),)

    def __init__(self, source: Source) -> None:
        self._source = source
        self._time_of = _way_of(source) or _iso
        self.notes = (_NO_YEAR,) if self._time_of is _short else ()

    def chunks(self, columns: Sequence[int]) -> Iterator[Chunk]:
        """Read the times; None for a line without one."""
        encoding = delimited.encoding_of(self._source) or "utf-8"
        lines = delimited.Lines(self._source, encoding, comments=False)
        rest = iter(lines)
        first = 1
        years = _Years()
        while part := list(islice(rest, CHUNK_ROWS)):
            times = list(map(self._time_of, part))
            if self._time_of is _short:
                times = list(map(years.named, times))
            yield Chunk((times,), first, None, lines.part)
            first += len(part)


class _Years:
    """Puts a year before times without one: the next where December is followed by January."""

    def __init__(self) -> None:
        self._year, self._month = _FIRST_YEAR, 0

    def named(self, time: str | None) -> str | None:
        if time is None:
            return None
        month = int(time[5:7])
        self._year += month < self._month - 6
        self._month = month
        return f"{self._year}{time[4:]}"
