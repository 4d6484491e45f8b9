"""Tables of events: `time|date|minute|start` with `event|what|kind|type|name|label`.

::

    start,what                    date;event;note               0:00 Introduction
    08:30,breakfast               2024-06-03;launch;first try   1:15 Chorus
    12:00,walk

    # title: Home 1-0 Away
    # duration_s: 5640
    time_s,kind,label,weight
    786.2,goal,1-0 Parris (pen),1
    2571,foul,,

CSV, TSV and their relatives, JSON and JSON lines; a header may name the columns by many words
(`columns`), a table without one is two columns of times and words. Times are read as in a series'
table (`tables.time_column`): clocks, dates (with a clock in a column of its own), numbers with a
unit in the header. What happened becomes the kind (`Own goal` is `own_goal`), a longer text the
label. A list of dates begins with its first event, one of clocks or numbers at 0. Numbers under
`time` are seconds (minutes only beside a team, player or scorer: `football.minute_list`). Two
comment lines are read: `# title:` (else the file's name) and `# duration_s:` (else the last event's
time: the timeline ends with it).

A header with `time_s` and `kind` is a strict list, which `encode` writes: `label` (empty) and
`weight` (1) are optional, other columns an error, as are rows that repeat another. Numbers have a
decimal point. In a file whose first column is `label`, lines after the header that begin with `#`
are rows.

A list of which half are football kinds gets a crowd-excitement curve (`crowd_excitement`).
"""

from __future__ import annotations

import contextlib
import os
import re
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from overview_dsp import validation
from overview_dsp.data.readers.data_file import DataFile, LoadOptions
from overview_dsp.data.readers.events.listing import About, Listed, kinds_or_labels, timeline_of
from overview_dsp.data.readers.series.rows import with_settled_order
from overview_dsp.data.readers.tables import json
from overview_dsp.data.readers.tables.cells import is_missing, parse
from overview_dsp.data.readers.tables.column_roles import (
    Roles,
    TimeChoice,
    is_event_table,
    is_wordy,
    named_time_column,
    roles_of,
)
from overview_dsp.data.readers.tables.delimited import DelimitedTable
from overview_dsp.data.readers.tables.dialect import COMMENTS, Accepts, detect, headed
from overview_dsp.data.readers.tables.json import is_single, tables_in
from overview_dsp.data.readers.tables.table import (
    CellLocation,
    Cells,
    Column,
    ColumnTable,
    Table,
    as_list,
    cell_locator,
    first_rows,
)
from overview_dsp.data.readers.tables.time_column import (
    CLOCKS,
    Format,
    TimeColumn,
    as_number,
    detected_format,
)
from overview_dsp.data.timeline.event import MAX_EVENTS
from overview_dsp.data.timeline.model import Timeline
from overview_dsp.errors import InputError, shown
from overview_dsp.files.atomic import atomic_file

COLUMNS = ("time_s", "kind", "label", "weight")
"""The columns an event list may have; the first two it must have."""

_NOT_FINITE = re.compile(r"[+-]?(nan|inf|infinity|\d+\.?\d*e\+?\d+)", re.ASCII | re.IGNORECASE)
_SPECIAL = re.compile(r'[",\r\n]')
_COMMENT = re.compile(r"#\s*(title|duration_s)\s*:(.*)", re.IGNORECASE | re.DOTALL)

_HEAD = 200
_BEATS = re.compile(r"\s*\d+\.\d+\.\d\d\s*")
_CHAPTER = re.compile(
    r"\s*[\[(]?(\d{1,3}(?::\d{2}){1,2}(?:[.,]\d{1,3})?)(?![\d:])[\])]?[\s,;\-–—:|]+(\S.*)"
)
_SERIES_OPTIONS = ("value", "map", "rate")


def sniff(source: DataFile) -> bool:
    """Return whether the file is a table of events, or lines of clock and words."""
    if source.head_text is None or any(getattr(source.options, o) for o in _SERIES_OPTIONS):
        return False
    found = _json_table(source) if source.looks_like_json else detect(source, _accepting(source))
    return found is not None or bool(_chapters(source.head_text))


def sniff_lines(source: DataFile) -> bool:
    """Return whether the file is one JSON object a line, each an event."""
    if any(getattr(source.options, o) for o in _SERIES_OPTIONS) or not json.sniff_lines(source):
        return False
    table = json.JsonLinesTable(source)
    return is_event_table(table.columns, first_rows(table, 50), source.options)


def read_lines(source: DataFile, options: LoadOptions) -> Timeline:
    """Read one JSON object a line, as `read`."""
    with validation.located(f"{source.where}: "):
        return _read(json.JsonLinesTable(source), source.stem, options)


def read(source: DataFile, options: LoadOptions) -> Timeline:
    """Read a list of events; InputError names row and column.

    Takes `duration_s`, and which columns to read: `time`, `kind`, `label`.
    """
    with validation.located(f"{source.where}: "):
        table = _table(source)
        if table is not None:
            return _read(table, source.stem, options)
    return _read_chapters(source, options)


def _read(table: Table, title: str, options: LoadOptions) -> Timeline:
    head = first_rows(table, _HEAD)
    roles = roles_of(table.columns, head, options)
    _refuse_beats(table, head[roles.time])
    columns = (roles.time,) if roles.clock is None else (roles.time, roles.clock)
    choice = with_settled_order(table, TimeChoice(columns, roles.format, " "))
    return _Reader(table, roles, choice).timeline(title, options.duration_s)


def _refuse_beats(table: Table, cells: Sequence[Any]) -> None:
    """Refuse REAPER's list of markers by measures and beats, which would pass for dates."""
    texts = [cell for cell in cells if isinstance(cell, str) and cell.strip()]
    if table.columns[0].header == "#" and texts and all(map(_BEATS.fullmatch, texts)):
        raise InputError(
            f"markers by measures and beats ({shown(texts[0])}), which are no times",
            "set REAPER's ruler to minutes and seconds, and export them again",
        )


def _accepting(source: DataFile) -> Accepts:
    """What tells lists of events from other tables."""

    def accepts(header: tuple[str, ...], below: list[list[str]]) -> bool:
        columns = [Column.of(name) for name in header]
        head = [[row[i] for row in below if i < len(row)] for i in range(len(header))]
        if is_event_table(columns, head, source.options):
            return True
        # no header: times and words
        bare = [column.plain for column in columns] == ["column1", "column2"]
        form = detected_format(Column.of("time"), head[0]) if bare and head[0] else None
        return form is not None and is_wordy(head[1])

    return accepts


def _json_table(source: DataFile) -> ColumnTable | None:
    """The largest table of events of a JSON document, None if there is none."""
    found = None
    for table in tables_in(source.json):
        cells = [as_list(table.cut(i, 0, 50)) for i in range(len(table.columns))]
        if all(is_single(cell) for column in cells for cell in column) and is_event_table(
            table.columns, cells, source.options
        ):
            found = table if found is None or table.rows > found.rows else found
    return found


def _table(source: DataFile) -> Table | None:
    """The file's table of events, None if there is none."""
    if source.looks_like_json:
        found = _json_table(source)
        return None if found is None else found.checked()
    dialect = detect(source, _accepting(source))
    if dialect is not None and dialect.header == ("column 1", "column 2"):
        dialect = replace(dialect, header=("time", "event"))  # a table without a header
    return None if dialect is None else DelimitedTable(source, dialect)


class _Reader:
    """The rows of a table on their way to a Timeline."""

    def __init__(self, table: Table, roles: Roles, choice: TimeChoice) -> None:
        self.table, self.roles, self.choice = table, roles, choice
        zoned = any(table.columns[i].zoned for i in choice.columns)
        self.times = TimeColumn(choice.format, offset_min=0 if zoned else None)
        self.timeless = 0

    def timeline(self, title: str, duration_s: float | None) -> Timeline:
        listed = list(self._listed())
        if self.roles.kind is None:
            listed = kinds_or_labels(listed)
        notes = [*self.table.notes, *self.choice.notes, *self.roles.notes]
        if self.timeless:
            notes.append(f"{self.timeless} rows without a time were left out")
        form = self.choice.format
        about = About(
            title,
            f"events: a {self.table.kind} list, times from column "
            f"{shown(self.table.columns[self.roles.time].header)} ({form.description})",
            tuple(dict.fromkeys(notes)),
            duration_s,
            self.times.start(min((one.time_s for one in listed), default=0.0)),
            from_first=form.calendar or form.name == "hhmm",
        )
        return timeline_of(listed, _about(about, self.table))

    def _listed(self) -> Iterator[Listed]:
        roles, count = self.roles, len(self.choice.columns)
        text_columns = (roles.kind, roles.label, roles.weight, roles.id)
        others = [i for i in (*text_columns, roles.end, roles.length) if i is not None]
        rows = 0
        for chunk in self.table.chunks((*self.choice.columns, *others)):
            locate = cell_locator(self.table, chunk, roles.time)
            seconds = self.times.seconds(self.choice.cells(chunk), locate)
            rows += len(chunk)
            if rows > MAX_EVENTS:
                raise InputError(
                    f"more than the {MAX_EVENTS} events that are read; cut the file into parts, or "
                    "make a curve of them (--map count)"
                )
            cells = dict(zip(others, chunk.cells[count:], strict=True))
            ends = self._ends(cells, seconds)
            for i, second in enumerate(seconds.tolist()):
                if np.isnan(second):
                    self.timeless += 1
                    continue
                kind, label, weight, id_ = (
                    "" if c is None else _words(cells[c][i]) for c in text_columns
                )
                place = CellLocation(chunk.number(i), word=self.table.row_word)
                strength = _weight(weight, replace(place, column="weight")) if weight else 1.0
                yield Listed(second, kind or label, label, str(place), ends[i], strength, id_)

    def _ends(self, cells: dict[int, Cells], seconds: Any) -> list[float | None]:
        """When each ends, as far as the table says and it can be read."""
        column = self.roles.end if self.roles.end is not None else self.roles.length
        found = np.full(len(seconds), np.nan)
        if column is not None and not self.choice.format.calendar:
            texts = list(cells[column])
            form = detected_format(Column.of("time"), texts)
            if form is not None:
                same = self.choice.format.name if form.name not in CLOCKS else form.name
                with contextlib.suppress(InputError):
                    found = TimeColumn(Format(same)).seconds(texts, CellLocation)
        if self.roles.end is None:
            found = found + seconds
        return [None if np.isnan(end) else float(end) for end in found]


def _words(cell: Any) -> str:
    return "" if is_missing(cell) else " ".join(str(cell).split())


def _weight(text: str, place: CellLocation) -> float:
    number = parse(text, ".")
    if number is None:
        raise place.error(text, "isn't a number; weights are above 0, 1 = ordinary")
    return validation.positive(number[0], str(place), "weights are above 0")


# --- strict lists


def sniff_list(source: DataFile) -> bool:
    """Return whether the first row has a column `kind`, and none of times but `time_s`.

    Other names of times, and columns that a caller names, are for the other tables of events.
    """
    options = source.options
    if source.head_text is None or source.looks_like_json:
        return False
    if options.time or options.kind or options.label:
        return False
    dialect = headed(source.head_text, COLUMNS)
    names = dialect.header if dialect is not None else ()
    if "kind" not in names or "time_s" in names:
        return "kind" in names
    return named_time_column([Column.of(name) for name in names]) is None


def read_list(source: DataFile, options: LoadOptions) -> Timeline:
    """Read an event list (takes `duration_s`, which outranks the file's own); InputError if bad."""
    text = source.text  # its errors name the file themselves
    with validation.located(f"{source.where}: "):
        return decode(text, source.stem, options.duration_s)


def decode(text: str, default_title: str = "", duration_s: float | None = None) -> Timeline:
    """Make a Timeline of the text of an event list.

    Parameters
    ----------
    text
        The file's text.
    default_title
        The title if no `# title:` line gives one.
    duration_s
        Length in s; None = the file's `# duration_s:`, else the last event's time.

    Raises
    ------
    InputError
        Names line and column: an unknown or missing column, a word for a number, NaN, a negative
        time, no kind, a row given twice, an event after the end.
    """
    dialect = headed(text, COLUMNS)
    if dialect is None:
        raise InputError(f"no header; the first row names the columns {', '.join(COLUMNS)}")
    _check_header(dialect.header, dialect.first - 1)
    marks = () if dialect.header[0] == "label" else COMMENTS
    table = DelimitedTable(text, replace(dialect, comments=marks))
    listed: list[Listed] = []
    lines: dict[tuple[float, str, str], int] = {}
    for line, row in table.records():
        one = _listed_row(row, line)
        key = (one.time_s, one.words, one.label)
        if key in lines:
            raise InputError(
                f"line {line} repeats line {lines[key]} ({one.words} at {one.time_s!r} s, label "
                f"{shown(one.label)}); remove one or change its label"
            )
        lines[key] = line
        listed.append(one)
    return timeline_of(
        listed,
        _about(
            About(default_title, "events: a CSV event list", (), duration_s, as_written=True), table
        ),
    )


def encode(timeline: Timeline) -> bytes:
    """Return the events as an event list, UTF-8; the curve, the gaps and the notes stay behind.

    Reading it gives the same events (blanks around a label trimmed), title and duration.

    Raises
    ------
    InputError
        The timeline has no events.
    """
    if not timeline.events:
        raise InputError(
            "the timeline has no events, which is all an event list holds; write the native "
            "format (.json)"
        )
    title = " ".join(timeline.title.split())
    lines = [f"# title: {title}", f"# duration_s: {timeline.duration_s!r}", ",".join(COLUMNS)]
    for event in timeline.events:
        label = event.label
        if _SPECIAL.search(label):  # the csv module leaves a lone carriage return unquoted
            label = '"' + label.replace('"', '""') + '"'
        lines.append(f"{event.time_s!r},{event.kind},{label},{event.weight!r}")
    return ("\n".join(lines) + "\n").encode()


def save_events(timeline: Timeline, path: str | os.PathLike[str]) -> None:
    """Write the events as an event list, whole or not at all; errors as `encode` and a write's."""
    data = encode(timeline)
    with atomic_file(path) as temporary:
        temporary.write_bytes(data)


def _about(about: About, table: Table) -> About:
    """Add the title and the length that comment lines of a text give."""
    comments = table.comments if isinstance(table, DelimitedTable) else {}
    found: dict[str, tuple[int, str]] = {}
    for line, text in sorted(comments.items()):
        comment = _COMMENT.match(text)
        if comment is not None:
            key = comment[1].lower()
            if key in found:
                raise InputError(f"line {line}: '# {key}:' is given twice; remove one")
            found[key] = line, comment[2].strip()
    if "title" in found:
        about = replace(about, title=found["title"][1])
    if "duration_s" in found:
        line, text = found["duration_s"]
        hint = "a duration is a finite number of seconds above 0"
        length = validation.positive(
            _number(text, CellLocation(line), hint), f"line {line}, duration_s", hint
        )
        if about.duration_s is None:
            about = replace(about, duration_s=length)
    return about


def _check_header(names: Sequence[str], line: int) -> None:
    known = f"columns are {', '.join(COLUMNS)}"
    for number, name in enumerate(names, start=1):
        if name not in COLUMNS:
            raise InputError(f"line {line}, column {number}: unknown column {shown(name)}; {known}")
        if names.index(name) != number - 1:
            raise InputError(f"line {line}, column {number}: '{name}' is there twice; {known}")
    for name in COLUMNS[:2]:
        if name not in names:
            raise InputError(f"line {line}: no column '{name}' in the header; {known}")


def _listed_row(row: dict[str, str], line: int) -> Listed:
    place, hint = CellLocation(line, "time_s"), "times are seconds from 0 up, such as 750.5"
    time_s = _number(row["time_s"], place, hint)
    if time_s < 0.0:
        raise place.error(time_s, f"is before the start; {hint}")
    place, kind = CellLocation(line, "kind"), row["kind"]
    if not kind:
        raise place.missing("name one, such as goal")
    weight = 1.0
    if not is_missing(row.get("weight", "")):
        place, hint = CellLocation(line, "weight"), "weights are above 0, 1 = ordinary"
        weight = validation.positive(_number(row["weight"], place, hint), str(place), hint)
    with validation.located(f"{CellLocation(line, 'kind')}: "):
        validation.kind(kind)
    with validation.located(f"line {line}: "):
        label = validation.text(row.get("label", ""), "label")
    return Listed(time_s, kind, label, f"line {line}, column 'time_s'", None, weight)


def _number(text: str, place: CellLocation, hint: str) -> float:
    if not text:
        raise place.missing(hint)
    number = as_number(text)
    if number is None:
        if _NOT_FINITE.fullmatch(text):
            raise place.error(text, f"isn't a finite number; {hint}")
        comma = " with a decimal point" if re.fullmatch(r"\d+,\d+", text) else ""
        raise place.error(text, f"isn't a number{comma}; {hint}")
    return float(number)


# --- lines of clock and words


def _chapters(text: str) -> list[tuple[int, str, str]]:
    """Line, clock and words of each line, if most lines that aren't blank have them."""
    lines = [(n, line) for n, line in enumerate(text.splitlines(), 1) if line.strip()]
    found = [
        (n, match[1], match[2].strip())
        for n, line in lines
        if (match := _CHAPTER.fullmatch(line)) and re.search(r"[^\W\d_]", match[2])
    ]
    if found and lines[0][0] != found[0][0] and any(mark in lines[0][1] for mark in ",;\t"):
        return []  # a header: a table of something else
    return found if len(found) > 1 and 3 * len(found) >= 2 * len(lines) else []


def _read_chapters(source: DataFile, options: LoadOptions) -> Timeline:
    found = _chapters(source.text)
    with validation.located(f"{source.where}: "):
        times = TimeColumn(Format("clock"))
        seconds = times.seconds(
            [clock for _, clock, _ in found], lambda i: CellLocation(found[i][0])
        )
        listed = [
            Listed(second, text, place=f"line {line}")
            for second, (line, _, text) in zip(seconds.tolist(), found, strict=True)
        ]
        about = About(source.stem, "events: lines of clock and words", (), options.duration_s)
        return timeline_of(kinds_or_labels(listed), about)
