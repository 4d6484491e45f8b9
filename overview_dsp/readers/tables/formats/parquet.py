"""Parquet as a table, read in batches with pyarrow (the extra `parquet`)."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import numpy as np

from overview_dsp.errors import InputError
from overview_dsp.readers.source import Source
from overview_dsp.readers.tables.table import CHUNK_ROWS, MAX_COLUMNS, Cells, Chunk, Column

MAGIC = b"PAR1"
"""What a Parquet file begins with."""

MAX_ROWS = 2_000_000_000
"""Most rows: a file of a few kilobytes can claim any number of equal ones."""

_INSTALL = 'Parquet needs pyarrow: pip install "overview-dsp[parquet]"'


def sniff(source: Source) -> bool:
    """Return whether the file begins as Parquet does."""
    return source.head.startswith(MAGIC)


def _library() -> Any:
    try:
        import pyarrow.parquet
    except ImportError as error:
        raise InputError(f"{_INSTALL}, or save the table as CSV") from error
    return pyarrow


class ParquetTable:
    """A Parquet file, streamed."""

    kind = "Parquet"
    row_word = "row"
    notes: tuple[str, ...] = ()

    def __init__(self, source: Source) -> None:
        arrow = _library()
        self._arrow = arrow
        self._path = str(source.path)
        with _one_line():
            file = arrow.parquet.ParquetFile(self._path, memory_map=False)
            with file:
                schema = file.schema_arrow
                self._rows = file.metadata.num_rows
        if self._rows > MAX_ROWS:
            raise InputError(f"{self._rows} rows, more than the {MAX_ROWS} that are read; cut it")
        if self._rows == 0:
            raise InputError("no rows; a series has one row a time")
        if len(schema) > MAX_COLUMNS:
            raise InputError(f"{len(schema)} columns, more than {MAX_COLUMNS}; keep fewer")
        types = arrow.types
        # nested columns (lists, structures) are none of a series
        fields = [
            (i, field)
            for i, field in enumerate(schema)
            if not types.is_nested(field.type) and schema.names.count(field.name) == 1
        ]
        self._names = [field.name for _, field in fields]
        self.columns = tuple(
            Column(
                (found := Column.of(field.name)).header,
                found.name,
                found.unit,
                bool(types.is_timestamp(field.type) and field.type.tz),
            )
            for _, field in fields
        )
        if not fields:
            raise InputError("no flat columns; a series is a table of times and values")

    def chunks(self, columns: Sequence[int]) -> Iterator[Chunk]:
        """Read these columns; InputError where the file is damaged."""
        names = [self._names[i] for i in columns]
        first = 1
        with (
            _one_line(),
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
            raise InputError("no rows; a series has one row a time")

    def _cells(self, column: Any) -> Cells:
        """A batch's column as numpy numbers or datetimes, or as Python values."""
        types, kind = self._arrow.types, column.type
        if types.is_timestamp(kind):
            naive = column.cast(self._arrow.timestamp(kind.unit))
            found = naive.to_numpy(zero_copy_only=False)
            return np.asarray(found)
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
        if types.is_decimal(kind):
            return [None if cell is None else float(cell) for cell in column.to_pylist()]
        if types.is_time(kind) or types.is_duration(kind):
            return [None if cell is None else str(cell) for cell in column.to_pylist()]
        return list(column.to_pylist())


@contextmanager
def _one_line() -> Iterator[None]:
    """Turn what pyarrow raises about a broken file into one line."""
    try:
        yield
    except InputError:  # a ValueError too
        raise
    except (OSError, ValueError, MemoryError, TypeError, NotImplementedError) as error:
        first = str(error).strip().split("\n")[0][:160] or type(error).__name__
        raise InputError(
            f"broken or unknown Parquet ({first}); get the file again, or save the table as CSV"
        ) from error


def open_table(source: Source) -> ParquetTable:
    """Return the file's table; InputError if it can't be read, or pyarrow is missing."""
    return ParquetTable(source)
