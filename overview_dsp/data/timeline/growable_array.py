"""Arrays that grow by chunks: one-dimensional ones, on disk when long, and tables in memory."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from typing import IO, Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

from overview_dsp.errors import OutputError

SPILL_BYTES = 32 * 1024 * 1024
"""Maximum size in memory; a longer array is stored in a temporary file, deleted after use."""


class Store:
    """Array that grows by `append`; `finish` returns it as a read-only array or memory map."""

    def __init__(self, dtype: type[np.float32] | type[np.float64]) -> None:
        self._dtype = np.dtype(dtype)
        self._chunks: list[NDArray[Any]] = []
        self._file: IO[bytes] | None = None
        self.count = 0

    def append(self, values: NDArray[Any]) -> None:
        """Add a copy of the values, shape (n,); OutputError if the temporary folder is full."""
        self.count += len(values)
        self._chunks.append(np.array(values, dtype=self._dtype))
        if self._file is None and self.count * self._dtype.itemsize > SPILL_BYTES:
            self._file = tempfile.TemporaryFile(prefix="overview-")  # noqa: SIM115
        if self._file is not None:
            try:
                for chunk in self._chunks:
                    self._file.write(chunk.data)
            except OSError as error:
                raise OutputError(
                    f"the temporary folder {tempfile.gettempdir()} can't take a long series: "
                    f"{error.strerror or error}; free some space, or set TMPDIR to another"
                ) from error
            self._chunks.clear()

    def finish(self) -> NDArray[Any]:
        """Return all values, shape (count,), read-only."""
        if self._file is None:
            whole = np.concatenate([np.empty(0, self._dtype), *self._chunks])
            whole.setflags(write=False)
            return whole
        with self._file as file:  # the map keeps the file until it is dropped itself
            try:
                file.flush()
            except OSError as error:
                raise OutputError(f"the temporary folder can't take a long series: {error}") from (
                    error
                )
            return np.memmap(file, dtype=self._dtype, mode="r", shape=(self.count,))


class GrowableArray:
    """Array (rows, columns) that grows by rows; up to `reserved` rows are never copied."""

    def __init__(self, columns: int, dtype: DTypeLike, reserved: int) -> None:
        """Space for `reserved` rows; it grows when more are added."""
        self._table: NDArray[Any] = np.empty((reserved, columns), dtype)
        self._count = 0

    def add(self, rows: NDArray[Any], columns: Sequence[int] | None = None) -> None:
        """Copy rows, or some columns of them, to the end."""
        end = self._count + len(rows)
        if end > len(self._table):
            larger = np.empty((max(end, 2 * len(self._table)), *self._table.shape[1:]), rows.dtype)
            larger[: self._count] = self._table[: self._count]
            self._table = larger
        added = self._table[self._count : end]
        if columns is None:
            added[:] = rows
        else:
            # only this mode makes no temporary copy; it clips nothing, as all columns exist
            rows.take(columns, axis=1, out=added, mode="clip")
        self._count = end

    @property
    def rows(self) -> NDArray[Any]:
        """Rows so far, as a view of the memory."""
        return self._table[: self._count]
