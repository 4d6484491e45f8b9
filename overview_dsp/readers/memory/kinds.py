"""What a timeline can be made of besides a file: the types that a checker sees."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import IO, Any, Protocol

from numpy.typing import NDArray


class SupportsNumpy(Protocol):
    """A Series or a DataFrame of pandas, polars and their relatives; a column of Arrow."""

    def to_numpy(self, *args: Any, **kwargs: Any) -> Any:
        """Give the values as an array."""
        ...


class SupportsArrow(Protocol):
    """A table of Arrow, and whatever gives its columns as one does."""

    def __arrow_c_stream__(self, requested_schema: Any = None) -> Any:
        """Give the columns."""
        ...


MemoryTable = SupportsNumpy | SupportsArrow | NDArray[Any] | Sequence[Any] | Mapping[Any, Any]
"""Columns, rows or samples in memory."""

MemoryFile = bytes | bytearray | memoryview | IO[bytes] | IO[str]
"""A file's content, or where it can be read."""

TimelineData = str | os.PathLike[str] | MemoryFile | MemoryTable
"""Whatever `load_timeline` takes besides a Timeline."""
