"""Readers of tables of events, such as a column `time` or `date` and a column `event` or `kind`.

::

    start,what                    date;event;note               0:00 Introduction
    08:30,breakfast               2024-06-03;launch;first try   1:15 Chorus
    12:00,walk

    # title: Home 1-0 Away
    # duration_s: 5640
    time_s,kind,label,weight,side
    786.2,goal,1-0 Parris (pen),1,1
    2571,foul,,,

The formats are CSV, TSV and similar, JSON, and JSON lines. `tables.column_roles` lists the column
names. A table without a header has two columns, times and text. `tables.time_column` reads the
times: clock times, dates (the clock may be in another column), and numbers with a unit in the
header. A short text is the event kind (`Own goal` is `own_goal`), a longer one the label. A list of
dates starts at its first event; lists of clock times and numbers start at 0. Numbers in a column
`time` are seconds, except in `football.minute_list`. Two comment lines are read: `# title:`
(default: the file name) and `# duration_s:` (default: the time of the last event).

A header with `time_s` and `kind` is a strict list, which `encode` writes. `label` (default: empty),
`weight` (default: 1) and `side` (team, 1 or 2) are optional; other columns and repeated rows are
errors. Numbers have a decimal point. If the first column is `label`, lines after the header that
begin with `#` are rows.

If at least half of the events have football kinds, a crowd-excitement curve is derived.
"""

from __future__ import annotations

import contextlib
import itertools
import os
import re
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from overview_dsp import validation
from overview_dsp.data.readers.data_file import DataFile, LoadOptions
from overview_dsp.data.readers.events.timeline_builder import (
    ListDescription,
    ListEntry,
    timeline_of,
    with_kinds,
)
from overview_dsp.data.readers.series.rows import with_settled_order
from overview_dsp.data.readers.tables import json_lines
from overview_dsp.data.readers.tables.cells import detect_decimal_mark, is_missing, parse
from overview_dsp.data.readers.tables.column_roles import (
    Roles,
    TimeChoice,
    clock_note,
    is_event_table,
    is_wordy,
    named_time_column,
    roles_of,
)
from overview_dsp.data.readers.tables.delimited import DelimitedTable
from overview_dsp.data.readers.tables.dialect import COMMENTS, Accepts, detect, header_dialect
from overview_dsp.data.readers.tables.groups import require_single_series, selected_group
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
from overview_dsp.data.timeline.event import FIELDS, MAX_EVENTS
from overview_dsp.data.timeline.model import Timeline
from overview_dsp.errors import InputError, quoted
from overview_dsp.files.atomic import write_file

_NOT_FINITE = re.compile(r"[+-]?(nan|inf|infinity|\d+\.?\d*e\+?\d+)", re.ASCII | re.IGNORECASE)
_SPECIAL = re.compile(r'[",\r\n]')
_COMMENT = re.compile(r"#\s*(title|duration_s)\s*:(.*)", re.IGNORECASE | re.DOTALL)

_HEAD = 200
_BEATS = re.compile(r"\s*\d+\.\d+\.\d\d\s*")
_CHAPTER = re.compile(
    r"\s*[\[(]?(\d{1,3}(?::\d{2}){1,2}(?:[.,]\d{1,3})?)(?![\d:])[\])]?[\s,;\-–—:|]+(\S.*)"
)
_SERIES_OPTIONS = ("value", "map", "rate")
_WEIGHT_HINT = "weights must be above 0 (ordinary events: 1)"


def sniff(source: DataFile) -> bool:
    """Return whether the file is a table of events, or has lines of a clock time and a text."""
    if source.head_text is None or any(getattr(source.options, o) for o in _SERIES_OPTIONS):
        return False
    found = _json_table(source) if source.looks_like_json else detect(source, _accepting(source))
    return found is not None or bool(_chapters(source.head_text))


def sniff_lines(source: DataFile) -> bool:
    """Return whether the file has one JSON object per line, each an event."""
    if any(getattr(source.options, o) for o in _SERIES_OPTIONS) or not json_lines.sniff(source):
        return False
    table = json_lines.JsonLinesTable(source)
    return is_event_table(table.columns, first_rows(table, 50), source.options)


def read_lines(source: DataFile, options: LoadOptions) -> Timeline:
    """Read one JSON object per line, as `read`."""
    return _read(json_lines.JsonLinesTable(source), source.stem, options)


def read(source: DataFile, options: LoadOptions) -> Timeline:
    """Read a table of events; the InputError contains row and column.

    Takes the options `duration_s`, and the columns `time`, `kind` and `label`.
    """
    table = open_table(source)
    return _read_chapters(source, options) if table is None else _read(table, source.stem, options)


def _read(table: Table, title: str, options: LoadOptions) -> Timeline:
    table = selected_group(table, options) or table
    head = first_rows(table, _HEAD)
    roles = roles_of(table.columns, head, options)
    _reject_beats(table, head[roles.time])
    columns = (roles.time,) if roles.clock is None else (roles.time, roles.clock)
    notes = (clock_note(table.columns, *columns),) if roles.unmarked else ()
    choice = with_settled_order(
        table, TimeChoice(columns, roles.format, " ", notes, roles.unmarked)
    )
    require_single_series(table, choice, [] if roles.kind is None else [roles.kind], events=True)
    return _Reader(table, roles, choice).timeline(title, options.duration_s)


def _reject_beats(table: Table, cells: Sequence[Any]) -> None:
    """Raise InputError for REAPER markers in measures and beats, which look like dates."""
    texts = [cell for cell in cells if isinstance(cell, str) and cell.strip()]
    if table.columns[0].header == "#" and texts and all(map(_BEATS.fullmatch, texts)):
        raise InputError(
            f"the markers have measures and beats ({quoted(texts[0])}); must be times",
            "set REAPER's ruler to minutes and seconds, and export the markers again",
        )


def _accepting(source: DataFile) -> Accepts:
    """Return a function that distinguishes tables of events from other tables."""

    def accepts(header: tuple[str, ...], below: list[list[str]]) -> bool:
        columns = [Column.of(name) for name in header]
        head = [[row[i] for row in below if i < len(row)] for i in range(len(header))]
        if is_event_table(columns, head, source.options):
            return True
        # no header: two columns of times and text
        bare = [column.plain for column in columns] == ["column1", "column2"]
        form = detected_format(Column.of("time"), head[0]) if bare and head[0] else None
        return form is not None and is_wordy(head[1])

    return accepts


def _json_table(source: DataFile) -> ColumnTable | None:
    """Return the largest table of events in a JSON document; None without one."""
    found = None
    for table in tables_in(source.json):
        cells = [as_list(table.cut(i, 0, 50)) for i in range(len(table.columns))]
        if all(is_single(cell) for column in cells for cell in column) and is_event_table(
            table.columns, cells, source.options
        ):
            found = table if found is None or table.rows > found.rows else found
    return found


def open_table(source: DataFile) -> Table | None:
    """Return the file's table of events; None without one."""
    if source.looks_like_json:
        found = _json_table(source)
        return None if found is None else found.checked()
    dialect = detect(source, _accepting(source))
    if dialect is not None and dialect.header == ("column 1", "column 2"):
        dialect = replace(dialect, header=("time", "event"))  # the table has no header
    return None if dialect is None else DelimitedTable(source, dialect)


class _Reader:
    """Reader of the rows of a table of events."""

    def __init__(self, table: Table, roles: Roles, choice: TimeChoice) -> None:
        self.table, self.roles, self.choice = table, roles, choice
        zoned = any(table.columns[i].zoned for i in choice.columns)
        first = (as_list(chunk.cells[0]) for chunk in table.chunks(choice.columns[:1]))
        mark = detect_decimal_mark(next(first, [])[:100]) or "."
        self.times = TimeColumn(choice.format, None, 0 if zoned else None, mark)
        self.timeless = 0

    def timeline(self, title: str, duration_s: float | None) -> Timeline:
        listed = list(self._listed())
        if self.roles.kind is None:
            listed = with_kinds(listed)
        notes = [*self.table.notes, *self.choice.notes, *self.roles.notes]
        if self.timeless:
            notes.append(f"{self.timeless} rows without a time were omitted")
        form, moments = self.choice.format, [one.time_s for one in listed]
        if form.name == "hhmm" and sorted(moments) not in (moments, moments[::-1]):
            back = next(b for a, b in itertools.pairwise(listed) if b.time_s < a.time_s)
            raise InputError(f"{back.location}: the clock goes back; give dates too, or sort rows")
        description = ListDescription(
            title,
            f"events: a {self.table.kind} list, times from column "
            f"{quoted(self.table.columns[self.roles.time].header)} ({form.description})",
            tuple(dict.fromkeys(notes)),
            duration_s,
            self.times.start(min((one.time_s for one in listed), default=0.0)),
            from_first=form.calendar or form.name == "hhmm",
        )
        return timeline_of(listed, _described(description, self.table))

    def _listed(self) -> Iterator[ListEntry]:
        roles, count = self.roles, len(self.choice.columns)
        text_columns = (roles.kind, roles.label, roles.weight, roles.id, roles.side)
        others = [i for i in (*text_columns, roles.end, roles.length) if i is not None]
        rows = 0
        for chunk in self.table.chunks((*self.choice.columns, *others)):
            locate = cell_locator(self.table, chunk, roles.time)
            seconds = self.times.seconds(self.choice.cells(chunk), locate)
            rows += len(chunk)
            if rows > MAX_EVENTS:
                raise InputError(
                    f"the file has more than {MAX_EVENTS} events, the maximum; cut it into parts, "
                    "or read it as a curve (--map count)"
                )
            cells = dict(zip(others, chunk.cells[count:], strict=True))
            ends = self._ends(cells, seconds)
            for i, second in enumerate(seconds.tolist()):
                if np.isnan(second):
                    self.timeless += 1
                    continue
                found = (None if c is None else cells[c][i] for c in text_columns)
                kind, label, weight, id_, side = (
                    "" if is_missing(cell) else " ".join(str(cell).split()) for cell in found
                )
                row = CellLocation(chunk.number(i), word=self.table.row_word)
                strength = _weight(weight, replace(row, column="weight")) if weight else 1.0
                team = int(side[0]) if side in ("1", "2", "1.0", "2.0") else 0
                entry = ListEntry(second, kind or label, label, str(row), ends[i], strength, id_)
                yield replace(entry, side=team) if team else entry

    def _ends(self, cells: dict[int, Cells], seconds: Any) -> list[float | None]:
        """Return the end of each event, s; None if it is unknown."""
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


def _weight(text: str, location: CellLocation) -> float:
    number = parse(text, ".")
    if number is None:
        raise location.error(text, f"isn't a number; {_WEIGHT_HINT}")
    return validation.positive(number[0], str(location), _WEIGHT_HINT)


# --- strict lists


def sniff_list(source: DataFile) -> bool:
    """Return whether the first row has the column `kind`, and no column of times but `time_s`.

    Tables with other columns of times, or with columns selected by options, are read by `read`.
    """
    options = source.options
    requested = options.time or options.kind or options.label
    if source.head_text is None or source.looks_like_json or requested:
        return False
    dialect = header_dialect(source.head_text, FIELDS)
    names = dialect.header if dialect is not None else ()
    if "kind" not in names or "time_s" in names:
        return "kind" in names
    return named_time_column([Column.of(name) for name in names]) is None


def read_list(source: DataFile, options: LoadOptions) -> Timeline:
    """Read an event list; the option `duration_s` replaces the duration in the file."""
    return decode(source.text, source.stem, options.duration_s)


def decode(text: str, default_title: str = "", duration_s: float | None = None) -> Timeline:
    """Return the Timeline of an event list.

    `text`: text of the file.
    `default_title`: title of a file without a `# title:` line.
    `duration_s`: duration, s. None: from the `# duration_s:` line, else the time of the last event.

    InputError: a column, number, time or kind is invalid or missing, a row is repeated, or an event
    is after the end. The message contains line and column.
    """
    dialect = header_dialect(text, FIELDS)
    if dialect is None:
        raise InputError(f"no header; the first row must have the columns {', '.join(FIELDS)}")
    _check_header(dialect.header, dialect.first - 1)
    marks = () if dialect.header[0] == "label" else COMMENTS
    table = DelimitedTable(text, replace(dialect, comments=marks))
    listed: list[ListEntry] = []
    lines: dict[tuple[float, str, str], int] = {}
    for line, row in table.records():
        one = _listed_row(row, line)
        key = (one.time_s, one.kind_text, one.label)
        if key in lines:
            raise InputError(
                f"line {line} repeats line {lines[key]} ({one.kind_text} at {one.time_s!r} s, "
                f"label {quoted(one.label)}); remove one or change its label"
            )
        lines[key] = line
        listed.append(one)
    description = ListDescription(
        default_title, "events: a CSV event list", (), duration_s, as_written=True
    )
    return timeline_of(listed, _described(description, table))


def encode(timeline: Timeline) -> bytes:
    """Return the events as an event list, UTF-8, without curve, gaps and notes.

    Reading the list returns the same title, duration and events, with labels stripped of spaces.

    InputError: the timeline has no events.
    """
    if not timeline.events:
        raise InputError(
            "the timeline has no events, and an event list contains nothing else; write the native "
            "format (.json)"
        )
    title = " ".join(timeline.title.split())
    fields = FIELDS if any(event.side for event in timeline.events) else FIELDS[:-1]
    lines = [f"# title: {title}", f"# duration_s: {timeline.duration_s!r}", ",".join(fields)]
    for event in timeline.events:
        label = event.label
        if _SPECIAL.search(label):  # the csv module does not quote a single carriage return
            label = '"' + label.replace('"', '""') + '"'
        row = f"{event.time_s!r},{event.kind},{label},{event.weight!r},{event.side or ''}"
        lines.append(row if fields is FIELDS else row.removesuffix(","))
    return ("\n".join(lines) + "\n").encode()


def save_events(timeline: Timeline, path: str | os.PathLike[str]) -> None:
    """Write the events as an event list; on any error no file is written."""
    write_file(path, encode(timeline))


def _described(description: ListDescription, table: Table) -> ListDescription:
    """Return the description with the title and duration in the comment lines."""
    comments = table.comments if isinstance(table, DelimitedTable) else {}
    found: dict[str, tuple[int, str]] = {}
    for line, text in sorted(comments.items()):
        comment = _COMMENT.match(text)
        if comment is not None:
            key = comment[1].lower()
            if key in found:
                raise InputError(f"line {line}: '# {key}:' is repeated; remove one of the lines")
            found[key] = line, comment[2].strip()
    if "title" in found:
        description = replace(description, title=found["title"][1])
    if "duration_s" in found:
        line, text = found["duration_s"]
        hint = "the duration must be a finite number of seconds above 0"
        length = validation.positive(
            _number(text, CellLocation(line), hint), f"line {line}, duration_s", hint
        )
        if description.duration_s is None:
            description = replace(description, duration_s=length)
    return description


def _check_header(names: Sequence[str], line: int) -> None:
    known = f"columns: {', '.join(FIELDS)}"
    for number, name in enumerate(names, start=1):
        if name not in FIELDS:
            raise InputError(
                f"line {line}, column {number}: unknown column {quoted(name)}; {known}"
            )
        if names.index(name) != number - 1:
            raise InputError(f"line {line}, column {number}: '{name}' is repeated; {known}")
    for name in FIELDS[:2]:
        if name not in names:
            raise InputError(f"line {line}: the header has no column '{name}'; {known}")


def _listed_row(row: dict[str, str], line: int) -> ListEntry:
    location, hint = CellLocation(line, "time_s"), "times must be 0 s or later, such as 750.5"
    time_s = _number(row["time_s"], location, hint)
    if time_s < 0.0:
        raise location.error(time_s, f"is before the start; {hint}")
    location, kind = CellLocation(line, "kind"), row["kind"]
    if not kind:
        raise location.missing("write a kind, such as goal")
    weight = 1.0
    if not is_missing(row.get("weight", "")):
        location = CellLocation(line, "weight")
        number = _number(row["weight"], location, _WEIGHT_HINT)
        weight = validation.positive(number, str(location), _WEIGHT_HINT)
    location, text = CellLocation(line, "side"), row.get("side", "")
    if text not in ("", "0", "1", "2"):
        raise location.error(text, "isn't 1 or 2, the number of a team")
    with validation.prefix_errors(f"{CellLocation(line, 'kind')}: "):
        validation.kind(kind)
    with validation.prefix_errors(f"line {line}: "):
        label = validation.text(row.get("label", ""), "label")
    where = f"line {line}, column 'time_s'"
    return ListEntry(time_s, kind, label, where, None, weight, side=int(text or 0))


def _number(text: str, location: CellLocation, hint: str) -> float:
    if not text:
        raise location.missing(hint)
    number = as_number(text)
    if number is None:
        if _NOT_FINITE.fullmatch(text):
            raise location.error(text, f"isn't a finite number; {hint}")
        comma = " with a decimal point" if re.fullmatch(r"\d+,\d+", text) else ""
        raise location.error(text, f"isn't a number{comma}; {hint}")
    return float(number)


# --- chapters: lines of a clock time and a text


def _chapters(text: str) -> list[tuple[int, str, str]]:
    """Return number, clock time and text of the lines, if at least two thirds have both."""
    lines = [(n, line) for n, line in enumerate(text.splitlines(), 1) if line.strip()]
    found = [
        (n, match[1], match[2].strip())
        for n, line in lines
        if (match := _CHAPTER.fullmatch(line)) and re.search(r"[^\W\d_]", match[2])
    ]
    if found and lines[0][0] != found[0][0] and any(mark in lines[0][1] for mark in ",;\t"):
        return []  # the first line is the header of another table
    return found if len(found) > 1 and 3 * len(found) >= 2 * len(lines) else []


def _read_chapters(source: DataFile, options: LoadOptions) -> Timeline:
    found = _chapters(source.text)
    times = TimeColumn(Format("clock"))
    seconds = times.seconds([clock for _, clock, _ in found], lambda i: CellLocation(found[i][0]))
    listed = [
        ListEntry(second, text, location=f"line {line}")
        for second, (line, _, text) in zip(seconds.tolist(), found, strict=True)
    ]
    origin = "events: lines of a clock time and a text"
    description = ListDescription(source.stem, origin, (), options.duration_s)
    return timeline_of(with_kinds(listed), description)
