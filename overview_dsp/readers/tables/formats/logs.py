"""A log as a table of one column, to count its lines (`--map count`): their times.

A line's time is the first thing in its first 100 characters that is written like one: ISO with a
blank or a T and any fraction, or a web server's `10/Oct/2000:13:55:36 -0700`. Lines without one
(the rest of a message of several lines) are no rows of their own.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from itertools import islice

from overview_dsp.readers.source import Source
from overview_dsp.readers.tables.formats import delimited
from overview_dsp.readers.tables.table import CHUNK_ROWS, Chunk, Column

_REACH = 100
_SNIFFED = 50
_ISO = re.compile(
    r"(\d{4})-(\d\d)-(\d\d)[T ](\d\d:\d\d(?::\d\d)?)(?:[.,](\d{1,9})\d*)?(Z| ?[+-]\d\d:?\d\d)?",
    re.ASCII,
)
_WEB = re.compile(r"(\d\d)/([A-Z][a-z]{2})/(\d{4}):(\d\d:\d\d:\d\d) ([+-]\d\d):?(\d\d)", re.ASCII)
_MONTHS = ["Jan", "Feb", "Mar", "Apr", "May", "Jun", "Jul", "Aug", "Sep", "Oct", "Nov", "Dec"]


def sniff(source: Source) -> bool:
    """Return whether rows are to be counted and the first line and most others have a time."""
    if not source.options.counts or source.options.time is not None:
        return False
    if source.head_text is None or source.looks_like_json:
        return False
    lines = [line for line in source.head_text.splitlines() if line.strip()][:_SNIFFED]
    times = [time_of(line) for line in lines]
    return bool(times) and times[0] is not None and 2 * times.count(None) <= len(times)


def time_of(line: str) -> str | None:
    """Return a line's time in ISO, None where it has none."""
    found = _ISO.search(line[:_REACH])
    if found is not None:
        year, month, day, clock, fraction, zone = found.groups()
        zone = (zone or "").strip()
        if len(zone) == 5:
            zone = f"{zone[:3]}:{zone[3:]}"
        clock = clock if clock.count(":") == 2 else f"{clock}:00"
        return f"{year}-{month}-{day}T{clock}{f'.{fraction}' if fraction else ''}{zone}"
    found = _WEB.search(line[:_REACH])
    if found is not None and found[2] in _MONTHS:
        day, name, year, clock, hours, minutes = found.groups()
        return f"{year}-{_MONTHS.index(name) + 1:02}-{day}T{clock}{hours}:{minutes}"
    return None


class LogTable:
    """The times of a log's lines, streamed."""

    kind = "log"
    row_word = "line"
    columns = (Column.of("time"),)
    notes: tuple[str, ...] = ()

    def __init__(self, source: Source) -> None:
        self._source = source

    def chunks(self, columns: Sequence[int]) -> Iterator[Chunk]:
        """Read the times; None for a line without one."""
        encoding = delimited.encoding_of(self._source) or "utf-8"
        lines = delimited.Lines(self._source, encoding, comments=False)
        rest = iter(lines)
        first = 1
        while part := list(islice(rest, CHUNK_ROWS)):
            yield Chunk((list(map(time_of, part)),), first, None, lines.part)
            first += len(part)
