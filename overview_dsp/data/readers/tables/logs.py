"""A log as a table of one column, the times of its lines, which are counted (`--map count`).

The time of a line is the first one in its first 100 characters, in one of these forms:

| written | by |
|---|---|
| `2024-05-03T18:20:01.5Z`, `2024/05/03 18:20:01,500` | most programs |
| `10/Oct/2000:13:55:36 -0700` | web servers |
| `Fri May 3 18:20:00 2024 +0200` | `git log`, `date`, Apache's errors |
| `[03.05.24, 18:20:01]`, `5/3/24, 6:20 PM -` | exported chats, at the beginning of a line |
| `May  3 18:20:01` | syslog: without a year, years are counted from 2000 |

A log uses one of these forms, that of most of its first lines. Lines without a time continue the
message before them and are not rows. In the output of `git log`, lines that begin with `Date:` are
rows.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from itertools import islice

from overview_dsp.data.readers.data_file import DataFile
from overview_dsp.data.readers.tables.delimited import Lines
from overview_dsp.data.readers.tables.dialect import encoding_of
from overview_dsp.data.readers.tables.table import CHUNK_ROWS, Chunk, Column, Table
from overview_dsp.data.timeline.time_parsing import LINE_FORMS, in_line

_TIME_WITHIN = 100
_SNIFFED = 50
_FIRST_YEAR = 2000
_NO_YEAR = f"its lines have no year; the first year is called {_FIRST_YEAR}"

_COMMIT = re.compile(r"commit [0-9a-f]{7,64}\b")


def _time_in(form: str, line: str) -> str | None:
    """Return the time in a line as ISO text; chats keep their order of day and month."""
    if form == "git":
        if not line.startswith("Date:"):
            return None
        return in_line(line[:_TIME_WITHIN], "long") or in_line(line[:_TIME_WITHIN], "iso")
    return in_line(line[:_TIME_WITHIN], form)


def sniff(source: DataFile) -> bool:
    """Return whether lines are counted, and the first line and most others have a time."""
    column = (source.options.time or "").rpartition(":")[0]
    if not source.options.counts or (source.options.time and column not in ("", "time")):
        return False  # a column of a table
    return is_log(source)


def is_log(source: DataFile) -> bool:
    """Return whether the first line and most others have a time, or the file is from `git log`."""
    return _form_of(source) is not None


def _form_of(source: DataFile) -> str | None:
    if source.head_text is None or source.looks_like_json:
        return None
    lines = [line for line in source.head_text.splitlines() if line.strip()][:_SNIFFED]
    if lines and _COMMIT.match(lines[0]):
        return "git" if any(_time_in("git", line) for line in lines) else None
    for form in LINE_FORMS:
        times = [_time_in(form, line) for line in lines]
        if times and times[0] is not None and 2 * times.count(None) <= len(times):
            return form
    return None


class LogTable(Table):
    """Table of the times of a log's lines, streamed."""

    kind = "log"
    row_word = "line"
    columns = (Column.of("time"),)

    def __init__(self, source: DataFile) -> None:
        self._source = source
        self._form = _form_of(source) or "iso"
        self.notes = (_NO_YEAR,) if self._form == "short" else ()

    def chunks(self, columns: Sequence[int]) -> Iterator[Chunk]:
        """Read the times; None for a line without time."""
        encoding = encoding_of(self._source) or "utf-8"
        lines = Lines(self._source, encoding)
        times: Iterator[str | None] = (_time_in(self._form, line) for line in lines)
        if self._form == "short":
            times = _with_years(times)
        first = 1
        while part := list(islice(times, CHUNK_ROWS)):
            yield Chunk((part,), first, None, lines.part)
            first += len(part)


def _with_years(times: Iterator[str | None]) -> Iterator[str | None]:
    """Yield times with their year: the next year begins when January follows December."""
    year, month = _FIRST_YEAR, 0
    for time in times:
        if time is None:
            yield None
            continue
        year += int(time[5:7]) < month - 6
        month = int(time[5:7])
        yield f"{year}{time[4:]}"
