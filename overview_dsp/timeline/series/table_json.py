"""JSON as a table: the shapes in which series are written.

- a list of records, also one a line: `[{"date": "2012-09-19", "close": 702.1}, ...]`
- columns: `{"time": [...], "temperature_2m": [...]}`
- rows with their names: `{"columns": [...], "index": [...], "data": [[...], ...]}`
- pairs: `[[1347926400000, 702.1], ...]`
- by time: `{"2012-09-19": 702.1, ...}` or `{"2012-09-19": {"close": 702.1}, ...}`

wherever in the document such a table lies; the one with the most rows is read. Units from a
neighbour `NAME_units` (`{"hourly": {...}, "hourly_units": {...}}`) are taken.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

from overview_dsp.errors import InputError
from overview_dsp.timeline import checks
from overview_dsp.timeline.series import delimited
from overview_dsp.timeline.series.moments import WAYS
from overview_dsp.timeline.series.numbers import looks_numeric
from overview_dsp.timeline.series.table import CHUNK_ROWS, MAX_COLUMNS, Chunk, Column
from overview_dsp.timeline.source import Source

MAX_DEPTH = 8
"""How deep in a document a table is looked for."""

_SAMPLE = 50
_TIME_WORDS = ("date", "time", "timestamp", "day", "month", "year", "period", "epoch", "unix")


@dataclass
class _Found:
    """A table in a document: names, and rows as one list a column."""

    names: list[str]
    rows: int
    units: dict[str, str] = field(default_factory=dict)
    place: str = ""

    def column(self, i: int, begin: int, end: int) -> list[Any]:
        raise NotImplementedError


@dataclass
class _Columns(_Found):
    columns: list[list[Any]] = field(default_factory=list)

    def column(self, i: int, begin: int, end: int) -> list[Any]:
        return self.columns[i][begin:end]


@dataclass
class _Records(_Found):
    records: list[Any] = field(default_factory=list)

    def column(self, i: int, begin: int, end: int) -> list[Any]:
        name = self.names[i]
        return [r.get(name) if isinstance(r, dict) else r for r in self.records[begin:end]]


@dataclass
class _RowLists(_Found):
    records: list[Any] = field(default_factory=list)

    def column(self, i: int, begin: int, end: int) -> list[Any]:
        return [
            (r[i] if i < len(r) else None) if isinstance(r, list) else r
            for r in self.records[begin:end]
        ]


def _scalar(value: Any) -> bool:
    return value is None or isinstance(value, str | int | float)


def _record_table(entries: list[Any], place: str) -> _Found | None:
    """A list of objects, or of equally long lists of single values."""
    sample = entries[:_SAMPLE]
    if all(isinstance(entry, dict) for entry in sample):
        names: dict[str, None] = {}
        for entry in sample:
            names.update(dict.fromkeys(key for key, value in entry.items() if _scalar(value)))
        if len(names) >= 2:
            return _Records(list(names), len(entries), {}, place, entries)
    if all(isinstance(entry, list) and 2 <= len(entry) <= 64 for entry in sample):
        width = len(sample[0])
        if all(len(entry) == width and all(map(_scalar, entry)) for entry in sample):
            head = entries[0]
            if len(entries) > 1 and all(isinstance(cell, str) for cell in head) and not all(
                isinstance(cell, str) for cell in entries[1]
            ):
                return _RowLists([str(c) for c in head], len(entries) - 1, {}, place, entries[1:])
            names_of = ["time" if i == 0 else f"column {i + 1}" for i in range(width)]
            return _RowLists(names_of, len(entries), {}, place, entries)
    return None


def _object_table(value: dict[str, Any], place: str) -> _Found | None:
    """An object of columns, of rows with names, or by time."""
    names, rows = value.get("columns"), value.get("data")
    if isinstance(names, list) and isinstance(rows, list) and rows:
        if all(isinstance(row, list) and len(row) == len(names) for row in rows[:_SAMPLE]):
            index = value.get("index")
            labels = [str(name) for name in names]
            if isinstance(index, list) and len(index) == len(rows):
                columns = [index, *([_nth(row, i) for row in rows] for i in range(len(names)))]
                return _Columns(["index", *labels], len(rows), {}, place, columns)
            return _RowLists(labels, len(rows), {}, place, rows)
    lists = {key: item for key, item in value.items() if isinstance(item, list)}
    flat = {k: v for k, v in lists.items() if v and all(map(_scalar, v[:_SAMPLE]))}
    if len(flat) >= 2:
        length = max(map(len, flat.values()))
        same = {key: item for key, item in flat.items() if len(item) == length}
        if len(same) >= 2:
            return _Columns(list(same), length, {}, place, list(same.values()))
    if len(value) >= 2 and all(_is_date(key) for key in list(value)[:_SAMPLE]):
        entries = list(value.values())
        if all(isinstance(entry, dict) for entry in entries[:_SAMPLE]):
            keys = list(dict.fromkeys(k for e in entries[:_SAMPLE] for k in e if _scalar(e[k])))
            columns = [list(value), *([_get(e, k) for e in entries] for k in keys)]
            return _Columns(["time", *keys], len(entries), {}, place, columns)
        if all(map(_scalar, entries[:_SAMPLE])):
            return _Columns(["time", "value"], len(entries), {}, place, [list(value), entries])
    inner = [item for item in value.values() if isinstance(item, dict)]
    if len(inner) == len(value) >= 2 and len({tuple(item) for item in inner}) == 1 and inner[0]:
        # {"date": {"0": ...}, "close": {"0": ...}}: columns by row name
        if all(_scalar(cell) for item in inner for cell in list(item.values())[:_SAMPLE]):
            rows_named = list(inner[0])
            columns = [list(item.values()) for item in inner]
            if all(_is_date(key) for key in rows_named[:_SAMPLE]):
                return _Columns(
                    ["time", *value], len(rows_named), {}, place, [rows_named, *columns]
                )
            return _Columns(list(value), len(rows_named), {}, place, columns)
    return None


def _nth(row: Any, i: int) -> Any:
    return row[i] if isinstance(row, list) and i < len(row) else None


def _get(entry: Any, key: str) -> Any:
    return entry.get(key) if isinstance(entry, dict) else entry


def _is_date(text: str) -> bool:
    return any(way(text.strip()) is not None for way in WAYS.values()) and not text.isdigit()


def _tables(value: Any, place: str, depth: int, units: dict[str, str]) -> Iterator[_Found]:
    found = None
    if isinstance(value, list) and value:
        found = _record_table(value, place)
    elif isinstance(value, dict):
        found = _object_table(value, place)
    if found is not None and found.rows:
        found.units = units
        yield found
    if depth >= MAX_DEPTH:
        return
    if isinstance(value, dict):
        for key, item in list(value.items())[:1000]:
            if isinstance(item, dict | list):
                near = value.get(f"{key}_units")
                known = (
                    {k: v for k, v in near.items() if isinstance(v, str)}
                    if isinstance(near, dict)
                    else {}
                )
                yield from _tables(item, f"{place}.{key}" if place else key, depth + 1, known)
    elif isinstance(value, list) and found is None:
        for i, item in enumerate(value[:10]):
            if isinstance(item, dict | list):
                yield from _tables(item, f"{place}[{i}]", depth + 1, {})


def _is_series(found: _Found) -> bool:
    """Tell whether a table has a column of times by name or by look, and one of numbers."""
    end = min(found.rows, _SAMPLE)
    cells = [found.column(i, 0, end) for i in range(len(found.names))]
    if not any(looks_numeric(column) for column in cells):
        return False
    for name, column in zip(found.names, cells, strict=True):
        if any(word in name.lower() for word in _TIME_WORDS):
            return True
        texts = [cell for cell in column if isinstance(cell, str)]
        if texts and len(texts) == len(column) and all(_is_date(text) for text in texts):
            return True
    return False


def _largest(document: Any) -> _Found | None:
    series = [found for found in _tables(document, "", 0, {}) if _is_series(found)]
    return max(series, key=lambda found: found.rows, default=None)


def _lines_of_records(source: Source) -> bool:
    """Tell whether the file is one JSON object a line."""
    text = source.head_text
    if text is None or not text.lstrip().startswith("{"):
        return False
    lines = [line for line in text.split("\n")[:3] if line.strip()]
    if len(lines) < 2 or not all(line.lstrip().startswith("{") for line in lines):
        return False
    try:
        return isinstance(json.loads(lines[0]), dict)
    except (ValueError, RecursionError):
        return False


class JsonTable:
    """A table in a JSON document."""

    kind = "JSON"
    row_word = "record"

    def __init__(self, found: _Found, others: int = 0) -> None:
        if len(found.names) > MAX_COLUMNS:
            raise InputError(f"{len(found.names)} columns, more than {MAX_COLUMNS}; keep fewer")
        self._found = found
        self.columns = tuple(Column.of(n, found.units.get(n, "")) for n in found.names)
        notes = [f"the table is at {checks.shown(found.place)}"] if found.place else []
        if others:
            notes.append(f"{others} smaller tables in the file were left out")
        self.notes: tuple[str, ...] = tuple(notes)

    def chunks(self, columns: Sequence[int]) -> Iterator[Chunk]:
        """Read these columns; InputError names a record with a nested value."""
        for begin in range(0, self._found.rows, CHUNK_ROWS):
            end = min(begin + CHUNK_ROWS, self._found.rows)
            cells = tuple(self._found.column(i, begin, end) for i in columns)
            _check_flat(cells, [self.columns[i] for i in columns], begin + 1, self.row_word)
            yield Chunk(cells, begin + 1, None, end / self._found.rows)


class JsonLinesTable:
    """One JSON object a line, streamed."""

    kind = "JSON lines"
    row_word = "line"
    notes: tuple[str, ...] = ()

    def __init__(self, source: Source) -> None:
        self._source = source
        names: dict[str, None] = {}
        for _, record in self._records():
            names.update(dict.fromkeys(k for k, v in record.items() if _scalar(v)))
            if len(names) > MAX_COLUMNS or _ > _SAMPLE:
                break
        self.columns = tuple(Column.of(name) for name in list(names)[:MAX_COLUMNS])
        self._names = list(names)
        self._lines: delimited.Lines | None = None
        if not names:
            raise InputError("line 1: an object without values; give times and values")

    def _records(self) -> Iterator[tuple[int, dict[str, Any]]]:
        encoding = delimited.encoding_of(self._source) or "utf-8"
        self._lines = delimited.Lines(self._source, encoding, comments=False)
        for number, line in enumerate(self._lines, 1):
            if not line.strip():
                continue
            try:
                record = json.loads(line)
            except (ValueError, RecursionError) as error:
                raise InputError(
                    f"line {number}: broken JSON ({error}); one object a line is read"
                ) from error
            if not isinstance(record, dict):
                raise InputError(f"line {number}: {checks.shown(record)} isn't an object {{...}}")
            yield number, record

    def chunks(self, columns: Sequence[int]) -> Iterator[Chunk]:
        """Read these columns; InputError names a broken line."""
        names = [self._names[i] for i in columns]
        numbers: list[int] = []
        rows: list[list[Any]] = []

        def chunk() -> Chunk:
            cells = tuple([row[i] for row in rows] for i in range(len(names)))
            asked = [self.columns[i] for i in columns]
            _check_flat(cells, asked, numbers, self.row_word)
            part = self._lines.part if self._lines else 1.0
            return Chunk(cells, numbers[0], numbers, part)

        for number, record in self._records():
            numbers.append(number)
            rows.append([record.get(name) for name in names])
            if len(rows) == CHUNK_ROWS:
                yield chunk()
                numbers, rows = [], []
        if rows:
            yield chunk()


def _check_flat(
    cells: tuple[list[Any], ...], columns: Sequence[Column], numbers: Any, word: str
) -> None:
    for column, entries in zip(columns, cells, strict=True):
        for i, cell in enumerate(entries):
            if not _scalar(cell):
                number = numbers + i if isinstance(numbers, int) else numbers[i]
                raise InputError(
                    f"{word} {number}, column {checks.shown(column.header)}: "
                    f"{checks.shown(cell)} isn't a single value"
                )


def sniff(source: Source) -> bool:
    """Tell whether the file is JSON that holds a series in one of the known shapes."""
    if not source.looks_like_json:
        return False
    if _lines_of_records(source):
        return True
    return _largest(source.json) is not None


def open_table(source: Source) -> JsonTable | JsonLinesTable:
    """Return the largest series of the document."""
    if _lines_of_records(source):
        return JsonLinesTable(source)
    series = [found for found in _tables(source.json, "", 0, {}) if _is_series(found)]
    largest = max(series, key=lambda found: found.rows)
    return JsonTable(largest, sum(found.rows > 1 for found in series) - 1)
