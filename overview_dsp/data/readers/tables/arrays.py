"""Tables in NumPy's `.npy` and `.npz` files, and in Parquet files.

`.npy`: one row of values (give `rate`), rows and columns (`column 1` ...), or a structured array
(its names). `.npz`: all arrays of one dimension and of the greatest length, by their names.
Arrays of Python objects are errors, since unpickling runs code from the file. The size in a header
is compared with the size of the file, or the limit, before data are read.
"""

from __future__ import annotations

import math
import zipfile
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from overview_dsp import validation
from overview_dsp.data.readers.data_file import DataFile
from overview_dsp.data.readers.opening import MAX_MB
from overview_dsp.data.readers.tables.table import (
    CHUNK_ROWS,
    NO_ROWS,
    Cells,
    Chunk,
    Column,
    ColumnTable,
    Table,
    require_few_columns,
)
from overview_dsp.data.readers.tables.text_cells import PAD, TextCells, padded
from overview_dsp.errors import InputError, quoted
from overview_dsp.installation import library_errors, require_library

MAGIC = b"\x93NUMPY"
ZIP_MAGIC = b"PK\x03\x04"
_NUMBERS = "bhilqBHILQefdg?"
_MAX_HEADER = 100_000


def array_table(
    names: Sequence[str], arrays: Sequence[NDArray[Any]], notes: Sequence[str] = ()
) -> ColumnTable:
    """Return a table of one-dimensional arrays of equal length, in memory or on disk.

    `names`: names of the columns.
    `arrays`: numbers, datetimes, texts.
    `notes`: messages about how the table was read.
    """
    return ColumnTable(
        "NumPy",
        tuple(map(Column.of, names)),
        len(arrays[0]) if arrays else 0,
        lambda i, begin, end: _cells(arrays[i][begin:end]),
        notes=tuple(notes),
    ).checked()


def _cells(part: Any) -> Cells:
    kind = part.dtype.kind
    if kind == "f":
        return np.asarray(part, np.float64)
    if kind in "iub":
        return np.asarray(part, np.float64 if kind == "u" else np.int64)
    return np.asarray(part) if kind == "M" else [str(cell) for cell in part.tolist()]


def open_npy(source: DataFile) -> ColumnTable:
    """Return the table of a file; InputError for objects or a truncated file."""
    with open(source.path, "rb") as stream:
        shape, fortran, dtype = _header(stream)
        offset = stream.tell()
    if dtype.itemsize * math.prod(shape) != source.size - offset:
        raise InputError(
            f"the header says an array of shape {shape}, {dtype.itemsize * math.prod(shape)} "
            f"bytes, but {source.size - offset} bytes follow; get the file again"
        )
    if not math.prod(shape):
        raise InputError(NO_ROWS)
    array = np.memmap(source.path, dtype, "r", offset, shape, "F" if fortran else "C")
    return _table(array)


def open_npz(source: DataFile) -> ColumnTable:
    """Return the table of the longest one-dimensional arrays in an archive."""
    limit = (source.options.max_mb if source.options.max_mb is not None else MAX_MB) * 2**20
    arrays: dict[str, Any] = {}
    try:
        with zipfile.ZipFile(source.path) as archive:
            for member in archive.infolist():
                with archive.open(member) as stream:
                    name = member.filename.removesuffix(".npy")
                    with validation.prefix_errors(f"{quoted(name)}: "):
                        shape, fortran, dtype = _header(stream)
                        size = dtype.itemsize * math.prod(shape)
                        limit -= size
                        if limit < 0:
                            raise InputError(
                                "unpacks to more than the limit; if that is intended, raise it "
                                "with max_mb (--read max-mb=MB)"
                            )
                        data = stream.read(size)
                        if len(data) != size:
                            raise InputError("the array is cut off; get the file again")
                    flat = np.frombuffer(data, dtype)
                    arrays[name] = flat.reshape(shape, order="F" if fortran else "C")
    except InputError:  # a ValueError too
        raise
    except (zipfile.BadZipFile, NotImplementedError, RuntimeError, OSError, EOFError) as error:
        raise InputError(f"can't be unpacked ({error}); get it again") from error
    rows = {name: array for name, array in arrays.items() if array.ndim == 1 and array.dtype.char}
    if not rows:
        if len(arrays) == 1:
            return _table(next(iter(arrays.values())))
        raise InputError("no array of one dimension; a series has a row of times and one of values")
    longest = max(len(array) for array in rows.values())
    same = {name: array for name, array in rows.items() if len(array) == longest}
    left = [name for name in arrays if name not in same]
    if len(same) == 1 and same[next(iter(same))].dtype.names:
        return _table(same[next(iter(same))])
    notes = [f"arrays of another length are left out: {', '.join(left)}"] if left else []
    return array_table(list(same), list(same.values()), notes)


def _header(stream: IO[bytes] | zipfile.ZipExtFile) -> tuple[tuple[int, ...], bool, np.dtype[Any]]:
    """Read the header of an array; InputError for objects or a wrong header."""
    form = np.lib.format
    with library_errors(  # a literal of any kind is parsed there
        lambda error: f"no NumPy array ({' '.join(str(error).split())[:120]}); get the file again"
    ):
        is_first = form.read_magic(stream) == (1, 0)
        read = form.read_array_header_1_0 if is_first else form.read_array_header_2_0
        shape, fortran, dtype = read(stream, _MAX_HEADER)
    if dtype.hasobject:
        raise InputError("an array of Python objects, which aren't read; save numbers")
    if any(size < 0 for size in shape) or not dtype.itemsize:
        raise InputError(f"an array of shape {shape} of {dtype}; save numbers")
    return shape, fortran, dtype


def _table(array: Any) -> ColumnTable:
    names = array.dtype.names
    if names and array.ndim == 1:
        plain = [name for name in names if array.dtype[name].shape == ()]
        return array_table(plain, [array[name] for name in plain])
    if array.ndim == 1:
        return array_table(["value"], [array])
    if array.ndim != 2:
        raise InputError(
            f"an array of {array.ndim} dimensions; save one of times and values in columns, or of "
            "values in a row"
        )
    if array.shape[1] > array.shape[0] and array.shape[0] <= 2:
        array = array.T  # a row of times over one of values
    first = "time" if array.shape[1] == 2 else "column 1"
    return array_table(
        [first, *(f"column {i}" for i in range(2, array.shape[1] + 1))],
        [array[:, i] for i in range(array.shape[1])],
    )


PARQUET_MAGIC = b"PAR1"
"""First bytes of a Parquet file."""

MAX_ROWS = 2_000_000_000
"""Maximum number of rows: a file of a few kilobytes can contain any number of equal rows."""


class ParquetTable(Table):
    """Table of a Parquet file, streamed."""

    kind = "Parquet"

    def __init__(self, source: DataFile) -> None:
        require_library("pyarrow.parquet", "Parquet", "parquet", "save the table as CSV")
        import pyarrow as arrow

        self._arrow: Any = arrow
        self._path = str(source.path)
        with library_errors(_broken), arrow.parquet.ParquetFile(self._path) as file:
            schema = file.schema_arrow
            self._rows = file.metadata.num_rows
        if self._rows > MAX_ROWS:
            raise InputError(f"{self._rows} rows; must be at most {MAX_ROWS}: cut it into parts")
        if self._rows == 0:
            raise InputError(NO_ROWS)
        require_few_columns(len(schema))
        types = arrow.types
        # nested columns (lists, structures) are left out
        flat = (field for field in schema if not types.is_nested(field.type))
        fields = [field for field in flat if schema.names.count(field.name) == 1]
        self._names = [field.name for field in fields]
        self.columns = tuple(
            replace(Column.of(field.name), zoned=types.is_timestamp(field.type) and field.type.tz)
            for field in fields
        )
        if not fields:
            raise InputError("no flat columns; a series is a table of times and values")

    def chunks(self, columns: Sequence[int]) -> Iterator[Chunk]:
        """Read these columns; InputError if the file is damaged."""
        names = [self._names[i] for i in columns]
        first = 1
        with (
            library_errors(_broken),
            self._arrow.parquet.ParquetFile(
                self._path, memory_map=False, buffer_size=1 << 20, pre_buffer=False
            ) as file,
        ):
            batches = file.iter_batches(
                batch_size=CHUNK_ROWS, columns=list(dict.fromkeys(names)), use_threads=False
            )
            for batch in batches:
                if not batch.num_rows:
                    continue
                cells = tuple(self._cells(batch.column(name)) for name in names)
                done = first - 1 + batch.num_rows
                yield Chunk(cells, first, None, min(1.0, done / self._rows))
                first = done + 1
        if first == 1:
            raise InputError(NO_ROWS)

    def _cells(self, column: Any) -> Cells:
        """Return a column of a batch as NumPy numbers or datetimes, or as Python values."""
        types, kind = self._arrow.types, column.type
        if types.is_timestamp(kind):
            naive = column.cast(self._arrow.timestamp(kind.unit))
            return np.asarray(naive.to_numpy(zero_copy_only=False))
        if types.is_date(kind):
            days = column.cast(self._arrow.date32()).cast(self._arrow.int32())
            whole = days.cast(self._arrow.int64()).fill_null(np.iinfo(np.int64).min)
            return np.asarray(whole.to_numpy(zero_copy_only=False)).astype("datetime64[D]")
        if types.is_floating(kind):
            return np.asarray(column.to_numpy(zero_copy_only=False), dtype=np.float64)
        if types.is_integer(kind) and column.null_count == 0 and kind.bit_width <= 64:
            whole = column.to_numpy(zero_copy_only=False)
            if whole.dtype.kind == "i" or not whole.size or int(whole.max()) < 2**63:
                return np.asarray(whole, dtype=np.int64)
        if (types.is_string(kind) or types.is_large_string(kind)) and column.null_count == 0:
            _, places, text = column.buffers()
            size = "i4" if types.is_string(kind) else "i8"
            ends = np.frombuffer(places, size)[column.offset :][: len(column) + 1].astype(np.int64)
            data = padded(memoryview(text or b"")[ends[0] : ends[-1]])
            if data.max() < 0x80:
                stops = ends - (ends[0] - PAD)
                return TextCells(data, stops[:-1], stops[1:])
        as_cell = float if types.is_decimal(kind) else str
        if types.is_decimal(kind) or types.is_time(kind) or types.is_duration(kind):
            return [None if cell is None else as_cell(cell) for cell in column.to_pylist()]
        return list(column.to_pylist())


def _broken(error: Exception) -> str:
    """Return the message for an error of pyarrow, in one line."""
    first = str(error).strip().split("\n")[0][:160] or type(error).__name__
    return f"broken or unknown Parquet ({first}); get the file again, or save the table as CSV"
