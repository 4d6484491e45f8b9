"""CSV, TSV and their relatives as a table, streamed: the file's size doesn't matter."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from operator import itemgetter
from typing import Any

from overview_dsp.errors import InputError
from overview_dsp.readers.source import Source
from overview_dsp.readers.tables import delimited
from overview_dsp.readers.tables.csv_layout import Layout, layout_of
from overview_dsp.readers.tables.table import CHUNK_ROWS, Chunk, Column


class CsvTable:
    """A text file with a table, streamed."""

    kind = "CSV"
    row_word = "line"

    def __init__(self, source: Source, layout: Layout) -> None:
        self._source, self._layout = source, layout
        self.columns = tuple(
            Column.of(name, unit) for name, unit in zip(layout.header, layout.units, strict=True)
        )
        self.notes = layout.notes
        self.separator = layout.separator

    def chunks(self, columns: Sequence[int]) -> Iterator[Chunk]:
        """Read these columns; InputError names a row that is too long, or a broken quote."""
        layout = self._layout
        lines = delimited.Lines(self._source, layout.encoding, layout.comments)
        width = len(layout.header)
        for first, numbers, rows in delimited.Rows(lines, layout.separator, CHUNK_ROWS):
            if first < layout.first:
                skip = self._skipped(first, numbers, rows)
                rows = rows[skip:]
                first, numbers = first + skip, numbers[skip:] if numbers else None
            lengths = set(map(len, rows))
            if lengths and lengths != {width}:
                first, numbers, rows = self._tidied(first, numbers, rows)
            if not rows:
                continue
            cells: tuple[Any, ...] = tuple(list(map(itemgetter(i), rows)) for i in columns)
            yield Chunk(cells, first, numbers, lines.part)

    def _skipped(self, first: int, numbers: list[int] | None, rows: list[list[str]]) -> int:
        """How many rows lie before the table's first line."""
        if numbers is None:
            return min(len(rows), self._layout.first - first)
        return sum(number < self._layout.first for number in numbers)

    def _tidied(
        self, first: int, numbers: list[int] | None, rows: list[list[str]]
    ) -> tuple[int, list[int], list[list[str]]]:
        """Drop blank rows, fill short ones, refuse those with more fields than columns."""
        width = len(self._layout.header)
        kept, lines = [], []
        for i, row in enumerate(rows):
            line = numbers[i] if numbers is not None else first + i
            if not any(cell.strip() for cell in row):
                continue
            if len(row) > width:
                if any(cell.strip() for cell in row[width:]):
                    raise InputError(
                        f"line {line}: {len(row)} fields for {width} columns; put quotes around a "
                        "field that holds the separator"
                    )
                row = row[:width]
            kept.append(row + [""] * (width - len(row)))
            lines.append(line)
        return first, lines, kept


def sniff(source: Source) -> bool:
    """Tell whether the file is text with a table that has a column of numbers."""
    return layout_of(source) is not None


def open_table(source: Source) -> CsvTable:
    """Return the file's table.

    Raises
    ------
    InputError
        No rows below the header.
    """
    layout = layout_of(source)
    assert layout is not None  # the reader asked `sniff`
    table = CsvTable(source, layout)
    if not any(len(chunk) for chunk in table.chunks([0])):
        raise InputError(f"no rows below the header (line {layout.first - 1}); add one row a time")
    return table
