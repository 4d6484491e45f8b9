"""Frames and columns of pandas, polars, Arrow and their relatives, through narwhals."""

from __future__ import annotations

import datetime as dt
from dataclasses import dataclass
from decimal import Decimal
from typing import Any

import numpy as np
from numpy.typing import NDArray

from overview_dsp.data.readers.tables.table import Cells, Column
from overview_dsp.errors import InputError

_OF_DAY = "hh:mm"
"""The unit of clocks of the day."""

_SECOND = np.timedelta64(1, "s")


@dataclass(frozen=True, eq=False)
class Given:
    """A column as it was given.

    Parameters
    ----------
    cells
        As a table's chunks have them.
    offset_min
        For datetimes with a zone, which are UTC in `cells`: its offset at the first of them, min.
    unit
        What the type says of the unit: `s` of time spans, `hh:mm` of clocks of the day.
    """

    cells: Cells
    offset_min: int | None = None
    unit: str = ""

    def column(self, header: object) -> Column:
        """Return the column's description under this header."""
        if self.unit == _OF_DAY:  # the header says it too, as that of a file would
            return Column.of(f"{header} ({_OF_DAY})")
        found = Column.of(str(header), self.unit)
        if self.offset_min is None:
            return found
        return Column(found.header, found.name, found.unit, True, self.offset_min)


def of_array(values: NDArray[Any]) -> Given:
    """Take a column of one dimension."""
    if isinstance(values, np.ma.MaskedArray):
        return of_list(values.tolist())
    kind = values.dtype.kind
    if kind == "f":
        return Given(values.astype(np.float64))
    if kind == "i" or (kind == "u" and (not values.size or int(values.max()) < 2**63)):
        return Given(values.astype(np.int64))
    if kind == "M" and np.datetime_data(values.dtype)[0] != "generic":
        return Given(values)
    if kind == "m":
        return Given(np.asarray(values / _SECOND, dtype=np.float64), unit="s")
    if kind == "S":
        return of_list([cell.decode("utf-8", "replace") for cell in values.tolist()])
    return of_list(values.tolist())


def of_list(values: list[Any]) -> Given:
    """Take a column of Python's values; None = missing."""
    kinds = set(map(type, values)) - {type(None)}
    if not kinds or kinds <= {str, bool}:
        return Given(values)
    if all(issubclass(kind, np.generic) for kind in kinds):
        if None in values:
            return of_list([None if value is None else value.item() for value in values])
        return of_array(np.array(values))
    if kinds <= {int, float}:
        return _numbers(values, kinds)
    if all(issubclass(kind, dt.datetime) for kind in kinds):
        return _moments(values)
    if kinds == {dt.date}:
        return Given(np.array(values, dtype="datetime64[D]"))
    if all(issubclass(kind, dt.timedelta) for kind in kinds):
        seconds = [np.nan if v is None else v.total_seconds() for v in values]
        return Given(np.array(seconds), unit="s")
    of_day = all(issubclass(kind, dt.time) for kind in kinds)
    return Given([_single(value) for value in values], unit=_OF_DAY if of_day else "")


def _numbers(values: list[Any], kinds: set[type]) -> Given:
    try:
        if kinds == {int}:
            # a whole number beside a missing one stays whole
            return Given(values if None in values else np.array(values, dtype=np.int64))
        return Given(np.array(values, dtype=np.float64))
    except OverflowError:
        return Given(values)


def _moments(values: list[Any]) -> Given:
    """Datetimes, with a zone or without; a mixture stays text, for the reader to refuse."""
    offsets = [None if v is None or v != v else v.utcoffset() for v in values]
    known = [v is not None and v == v for v in values]  # NaT isn't itself
    zoned = [offset is not None for offset in offsets]
    if any(zoned) and zoned != known:
        both = zip(values, known, strict=True)
        return Given([value.isoformat(" ") if there else None for value, there in both])
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
    return Given(np.array(moments), minutes)


def _single(value: Any) -> Any:
    """A cell as a table's: text for what a file would hold as text."""
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


_INSTALL = (
    'needs narwhals: pip install "overview-dsp[dataframes]", or give its columns as a dict of lists'
)


def is_frame(data: object) -> bool:
    """Return whether data are a frame or a column of some library for them."""
    if isinstance(data, np.ndarray | list | tuple | dict | type):
        return False
    faces = ("to_numpy", "__arrow_c_stream__", "__dataframe__", "__narwhals_dataframe__", "collect")
    return any(hasattr(data, face) for face in faces)


def columns_of(frame: Any) -> tuple[str, list[tuple[str, Given]]]:
    """Return the library's name and the columns (header, cells) of a frame or a column.

    An index is the first column, but for one of plain row numbers.

    Raises
    ------
    InputError
        narwhals isn't installed, or doesn't know the frame; a lazy one; a header given twice.
    """
    library = type(frame).__module__.partition(".")[0]
    what = f"a {library} {type(frame).__name__}"
    try:
        import narwhals.stable.v2 as nw
    except ImportError as error:
        raise InputError(f"{what} {_INSTALL}") from error
    if hasattr(frame, "collect") and not hasattr(frame, "to_numpy"):
        raise InputError(f"{what} isn't computed yet; give what its collect() returns")
    if hasattr(frame, "get_level_values"):  # an index by itself
        return library, _index(frame) or [("value", _of_index(frame))]
    frame = _one_header_a_column(frame)
    try:
        known: Any = nw.from_native(frame, eager_only=True, allow_series=True)
        if isinstance(known, nw.Series):
            header = known.name if known.name not in (None, "") else "value"
            series = [(str(header), known)]
        else:
            series = [(str(header), known[header]) for header in known.columns]
        columns = [(header, _given(nw, column)) for header, column in series]
    except (TypeError, ValueError, AttributeError) as error:
        reason = " ".join(str(error).split())[:160]
        raise InputError(f"{what} can't be read as a table ({reason})") from error
    index = nw.maybe_get_index(known)
    return library, [*_index(index), *columns]


def _one_header_a_column(frame: Any) -> Any:
    """Join headers of several levels (`Close`, `AAPL`), but for levels that are the same in all."""
    headers: Any = getattr(frame, "columns", None)
    if getattr(headers, "nlevels", 1) == 1:
        return frame
    rows = [tuple(map(str, header)) for header in headers]
    told = [level for level in range(headers.nlevels) if len({row[level] for row in rows}) > 1]
    joined = [" ".join(filter(None, (row[level] for level in told or [0]))) for row in rows]
    return frame.set_axis(joined, axis="columns")


def _index(index: Any) -> list[tuple[str, Given]]:
    """The columns of an index that says something: names, or anything but whole numbers."""
    if index is None:
        return []
    names = list(index.names)
    if names == [None] and index.dtype.kind in "iu":
        return []  # row numbers, or what is left of them, are no times
    if hasattr(index, "to_timestamp"):
        index = index.to_timestamp()  # periods begin
    levels = [index] if len(names) == 1 else [index.get_level_values(i) for i in range(len(names))]
    return [
        (str(name) if name is not None else "index", _of_index(level))
        for name, level in zip(names, levels, strict=True)
    ]


def _of_index(level: Any) -> Given:
    values = level.to_numpy()
    # one with a zone gives Timestamps
    return of_list(list(values)) if values.dtype.kind == "O" else of_array(values)


def _given(nw: Any, column: Any) -> Given:
    kind = column.dtype
    if kind == nw.Datetime:
        offset_min = None
        if kind.time_zone is not None:
            offset_min = _offset_min(column)
            column = column.dt.convert_time_zone("UTC").dt.replace_time_zone(None)
        return Given(np.asarray(column.to_numpy()), offset_min)
    if kind == nw.Date:
        return Given(np.asarray(column.cast(nw.Datetime("ms")).to_numpy()).astype("datetime64[D]"))
    if kind.is_float() or kind == nw.Duration or (kind.is_integer() and not column.null_count()):
        return of_array(np.asarray(column.to_numpy()))
    return of_list(column.to_list())


def _offset_min(column: Any) -> int:
    """The offset of a column's first moment from UTC, min."""
    first = column.drop_nulls().head(1).to_list()
    return round(first[0].utcoffset().total_seconds() / 60.0) if first else 0
