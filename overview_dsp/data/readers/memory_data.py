"""From data in memory to a Timeline, by the same rules as from the file that would hold them."""

from __future__ import annotations

import json
import os
import tempfile
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import IO, Any, Protocol

from numpy.typing import NDArray

from overview_dsp import validation
from overview_dsp.data.readers.series import series
from overview_dsp.data.readers.source import UNNAMED, LoadOptions, Source
from overview_dsp.data.readers.tables.memory import MemoryTable
from overview_dsp.data.timeline.model import Timeline
from overview_dsp.errors import InputError


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


TableData = SupportsNumpy | SupportsArrow | NDArray[Any] | Sequence[Any] | Mapping[Any, Any]
"""Columns, rows or samples in memory."""

MemoryFile = bytes | bytearray | memoryview | IO[bytes] | IO[str]
"""A file's content, or where it can be read."""

TimelineData = str | os.PathLike[str] | MemoryFile | TableData
"""Whatever `load_timeline` takes besides a Timeline."""


Claim = Callable[[Source], Callable[[Source, LoadOptions], Timeline] | None]
"""Takes a source; returns what reads it as something else than a series of numbers, or None."""

MAX_ROWS = 5_000_000
"""Most rows of data in memory that are read as something else than a series."""

_HEAD_ROWS, _HEAD_CELLS = 1000, 50_000
_SAMPLE = 50


def read_table(table: MemoryTable, options: LoadOptions, claim: Claim) -> Timeline:
    """Make a Timeline of a table in memory: an event list's, a match's, a heart's, or a series'.

    Which of them is told from its first rows, written as a file has them: `claim` says what reads
    those, and refuses options that this doesn't take.

    Raises
    ------
    InputError
        As the reader of a file; places are rows (a file's lines, where it isn't a series).
    """
    where = f"the {table.kind} data"
    with tempfile.TemporaryDirectory(prefix="overview-") as folder:
        path = Path(folder) / UNNAMED
        most = max(20, min(_HEAD_ROWS, _HEAD_CELLS // len(table.columns)))
        source = _written(path, table.csv(most), options, where)
        read = claim(source)
        if read is not None:
            if table.rows > MAX_ROWS:
                raise InputError(
                    f"{where}: {table.rows} rows, more than the {MAX_ROWS} that are read; cut them"
                )
            if table.rows > most:
                source = _written(path, table.csv(table.rows), options, where)
            return read(source, options)
    with validation.located(f"{where}: "):
        return series.series_of(table, options)


def is_document(data: Any) -> bool:
    """Return whether data are what a JSON file of objects within objects holds."""
    if isinstance(data, Mapping):
        values = list(data.values())
        return any(isinstance(value, Mapping) or _holds_more(value) for value in values)
    return _holds_more(data) and any(
        isinstance(value, Mapping | list)
        for entry in data[:_SAMPLE]
        if isinstance(entry, Mapping)
        for value in entry.values()
    )


def _holds_more(data: Any) -> bool:
    return isinstance(data, list) and bool(data) and isinstance(data[0], Mapping)


def document_bytes(data: Any) -> bytes:
    """Write a document as the file that it came from; InputError where JSON can't hold it."""
    try:
        return json.dumps(data).encode()
    except (TypeError, ValueError, RecursionError) as error:
        raise InputError(f"a {type(data).__name__} that JSON can't hold ({error})") from error


def _written(path: Path, text: str, options: LoadOptions, where: str) -> Source:
    path.write_text(text, encoding="utf-8", errors="surrogateescape", newline="")
    return Source.open(path, options, where)
