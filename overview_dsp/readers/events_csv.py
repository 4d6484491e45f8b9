"""Event lists as CSV: one row an event.

::

    # title: Home 1-0 Away
    # duration_s: 5640
    time_s,kind,label,weight
    786.2,goal,1-0 Parris (pen),1
    2571,foul,,

A header names the columns in any order: `time_s` and `kind` are required, `label` (empty) and
`weight` (1) optional, others an error. Fields are separated by commas, semicolons or tabs,
whichever the header uses, and may be quoted. Numbers have a decimal point. Blank lines are skipped,
and so are lines that begin with `#`, except for two that are read: `# title:` (else the file's
name) and `# duration_s:` (else the last event's time: the timeline ends with it). In a file whose
first column is `label`, lines after the header that begin with `#` are rows.

A list with football kinds gets a crowd-excitement curve (`excitement.py`).
"""

from __future__ import annotations

import io
import itertools
import os
import re
from collections.abc import Iterator, Sequence
from dataclasses import replace

from overview_dsp import validation
from overview_dsp.analysis.crowd_excitement import derive_intensity
from overview_dsp.errors import InputError, shown
from overview_dsp.files.atomic import whole_file
from overview_dsp.readers.everyday.columns import time_named
from overview_dsp.readers.source import LoadOptions, Source
from overview_dsp.readers.tables.cells import is_missing
from overview_dsp.readers.tables.delimited import DelimitedTable
from overview_dsp.readers.tables.dialect import COMMENTS, headed
from overview_dsp.readers.tables.table import Column, Location
from overview_dsp.timeline.event import MAX_EVENTS
from overview_dsp.timeline.model import Event, Timeline

COLUMNS = ("time_s", "kind", "label", "weight")
"""The columns an event list may have; the first two it must have."""

# Python's float() also takes "1_000" and other scripts' digits; a file means neither
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?", re.ASCII | re.IGNORECASE)
_NOT_FINITE = re.compile(r"[+-]?(nan|inf|infinity)", re.IGNORECASE)
_SPECIAL = re.compile(r'[",\r\n]')
_COMMENT = re.compile(r"#\s*(title|duration_s)\s*:(.*)", re.IGNORECASE | re.DOTALL)


def sniff(source: Source) -> bool:
    """Return whether the first row has a column `kind`, and none of times but `time_s`.

    Other names of times, and columns that a caller names, are for `everyday.table_reader`.
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
    return time_named([Column.of(name) for name in names]) is None


def read(source: Source, options: LoadOptions) -> Timeline:
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
    comments = _Comments()
    events: dict[tuple[float, str, str], tuple[Event, int]] = {}
    for line, row in _rows(text, comments):
        event = _event(row, line)
        key = (event.time_s, event.kind, event.label)
        if key in events:
            raise InputError(
                f"line {line} repeats line {events[key][1]} ({event.kind} at {event.time_s!r} s, "
                f"label {shown(event.label)}); remove one or change its label"
            )
        if len(events) == MAX_EVENTS:
            raise InputError(
                f"line {line}: more than the {MAX_EVENTS} events that are read; cut the file into "
                "parts, or make a curve of them"
            )
        events[key] = (event, line)
    if not events:
        raise InputError("no events below the header; add one row for each event")
    if duration_s is None:
        duration_s = comments.duration_s
    if duration_s is None:
        duration_s = max(event.time_s for event, _ in events.values())
        if duration_s == 0.0:
            raise InputError(
                "all events are at 0 s, so the duration is unknown; give it (a line "
                "'# duration_s: 5400' before the header, or the option duration_s)"
            )
    duration_s = validation.positive(
        duration_s, "duration_s", "a duration is a finite number of seconds above 0"
    )
    for event, line in events.values():
        if event.time_s > duration_s:
            raise Location(line, "time_s").error(
                event.time_s,
                f"s is after the end of the timeline (duration_s {duration_s!r}); correct one of "
                "them",
            )
    listed = tuple(event for event, _ in events.values())
    intensity, derived, notes = derive_intensity(listed, duration_s)
    return Timeline(
        title=comments.title if comments.title is not None else default_title,
        duration_s=duration_s,
        events=listed,
        intensity=intensity,
        provenance="; ".join(part for part in ("events: a CSV event list", derived) if part),
        notes=notes,
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
    with whole_file(path) as temporary:
        temporary.write_bytes(data)


class _Comments:
    """The two comment lines that are read; InputError for one that is there twice, or no length."""

    title: str | None = None
    duration_s: float | None = None

    def add(self, line: int, text: str) -> None:
        found = _COMMENT.match(text)
        if found is None:
            return
        key, value = found[1].lower(), found[2].strip()
        if getattr(self, key) is not None:
            raise InputError(f"line {line}: '# {key}:' is given twice; remove one")
        if key == "title":
            self.title = value
        else:
            hint = "a duration is a finite number of seconds above 0"
            duration = _number(value, Location(line), hint)
            self.duration_s = validation.positive(duration, f"line {line}, duration_s", hint)


def _rows(text: str, comments: _Comments) -> Iterator[tuple[int, dict[str, str]]]:
    """Give line and fields of each row; the comments' values are there afterwards."""
    dialect = headed(text, COLUMNS)
    if dialect is None:
        raise InputError(f"no header; the first row names the columns {', '.join(COLUMNS)}")
    line = dialect.first - 1
    _check_header(dialect.header, line)
    for number, above in enumerate(itertools.islice(io.StringIO(text, newline=""), line - 1), 1):
        comments.add(number, above)
    marks = () if dialect.header[0] == "label" else COMMENTS
    table = DelimitedTable(text, replace(dialect, comments=marks))
    yield from table.records()
    for number, below in table.lines.found:
        comments.add(number, below)


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


def _event(row: dict[str, str], line: int) -> Event:
    place, hint = Location(line, "time_s"), "times are seconds from 0 up, such as 750.5"
    time_s = _number(row["time_s"], place, hint)
    if time_s < 0.0:
        raise place.error(time_s, f"is before the start; {hint}")
    place, kind = Location(line, "kind"), row["kind"]
    if not kind:
        raise place.missing("name one, such as goal")
    weight = 1.0
    if not is_missing(row.get("weight", "")):
        place, hint = Location(line, "weight"), "weights are above 0, 1 = ordinary"
        weight = validation.positive(_number(row["weight"], place, hint), str(place), hint)
    with validation.located(f"{Location(line, 'kind')}: "):
        validation.kind(kind)
    with validation.located(f"line {line}: "):
        return Event(time_s, kind, row.get("label", ""), weight)


def _number(text: str, place: Location, hint: str) -> float:
    if not text:
        raise place.missing(hint)
    if _NOT_FINITE.fullmatch(text):
        raise place.error(text, f"isn't a finite number; {hint}")
    if not _NUMBER.fullmatch(text):
        comma = " with a decimal point" if re.fullmatch(r"\d+,\d+", text) else ""
        raise place.error(text, f"isn't a number{comma}; {hint}")
    return validation.number(float(text), str(place), hint)
