"""What every table looks like to the rest of this package, whichever file it came from."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from overview_dsp.errors import InputError, shown

CHUNK_ROWS = 65_536
"""Rows read at a time: some 10 MB as text cells, whatever the file's size."""

CHUNK_CELLS = 2_000_000
"""Cells read at a time, of a wide table."""

_HEAD_CELLS = 150_000

MAX_COLUMNS = 10_000
"""Most columns a table may have: each is looked at before one is chosen."""

NO_ROWS = "no rows; a series has one row a time, an event list one an event"

Cells = list[Any] | NDArray[Any]
"""One column of a chunk: text and other single values (None = missing), or an array of float64
(NaN = missing), int64 or datetime64 (NaT = missing)."""

_WITH_UNIT = re.compile(r"(.*?)\s*[(\[]\s*([^()\[\]]{1,24}?)\s*[)\]]\s*", re.DOTALL)

_LAST_WORDS = {
    "celsius": "°C", "degc": "°C", "fahrenheit": "°F", "degf": "°F", "kelvin": "K", "mm": "mm",
    "cm": "cm", "km": "km", "kmh": "km/h", "kph": "km/h", "mph": "mph", "kg": "kg", "hpa": "hPa",
    "mbar": "mbar", "watts": "W", "kw": "kW", "kwh": "kWh", "mwh": "MWh", "volts": "V",
    "bpm": "bpm", "rpm": "rpm", "hz": "Hz", "khz": "kHz", "db": "dB", "lufs": "LUFS", "lux": "lux",
    "ppm": "ppm", "pct": "%", "percent": "%",
}  # fmt: skip
"""Units that a header may end with (`rain_mm`), none of time nor money."""


@dataclass(frozen=True)
class Column:
    """A column: its header as written, and what the header says.

    Parameters
    ----------
    header
        As the file has it, without the blanks around it.
    name, unit
        `temp_max` and `°C` of `temp_max (°C)`, `rain_mm` and `mm` of `rain_mm`; the unit is empty
        where the header has none.
    zoned
        Its datetimes are UTC. (Text says so itself.)
    offset_min
        The offset from UTC, min, of the clock they were written by.
    """

    header: str
    name: str
    unit: str = ""
    zoned: bool = False
    offset_min: int = 0

    @classmethod
    def of(cls, header: str, unit: str = "") -> Column:
        """Take a header apart."""
        header = " ".join(header.split())
        found = _WITH_UNIT.fullmatch(header)
        if unit or found is None or not found[1]:
            last = header.rpartition("_")[2].lower()
            return cls(header, header, unit or _LAST_WORDS.get(last, ""))
        return cls(header, found[1], found[2])

    @property
    def plain(self) -> str:
        """The name in small letters and digits alone: `adjclose` of `Adj Close**`."""
        return re.sub(r"[^0-9a-zäöüßéèáíóú]+", "", self.name.lower())


Columns = Sequence[Column]
"""The columns of a table."""

Head = Sequence[Sequence[Any]]
"""The first rows of a table, a list a column."""


@dataclass(frozen=True)
class Chunk:
    """Some rows of some columns.

    Parameters
    ----------
    cells
        One entry a column asked for, all of the same length.
    first
        The number of the first row as a person counts (a line, a row, a record).
    numbers
        The number of each row where they don't just count on from `first`.
    part
        How much of the file has been read, 0 to 1.
    """

    cells: tuple[Cells, ...]
    first: int
    numbers: Sequence[int] | None = None
    part: float = 1.0

    def __len__(self) -> int:
        return len(self.cells[0])

    def number(self, i: int) -> int:
        """The number of row `i` of this chunk."""
        return self.first + i if self.numbers is None else self.numbers[i]


@dataclass(frozen=True)
class Location:
    """Where a cell stands, and the errors about it: their sentences are made here.

    Parameters
    ----------
    line
        Its number as a person counts.
    column
        The column's header; empty for the whole row.
    word
        What a row is called: `line`, `row`, `record`.
    """

    line: int
    column: str = ""
    word: str = "line"

    def __str__(self) -> str:
        row = f"{self.word} {self.line}"
        return f"{row}, column {shown(self.column)}" if self.column else row

    def error(self, value: object, note: str) -> InputError:
        """Return the error of a value that `note` says what is wrong with."""
        words = f"{self}: {shown(value)} {note}"
        return InputError(words, line=self.line, column=self.column, value=value, note=note)

    def missing(self, note: str) -> InputError:
        """Return the error of a cell that is empty; `note` says what to write."""
        words = f"{self}: is missing; {note}"
        return InputError(words, line=self.line, column=self.column, value="", note=note)

    def fault(self, note: str) -> InputError:
        """Return the error of a whole row that `note` says what is wrong with."""
        return InputError(f"{self}: {note}", line=self.line, column=self.column, note=note)


class Table:
    """A table that can be read as often as needed, some rows at a time.

    Attributes
    ----------
    kind
        What it is: `CSV`, `Parquet`, `JSON`.
    columns
        All columns, in order.
    row_word
        What a row is called in an error line: `line`, `row`, `record`.
    notes
        What a person should know about how it was read.
    """

    kind: str
    columns: tuple[Column, ...]
    row_word: str = "row"
    notes: tuple[str, ...] = ()

    def chunks(self, columns: Sequence[int]) -> Iterator[Chunk]:
        """Read these columns from the beginning; InputError names row and column."""
        raise NotImplementedError


@dataclass(eq=False)
class ColumnTable(Table):
    """A table of which any part can be cut: in memory, or mapped from a file.

    Parameters
    ----------
    rows
        How many it has.
    cut
        Takes the index of a column and the rows from and to; returns its cells.
    """

    kind: str
    columns: tuple[Column, ...]
    rows: int
    cut: Callable[[int, int, int], Cells]
    row_word: str = "row"
    notes: tuple[str, ...] = ()

    def checked(self) -> ColumnTable:
        """Return the table; InputError for one without rows or of too many columns."""
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
    """Refuse a table of more than `MAX_COLUMNS`."""
    if count > MAX_COLUMNS:
        raise InputError(f"{count} columns, more than {MAX_COLUMNS}; keep fewer")


def headers_of(columns: Columns) -> frozenset[str]:
    """Return what columns may be called: headers, and names without a unit, in small letters."""
    return frozenset(word.lower() for c in columns for word in (c.header, c.name) if word)


def split_wish(wish: str, columns: Columns) -> tuple[str, str]:
    """Return the column and the word of `COLUMN:WORD`, "" for none; a header with a colon outranks.

    The word is in small letters, and either may be left out.
    """
    name, colon, word = wish.rpartition(":")
    if not colon or " ".join(wish.split()).lower() in headers_of(columns):
        return wish, ""
    return name.strip(), word.strip().lower()


def column_named(columns: Columns, wanted: str) -> int | None:
    """Return the column a person means: the header itself, then its name, in any case.

    Raises
    ------
    InputError
        The words fit several columns.
    """
    asked = " ".join(wanted.split())
    headers, names = [c.header for c in columns], [c.name for c in columns]
    small = asked.lower()
    rules = (
        (headers, asked),
        (names, asked),
        ([header.lower() for header in headers], small),
        ([name.lower() for name in names], small),
    )
    for words, word in rules:
        found = [i for i, candidate in enumerate(words) if candidate == word]
        if len(found) == 1:
            return found[0]
        if found:
            raise InputError(
                f"{len(found)} columns are called {shown(wanted)}; rename one in the file"
            )
    return None


def listed(columns: Columns, limit: int = 12) -> str:
    """Return the columns' headers for a line to a person."""
    names = [shown(column.header) for column in columns[:limit]]
    more = len(columns) - limit
    return ", ".join(names) + (f" and {more} more" if more > 0 else "")


def first_rows(table: Table, rows: int) -> list[list[Any]]:
    """Return the first `rows` rows (of a wide table fewer, some 30) as one list a column."""
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
    """Return cells as Python values: datetimes stay numpy's, since theirs may not fit Python's."""
    if isinstance(cells, np.ndarray):
        return list(cells) if cells.dtype.kind == "M" else list(cells.tolist())
    return cells


def location(table: Table, chunk: Chunk, column: int) -> Callable[[int], Location]:
    """Return what gives the location of a cell in a column of a chunk, by its index."""
    header, word = table.columns[column].header, table.row_word
    return lambda i: Location(chunk.number(i), header, word)


def single_cells(table: Table, chunk: Chunk, columns: Sequence[int]) -> Chunk:
    """Return a chunk of single values; InputError names row and column of a list or an object."""
    for index, cells in zip(columns, chunk.cells, strict=True):
        for i, cell in enumerate(cells if isinstance(cells, list) else ()):
            if isinstance(cell, list | dict):
                raise location(table, chunk, index)(i).error(cell, "isn't a single value")
    return chunk
