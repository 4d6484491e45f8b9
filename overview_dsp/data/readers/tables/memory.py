"""Tables of data in memory: data frames, arrays, lists and dicts.

Frames and columns of pandas, polars, Arrow and their relatives are read through narwhals.
"""

from __future__ import annotations

import csv
import datetime as dt
import io
import itertools
import json
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from decimal import Decimal
from typing import IO, Any, Protocol

import numpy as np
from numpy.typing import NDArray

from overview_dsp.arrays import FloatArray
from overview_dsp.data.readers.tables.column_roles import is_price
from overview_dsp.data.readers.tables.table import CellLocation, Cells, Column, ColumnTable, as_list
from overview_dsp.data.readers.tables.time_column import detected_format
from overview_dsp.data.timeline.event import FIELDS, Event
from overview_dsp.errors import InputError, quoted
from overview_dsp.installation import require_library


class SupportsNumpy(Protocol):
    """A Series or a DataFrame of pandas, polars and their relatives; a column of Arrow."""

    def to_numpy(self, *args: Any, **kwargs: Any) -> Any:
        """Return the values as an array."""
        ...


class SupportsArrow(Protocol):
    """A table of Arrow, or another object with its interface."""

    def __arrow_c_stream__(self, requested_schema: Any = None) -> Any:
        """Return the columns."""
        ...


TableData = SupportsNumpy | SupportsArrow | NDArray[Any] | Sequence[Any] | Mapping[Any, Any]
"""Columns, rows or samples in memory."""

MemoryFile = bytes | bytearray | memoryview | IO[bytes] | IO[str]
"""Content of a file, or an open file."""

TimelineData = str | os.PathLike[str] | MemoryFile | TableData
"""Types that `load_timeline` accepts, in addition to Timeline."""

_SAMPLE = 50  # entries of a list whose types are checked
_MAX_CHANNELS = 8
_OF_DAY = "hh:mm"
"""Unit of times of day."""

_SECOND = np.timedelta64(1, "s")


def table_of(data: Any, times: Any = None) -> ColumnTable:
    """Return data in memory as a table, if `is_table` returns True for them.

    `data`: a data frame or series; an array of one or two dimensions, or with named fields; a list
    of numbers, rows, records or events; a dict of columns, or of values by time.
    `times`: times of the rows, if `data` does not contain them.

    InputError: rows of different types or lengths, no rows, too many columns, columns of different
    lengths, a data frame that can't be read.
    """
    kind, columns = _columns(data)
    if times is not None:
        _, time_columns = _columns(times)
        if len(time_columns) != 1:
            raise InputError(f"time has {len(time_columns)} columns; give one time per row")
        columns = [("time", time_columns[0][1]), *((h, c) for h, c in columns if h != "time")]
    lengths = {header: len(column.cells) for header, column in columns}
    if len(set(lengths.values())) > 1:
        uneven = ", ".join(f"{quoted(h)} {n}" for h, n in itertools.islice(lengths.items(), 6))
        raise InputError(f"columns of different lengths ({uneven}); give one value per row")
    return ColumnTable(
        kind,
        tuple(column.column(header) for header, column in columns),
        max(lengths.values(), default=0),
        lambda i, begin, end: columns[i][1].cells[begin:end],
    ).checked()


def samples_of(data: Any) -> FloatArray | None:
    """Return an array or a list of numbers as frames x channels from -1 to 1; None for other data.

    Whole numbers of 64 bits, as in a list, are those of 16 or 32 bits.
    """
    if is_frame(data) or isinstance(data, Mapping | str | bytes):
        return None
    if isinstance(data, Sequence) and not all(isinstance(x, int | float) for x in data):
        return None
    array = np.asarray(data)
    if array.dtype.kind not in "iuf" or array.ndim not in (1, 2) or not array.size:
        return None
    if array.ndim == 1:
        array = array[:, None]
    elif array.shape[0] < array.shape[1] and array.shape[0] <= _MAX_CHANNELS:
        array = array.T
    if array.shape[1] > _MAX_CHANNELS:
        return None
    samples = array.astype(np.float64)
    if array.dtype.kind == "f":
        return samples
    bits = 8 * array.dtype.itemsize
    if bits == 64:
        bits = 16 if np.abs(samples).max() <= 2.0**15 else 32
    full = 2.0 ** (bits - 1)
    return samples / full - (array.dtype.kind == "u")  # half of the range of unsigned numbers is 0


def csv_text(table: ColumnTable, rows: int) -> str:
    """Return the header and the first rows as CSV."""
    lines = [",".join(_field(column.header) for column in table.columns)]
    texts = []
    for i, column in enumerate(table.columns):
        cells = table.cut(i, 0, rows)
        if isinstance(cells, np.ndarray) and cells.dtype.kind == "M":
            texts.append(_dated_texts(cells, column))
        else:
            texts.append([_text(cell) for cell in as_list(cells)])
    lines += map(",".join, zip(*texts, strict=True))
    return "\n".join(lines) + "\n"


def is_table(data: object) -> bool:
    """Return whether `table_of` accepts data."""
    if isinstance(data, Sequence):
        return not isinstance(data, str | bytes)
    return isinstance(data, Mapping) or hasattr(data, "__array__") or is_frame(data)


def is_document(data: Any) -> bool:
    """Return whether data are nested objects, as in a JSON file."""
    if isinstance(data, Mapping):
        values = list(data.values())
        return any(isinstance(value, Mapping) or _has_records(value) for value in values)
    return _has_records(data) and any(
        isinstance(value, Mapping | list)
        for entry in data[:_SAMPLE]
        if isinstance(entry, Mapping)
        for value in entry.values()
    )


def _has_records(data: Any) -> bool:
    return isinstance(data, list) and bool(data) and isinstance(data[0], Mapping)


def document_bytes(data: Any) -> bytes:
    """Return a document as JSON; InputError for values that JSON cannot contain."""
    try:
        return json.dumps(data).encode()
    except (TypeError, ValueError, RecursionError) as error:
        raise InputError(f"a {type(data).__name__} can't be written as JSON ({error})") from error


def _columns(data: Any) -> tuple[str, list[tuple[str, InputColumn]]]:
    if is_frame(data):
        return columns_of(data)
    if isinstance(data, Mapping):
        if all(_is_column(value) for value in data.values()):
            return "Python", [(str(name), _columns(data[name])[1][0][1]) for name in data]
        return "Python", [("time", of_list(list(data))), ("value", of_list(list(data.values())))]
    if isinstance(data, np.ndarray):
        return "NumPy", _of_array(data)
    if isinstance(data, Sequence) and not isinstance(data, str | bytes):
        return "Python", _of_sequence(list(data))
    return type(data).__module__.partition(".")[0], _of_array(np.asarray(data))


def _of_array(data: np.ndarray[Any, Any]) -> list[tuple[str, InputColumn]]:
    if data.dtype.names is not None:
        return [(name, of_array(data[name])) for name in data.dtype.names]
    if data.ndim == 1:
        return [("value", of_array(data))]
    if data.ndim == 2:
        names = _numbered(data.shape[1])
        return [(name, of_array(data[:, i])) for i, name in enumerate(names)]
    raise InputError(
        f"an array of {data.ndim} dimensions; give one value per row, or one row per time"
    )


def _is_column(value: Any) -> bool:
    if isinstance(value, np.ndarray):
        return value.ndim == 1
    if is_frame(value):
        return True
    return isinstance(value, Sequence) and not isinstance(value, str | bytes)


def _of_sequence(data: list[Any]) -> list[tuple[str, InputColumn]]:
    sample = data[:_SAMPLE]
    for kind, taken in ((Event, _of_events), (Mapping, _of_records), (list | tuple, _of_rows)):
        if sample and isinstance(sample[0], kind):
            for number, entry in enumerate(data, 1):
                if not isinstance(entry, kind):
                    raise CellLocation(number, word="row").error(
                        entry, "has another type than the others"
                    )
            return taken(data)
    return [("value", of_list(data))]


def _of_events(events: Sequence[Event]) -> list[tuple[str, InputColumn]]:
    return [(name, of_list([getattr(e, name) for e in events])) for name in FIELDS]


def _of_records(records: Sequence[Mapping[Any, Any]]) -> list[tuple[str, InputColumn]]:
    names = dict.fromkeys(name for record in records for name in record)
    return [(str(name), of_list([record.get(name) for record in records])) for name in names]


def _of_rows(rows: Sequence[Sequence[Any]]) -> list[tuple[str, InputColumn]]:
    """Return the columns of rows of times and values, or times and kinds; a header is optional."""
    head, *below = rows
    width = max(map(len, rows))
    if below and _is_header(head, below[0]):
        names, rows = list(head), below
    elif 2 <= width <= len(FIELDS) and all(_is_event(row) for row in rows[:_SAMPLE]):
        names = list(FIELDS[:width])
        rows = [(*row, *("", 1.0, 0)[len(row) - 2 : width - 2]) for row in rows]
        if not all(isinstance(row[0], int | float) for row in rows[:_SAMPLE]):
            names[0] = "time"
    else:
        names = ["value"] if width == 1 else ["time", *_numbered(width)[1:]]
    for number, row in enumerate(rows, 1):
        if len(row) != len(names):
            note = f"has {len(row)} values, not {len(names)} as the others"
            raise CellLocation(number, word="row").error(row, note)
    return [(name, of_list([row[i] for row in rows])) for i, name in enumerate(names)]


def _is_header(row: Sequence[Any], below: Sequence[Any]) -> bool:
    """Return whether a row is a header: texts, and unlike the row below, none of them a time."""
    if not _is_text(row):
        return False
    return not _is_text(below) or (not any(map(_is_time, row)) and any(map(_is_time, below)))


def _is_time(cell: str) -> bool:
    return detected_format(Column.of("time"), [cell]) is not None


def _is_text(row: Sequence[Any]) -> bool:
    return all(isinstance(cell, str) for cell in row)


def _is_event(row: Sequence[Any]) -> bool:
    """Return whether a row is a time and a kind, perhaps with label, weight and side."""
    return (
        2 <= len(row) <= len(FIELDS)
        and isinstance(row[1], str)
        and bool(row[1][:1].isalpha())
        and (len(row) < 3 or isinstance(row[2], str | None))
    )


def _numbered(count: int) -> list[str]:
    return ["value"] if count == 1 else [f"column {i}" for i in range(1, count + 1)]


def _text(cell: Any) -> str:
    """Return a cell as a field of a CSV file."""
    if cell is None or cell != cell:
        return ""
    # whole numbers in a column with missing values are floats
    if isinstance(cell, float) and cell.is_integer() and abs(cell) < 1e15:
        return str(int(cell))
    return _field(str(cell))


def _dated_texts(cells: np.ndarray[Any, Any], column: Column) -> list[str]:
    missing = np.isnat(cells)
    if column.zoned:
        cells = cells + np.timedelta64(column.offset_min, "m")
    days = cells.astype("datetime64[D]")
    dates = not column.zoned and bool((missing | (days == cells)).all())
    texts = np.datetime_as_string(days if dates else cells).tolist()
    zone = ""
    if column.zoned:
        hours, minutes = divmod(abs(column.offset_min), 60)
        zone = f"{'-' if column.offset_min < 0 else '+'}{hours:02d}:{minutes:02d}"
    return ["" if gone else text + zone for text, gone in zip(texts, missing, strict=True)]


def _field(text: str) -> str:
    """Return a field of a CSV file, quoted if necessary, also if it looks like a comment."""
    if text[:1] == "#" or text != text.strip():
        return '"' + text.replace('"', '""') + '"'
    line = io.StringIO()
    csv.writer(line, lineterminator="").writerow([text])
    return "" if text == "" else line.getvalue()


# --- columns, and frames of them


@dataclass(frozen=True, eq=False)
class InputColumn:
    """Column of data in memory.

    `cells`: cells, as in the chunks of a table.
    `offset_min`: offset from UTC of the first datetime, min, for datetimes with a zone; `cells` are
    in UTC.
    `unit`: unit of the type: `s` for time spans, `hh:mm` for times of day.
    `key`: as in `Column`.
    """

    cells: Cells
    offset_min: int | None = None
    unit: str = ""
    key: bool = False

    def column(self, header: object) -> Column:
        """Return the description of the column with this header."""
        if self.unit == _OF_DAY:  # the header contains the unit, as in a file
            return Column.of(f"{header} ({_OF_DAY})")
        found = replace(Column.of(str(header), self.unit), key=self.key)
        if self.offset_min is None:
            return found
        return replace(found, zoned=True, offset_min=self.offset_min)


def of_array(values: NDArray[Any]) -> InputColumn:
    """Return a one-dimensional array as a column."""
    if isinstance(values, np.ma.MaskedArray):
        return of_list(values.tolist())
    kind = values.dtype.kind
    if kind == "f":
        return InputColumn(values.astype(np.float64))
    if kind == "i" or (kind == "u" and (not values.size or int(values.max()) < 2**63)):
        return InputColumn(values.astype(np.int64))
    if kind == "M" and np.datetime_data(values.dtype)[0] != "generic":
        return InputColumn(values)
    if kind == "m":
        return InputColumn(np.asarray(values / _SECOND, dtype=np.float64), unit="s")
    if kind == "S":
        return of_list([cell.decode("utf-8", "replace") for cell in values.tolist()])
    return of_list(values.tolist())


def of_list(values: list[Any]) -> InputColumn:
    """Return a list of Python values as a column; None means missing."""
    kinds = set(map(type, values)) - {type(None)}
    if not kinds or kinds <= {str, bool}:
        return InputColumn(values)
    if all(issubclass(kind, np.generic) for kind in kinds):
        if None in values:
            return of_list([None if value is None else value.item() for value in values])
        return of_array(np.array(values))
    if kinds <= {int, float}:
        return _numbers(values, kinds)
    if all(issubclass(kind, dt.datetime) for kind in kinds):
        return _moments(values)
    if kinds == {dt.date}:
        return InputColumn(np.array(values, dtype="datetime64[D]"))
    if all(issubclass(kind, dt.timedelta) for kind in kinds):
        seconds = [np.nan if v is None else v.total_seconds() for v in values]
        return InputColumn(np.array(seconds), unit="s")
    of_day = all(issubclass(kind, dt.time) for kind in kinds)
    return InputColumn([_single(value) for value in values], unit=_OF_DAY if of_day else "")


def _numbers(values: list[Any], kinds: set[type]) -> InputColumn:
    try:
        if kinds == {int}:
            # whole numbers stay whole if some are missing
            return InputColumn(values if None in values else np.array(values, dtype=np.int64))
        return InputColumn(np.array(values, dtype=np.float64))
    except OverflowError:
        return InputColumn(values)


def _moments(values: list[Any]) -> InputColumn:
    """Return a column of datetimes; a mixture with and without zone is text, rejected later."""
    offsets = [None if v is None or v != v else v.utcoffset() for v in values]
    known = [v is not None and v == v for v in values]  # NaT isn't equal to itself
    zoned = [offset is not None for offset in offsets]
    if any(zoned) and zoned != known:
        both = zip(values, known, strict=True)
        return InputColumn([value.isoformat(" ") if there else None for value, there in both])
    moments = []
    for value, there in zip(values, known, strict=True):
        if not there:
            moments.append(np.datetime64("NaT"))
            continue
        if value.tzinfo is not None:
            value = value.astimezone(dt.UTC).replace(tzinfo=None)
        # a Timestamp holds nanoseconds
        fine = getattr(value, "to_datetime64", None)
        moments.append(np.datetime64(value) if fine is None else fine())
    first = next((offset for offset in offsets if offset is not None), None)
    minutes = None if first is None else round(first.total_seconds() / 60.0)
    return InputColumn(np.array(moments), minutes)


def _single(value: Any) -> Any:
    """Return a value as a single cell, as text if a file would contain text."""
    if value is None or isinstance(value, str | bool | int | float | list | dict):
        return value
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, Decimal):
        return float(value)
    if isinstance(value, dt.datetime):
        return None if value != value else value.isoformat(" ")
    # a date, a clock, a period; what a library has for "missing" is found by its name (<NA>, NaT)
    return str(value)


def is_frame(data: object) -> bool:
    """Return whether data are a data frame, a series or an index."""
    if isinstance(data, np.ndarray | list | tuple | dict | type):
        return False
    interfaces = (
        "to_numpy __arrow_c_stream__ __dataframe__ __narwhals_dataframe__ collect to_dataframe"
    )
    return any(hasattr(data, name) for name in interfaces.split())


def columns_of(frame: Any) -> tuple[str, list[tuple[str, InputColumn]]]:
    """Return the name of the library and the columns of a data frame or series.

    An index becomes the first column, except plain row numbers.

    InputError: narwhals isn't installed, or does not support the type; a lazy frame; a repeated
    header.
    """
    library = type(frame).__module__.partition(".")[0]
    what = f"a {library} {type(frame).__name__}"
    remedy = "give its columns as a dict of lists"
    nw = require_library("narwhals.stable.v2", what, "dataframes", remedy)
    if hasattr(frame, "collect") and not hasattr(frame, "to_numpy"):
        raise InputError(f"{what} isn't computed yet; give what its collect() returns")
    if hasattr(frame, "get_level_values"):  # an index by itself
        return library, _index(frame) or [("value", _of_index(frame))]
    try:
        frame = _with_text_headers(_as_frame(library, frame))
        units = _units_of(frame)
        known: Any = nw.from_native(frame, eager_only=True, allow_series=True)
        if isinstance(known, nw.Series):
            name: object = known.name if known.name not in (None, "") else "value"
            header = " ".join(map(str, name)) if isinstance(name, tuple) else str(name)
            series = [(header, known)]
            units = units if isinstance(units, Mapping) else {header: units}
        else:
            series = [(str(header), known[header]) for header in known.columns]
        columns = [(header, _input_column(nw, column)) for header, column in series]
        if isinstance(units, Mapping):
            columns = [
                (h, replace(column, unit=str(units[h])) if units.get(h) else column)
                for h, column in columns
            ]
    except (TypeError, ValueError, AttributeError) as error:
        reason = " ".join(str(error).split())[:160]
        raise InputError(f"{what} can't be read as a table ({reason})") from error
    index = nw.maybe_get_index(known)
    return library, [*_index(index), *columns]


def _as_frame(library: str, data: Any) -> Any:
    """Return data of xarray as a pandas data frame, those of Arrow as a table or a column."""
    if library == "pyarrow" and not hasattr(data, "to_pandas_dtype"):
        import pyarrow

        if isinstance(data, pyarrow.Array):
            return pyarrow.chunked_array([data])
        return data if isinstance(data, pyarrow.ChunkedArray) else pyarrow.table(data)
    if library != "xarray":
        return data
    named = data.to_dataset(name=data.name or "value") if hasattr(data, "to_dataset") else data
    named = named.reset_coords(drop=True)
    unlabelled = [dimension for dimension in named.dims if dimension not in named.indexes]
    frame = named.to_dataframe().reset_index(level=unlabelled, drop=True)
    frame.attrs = {"units": {name: _unit_in(one.attrs) for name, one in named.items()}}
    return frame


def _unit_in(attributes: Mapping[Any, Any]) -> Any:
    return attributes.get("units") or attributes.get("unit") or ""


def _units_of(frame: Any) -> Any:
    """Return the units of a frame by header, or the one of a series, from its attributes."""
    attributes, schema = getattr(frame, "attrs", None), getattr(frame, "schema", ())
    if isinstance(attributes, Mapping):
        return _unit_in(attributes)
    if not hasattr(schema, "field"):
        return {}
    fields = [(field.name, field.metadata or {}) for field in schema]
    return {n: (m.get(b"units") or m.get(b"unit") or b"").decode() for n, m in fields}


def _with_text_headers(frame: Any) -> Any:
    """Return a frame whose headers are texts.

    Headers of several levels (`Close`, `AAPL`) are joined, except levels that are equal in all and
    no price.
    """
    headers: Any = getattr(frame, "columns", ())
    if getattr(headers, "nlevels", 1) == 1:
        if not hasattr(frame, "set_axis") or not len(headers):
            return frame
        return frame.set_axis(list(map(str, headers)), axis="columns")
    rows = [tuple(map(str, header)) for header in headers]
    distinct = [
        level
        for level in range(headers.nlevels)
        if len({row[level] for row in rows}) > 1
        or (len(rows) > 1 and is_price(Column.of(rows[0][level]), ()))
    ]
    joined = [" ".join(filter(None, (row[level] for level in distinct or [0]))) for row in rows]
    return frame.set_axis(joined, axis="columns")


def _index(index: Any) -> list[tuple[str, InputColumn]]:
    """Return the columns of an index, none for an unnamed index of whole numbers."""
    if index is None:
        return []
    names = list(index.names)
    if names == [None] and index.dtype.kind in "iu":
        return []  # row numbers are not times
    if hasattr(index, "to_timestamp"):
        index = index.to_timestamp()  # the beginnings of periods
    levels = [index] if len(names) == 1 else [index.get_level_values(i) for i in range(len(names))]
    several = len(levels) > 1
    return [
        (str(name) if name is not None else "index", replace(_of_index(level), key=several))
        for name, level in zip(names, levels, strict=True)
    ]


def _of_index(level: Any) -> InputColumn:
    values = level.to_numpy()
    # an index with a zone contains Timestamps
    found = of_list(list(values)) if values.dtype.kind == "O" else of_array(values)
    # the decimals of an index without a name are seconds
    return replace(found, unit="s") if level.name is None and values.dtype.kind == "f" else found


def _input_column(nw: Any, column: Any) -> InputColumn:
    kind = column.dtype
    if kind == nw.Datetime:
        offset_min = None
        if kind.time_zone is not None:
            first = column.drop_nulls().head(1).to_list()
            offset_min = round(first[0].utcoffset().total_seconds() / 60.0) if first else 0
            column = column.dt.convert_time_zone("UTC").dt.replace_time_zone(None)
        return InputColumn(np.asarray(column.to_numpy()), offset_min)
    if kind == nw.Date:
        return InputColumn(
            np.asarray(column.cast(nw.Datetime("ms")).to_numpy()).astype("datetime64[D]")
        )
    if kind.is_float() or kind == nw.Duration or (kind.is_integer() and not column.null_count()):
        return of_array(np.asarray(column.to_numpy()))
    return of_list(column.to_list())
