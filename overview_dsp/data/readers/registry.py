"""Loading of timelines: format detection of files and of data in memory.

Of an unknown file, the error names the most similar format, and what is missing for it.
"""

from __future__ import annotations

import contextlib
import os
import re
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import replace
from importlib import resources
from pathlib import Path
from typing import Any, cast

from overview_dsp import validation
from overview_dsp.data.readers import native
from overview_dsp.data.readers.audio import reader as audio_reader
from overview_dsp.data.readers.data_file import (
    DEEPEST,
    READ_AS_WINDOWS,
    UNNAMED,
    WINDOWS,
    DataFile,
    Format,
    LoadOptions,
    decode_text,
    parse_json,
    signature,
)
from overview_dsp.data.readers.formats import LIMITS, SERIES_OPTIONS, formats, is_series
from overview_dsp.data.readers.opening import is_content, opened
from overview_dsp.data.readers.series import series_reader
from overview_dsp.data.readers.tables import json
from overview_dsp.data.readers.tables.cells import looks_numeric
from overview_dsp.data.readers.tables.column_roles import (
    is_wordy,
    kind_and_label_columns,
    named_time_column,
)
from overview_dsp.data.readers.tables.delimited import DelimitedTable
from overview_dsp.data.readers.tables.dialect import detect
from overview_dsp.data.readers.tables.groups import groups_of
from overview_dsp.data.readers.tables.json import is_single, tables_in
from overview_dsp.data.readers.tables.logs import is_log
from overview_dsp.data.readers.tables.memory import (
    TableData,
    TimelineData,
    csv_text,
    document_bytes,
    is_document,
    is_table,
    samples_of,
    table_of,
)
from overview_dsp.data.readers.tables.table import Columns, ColumnTable, Head, Table, listed
from overview_dsp.data.readers.tables.time_column import detected_format
from overview_dsp.data.timeline.model import Timeline
from overview_dsp.errors import InputError, quoted, warn

BUNDLED: dict[str, str] = {
    "world-cup-final-2018": "world_cup_final_2018.json",
    "made-up-share": "made_up_share.json",
}
"""Names and files of the bundled timelines."""

_BUNDLED_NAMES = ", ".join(BUNDLED)
_OR_BUNDLED = f", or use a bundled name ({_BUNDLED_NAMES})"

MIN_SOUND_RATE = 8000.0
"""Rate from which samples in memory are a sound, Hz."""

MAX_ROWS = 5_000_000
"""Maximum number of rows of data in memory, except series."""

_HEAD_ROWS, _HEAD_CELLS = 1000, 50_000
_ABOVE_0 = {
    "duration_s": "a duration in s",
    "rate": "a sample rate in Hz",
    "max_mb": "a limit in MB",
}
_CONTROL = re.compile(rb"[\x00-\x08\x0e-\x1f]")


def load_timeline(
    data: Timeline | TimelineData,
    duration_s: float | None = None,
    *,
    value: str | None = None,
    time: str | TableData | None = None,
    kind: str | None = None,
    label: str | None = None,
    map: str | None = None,
    rate: float | None = None,
    match: str | None = None,
    max_mb: float | None = None,
    progress: Callable[[float], None] | None = None,
    max_depth: int | None = None,
) -> Timeline:
    """Load a timeline from a file, from data in memory, or a bundled timeline by its name.

    Parameters
    ----------
    data : str, path, bytes, open file, DataFrame, Series, array, list or dict
        A file, whose format is detected; a bundled timeline, `"world-cup-final-2018"` or
        `"made-up-share"` (for a file of that name, write `./made-up-share`); a URL (`https://`,
        `s3://` or another one of fsspec); the content of a file, or an open file; a data frame or
        series of pandas, polars or Arrow; an array; a list of numbers, of (time, value) or of
        events: (time, kind, label, weight), dicts, `Event`; a dict of columns. Data in memory
        follow the same rules as files. A Timeline is returned unchanged.
    duration_s : float or None
        Length, s, for formats without it (event lists).
    value, time : str or None
        Columns of the values and of the times, for tables; by default, they are detected.
        `time="day:dmy"` sets the format of dates (`time="start:hhmm"`: times of day),
        `value="Close:share"` the type of the values: `share`, `price` or `plain`. For data in
        memory, `time` may be the times themselves, one per row: an array, a list, a Series.
    kind, label : str or None
        Columns of the kinds and the labels of events, for event lists.
    map : str or None
        Mapping of a table to friction: `level`, `change`, `activity`, `volatility[:WINDOW]` of
        its values, `count[:WINDOW]` of its rows, or a column.
    rate : float or None
        Sample rate, Hz, for tables and records without times.
    match : str or None
        Match in a file of several: words of its description, or its number from 1.
    max_mb : float or None
        Maximum size of a file that is read as a whole, and of unpacked files, MB.
    progress : callable or None
        Called with the fraction of the file that is read, 0 to 1, by slow formats.
    max_depth : int or None
        Maximum nesting level of JSON.

    Returns
    -------
    Timeline
        Events, curve and gaps; `notes` has messages about how the file was interpreted.

    Raises
    ------
    InputError
        One line with location, problem, allowed values and remedy.

    Examples
    --------
    >>> ov.load_timeline("world-cup-final-2018").duration_s
    5880.0
    >>> rows = ("time,load", "2024-06-03 09:00,1", "2024-06-03 10:00,3", "2024-06-03 11:00,2")
    >>> with open("load.csv", "w") as file:
    ...     for row in rows:
    ...         print(row, file=file)
    >>> ov.load_timeline("load.csv", value="load").duration_s
    7200.0
    >>> ov.load_timeline([1.0, 3.0, 2.0], rate=0.5).duration_s
    4.0
    >>> ov.load_timeline([(2.0, "goal", "1-0"), (8.0, "foul")], duration_s=10.0).kinds()
    {'goal': 1, 'foul': 1}
    """
    times = None if time is None or isinstance(time, str) else time
    time = "time" if times is not None else cast("str | None", time)
    options = LoadOptions(
        duration_s, value, time, map, rate, match, max_mb, progress, max_depth, kind, label
    )
    options = _checked(options)
    if isinstance(data, Timeline):
        _refuse_options(options, "a Timeline", frozenset())
        return data
    if isinstance(data, str) and data in BUNDLED:
        _refuse_options(options, data, LIMITS)
        return bundled_timeline(data)
    if is_document(data):
        data = document_bytes(data)
    if not (isinstance(data, str | os.PathLike) or is_content(data)):
        return _of_memory(data, times, options)
    if times is not None:
        raise InputError("time names a column of a file; time lists are only for data in memory")
    with opened(data, options, _OR_BUNDLED) as source:
        require_no_other_document(source)
        candidate, options = _format_of(source), source.options
        _refuse_options(options, f"{source.where}: {candidate.name}", candidate.options | LIMITS)
        with _located(source):
            timeline = candidate.read(source, options)
        notes = (*source.notes, *([READ_AS_WINDOWS] if source.encoding == WINDOWS else []))
        return replace(timeline, notes=(*notes, *timeline.notes)) if notes else timeline


def load_timelines(data: TimelineData, group: str, **options: Any) -> dict[str, Timeline]:
    """Load a table of several series or event lists, one timeline for each text of a column.

    Parameters
    ----------
    data : str, path, bytes, open file, DataFrame or list
        As for `load_timeline`.
    group : str
        Column that distinguishes the rows, such as `"country"`, or several: `"country, sex"`.
    **options
        As for `load_timeline`, except `match`.

    Returns
    -------
    dict
        Timelines by their texts. Those that cannot be read, and rows without a text, are left out,
        with a warning.

    Raises
    ------
    InputError
        The column is unknown, the format has no columns, or no timeline can be read.

    Examples
    --------
    >>> rows = [(0, "north", 1.0), (0, "south", 5.0), (9, "north", 2.0), (9, "south", 4.0)]
    >>> table = [dict(zip(("time", "station", "level"), row)) for row in rows]
    >>> {name: one.duration_s for name, one in ov.load_timelines(table, "station").items()}
    {'north': 9.0, 'south': 9.0}
    """
    for name in options.keys() - vars(LoadOptions()).keys() | options.keys() & {"match", "group"}:
        raise InputError(f"load_timelines has no option {name}, as it reads all series; remove it")
    chosen = _checked(LoadOptions(**options))
    if is_document(data):
        data = document_bytes(data)
    if not (isinstance(data, str | os.PathLike) or is_content(data)):
        _require_table(data, "not a path or data")
        table = table_of(data)
        return _by_group(table, group, lambda one: _of_memory(table, None, one), chosen)
    with opened(data, chosen, "") as source:
        candidate = _format_of(source)
        if candidate.open_table is None:
            raise InputError(
                f"{source.where}: {candidate.name}: has no columns for group (--group)"
            )
        with _located(source):
            table = candidate.open_table(source)
        _refuse_options(chosen, f"{source.where}: {candidate.name}", candidate.options | LIMITS)

        def read(one: LoadOptions) -> Timeline:
            with _located(source):
                return candidate.read(source, one)

        return _by_group(table, group, read, chosen)


@contextlib.contextmanager
def _located(source: DataFile) -> Iterator[None]:
    """Prefix errors with the file, unless they name it or another one of the same record."""
    try:
        yield
    except InputError as error:
        begins = (source.where, f"{source.path.with_suffix('')}.")
        with validation.prefix_errors("" if str(error).startswith(begins) else f"{source.where}: "):
            raise


def _by_group(
    table: Table, group: str, read: Callable[[LoadOptions], Timeline], options: LoadOptions
) -> dict[str, Timeline]:
    """Read one timeline per text of the columns `group`; a warning counts those that failed."""
    found: dict[str, Timeline] = {}
    failed: list[tuple[str, InputError]] = []
    for name, texts in groups_of(table, group).items():
        try:
            found[name] = read(replace(options, group=texts))
        except InputError as error:
            failed.append((name, error))
    if failed:
        name, first = failed[0]
        if not found:
            raise first
        words = f"{len(failed)} of {len(found) + len(failed)} series are left out; {name}: {first}"
        warn(words, 2)
    return found


def _of_memory(data: object, times: object, options: LoadOptions) -> Timeline:
    """Read a table in memory: an event list, a match, a heart recording or a series.

    The format is detected from the first rows, written to a CSV file.
    """
    is_fast = options.rate is not None and options.rate >= MIN_SOUND_RATE
    of_series = times is not None or options.value is not None
    may_be_sound = is_fast and not of_series and options.map in (None, *audio_reader.MAPS)
    if may_be_sound and (samples := samples_of(data)) is not None:
        _refuse_options(options, "a sound", frozenset({"rate", "map"}) | LIMITS)
        return audio_reader.read_samples(samples, options)
    if isinstance(data, ColumnTable):
        table = data
    else:
        _require_table(data, f"not a path, data or a bundled name ({_BUNDLED_NAMES})")
        if times is not None:
            _require_table(times, "not a column of times")
        table = table_of(data, times)
    where = f"the {table.kind} data"
    with tempfile.TemporaryDirectory(prefix="overview-") as folder:

        def written(rows: int) -> DataFile:
            path = Path(folder) / UNNAMED
            path.write_text(csv_text(table, rows), "utf-8", "surrogateescape", newline="")
            return DataFile.open(path, options, where)

        most = max(20, min(_HEAD_ROWS, _HEAD_CELLS // len(table.columns)))
        source = written(most)
        others = () if options.counts else (f for f in formats() if not is_series(f))
        found = next((f for f in others if f.sniff(source)), None)
        name, taken = (found.name, found.options) if found else ("series", SERIES_OPTIONS)
        _refuse_options(options, f"{where}: {name}", taken | LIMITS)
        if found is not None:
            if table.rows > MAX_ROWS:
                raise InputError(
                    f"{where}: {table.rows} rows, at most {MAX_ROWS} are allowed; split them"
                )
            return found.read(written(table.rows) if table.rows > most else source, options)
    with validation.prefix_errors(f"{where}: "):
        return series_reader.series_timeline(table, options)


def _require_table(data: object, what: str) -> None:
    if not is_table(data):
        hint = "; give list(...) of it" if hasattr(data, "__next__") else ""
        raise InputError(f"{quoted(data)} is {what}{hint}")


def _format_of(source: DataFile) -> Format:
    """Return the first format that accepts the file; InputError describes an unknown file."""
    # rows of an event list can be counted, too
    for candidate in formats():
        if source.options.counts and not is_series(candidate):
            continue
        if candidate.sniff(source):
            return candidate
    reason = signature(source.head, "other") or ""
    document = source.json if source.looks_like_json else None
    if other := json.other_document(document):
        reason = f"{other} without a series of times; write its values as a table with times"
    elif report := json.error_report(document):
        reason = f"an error report, not data: {quoted(report)}; check the address and its key"
    elif len(source.sheets) > 1 and not source.sheet:
        names = ", ".join(map(quoted, source.sheets[:6]))
        reason = f"no table of times in the first sheet; choose one with match (--select): {names}"
    if reason:
        raise InputError(f"{source.where}: {reason}")
    raise InputError(
        f"{source.where}: {_described(source)}, not a format that can be read",
        f"{format_hint(source)}; overview timeline formats lists all that can be read",
    )


def list_matches(
    path: str | os.PathLike[str], options: LoadOptions | None = None
) -> tuple[str, ...]:
    """Return one line per match of a file or URL, in the order of their numbers (`match`).

    The result is empty for formats of one timeline.

    InputError: as `load_timeline`.
    """
    if os.fspath(path) in BUNDLED:
        return ()
    with opened(path, _checked(options or LoadOptions()), _OR_BUNDLED) as source:
        candidate = _format_of(source)
        with _located(source):
            return tuple(candidate.matches(source)) if candidate.matches is not None else ()


def bundled_timeline(name: str = "world-cup-final-2018") -> Timeline:
    """Load a bundled timeline; InputError lists their names."""
    if name not in BUNDLED:
        raise InputError(f"no bundled timeline is called {quoted(name)}; there is {_BUNDLED_NAMES}")
    data = (resources.files("overview_dsp.data.readers") / "bundled" / BUNDLED[name]).read_bytes()
    return native.decode(parse_json(decode_text(data, name), name), name)


def _checked(options: LoadOptions) -> LoadOptions:
    """Return validated options; InputError names one that is out of range."""
    checked: dict[str, Any] = {}
    for name in options.names_set():
        value = getattr(options, name)
        if name in _ABOVE_0:
            hint = f"{_ABOVE_0[name]}, a finite number above 0"
            checked[name] = validation.positive(value, name, hint)
        elif name != "max_depth":
            checked[name] = validation.text(value, name)
        elif type(value) is not int or not 1 <= value <= DEEPEST:
            raise InputError(f"max_depth is {quoted(value)}; give a whole number, 1 to {DEEPEST}")
    return replace(options, **checked)


def _refuse_options(options: LoadOptions, what: str, taken: frozenset[str]) -> None:
    for option in sorted(options.names_set() - taken):
        raise InputError(f"{what}: {option} does not apply to this format; remove it")


def _described(source: DataFile) -> str:
    """Return a description of an unknown file."""
    if source.head_text is None:
        binary = _CONTROL.search(source.head) is not None
        return "binary data" if binary else "text that isn't UTF-8 (save it as UTF-8)"
    if not source.head_text.strip():
        return "a text file of blanks only"
    if not source.looks_like_json:
        first = source.head_text.strip().splitlines()[0]
        return f"text that begins {quoted(first)}"
    document = source.json
    if isinstance(document, dict):
        keys = ", ".join(quoted(key) for key in list(document)[:6])
        return f"a JSON object with the keys {keys or '(none)'}"
    return f"a JSON list of {len(document) if isinstance(document, list) else 0} entries"


_AS_EVENTS = "write the events as CSV with the columns time and event"
_XML = "<?xml"

_PAGE = re.compile(r"<!doctype html|<html\b|^\s*<(?:head|body)\b", re.I)
_LOGIN = re.compile(r"type\s*=\s*[\"']?password", re.I)
_FEED = re.compile(r"<(?:rss|feed|rdf:rdf)\b", re.I)
_LYRICS = re.compile(r"\[(?:ti|ar|al|au|by|re|ve|offset|length):|\[\d{1,3}:\d\d\.\d{2,3}\]", re.I)
_FIRST = 1000
"""Number of characters in which the root element of XML begins, after comments."""
_EVENT_LIST = "nearest: a table of events"


def require_no_other_document(source: DataFile) -> None:
    """Raise InputError for a web page, a login page, a news feed, lyrics and a blank file.

    A reader of text would take them for a table or for broken JSON.
    """
    if source.head_text is None:
        return
    text = source.head_text.lstrip("\ufeff \r\n\t")
    begin = text[:_FIRST]
    what = None
    if not text and source.size <= len(source.head):
        what = "holds blanks only; check how it was made, or get it again"
    elif begin.startswith("<") and _FEED.search(begin):
        what = f"is a news feed (RSS or Atom), not a timeline; {_AS_EVENTS}"
    elif begin.startswith("<") and _PAGE.search(begin):
        what = "is a web page; save the file it links to, or its table as CSV"
        if _LOGIN.search(text):
            what = "is a login page; sign in with a browser and save the file itself"
    elif _LYRICS.match(begin):
        what = "holds lyrics (LRC); write their lines as CSV with the columns time and label"
    if what is not None:
        raise InputError(f"{source.where}: {what}")


def format_hint(source: DataFile) -> str:
    """Return a hint with the most similar format and the missing column."""
    text = source.head_text
    if text is None:
        return "nearest: text (CSV, JSON), a recording, or a WFDB record"
    if text.lstrip("\ufeff \r\n\t").lower().startswith(_XML):
        return f"XML: {_AS_EVENTS}"
    if is_log(source):
        return "nearest: a log; its lines are counted with map='count' (--map count)"
    found = _json_table(source) if source.looks_like_json else _text_table(source)
    if found is None:
        lacking = "a first row that names the columns, such as time,event"
        if source.looks_like_json:
            lacking = "a list of records with time and event"
        return f"{_EVENT_LIST}; it lacks {lacking}"
    return _lacking(*found)


def _text_table(source: DataFile) -> tuple[Columns, list[list[object]]] | None:
    layout = detect(source, lambda header, below: bool(below))
    if layout is None or layout.separator is None:  # text without columns
        return None
    table = DelimitedTable(source, layout)
    with contextlib.suppress(InputError):  # for example broken quotes
        for chunk in table.chunks(range(len(table.columns))):
            return table.columns, [list(cells[:50]) for cells in chunk.cells]
    return None


def _json_table(source: DataFile) -> tuple[Columns, list[list[object]]] | None:
    tables = list(tables_in(source.json))
    if not tables:
        return None
    table = max(tables, key=lambda one: one.rows)
    cells = [table.cut(i, 0, 50) for i in range(len(table.columns))]
    head = [[cell if is_single(cell) else str(cell) for cell in column] for column in cells]
    return table.columns, head


def _lacking(columns: Columns, head: Head) -> str:
    """Return which column is missing for a series, or for a table of events."""
    there = f"its columns are {listed(columns)}"
    named = named_time_column(columns)
    timed = named
    for i, column in enumerate(columns):
        is_text = head[i] and not looks_numeric(head[i])
        if timed is None and is_text and detected_format(column, head[i]) is not None:
            timed = i
    numbers = [i for i in range(len(columns)) if i != timed and looks_numeric(head[i])]
    words = [i for i in range(len(columns)) if i != timed and is_wordy(head[i])]
    kind, label = kind_and_label_columns(columns)
    if timed is None:
        if words:
            return f"{_EVENT_LIST}; no column is called time, date, start or minute: {there}"
        return f"nearest: a series; no column is called time or date: {there}"
    if numbers and not words:
        return f"nearest: a series; no column except {_column(columns, timed)} has values: {there}"
    if kind is None and label is None and words:
        return (
            f"{_EVENT_LIST}; no column is called event, what, type, kind, name or label: rename "
            f"{_column(columns, words[0])}"
        )
    if not words:
        return f"{_EVENT_LIST}; no column of kinds or labels (event, what, type, name): {there}"
    if named is None:
        return f"{_EVENT_LIST}; call {_column(columns, timed)} time"
    return f"{_EVENT_LIST}; {_column(columns, timed)} has no known format of times: {there}"


def _column(columns: Columns, i: int) -> str:
    return f"column {quoted(columns[i].header)}"
