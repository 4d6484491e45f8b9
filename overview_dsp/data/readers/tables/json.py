"""JSON as a table: the series with the most rows that its document holds.

The shapes that are read:

- a list of records: `[{"date": "2012-09-19", "close": 702.1}, ...]`
- columns: `{"time": [...], "temperature_2m": [...]}`
- rows with their names: `{"columns": [...], "index": [...], "data": [[...], ...]}`
- pairs: `[[1347926400000, 702.1], ...]`
- by time: `{"2012-09-19": 702.1, ...}` or `{"2012-09-19": {"close": 702.1}, ...}`
- share charts of several kinds (`price_charts`)
- columns by row: `{"date": {"0": ...}, "close": {"0": ...}}`

wherever in the document such a table lies. Units from a neighbour `NAME_units` (`{"hourly": {...},
"hourly_units": {...}}`) are taken.
"""

from __future__ import annotations

import itertools
import json
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

from overview_dsp.data.readers.source import Source
from overview_dsp.data.readers.tables.cells import looks_numeric
from overview_dsp.data.readers.tables.delimited import Lines
from overview_dsp.data.readers.tables.dialect import encoding_of
from overview_dsp.data.readers.tables.table import (
    CHUNK_ROWS,
    MAX_COLUMNS,
    Chunk,
    Column,
    check_single,
)
from overview_dsp.data.timeline.times import FORMS, moment
from overview_dsp.errors import InputError, shown


class JsonTable:
    """A table in a JSON document."""

    kind = "JSON"
    row_word = "record"

    def __init__(self, shape: Shape, others: int = 0) -> None:
        if len(shape.names) > MAX_COLUMNS:
            raise InputError(f"{len(shape.names)} columns, more than {MAX_COLUMNS}; keep fewer")
        self._shape = shape
        self.columns = tuple(Column.of(name, shape.units.get(name, "")) for name in shape.names)
        notes = [f"the table is at {shown(shape.place)}"] if shape.place else []
        if others:
            notes.append(f"{others} other tables in the file were left out")
        self.notes: tuple[str, ...] = tuple(notes)

    def chunks(self, columns: Sequence[int]) -> Iterator[Chunk]:
        """Read these columns; InputError names a record unlike the others or a nested value."""
        rows = self._shape.rows
        for begin in range(0, rows, CHUNK_ROWS):
            end = min(begin + CHUNK_ROWS, rows)
            cells = tuple(self._shape.cut(i, begin, end) for i in columns)
            chunk = Chunk(cells, begin + 1, None, end / rows)
            check_single(self, chunk, columns)
            yield chunk


def sniff(source: Source) -> bool:
    """Return whether the file is JSON that holds a series in one of the known shapes."""
    return source.looks_like_json and bool(series_in(source.json))


def open_table(source: Source) -> JsonTable:
    """Return the largest series of the document."""
    series = series_in(source.json)
    largest = max(series, key=lambda shape: shape.rows)
    return JsonTable(largest, sum(shape.rows > 1 for shape in series if shape is not largest))


MAX_DEPTH = 8
"""How deep in a document a table is looked for."""

MAX_WIDTH = 64
"""Longest list that may be a row."""

_MAX_KEYS, _MAX_ENTRIES = 1000, 10
_SAMPLE = 50
_TIME_WORDS = ("date", "time", "timestamp", "day", "month", "year", "period", "epoch", "unix")

Cut = Callable[[int, int, int], list[Any]]
"""Takes the index of a column and the rows from and to; returns its cells."""


@dataclass(frozen=True)
class Shape:
    """A table in a document.

    Parameters
    ----------
    names
        Of its columns.
    rows
        How many it has.
    cut
        Gives part of a column; InputError names a record unlike the ones before it.
    place
        Where in the document it is: `hourly`, `chart.result[0]`; empty for the document itself.
    units
        Of columns by name.
    """

    names: tuple[str, ...]
    rows: int
    cut: Cut
    place: str = ""
    units: dict[str, str] = field(default_factory=dict)


def series_in(document: Any) -> list[Shape]:
    """Return all tables of a document that have a column of times and one of numbers."""
    return [shape for shape in shapes_in(document) if _is_series(shape)]


def shapes_in(document: Any) -> Iterator[Shape]:
    """Yield all tables of a document."""
    return _shapes(document, "", 0, {})


def is_single(value: Any) -> bool:
    """Return whether a value may be a cell: text, a number, true, false or null."""
    return value is None or isinstance(value, str | int | float)


def _shapes(value: Any, place: str, depth: int, units: dict[str, str]) -> Iterator[Shape]:
    found = None
    features = value.get("features") if isinstance(value, dict) else None
    if isinstance(features, list) and value.get("type") == "FeatureCollection":
        value = [_properties(feature) for feature in features]  # GeoJSON
        place = f"{place}.features" if place else "features"
    if isinstance(value, list) and value:
        found = _record_list(value) or _row_list(value)
    elif isinstance(value, dict):
        found = next(filter(None, (shape(value) for shape in _OBJECT_SHAPES)), None)
    if found is not None:
        names = spelled_out(found.names)
        yield Shape(names, found.rows, found.cut, place, found.units or units)
    if depth >= MAX_DEPTH:
        return
    if isinstance(value, dict):
        for key, item in list(value.items())[:_MAX_KEYS]:
            if isinstance(item, dict | list):
                below = f"{place}.{key}" if place else key
                yield from _shapes(item, below, depth + 1, _units(value, key))
    elif isinstance(value, list) and found is None:
        for i, item in enumerate(value[:_MAX_ENTRIES]):
            if isinstance(item, dict | list):
                yield from _shapes(item, f"{place}[{i}]", depth + 1, {})


def _properties(feature: object) -> object:
    return feature.get("properties") if isinstance(feature, dict) else feature


def _units(value: dict[str, Any], key: str) -> dict[str, str]:
    near = value.get(f"{key}_units")
    if not isinstance(near, dict):
        return {}
    return {name: unit for name, unit in near.items() if isinstance(unit, str)}


def _record_list(entries: list[Any]) -> Shape | None:
    """A list of objects."""
    sample = entries[:_SAMPLE]
    if not all(isinstance(entry, dict) for entry in sample):
        return None
    names = tuple(dict.fromkeys(k for e in sample for k, v in e.items() if is_single(v)))
    return _of_records(entries, names) if len(names) >= 2 else None


def _row_list(entries: list[Any]) -> Shape | None:
    """A list of equally long lists of single values, with or without a row of names."""
    sample = entries[:_SAMPLE]
    head = entries[0]
    if not isinstance(head, list) or not 2 <= len(head) <= MAX_WIDTH:
        return None
    if not _all_rows(sample, len(head)):
        return None
    named = all(isinstance(cell, str) for cell in head)
    if named and len(entries) > 1 and not all(isinstance(cell, str) for cell in entries[1]):
        return _of_rows(entries[1:], tuple(head))
    candles = candle_names(sample)
    return _of_rows(entries, candles or ("time", *(f"column {i}" for i in range(2, len(head) + 1))))


def _named_rows(value: dict[str, Any]) -> Shape | None:
    """`columns`, `data` and maybe `index`, as pandas writes with orient="split"."""
    names, rows, index = value.get("columns"), value.get("data"), value.get("index")
    if not (isinstance(names, list) and isinstance(rows, list) and rows):
        return None
    if not all(map(is_single, names)) or not _all_rows(rows[:_SAMPLE], len(names)):
        return None
    shape = _of_rows(rows, tuple(map(str, names)))
    if not isinstance(index, list) or len(index) != len(rows):
        return shape

    def cut(i: int, begin: int, end: int) -> list[Any]:
        return index[begin:end] if i == 0 else shape.cut(i - 1, begin, end)

    return Shape(("index", *shape.names), shape.rows, cut)


def _price_chart(value: dict[str, Any]) -> Shape | None:
    """Times, and quotes further down (Yahoo)."""
    found = yahoo(value)
    if found is None:
        return None
    columns, units = found
    shape = _of_lists(tuple(columns), list(columns.values()))
    return Shape(shape.names, shape.rows, shape.cut, "", units)


def _columns(value: dict[str, Any]) -> Shape | None:
    """Two or more lists of one length."""
    lists = {
        key: item
        for key, item in value.items()
        if isinstance(item, list) and item and all(map(is_single, item[:_SAMPLE]))
    }
    longest = max(map(len, lists.values()), default=0)
    same = {key: item for key, item in lists.items() if len(item) == longest}
    return _of_lists(tuple(same), list(same.values())) if len(same) >= 2 else None


def _by_time(value: dict[str, Any]) -> Shape | None:
    """Dates as keys, of a value each or of an object of values each."""
    if len(value) < 2 or not all(_is_date(key) for key in list(value)[:_SAMPLE]):
        return None
    times, entries = list(value), list(value.values())
    sample = entries[:_SAMPLE]
    if all(map(is_single, sample)):
        return _of_lists(("time", "value"), [times, entries])
    if not all(isinstance(entry, dict) for entry in sample):
        return None
    names = tuple(dict.fromkeys(k for e in sample for k, v in e.items() if is_single(v)))
    records = _of_records(entries, names)

    def cut(i: int, begin: int, end: int) -> list[Any]:
        return times[begin:end] if i == 0 else records.cut(i - 1, begin, end)

    return Shape(("time", *names), len(entries), cut)


def _columns_by_row(value: dict[str, Any]) -> Shape | None:
    """Objects of the same keys, which name the rows, as pandas writes them."""
    columns = [item for item in value.values() if isinstance(item, dict)]
    if len(columns) != len(value) or len(columns) < 2 or not columns[0]:
        return None
    rows = tuple(columns[0])
    if any(tuple(column) != rows for column in columns):
        return None
    cells = [list(column.values()) for column in columns]
    if not all(is_single(cell) for column in cells for cell in column[:_SAMPLE]):
        return None
    if all(_is_date(row) for row in rows[:_SAMPLE]):
        return _of_lists(("time", *value), [list(rows), *cells])
    return _of_lists(tuple(value), cells)


_OBJECT_SHAPES = (_named_rows, _price_chart, _columns, _by_time, _columns_by_row)


def _all_rows(rows: Sequence[Any], width: int) -> bool:
    return all(
        isinstance(row, list) and len(row) == width and all(map(is_single, row)) for row in rows
    )


def _of_lists(names: tuple[str, ...], columns: list[list[Any]]) -> Shape:
    return Shape(names, len(columns[0]), lambda i, begin, end: columns[i][begin:end])


def _of_records(records: list[Any], names: tuple[str, ...]) -> Shape:
    def cut(i: int, begin: int, end: int) -> list[Any]:
        name = names[i]
        part = records[begin:end]
        for number, record in enumerate(part, begin + 1):
            if not isinstance(record, dict):
                raise InputError(_unlike(number, record, "an object {...}"))
        return [record.get(name) for record in part]

    return Shape(names, len(records), cut)


def _of_rows(rows: list[Any], names: tuple[str, ...]) -> Shape:
    width = len(names)

    def cut(i: int, begin: int, end: int) -> list[Any]:
        part = rows[begin:end]
        for number, row in enumerate(part, begin + 1):
            if not isinstance(row, list) or len(row) != width:
                raise InputError(_unlike(number, row, f"a list of {width}"))
        return [row[i] for row in part]

    return Shape(names, len(rows), cut)


def _unlike(number: int, entry: Any, words: str) -> str:
    return f"record {number}: {shown(entry)} isn't {words}, as those before it"


def _is_date(text: str) -> bool:
    return moment(text.strip(), *FORMS) is not None and not text.isdigit()


def _is_series(shape: Shape) -> bool:
    """Return whether a table has a column of times by name or by look, and one of numbers."""
    end = min(shape.rows, _SAMPLE)
    cells = [shape.cut(i, 0, end) for i in range(len(shape.names))]
    if not any(looks_numeric(column) for column in cells):
        return False
    for name, column in zip(shape.names, cells, strict=True):
        if any(word in name.lower() for word in _TIME_WORDS):
            return True
        texts = [cell for cell in column if isinstance(cell, str)]
        if texts and len(texts) == len(column) and all(_is_date(text) for text in texts):
            return True
    return False


_LINES_SAMPLE = 50


class JsonLinesTable:
    """One JSON object a line."""

    kind = "JSON lines"
    row_word = "line"
    notes: tuple[str, ...] = ()

    def __init__(self, source: Source) -> None:
        self._source = source
        encoding = encoding_of(source) or "utf-8"
        self._lines = Lines(source, encoding)
        sample = itertools.islice(self._records(), _LINES_SAMPLE)
        keys = (key for _, record in sample for key, v in record.items() if is_single(v))
        self._names = list(dict.fromkeys(keys))
        if not self._names:
            raise InputError("line 1: an object without values; give times and values")
        if len(self._names) > MAX_COLUMNS:
            raise InputError(f"{len(self._names)} columns, more than {MAX_COLUMNS}; keep fewer")
        self.columns = tuple(map(Column.of, self._names))

    def chunks(self, columns: Sequence[int]) -> Iterator[Chunk]:
        """Read these columns; InputError names a broken line."""
        names = [self._names[i] for i in columns]
        records = self._records()
        while part := list(itertools.islice(records, CHUNK_ROWS)):
            numbers = [number for number, _ in part]
            cells = tuple([record.get(name) for _, record in part] for name in names)
            chunk = Chunk(cells, numbers[0], numbers, self._lines.part)
            check_single(self, chunk, columns)
            yield chunk

    def _records(self) -> Iterator[tuple[int, dict[str, Any]]]:
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
                raise InputError(f"line {number}: {shown(record)} isn't an object {{...}}")
            yield number, record


def sniff_lines(source: Source) -> bool:
    """Return whether the file is one JSON object a line."""
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


def open_lines(source: Source) -> JsonLinesTable:
    """Return the file's table; InputError names a broken line."""
    return JsonLinesTable(source)


_LETTERS = {
    "t": "time", "o": "open", "h": "high", "l": "low", "c": "close", "v": "volume",
}  # fmt: skip
_CANDLE = ("time", "open", "high", "low", "close", "volume")
_QUOTES = ("open", "high", "low", "close", "volume")


def yahoo(value: dict[str, Any]) -> tuple[dict[str, list[Any]], dict[str, str]] | None:
    """Return the columns and units of Yahoo's chart; None for anything else."""
    times, indicators = value.get("timestamp"), value.get("indicators")
    if not isinstance(times, list) or not times or not isinstance(indicators, dict):
        return None
    quote, adjusted = (_first(indicators.get(key)) for key in ("quote", "adjclose"))
    columns = {"time": times}
    columns |= {name: quote[name] for name in _QUOTES if _fits(quote.get(name), times)}
    if _fits(adjusted.get("adjclose"), times):
        columns["adj close"] = adjusted["adjclose"]
    about = value.get("meta")
    currency = about.get("currency") if isinstance(about, dict) else None
    units = dict.fromkeys(columns, currency) if isinstance(currency, str) else {}
    return columns, {name: unit for name, unit in units.items() if name not in ("time", "volume")}


def _first(value: Any) -> dict[str, Any]:
    return value[0] if isinstance(value, list) and value and isinstance(value[0], dict) else {}


def _fits(column: Any, times: list[Any]) -> bool:
    return isinstance(column, list) and len(column) == len(times)


def spelled_out(names: Sequence[str]) -> tuple[str, ...]:
    """Return the names of columns, single letters of a price chart written out."""
    if not {"t", "o", "h", "l", "c"} <= set(names):
        return tuple(names)
    return tuple(_LETTERS.get(name, name) for name in names)


def candle_names(rows: Sequence[Sequence[Any]]) -> tuple[str, ...] | None:
    """Return names of the columns of candles; None where the rows are none.

    In a candle the third number is the highest and the fourth the lowest of four.
    """
    if not rows or not len(rows[0]) >= 5:
        return None
    moved = False
    for row in rows:
        try:
            begin, high, low, end = (float(cell) for cell in row[1:5])
        except (TypeError, ValueError):
            return None
        if not (low <= min(begin, end) and max(begin, end) <= high):
            return None
        moved = moved or high > low
    width = len(rows[0])
    return (*_CANDLE[:width], *(f"column {i}" for i in range(7, width + 1))) if moved else None
