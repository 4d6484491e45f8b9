"""Tables read in chunks of rows: columns, chunks, cell locations and errors.

Every file format of tables, and data in memory, become one of these.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from overview_dsp.data.readers.tables import column_names
from overview_dsp.data.readers.tables.text_cells import TextCells
from overview_dsp.errors import InputError, quoted

CHUNK_ROWS = 65_536
"""Rows read at a time: some 10 MB as text cells, whatever the file's size."""

CHUNK_CELLS = 2_000_000
"""Most cells read at a time from a wide table."""

_HEAD_CELLS = 150_000

MAX_COLUMNS = 10_000
"""Maximum number of columns: each is examined before one is chosen."""

NO_ROWS = "no rows; a series has one row per time, an event list one row per event"

Cells = list[Any] | NDArray[Any] | TextCells
"""One column of a chunk: text and other single values (None = missing), an array of float64
(NaN = missing), int64 or datetime64 (NaT = missing), or texts in a buffer."""

_WITH_UNIT = re.compile(r"(.*?)\s*[(\[]\s*([^()\[\]]{1,24}?)\s*[)\]]\s*", re.DOTALL)


@dataclass(frozen=True)
class Column:
    """Header of a column, with the name and the unit that it contains.

    `header`: header as written, without surrounding blanks.
    `name`, `unit`: `temp_max` and `°C` for `temp_max (°C)`, `rain_mm` and `mm` for `rain_mm`.
    Without a unit, `unit` is empty.
    `zoned`: true if the datetimes are UTC. Columns of text contain their time zone instead.
    `offset_min`: offset of the original time zone from UTC, min.
    `key`: true for one of several levels of an index: times, or names of series, but no values.
    """

    header: str
    name: str
    unit: str = ""
    zoned: bool = False
    offset_min: int = 0
    key: bool = False

    @classmethod
    def of(cls, header: str, unit: str = "") -> Column:
        """Split a header into name and unit."""
        header = " ".join(header.split())
        found = _WITH_UNIT.fullmatch(header)
        if unit or found is None or not found[1]:
            last = header.rpartition("_")[2].lower()
            return cls(header, header, unit or column_names.HEADER_UNITS.get(last, ""))
        return cls(header, found[1], found[2])

    @property
    def plain(self) -> str:
        """Name reduced to lower-case letters and digits: `adjclose` for `Adj Close**`."""
        return re.sub(r"[^0-9a-zäöüßéèáíóú]+", "", self.name.lower())


Columns = Sequence[Column]
"""Columns of a table."""

Head = Sequence[Sequence[Any]]
"""First rows of a table, one list per column."""


@dataclass(frozen=True)
class Chunk:
    """Some rows of the requested columns.

    `cells`: one entry per requested column, all of the same length.
    `first`: number of the first row: of its line, row or record, counted from 1.
    `numbers`: number of each row, if they are not consecutive from `first`.
    `part`: fraction of the file that has been read, 0 to 1.
    """

    cells: tuple[Cells, ...]
    first: int
    numbers: Sequence[int] | None = None
    part: float = 1.0

    def __len__(self) -> int:
        return len(self.cells[0])

    def number(self, i: int) -> int:
        """Return the number of row `i` of this chunk."""
        return self.first + i if self.numbers is None else self.numbers[i]


@dataclass(frozen=True)
class CellLocation:
    """Location of a cell or row in a file. It builds all error messages about cells.

    `line`: number of the line, row or record, counted from 1.
    `column`: header of the column; empty for a whole row.
    `word`: name of a row: `line`, `row` or `record`.
    """

    line: int
    column: str = ""
    word: str = "line"

    def __str__(self) -> str:
        row = f"{self.word} {self.line}"
        return f"{row}, column {quoted(self.column)}" if self.column else row

    def error(self, value: object, note: str) -> InputError:
        """Return the error for a wrong value; `note` states the problem."""
        words = f"{self}: {quoted(value)} {note}"
        return InputError(words, line=self.line, column=self.column, value=value, note=note)

    def missing(self, note: str) -> InputError:
        """Return the error for an empty cell; `note` states the requirement."""
        words = f"{self}: is missing; {note}"
        return InputError(words, line=self.line, column=self.column, value="", note=note)

    def fault(self, note: str) -> InputError:
        """Return the error for a whole row; `note` states the problem."""
        return InputError(f"{self}: {note}", line=self.line, column=self.column, note=note)


class Table:
    """A table that is read in chunks of rows, any number of times.

    `kind`: kind of file: `CSV`, `Parquet`, `JSON`.
    `columns`: all columns, in order.
    `row_word`: name of a row in error messages: `line`, `row` or `record`.
    `notes`: messages about how the table was read.
    `sheets`, `sheet`: sheets of its workbook, and that which an option has chosen.
    """

    kind: str
    columns: tuple[Column, ...]
    row_word: str = "row"
    notes: tuple[str, ...] = ()
    sheets: tuple[str, ...] = ()
    sheet: str = ""

    def chunks(self, columns: Sequence[int]) -> Iterator[Chunk]:
        """Read these columns from the first row; InputError names row and column."""
        raise NotImplementedError


@dataclass(eq=False)
class ColumnTable(Table):
    """A table with random access: in memory, or mapped from a file.

    `rows`: number of rows.
    `cut`: function of column index, first row and end row that returns the cells.
    """

    kind: str
    columns: tuple[Column, ...]
    rows: int
    cut: Callable[[int, int, int], Cells]
    row_word: str = "row"
    notes: tuple[str, ...] = ()

    def checked(self) -> ColumnTable:
        """Return the table; InputError if it has no rows or too many columns."""
        require_few_columns(len(self.columns))
        if not self.rows:
            raise InputError(NO_ROWS)
        return self

    def chunks(self, columns: Sequence[int]) -> Iterator[Chunk]:
        """Read these columns; InputError names a row with a nested value."""
        for begin in range(0, self.rows, CHUNK_ROWS):
            end = min(begin + CHUNK_ROWS, self.rows)
            cells = tuple(self.cut(i, begin, end) for i in columns)
            yield single_cells(self, Chunk(cells, begin + 1, None, end / self.rows), columns)


def require_few_columns(count: int) -> None:
    """Raise InputError for more than `MAX_COLUMNS` columns."""
    if count > MAX_COLUMNS:
        raise InputError(f"{count} columns; at most {MAX_COLUMNS} are allowed, remove some")


def headers_of(columns: Columns) -> frozenset[str]:
    """Return headers and names of columns, in lower case."""
    return frozenset(word.lower() for c in columns for word in (c.header, c.name) if word)


def split_column_option(option: str, columns: Columns) -> tuple[str, str]:
    """Split `COLUMN:WORD` into column and lower-case word; either may be "".

    An option that equals a header is a column, even with a colon in it.
    """
    name, colon, word = option.rpartition(":")
    if not colon or " ".join(option.split()).lower() in headers_of(columns):
        return option, ""
    return name.strip(), word.strip().lower()


def column_named(columns: Columns, name: str) -> int | None:
    """Return the index of a column by header or name; case matters only to choose between several.

    InputError: several columns have this name.
    """
    exact = " ".join(name.split())
    headers, names = [c.header for c in columns], [c.name for c in columns]
    for fold in (str, str.lower):
        for candidates in (headers, names):
            found = [i for i, text in enumerate(candidates) if fold(text) == fold(exact)]
            if len(found) == 1:
                return found[0]
            if found:
                raise InputError(
                    f"{len(found)} columns are called {quoted(name)}; rename one in the file"
                )
    return None


def listed(columns: Columns, limit: int = 12) -> str:
    """Return the headers of columns, quoted, for a message."""
    names = [quoted(column.header) for column in columns[:limit]]
    more = len(columns) - limit
    return ", ".join(names) + (f" and {more} more" if more > 0 else "")


def first_rows(table: Table, rows: int) -> list[list[Any]]:
    """Return the first `rows` rows, fewer of a wide table (at least 30), as one list per column."""
    wanted = range(len(table.columns))
    most = min(rows, max(_HEAD_CELLS // len(wanted), 30))
    found: list[list[Any]] = [[] for _ in wanted]
    for chunk in table.chunks(wanted):
        missing = most - len(found[0])
        for column, cells in zip(found, chunk.cells, strict=True):
            column += as_list(cells[:missing])
        if len(found[0]) >= most:
            break
    return found


def as_list(cells: Cells) -> list[Any]:
    """Return cells as Python values, except datetimes, which may not fit Python's type."""
    if isinstance(cells, np.ndarray):
        return list(cells) if cells.dtype.kind == "M" else list(cells.tolist())
    return cells.tolist() if isinstance(cells, TextCells) else cells


def cell_locator(table: Table, chunk: Chunk, column: int) -> Callable[[int], CellLocation]:
    """Return a function from the index of a cell in a chunk to its location."""
    header, word = table.columns[column].header, table.row_word
    return lambda i: CellLocation(chunk.number(i), header, word)


def single_cells(table: Table, chunk: Chunk, columns: Sequence[int]) -> Chunk:
    """Return a chunk; InputError names row and column of a nested list or object."""
    for index, cells in zip(columns, chunk.cells, strict=True):
        for i, cell in enumerate(cells if isinstance(cells, list) else ()):
            if isinstance(cell, list | dict):
                raise cell_locator(table, chunk, index)(i).error(cell, "isn't a single value")
    return chunk
