"""Text with separated fields as a table, streamed: the file's size doesn't matter.

Most tables are plain: no quotes, no blank lines, one width. Their fields are found in a block at a
time, and only the columns that are asked for become text cells. From the first block on that isn't
plain, rows are read line by line.
"""

from __future__ import annotations

import codecs
import contextlib
import csv
import io
import itertools
from collections import Counter
from collections.abc import Generator, Iterator, Sequence
from dataclasses import dataclass, field
from operator import itemgetter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from overview_dsp.arrays import IntArray
from overview_dsp.data.readers.data_file import DataFile
from overview_dsp.data.readers.tables.dialect import COMMENTS, Dialect, detect, header_dialect
from overview_dsp.data.readers.tables.table import (
    CHUNK_CELLS,
    CHUNK_ROWS,
    MAX_COLUMNS,
    CellLocation,
    Chunk,
    Column,
    Table,
)
from overview_dsp.data.readers.tables.text_cells import PAD, TextCells, padded
from overview_dsp.errors import InputError

BLOCK_BYTES = 1 << 20
"""Bytes read at a time."""

MAX_RECORDS = 200_000
"""Maximum number of rows of a list: about a hundred matches."""

MAX_LINE = 1 << 20
"""Maximum length of a line, in characters."""

_UTF8 = "utf-8"

LONGEST_FIELD = 131_072
"""Maximum length of a field, in characters, as in Python's csv module."""

_NEWLINE = 10


def sniff(source: DataFile) -> bool:
    """Return whether the file is text with a table that has a column of numbers."""
    return detect(source) is not None


def open_table(source: DataFile) -> DelimitedTable:
    """Return the file's table.

    InputError: no rows below the header.
    """
    dialect = detect(source)
    assert dialect is not None  # `sniff` has returned True
    table = DelimitedTable(source, dialect)
    if not any(len(chunk) for chunk in table.chunks([0])):
        raise InputError(
            f"no rows below the header (line {dialect.first - 1}); add one row for each time"
        )
    return table


def records(text: str) -> Iterator[tuple[int, dict[str, str]]]:
    """Yield (line, {column: field}) for each row below a header, with lower-case names.

    InputError: no header, a column named twice, more fields than columns, broken quotes, too many
    rows.
    """
    dialect = header_dialect(text)
    if dialect is None:
        raise InputError("no header; the first row names the columns")
    if len(dialect.header) > MAX_COLUMNS:
        raise InputError(f"{len(dialect.header)} columns in the header, more than {MAX_COLUMNS}")
    named = Counter(name for name in dialect.header if name)
    twice = next((name for name, count in named.items() if count > 1), None)
    if twice is not None:
        raise InputError(f"the header names the column '{twice}' twice; rename one")
    for count, (line, fields) in enumerate(DelimitedTable(text, dialect).records(), start=1):
        if count > MAX_RECORDS:
            raise CellLocation(line).fault(
                f"more than {MAX_RECORDS} rows; keep those of one match or season"
            )
        yield line, fields


class DelimitedTable(Table):
    """A file or a text with a table, streamed."""

    kind = "CSV"
    row_word = "line"

    def __init__(self, source: DataFile | str, dialect: Dialect) -> None:
        self._source, self._dialect = source, dialect
        self.columns = tuple(
            Column.of(name, unit) for name, unit in zip(dialect.header, dialect.units, strict=True)
        )
        self.notes = dialect.notes
        if isinstance(source, DataFile) and source.sheets:
            self.kind, self.row_word = "spreadsheet", "row"
            self.sheets, self.sheet = source.sheets, source.sheet
        self.separator = dialect.separator
        self.comments: dict[int, str] = {}
        """Comment lines read so far, by their number."""

    def chunks(self, columns: Sequence[int]) -> Iterator[Chunk]:
        """Read these columns; InputError names a row with too many fields, or a broken quote."""
        rest = yield from self._plain(columns)
        if rest is not None:
            yield from self._rows(columns, rest)

    def records(self) -> Iterator[tuple[int, dict[str, str]]]:
        """Yield the line of each row and its trimmed fields, by the names of their columns.

        Rows are read one by one, so that an error further down is raised only when reached.
        """
        names = self._dialect.header
        for chunk in self._rows(range(len(names)), self._dialect.first, 1):
            fields = ((cells[0] or "").strip() for cells in chunk.cells)
            yield chunk.number(0), {n: f for n, f in zip(names, fields, strict=True) if n}

    def _plain(self, columns: Sequence[int]) -> Generator[Chunk, None, int | None]:
        """Read blocks without quotes or comments; return the line of the first other block."""
        dialect, width = self._dialect, len(self._dialect.header)
        separator = dialect.separator
        if separator is None:
            return dialect.first
        lines = Lines(self._source, dialect.encoding)
        first, above = dialect.first, dialect.first - 1
        for block in lines.blocks():
            while above and block:
                head, _, block = block.partition(b"\n")
                if (line := as_text(head)).startswith(COMMENTS):
                    self.comments[dialect.first - above] = line
                above -= 1
            if not block:
                continue
            found = field_ends(block, separator, width, dialect.comments)
            if found is None:
                return first
            cells = [_column(*found, width, i) for i in columns]
            for begin in range(0, len(cells[0]), CHUNK_ROWS):
                some = tuple(column[begin : begin + CHUNK_ROWS] for column in cells)
                yield Chunk(some, first, None, lines.part)
                first += len(some[0])
        return None

    def _rows(self, columns: Sequence[int], begin: int, block: int = 0) -> Iterator[Chunk]:
        """Read all lines from line `begin` on, with the csv module."""
        dialect, width = self._dialect, len(self._dialect.header)
        lines = Lines(
            self._source, dialect.encoding, dialect.comments, dialect.first - 1, found=self.comments
        )
        block = block or min(CHUNK_ROWS, max(CHUNK_CELLS // width, 1))
        for first, numbers, rows in _row_blocks(lines, dialect.separator, block):
            if first < begin:
                skip = begin - first if numbers is None else sum(n < begin for n in numbers)
                rows = rows[skip:]
                first, numbers = first + skip, numbers[skip:] if numbers else None
            lengths = set(map(len, rows))
            if lengths and lengths != {width}:
                first, numbers, rows = self._tidied(first, numbers, rows)
            if not rows:
                continue
            cells: tuple[Any, ...] = tuple(list(map(itemgetter(i), rows)) for i in columns)
            yield Chunk(cells, first, numbers, lines.part)

    def _tidied(
        self, first: int, numbers: list[int] | None, rows: list[list[Any]]
    ) -> tuple[int, list[int], list[list[Any]]]:
        """Drop blank rows, fill short rows, raise InputError for rows with too many fields."""
        width = len(self._dialect.header)
        kept, lines = [], []
        for i, row in enumerate(rows):
            line = numbers[i] if numbers is not None else first + i
            if not any(cell.strip() for cell in row):
                continue
            if any(cell.strip() for cell in row[width:]):
                raise CellLocation(line).fault(
                    f"{len(row)} fields for {width} columns; put quotes around a field that "
                    "holds the separator"
                )
            kept.append([*row[:width], *[None] * (width - len(row))])
            lines.append(line)
        return first, lines, kept


@dataclass
class Lines:
    """Iterator over the lines of a file or a text, with their line ends.

    Line ends of a file become "\\n", those of a text are kept. Comment lines outside of quoted
    fields become blank, and so do the first `above` lines. Invalid bytes in a UTF-8 file become
    lone surrogates, so that they are errors only in cells that are used.
    """

    source: DataFile | str
    encoding: str = _UTF8
    comments: tuple[str, ...] = ()
    above: int = 0
    part: float = 0.0
    found: dict[int, str] = field(default_factory=dict)
    """Comment lines by their number."""

    def __iter__(self) -> Iterator[str]:
        number, quotes = 0, 0
        for block in map(as_text, self.blocks()):
            if number >= self.above and not _has_comment(block, self.comments):
                number += _line_ends(block)
                quotes += block.count('"')
                yield from io.StringIO(block, newline="")
                continue
            for line in io.StringIO(block, newline=""):
                number += 1
                marks = COMMENTS if number <= self.above else self.comments
                comment = line.startswith(marks) and not quotes % 2
                if comment:
                    self.found[number] = line
                if comment or number <= self.above:
                    line = "\n"
                quotes += line.count('"')
                yield line

    def blocks(self) -> Iterator[bytes]:
        """Yield blocks of whole lines, with comments, for `as_text`.

        InputError: a line that is too long.
        """
        if isinstance(self.source, str):
            self.part = 1.0
            yield _encoded(self.source)
            return
        is_plain = self.encoding.startswith(_UTF8)
        errors = "surrogateescape" if is_plain else "replace"
        decoder = codecs.getincrementaldecoder(self.encoding)(errors)
        newlines = io.IncrementalNewlineDecoder(decoder, True)
        rest, seen = b"", 0
        for number, data in enumerate(self._data()):
            seen += len(data)
            # ASCII with these line ends needs no decoding
            is_plain = is_plain and data.isascii() and b"\r" not in data
            text = rest + (data if is_plain else _encoded(newlines.decode(data, final=not data)))
            cut = text.rfind(b"\n") + 1 if data else len(text)
            block, rest = text[:cut], text[cut:]
            if len(rest) > MAX_LINE and len(as_text(rest)) > MAX_LINE:
                before = itertools.islice(Lines(self.source, self.encoding).blocks(), number)
                line = 1 + sum(block.count(b"\n") for block in (*before, block))
                raise InputError(
                    f"line {line} is longer than {MAX_LINE} characters; a table has one "
                    "line per row: save it as CSV"
                )
            self.part = min(1.0, seen / max(1, self.source.size))
            yield block

    def _data(self) -> Iterator[bytes]:
        """Yield the bytes of the file in blocks, then an empty block."""
        assert not isinstance(self.source, str)
        try:
            with open(self.source.path, "rb") as stream:
                yield from iter(lambda: stream.read(BLOCK_BYTES), b"")
        except OSError as error:
            raise InputError(f"can't be read ({error.strerror})") from error
        yield b""


def as_text(block: bytes) -> str:
    """Return a block of `Lines` as text."""
    return block.decode(_UTF8, "surrogatepass")


def _encoded(text: str) -> bytes:
    return text.encode(_UTF8, "surrogatepass")


def _row_blocks(
    lines: Lines, separator: str | None, block: int
) -> Iterator[tuple[int, list[int] | None, list[list[Any]]]]:
    """Yield blocks of rows: (line of the first row, line numbers or None, rows).

    Line numbers are None if each row is one line. Blank lines are empty rows.
    """
    first = 1
    if separator is None:
        words = map(str.split, lines)
        while rows := list(itertools.islice(words, block)):
            yield first, None, rows
            first += len(rows)
        return
    options: Any = {"delimiter": separator, "strict": True, "skipinitialspace": separator != "\t"}
    reader = csv.reader(lines, **options)
    while True:
        try:
            rows = list(itertools.islice(reader, block))
        except csv.Error as error:
            broken = CellLocation(_broken_row(csv.reader(lines, **options)))
            raise broken.fault(f"{error}; check the quotes from there on") from error
        if not rows:
            return
        numbers = None
        if reader.line_num - first + 1 != len(rows):
            heights = (1 + sum(map(_line_ends, row)) for row in rows[:-1])
            numbers = list(itertools.accumulate(heights, initial=first))
        yield first, numbers, rows
        first = reader.line_num + 1


def _broken_row(reader: Any) -> int:
    """Read again, row by row, and return the line where the broken row begins."""
    first = 1
    with contextlib.suppress(csv.Error):
        for _ in reader:
            first = reader.line_num + 1
    return first


def _has_comment(block: str, marks: tuple[str, ...]) -> bool:
    return any(block.startswith(m) or f"\n{m}" in block or f"\r{m}" in block for m in marks)


def _line_ends(text: str) -> int:
    return text.count("\n") + text.count("\r") - text.count("\r\n")


def field_ends(
    block: bytes, separator: str, width: int, comments: tuple[str, ...] = ()
) -> tuple[NDArray[np.uint8], IntArray] | None:
    """Return a buffer, and the ends of all fields in it; None if a block isn't plain.

    `block`: whole lines.
    `separator`: character between fields.
    `width`: number of fields per line.
    `comments`: prefixes of comment lines.
    """
    if b'"' in block or b"\r" in block or not block.isascii():
        return None
    data = padded(block if block.endswith(b"\n") else block + b"\n")
    ends = data == _NEWLINE
    marks = np.flatnonzero(ends | (data == ord(separator)))
    rows, left = divmod(len(marks), width)
    lines = marks[width - 1 :: width]
    if not rows or left or np.count_nonzero(ends) != rows or not ends[lines].all():
        return None
    length = np.diff(lines, prepend=PAD - 1)
    if width == 1 and length.min() == 1:
        return None
    if length.max() > LONGEST_FIELD and np.diff(marks, prepend=PAD - 1).max() > LONGEST_FIELD:
        return None
    others = {mark[0].encode(): lines for mark in comments}
    if separator != "\t":
        others[b" "] = marks  # blanks before a field don't belong to it
    found = (mark in block and (data[some + 1] == ord(mark)).any() for mark, some in others.items())
    return None if block[:1] in (b" ", b"#", *others) or any(found) else (data, marks)


def _column(data: NDArray[np.uint8], marks: IntArray, width: int, i: int) -> TextCells:
    """Return the cells of a column in a block whose fields end at `marks`."""
    starts = marks[i - 1 :: width] + 1 if i else np.append(PAD, marks[width - 1 : -1 : width] + 1)
    return TextCells(data, starts, marks[i::width].copy())
