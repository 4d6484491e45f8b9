"""JSON as a table: the series with the most rows that its document holds.

These shapes are read:

- a list of records: `[{"date": "2012-09-19", "close": 702.1}, ...]`
- columns: `{"time": [...], "temperature_2m": [...]}`
- rows with their names: `{"columns": [...], "index": [...], "data": [[...], ...]}`
- pairs: `[[1347926400000, 702.1], ...]`
- by time: `{"2012-09-19": 702.1, ...}` or `{"2012-09-19": {"close": 702.1}, ...}`
- charts of share prices in several forms
- columns by row: `{"date": {"0": ...}, "close": {"0": ...}}`

The table may be at any level of the document. Units come from a key `NAME_units` next to it
(`{"hourly": {...}, "hourly_units": {...}}`).
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from overview_dsp.data.readers.data_file import DataFile
from overview_dsp.data.readers.tables.cells import looks_numeric
from overview_dsp.data.readers.tables.column_names import CHART_LETTERS, NAMES
from overview_dsp.data.readers.tables.dialect import is_date
from overview_dsp.data.readers.tables.table import CellLocation, Column, ColumnTable, Table, as_list
from overview_dsp.errors import InputError, quoted


def sniff(source: DataFile) -> bool:
    """Return whether the file is JSON that holds a series in one of the known shapes."""
    return source.looks_like_json and bool(series_in(source.json))


def open_table(source: DataFile) -> Table:
    """Return the largest series of the document."""
    series = series_in(source.json)
    largest = max(series, key=lambda table: table.rows)
    if [column.header for column in largest.columns] == ["time", "column 2"]:
        cells = as_list(largest.cut(0, 0, largest.rows))
        numbers = [cell for cell in cells if isinstance(cell, int | float)]
        steps = [b - a for a, b in itertools.pairwise(numbers)]
        if steps and min(steps) < 0 < max(steps):
            raise InputError(
                "pairs whose first numbers are in no order, so not times (places?); sort them by "
                'time, or write records such as {"time": 0, "value": 1}'
            )
    if others := sum(table.rows > 1 for table in series if table is not largest):
        note = f"{others} other tables in the file were left out"
        largest = replace(largest, notes=(*largest.notes, note))
    return largest.checked()


MAX_DEPTH = 8
"""Maximum nesting level of a table in a document."""

MAX_WIDTH = 64
"""Maximum number of values in a row."""

_MAX_KEYS, _MAX_ENTRIES = 1000, 10
_SAMPLE = 50


@dataclass(frozen=True)
class _Shape:
    """Column names, number of rows, units, and `cut(column, first, end)`, which returns cells."""

    names: tuple[str, ...]
    rows: int
    cut: Callable[[int, int, int], list[Any]]
    units: dict[str, str] = field(default_factory=dict)


def series_in(document: Any) -> list[ColumnTable]:
    """Return all tables of a document that have a column of times and one of numbers."""
    return [table for table in tables_in(document) if _is_series(table)]


def tables_in(document: Any) -> Iterator[ColumnTable]:
    """Yield all tables of a document."""
    return _tables(document, "", 0, {})


def is_single(value: Any) -> bool:
    """Return whether a value may be a cell: text, a number, true, false or null."""
    return value is None or isinstance(value, str | int | float)


def other_document(document: Any) -> str:
    """Return the name of JSON that is a map, a graph or a tree, "" for other documents."""
    if not isinstance(document, dict):
        return ""
    kind = document.get("type")
    if kind == "Topology":
        return "a map (TopoJSON)"
    if kind in (*NAMES["map_shapes"], "Feature", "FeatureCollection"):
        return "a map (GeoJSON)"
    if any(isinstance(document.get(key), list) for key in ("links", "edges")):
        return "a graph (nodes and links)" if "nodes" in document else ""
    return "a tree (name and children)" if isinstance(document.get("children"), list) else ""


def error_report(document: Any) -> str:
    """Return the words of an error report (RFC 9457, or message and code), "" for other JSON."""
    top = document if isinstance(document, dict) else {}
    for words, codes in (("title", ("status",)), ("message", ("errorCode", "error", "status"))):
        code = next((top[key] for key in codes if type(top.get(key)) is int), None)
        if code is not None and isinstance(top.get(words), str):
            return f"{code} {top[words]}"
    return ""


def _tables(value: Any, path: str, depth: int, units: dict[str, str]) -> Iterator[ColumnTable]:
    found = None
    if isinstance(value, dict) and value.get("type") in NAMES["map_shapes"]:
        return  # positions are pairs of numbers, too
    features = value.get("features") if isinstance(value, dict) else None
    if isinstance(features, list) and value.get("type") == "FeatureCollection":
        # GeoJSON
        value = [one.get("properties") if isinstance(one, dict) else one for one in features]
        path = f"{path}.features" if path else "features"
    if isinstance(value, list) and value:
        found = _record_list(value) or _row_list(value)
    elif isinstance(value, dict):
        found = next(filter(None, (shape(value) for shape in _OBJECT_SHAPES)), None)
    if found is not None:
        units = found.units or units
        names = found.names
        if {"t", "o", "h", "l", "c"} <= set(names):  # the single letters of a price chart
            names = tuple(CHART_LETTERS.get(name, name) for name in names)
        columns = tuple(Column.of(name, units.get(name, "")) for name in names)
        notes = (f"the table is at {quoted(path)}",) if path else ()
        yield ColumnTable("JSON", columns, found.rows, found.cut, "record", notes)
    if depth >= MAX_DEPTH:
        return
    if isinstance(value, dict):
        for key, item in list(value.items())[:_MAX_KEYS]:
            if isinstance(item, dict | list):
                below = f"{path}.{key}" if path else key
                near = value.get(f"{key}_units")
                texts = near.items() if isinstance(near, dict) else ()
                inner = {name: unit for name, unit in texts if isinstance(unit, str)}
                yield from _tables(item, below, depth + 1, inner)
    elif isinstance(value, list) and found is None:
        for i, item in enumerate(value[:_MAX_ENTRIES]):
            if isinstance(item, dict | list):
                yield from _tables(item, f"{path}[{i}]", depth + 1, {})


def _record_list(entries: list[Any]) -> _Shape | None:
    """Return the shape of a list of objects."""
    sample = entries[:_SAMPLE]
    if not all(isinstance(entry, dict) for entry in sample):
        return None
    names = names_in(sample)
    return _of_entries(entries, names, dict) if len(names) >= 2 else None


def names_in(records: Iterable[dict[str, Any]]) -> tuple[str, ...]:
    """Return the keys with single values, in order of appearance."""
    single = (name for record in records for name, v in record.items() if is_single(v))
    return tuple(dict.fromkeys(single))


def _row_list(entries: list[Any]) -> _Shape | None:
    """Return the shape of a list of equally long rows, with or without a row of names."""
    sample = entries[:_SAMPLE]
    head = entries[0]
    if not isinstance(head, list) or not 2 <= len(head) <= MAX_WIDTH:
        return None
    if not _all_rows(sample, len(head)):
        return None
    named = all(isinstance(cell, str) for cell in head)
    if named and len(entries) > 1 and not all(isinstance(cell, str) for cell in entries[1]):
        return _of_entries(entries[1:], tuple(head), list)
    names = _candle_names(sample) or ("time", *(f"column {i}" for i in range(2, len(head) + 1)))
    return _of_entries(entries, names, list)


def _named_rows(value: dict[str, Any]) -> _Shape | None:
    """Return the shape of `columns`, `data` and `index`, as pandas writes with orient="split"."""
    names, rows, index = value.get("columns"), value.get("data"), value.get("index")
    if not (isinstance(names, list) and isinstance(rows, list) and rows):
        return None
    if not all(map(is_single, names)) or not _all_rows(rows[:_SAMPLE], len(names)):
        return None
    shape = _of_entries(rows, tuple(map(str, names)), list)
    if not isinstance(index, list) or len(index) != len(rows):
        return shape
    return _with_first_column("index", index, shape)


def _price_chart(value: dict[str, Any]) -> _Shape | None:
    """Return the shape of a price chart from Yahoo."""
    times, indicators = value.get("timestamp"), value.get("indicators")
    if not isinstance(times, list) or not times or not isinstance(indicators, dict):
        return None
    quote, adjusted = (_first(indicators.get(key)) for key in ("quote", "adjclose"))
    lists = {name: quote.get(name) for name in NAMES["quotes"]} | {
        "adj close": adjusted.get("adjclose")
    }
    columns = {"time": times}
    columns |= {n: c for n, c in lists.items() if isinstance(c, list) and len(c) == len(times)}
    currency = _first([value.get("meta")]).get("currency")
    priced = [name for name in columns if name not in ("time", "volume")]
    units = dict.fromkeys(priced, currency) if isinstance(currency, str) else {}
    return replace(_of_lists(columns), units=units)


def _first(value: Any) -> dict[str, Any]:
    return value[0] if isinstance(value, list) and value and isinstance(value[0], dict) else {}


def _columns(value: dict[str, Any]) -> _Shape | None:
    """Return the shape of two or more lists of one length."""
    lists = {
        key: item
        for key, item in value.items()
        if isinstance(item, list) and item and all(map(is_single, item[:_SAMPLE]))
    }
    longest = max(map(len, lists.values()), default=0)
    same = {key: item for key, item in lists.items() if len(item) == longest}
    return _of_lists(same) if len(same) >= 2 else None


def _by_time(value: dict[str, Any]) -> _Shape | None:
    """Return the shape of an object whose keys are dates, with values or objects of values."""
    if len(value) < 2 or not _all_dates(value):
        return None
    times, entries = list(value), list(value.values())
    sample = entries[:_SAMPLE]
    if all(map(is_single, sample)):
        return _of_lists({"time": times, "value": entries})
    if not all(isinstance(entry, dict) for entry in sample):
        return None
    return _with_first_column("time", times, _of_entries(entries, names_in(sample), dict))


def _columns_by_row(value: dict[str, Any]) -> _Shape | None:
    """Return the shape of columns that are objects with the same keys, as pandas writes."""
    columns = [item for item in value.values() if isinstance(item, dict)]
    if len(columns) != len(value) or len(columns) < 2 or not columns[0]:
        return None
    rows = tuple(columns[0])
    if any(tuple(column) != rows for column in columns):
        return None
    cells = {name: list(column.values()) for name, column in value.items()}
    if not all(is_single(cell) for column in cells.values() for cell in column[:_SAMPLE]):
        return None
    shape = _of_lists(cells)
    return _with_first_column("time", list(rows), shape) if _all_dates(rows) else shape


_OBJECT_SHAPES = (_named_rows, _price_chart, _columns, _by_time, _columns_by_row)


def _all_rows(rows: Sequence[Any], width: int) -> bool:
    return all(
        isinstance(row, list) and len(row) == width and all(map(is_single, row)) for row in rows
    )


def _all_dates(keys: Iterable[str]) -> bool:
    return all(map(is_date, itertools.islice(keys, _SAMPLE)))


def _of_lists(columns: dict[str, list[Any]]) -> _Shape:
    lists = list(columns.values())
    return _Shape(tuple(columns), len(lists[0]), lambda i, begin, end: lists[i][begin:end])


def _of_entries(
    entries: list[Any], names: tuple[str, ...], kind: type[dict[Any, Any]] | type[list[Any]]
) -> _Shape:
    """Return the shape of a list of records; an entry of another type or length is an error."""
    words = "an object {...}" if kind is dict else f"a list of {len(names)}"

    def cut(i: int, begin: int, end: int) -> list[Any]:
        part = entries[begin:end]
        for number, entry in enumerate(part, begin + 1):
            if not isinstance(entry, kind) or (kind is list and len(entry) != len(names)):
                location = CellLocation(number, word="record")
                raise location.error(entry, f"isn't {words}, as those before it")
        return [entry.get(names[i]) if kind is dict else entry[i] for entry in part]

    return _Shape(names, len(entries), cut)


def _with_first_column(name: str, cells: list[Any], shape: _Shape) -> _Shape:
    """Return a shape with an additional first column."""

    def cut(i: int, begin: int, end: int) -> list[Any]:
        return cells[begin:end] if i == 0 else shape.cut(i - 1, begin, end)

    return _Shape((name, *shape.names), shape.rows, cut)


def _is_series(table: ColumnTable) -> bool:
    """Return whether a table has a column of numbers and one that looks or is named like times."""
    cells = [table.cut(i, 0, _SAMPLE) for i in range(len(table.columns))]
    if not any(looks_numeric(column) for column in cells):
        return False
    for named, column in zip(table.columns, cells, strict=True):
        if any(word in named.header.lower() for word in NAMES["json_time_parts"]):
            return True
        if column and all(isinstance(cell, str) and is_date(cell) for cell in column):
            return True
    return False


def _candle_names(rows: Sequence[Sequence[Any]]) -> tuple[str, ...] | None:
    """Return the column names of a price chart, None for other rows.

    In a price chart, the second of four prices is the highest and the third the lowest.
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
    return (
        (*NAMES["candle"][:width], *(f"column {i}" for i in range(7, width + 1))) if moved else None
    )
