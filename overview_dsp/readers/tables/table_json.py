"""JSON as a table: the series with the most rows that its document holds (`json_shapes`)."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from overview_dsp.errors import InputError
from overview_dsp.readers.source import Source
from overview_dsp.readers.tables.json_shapes import Shape, series_in
from overview_dsp.readers.tables.table import (
    CHUNK_ROWS,
    MAX_COLUMNS,
    Chunk,
    Column,
    check_single,
)
from overview_dsp.timeline import checks


class JsonTable:
    """A table in a JSON document."""

    kind = "JSON"
    row_word = "record"

    def __init__(self, shape: Shape, others: int = 0) -> None:
        if len(shape.names) > MAX_COLUMNS:
            raise InputError(f"{len(shape.names)} columns, more than {MAX_COLUMNS}; keep fewer")
        self._shape = shape
        self.columns = tuple(Column.of(name, shape.units.get(name, "")) for name in shape.names)
        notes = [f"the table is at {checks.shown(shape.place)}"] if shape.place else []
        if others:
            notes.append(f"{others} other tables in the file were left out")
        self.notes: tuple[str, ...] = tuple(notes)

    def chunks(self, columns: Sequence[int]) -> Iterator[Chunk]:
        """Read these columns; InputError names a record unlike the others or a nested value."""
        rows = self._shape.rows
        for begin in range(0, rows, CHUNK_ROWS):
            end = min(begin + CHUNK_ROWS, rows)
            cells = tuple(self._shape.cut(i, begin, end) for i in columns)
            chunk = Chunk(cells, begin + 1, None, end / rows)
            check_single(self, chunk, columns)
            yield chunk


def sniff(source: Source) -> bool:
    """Tell whether the file is JSON that holds a series in one of the known shapes."""
    return source.looks_like_json and bool(series_in(source.json))


def open_table(source: Source) -> JsonTable:
    """Return the largest series of the document."""
    series = series_in(source.json)
    largest = max(series, key=lambda shape: shape.rows)
    return JsonTable(largest, sum(shape.rows > 1 for shape in series if shape is not largest))
