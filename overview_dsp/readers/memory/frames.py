"""Frames and columns of pandas, polars, Arrow and their relatives, through narwhals."""

from __future__ import annotations

from typing import Any

import numpy as np

from overview_dsp.errors import InputError
from overview_dsp.readers.memory.cells import Given, of_array, of_list

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
