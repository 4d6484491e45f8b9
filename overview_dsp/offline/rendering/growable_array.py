"""Rows that come block by block, in one array of them all."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray


class GrowableArray:
    """An array (rows, columns) to add to; what is reserved in time is never copied again."""

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
            # no other mode writes to its place at once; every column is there
            rows.take(columns, axis=1, out=added, mode="clip")
        self._count = end

    @property
    def rows(self) -> NDArray[Any]:
        """Those there are: the same memory."""
        return self._table[: self._count]
