"""Which columns of a table of events hold the time, what happened, and what is said of it."""

from __future__ import annotations

import contextlib
import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

from overview_dsp.errors import InputError, shown
from overview_dsp.readers.source import LoadOptions
from overview_dsp.readers.tables.cells import is_missing, looks_numeric
from overview_dsp.readers.tables.table import Column, column_named, listed
from overview_dsp.readers.tables.time_column import Format, detected_format, split_wish

TIMES = (
    "time", "times", "date", "datetime", "timestamp", "minute", "start", "begin", "onset", "when",
    "times", "clock", "starttime", "startdate", "start_time", "begintime", "from", "in", "at",
    "day", "datum", "zeit", "uhrzeit", "beginn", "fecha", "hora", "heure", "debut", "début",
    "minutes", "min", "second", "seconds", "sec", "secs", "position", "offset", "timecode", "tc",
    "t", "ts", "hour", "hours", "year", "timeofday", "createdat", "elapsed", "eventtime",
    "eventdate", "dtstart", "ms", "milliseconds", "gametime", "matchtime", "startdatetime",
)  # fmt: skip
"""Names of a column of times, the likelier first; a unit may follow (`time_s`, `start (min)`)."""

KINDS = (
    "kind", "event", "eventtype", "type", "what", "category", "action", "eventname", "class",
    "ereignis", "evento", "evenement", "événement", "art", "typ", "tipo", "tag", "code",
    "behavior", "behaviour", "annotation", "incident", "trialtype", "status", "activity",
)  # fmt: skip
"""Names of a column that says what happened."""

LABELS = (
    "label", "name", "title", "description", "text", "note", "notes", "comment", "summary",
    "subject", "message", "details", "detail", "bezeichnung", "beschreibung", "titel", "nombre",
    "nom", "caption", "remark", "content", "chapter", "marker", "scene", "task", "milestone",
)  # fmt: skip
"""Names of a column of words."""

EXTRAS = (
    "weight", "strength", "importance", "priority", "intensity", "end", "endtime", "enddate",
    "stop", "finish", "out", "to", "duration", "length", "dur", "id", "eventid", "no", "nr",
    "number", "num", "index", "row", "n", "", "color", "colour", "player", "team", "who", "person",
    "user", "author", "channel", "track", "speaker", "fps", "enddatetime", "allday",
    "location", "place", "where", "latitude", "longitude", "lat", "lon", "url", "link", "period",
)  # fmt: skip
"""Names of columns that a list of events may have besides; numbers in them are no series."""

_WEIGHTS = ("weight", "strength", "importance")
_ENDS = ("end", "endtime", "enddate", "stop", "finish", "out", "to", "enddatetime")
_LENGTHS = ("duration", "length", "dur")
_IDS = ("id", "eventid", "uuid", "uid", "guid")
_UNIT = re.compile(r"(?:in)?(ns|us|ms|s|sec|secs|seconds|min|mins|minutes|h|hrs|hours)$")
_CLOCKS = ("time", "clock", "zeit", "uhrzeit", "hora", "heure", "starttime", "timeofday", "begin")
_LONGEST = 64


@dataclass(frozen=True)
class Roles:
    """The index of each column that is read; None where there is none."""

    time: int
    kind: int | None
    label: int | None
    format: Format
    clock: int | None = None
    weight: int | None = None
    end: int | None = None
    length: int | None = None
    id: int | None = None
    notes: tuple[str, ...] = field(default=())


def named(columns: Sequence[Column], names: Sequence[str]) -> int | None:
    """Return the first column with one of these names, the first name first."""
    plain = [column.plain for column in columns]
    return next((plain.index(name) for name in names if name in plain), None)


def time_named(columns: Sequence[Column]) -> int | None:
    """Return the column that is called like times, with a unit or without."""
    found = named(columns, TIMES)
    if found is not None:
        return found
    for i, column in enumerate(columns):
        stem = _UNIT.sub("", column.plain)
        if stem in TIMES and stem != column.plain:
            return i
    return None


def words_named(columns: Sequence[Column]) -> tuple[int | None, int | None]:
    """Return the column of kinds and that of labels."""
    return named(columns, KINDS), named(columns, LABELS)


def is_wordy(cells: Sequence[Any]) -> bool:
    """Return whether cells are words and not numbers."""
    known = [cell for cell in cells if not is_missing(cell)]
    return bool(known) and not looks_numeric(known) and any(isinstance(c, str) for c in known)


def looks_listed(
    columns: Sequence[Column], head: Sequence[Sequence[Any]], options: LoadOptions
) -> bool:
    """Return whether a table is a list of events: times, words, and no series of numbers.

    A table of which a caller names the kinds or the labels is one, whatever it holds.
    """
    if len(columns) < 2:
        return False
    if options.kind is not None or options.label is not None:
        return True
    time = _asked_time(columns, options.time)
    kind, label = words_named(columns)
    if time is None or (kind is None and label is None):
        return False
    words = [i for i in (kind, label) if i is not None and i != time]
    if not any(is_wordy(head[i]) for i in words):
        return False
    for i, column in enumerate(columns):
        if i in (time, *words) or column.plain in (*EXTRAS, *TIMES, *KINDS, *LABELS):
            continue
        numeric = [cell for cell in head[i] if not is_missing(cell)]
        if numeric and looks_numeric(numeric) and detected_format(column, list(numeric)) is None:
            return False
        if numeric and looks_numeric(numeric) and not _UNIT.search(column.plain):
            return False  # a quantity: a series with words beside it
    return True


def _asked_time(columns: Sequence[Column], wish: str | None) -> int | None:
    """The column of times that a caller names, else the one that is called like times."""
    if wish is not None:
        with contextlib.suppress(InputError):  # said when it is read
            asked, _ = split_wish(wish, tuple(columns))
            if asked is not None:
                return column_named(columns, asked)
    return time_named(columns)


def roles_of(
    columns: Sequence[Column], head: Sequence[Sequence[Any]], options: LoadOptions
) -> Roles:
    """Decide which columns are read.

    Parameters
    ----------
    columns, head
        The table's, and its first rows, a list a column.
    options
        `time` (`COLUMN`, `COLUMN:FORMAT` or `:FORMAT`), `kind` and `label`.

    Raises
    ------
    InputError
        No such column, or cells that aren't times.
    """
    wish = options.time
    asked, written = (None, None) if wish is None else split_wish(wish, tuple(columns))
    if asked is not None:
        time = _column_asked(columns, asked, "times")
    else:
        found = _best_time(columns, head)
        if found is None:
            raise InputError(
                f"no column is called time, date, start or minute; columns are {listed(columns)}: "
                "name one with time (--time)"
            )
        time = found
    form = Format(written) if written else detected_format(columns[time], list(head[time]))
    if form is None and asked is not None and looks_numeric(head[time]):
        header = shown(columns[time].header)
        form = Format("s", f"the numbers of column {header} are read as seconds")
    if form is None:
        first = next((cell for cell in head[time] if not is_missing(cell)), None)
        raise InputError(
            f"column {shown(columns[time].header)} holds {shown(first)}, which isn't "
            "a time in any known way; say how times are written with time (--time COLUMN:FORMAT)"
        )
    kind, label = words_named(columns)
    if options.kind is not None:
        kind = _column_asked(columns, options.kind, "kinds")
        label = None if label == kind else label
    if options.label is not None:
        label = _column_asked(columns, options.label, "labels")
        kind = None if kind == label and options.kind is None else kind
    if kind is None and label is None:
        raise InputError(
            "no column says what happened (event, what, kind, type, name); columns are "
            f"{listed(columns)}: name one with kind or label (--kind, --label)"
        )
    return Roles(
        time,
        kind,
        label,
        form,
        _clock_beside(columns, head, time, form),
        named(columns, _WEIGHTS),
        named(columns, _ENDS),
        named(columns, _LENGTHS),
        named(columns, _IDS),
        (form.note,) if form.note else (),
    )


def _column_asked(columns: Sequence[Column], name: str, what: str) -> int:
    index = column_named(columns, name)
    if index is None:
        raise InputError(f"no column {shown(name)} for the {what}; columns are {listed(columns)}")
    return index


def _best_time(columns: Sequence[Column], head: Sequence[Sequence[Any]]) -> int | None:
    """The column that is called like times; one of dates before one of clocks."""
    for i, column in enumerate(columns):
        if column.plain in TIMES:
            form = detected_format(column, list(head[i]))
            if form is not None and form.calendar:
                return i
    return time_named(columns)


def _clock_beside(
    columns: Sequence[Column], head: Sequence[Sequence[Any]], date: int, form: Format
) -> int | None:
    """A column of clock times that completes one of days."""
    days = [cell for cell in head[date] if isinstance(cell, str)]
    if not form.calendar or any(":" in cell for cell in days):
        return None
    for i, column in enumerate(columns):
        texts = [cell for cell in head[i] if isinstance(cell, str) and not is_missing(cell)]
        clock = i != date and any(name in column.plain for name in _CLOCKS)
        if clock and texts and all(":" in text for text in texts):
            return i
    return None
