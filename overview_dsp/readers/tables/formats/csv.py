"""CSV, TSV and their relatives as a table, streamed: the file's size doesn't matter.

The layout is detected from the file's head. Fields are separated by commas, semicolons, tabs, bars
or blanks. There may be lines before the table, a header, a row of units below it, and comment lines
that begin with `#` (the last of which may be the header).
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Generator, Iterator, Sequence
from dataclasses import dataclass
from operator import itemgetter
from typing import Any

from overview_dsp.errors import InputError
from overview_dsp.readers.source import Source
from overview_dsp.readers.tables.cells import is_missing, is_number, looks_numeric
from overview_dsp.readers.tables.formats import delimited, plain_lines
from overview_dsp.readers.tables.table import (
    CHUNK_CELLS,
    CHUNK_ROWS,
    MAX_COLUMNS,
    Chunk,
    Column,
)
from overview_dsp.timeline.times import FORMS, moment


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
        rest = yield from self._plain(columns)
        if rest is not None:
            yield from self._rows(columns, rest)

    def _plain(self, columns: Sequence[int]) -> Generator[Chunk, None, int | None]:
        """Read plain blocks of lines; return the line where the first begins that isn't."""
        layout, width = self._layout, len(self._layout.header)
        separator = layout.separator
        if separator is None:
            return layout.first
        lines = delimited.Lines(self._source, layout.encoding, layout.comments)
        first = layout.first
        above = first - 1
        for block in lines.blocks():
            while above and block:
                block = block.partition("\n")[2]
                above -= 1
            if not block:
                continue
            whole = block if block.endswith("\n") else block + "\n"
            marks = plain_lines.marks_of(whole, separator, width, layout.comments)
            if marks is None:
                return first
            cells = plain_lines.cells_of(whole, marks, separator, width, columns)
            for begin in range(0, len(cells[0]), CHUNK_ROWS):
                some = tuple(column[begin : begin + CHUNK_ROWS] for column in cells)
                yield Chunk(some, first, None, lines.part)
                first += len(some[0])
        return None

    def _rows(self, columns: Sequence[int], begin: int) -> Iterator[Chunk]:
        """Read whatever lines there are from line `begin` on."""
        layout = self._layout
        lines = delimited.Lines(self._source, layout.encoding, layout.comments)
        width = len(layout.header)
        block = min(CHUNK_ROWS, max(CHUNK_CELLS // width, 1))
        for first, numbers, rows in delimited.Rows(lines, layout.separator, block):
            if first < begin:
                skip = self._skipped(begin, first, numbers, rows)
                rows = rows[skip:]
                first, numbers = first + skip, numbers[skip:] if numbers else None
            lengths = set(map(len, rows))
            if lengths and lengths != {width}:
                first, numbers, rows = self._tidied(first, numbers, rows)
            if not rows:
                continue
            cells: tuple[Any, ...] = tuple(list(map(itemgetter(i), rows)) for i in columns)
            yield Chunk(cells, first, numbers, lines.part)

    def _skipped(
        self, begin: int, first: int, numbers: list[int] | None, rows: list[list[str]]
    ) -> int:
        """How many rows lie before line `begin`."""
        if numbers is None:
            return min(len(rows), begin - first)
        return sum(number < begin for number in numbers)

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
    """Return whether the file is text with a table that has a column of numbers."""
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


SAMPLE_LINES = 400
"""Lines of the head from which the layout is detected."""

_COLUMN_ROWS = 50
_BLANKS_COST = 0.25
_LONGEST_UNIT = 24
_TIME_HEADERS = ("date", "time", "datum", "zeit", "year", "fecha")
_SEPARATOR_LINE = re.compile(r'"?sep=.?"?\s*', re.IGNORECASE)  # what spreadsheets begin with
_WIDTH = re.compile(r"\d+[sdn]", re.ASCII)  # what a field of an RDB file may hold
_EVENT_LIST = {"time_s", "kind"}

Rows = list[tuple[int, list[str]]]
"""Line numbers from 1, and the fields of each."""


@dataclass(frozen=True)
class Layout:
    """How a text file holds a table.

    Parameters
    ----------
    encoding, separator
        As `delimited` takes them.
    header
        The header's fields; made up (`column 1`) where the file has none.
    units
        What a row of units below the header says, or empty texts.
    first
        The line of the first row.
    comments
        Lines that begin with `#` are comments.
    notes
        What a person should know.
    """

    encoding: str
    separator: str | None
    header: tuple[str, ...]
    units: tuple[str, ...]
    first: int
    comments: bool
    notes: tuple[str, ...] = ()


Accepts = Callable[[tuple[str, ...], list[list[str]]], bool]
"""Whether a table with this header and these first rows is the one that is looked for."""


def layout_of(source: Source, accepts: Accepts | None = None) -> Layout | None:
    """Detect how a file holds a table; None if it is no table of numbers (or that `accepts`)."""
    if source.looks_like_json:
        return None
    encoding = delimited.encoding_of(source)
    if encoding is None:
        return None
    head = delimited.head_lines(source, encoding)[:SAMPLE_LINES]
    lines = [(i, line) for i, line in enumerate(head, 1) if line.strip()]
    if lines and _SEPARATOR_LINE.fullmatch(lines[0][1]):
        del lines[0]
    # where most lines begin with # (rank, hash tags), they are rows, and so is a header "#,name"
    ranked = bool(lines) and re.match(r'"?#"?[,;\t|]', lines[0][1]) is not None
    comments = not ranked and 2 * sum(line.startswith("#") for _, line in lines) <= len(lines)
    kept = [entry for entry in lines if not (comments and entry[1].startswith("#"))]
    separation = _separation(kept)
    if separation is None:
        return None
    separator, width = separation
    rows = delimited.split(kept, separator)
    begin = _begin(rows, width)
    if begin is None or width > MAX_COLUMNS:
        return None
    before = [line for i, line in lines if comments and i < rows[begin][0] and line[0] == "#"]
    named = delimited.split([(0, line.lstrip("#").strip()) for line in before[-1:]], separator)
    commented = named[0][1] if named else []
    notes = [f"{begin} lines before the table (line {rows[begin][0]}) were left out"] * bool(begin)
    header, units, first, note = _header(rows[begin:], commented)
    below = [row for i, row in rows[begin:] if i >= first]
    if accepts is None and note and not _is_bare(below):
        return None
    claims = accepts or (_has_times if source.options.counts else _is_series)
    if not claims(header, below):
        return None
    return Layout(
        encoding, separator, header, units, first, comments, tuple(filter(None, (*notes, note)))
    )


def _separation(lines: list[tuple[int, str]]) -> tuple[str | None, int] | None:
    """Detect the separator and how many fields most lines have; None if there are no lines."""
    best: tuple[float, int, str | None, int] | None = None
    for rank, separator in enumerate((*delimited.SEPARATORS, None)):
        widths = Counter(len(row) for _, row in delimited.split(lines, separator))
        widths.pop(0, None)
        if not widths:
            continue
        width, count = max(widths.items(), key=lambda item: (item[1], item[0]))
        if width < 2 and separator is not None:
            continue
        # blanks come last: dates, names and units hold them too
        share = round(count / len(lines), 1) - (_BLANKS_COST if separator is None else 0.0)
        if best is None or share > best[0]:
            best = (share, -rank, separator, width)
    if best is None:
        return None
    _, _, separator, width = best
    return ("," if width == 1 else separator), width


def _begin(rows: Rows, width: int) -> int | None:
    """Return where the table begins: where rows of its width follow each other."""
    least = max(min(width, 2), width - 1)  # a header may leave the rows' names out
    lengths = [len(row) for _, row in rows]
    for k in range(len(rows)):
        if all(least <= length <= width + 1 for length in lengths[k : k + 3]):
            return k
    return next((k for k, length in enumerate(lengths) if length >= least), None)


def _header(rows: Rows, commented: list[str]) -> tuple[tuple[str, ...], tuple[str, ...], int, str]:
    """Return the header's fields, units, the line of the first row, and a note."""
    (first, top), below = rows[0], [row for _, row in rows[1:]]
    units: list[str] = []
    note = ""
    if _is_header(top, below):
        header, first = top, first + 1
        if len(below) > 1 and _is_units(below[0], below[1:]):
            units, first, below = below[0], rows[1][0] + 1, below[1:]
        elif len(below) > 1 and all(_WIDTH.fullmatch(cell.strip()) for cell in below[0]):
            first, below = rows[1][0] + 1, below[1:]
    else:
        below = [top, *below]
        header = commented
        if len(commented) != len(top):
            header = [f"column {i}" for i in range(1, len(top) + 1)]
            note = "the file has no header: columns are called column 1, column 2 ..."
    named = bool(below) and all(len(row) == len(header) + 1 for row in below)
    if named and any(row[-1].strip() for row in below):
        # rows begin with a name that the header doesn't count
        header, units = ["", *header], ["", *units] if units else []
    if len(header) > 1 and not header[-1].strip() and not _fields(below, len(header) - 1, 1):
        header = header[:-1]  # every line ends with a separator
    units = (units + [""] * len(header))[: len(header)]
    return _stripped(header), _stripped(units), first, note


def _stripped(cells: list[str]) -> tuple[str, ...]:
    return tuple(cell.strip() for cell in cells)


def _fields(rows: list[list[str]], i: int, most: int = _COLUMN_ROWS) -> list[str]:
    """A column's first fields that hold a value."""
    found = [row[i].strip() for row in rows[:_COLUMN_ROWS] if i < len(row)]
    return [cell for cell in found if not is_missing(cell)][:most]


def _is_date(cell: str) -> bool:
    return moment(cell, *FORMS) is not None and not cell.isdigit()


def _is_header(top: list[str], below: list[list[str]]) -> bool:
    """Return whether a row names columns: it is unlike those below it.

    Columns of dates decide, else those of numbers: most of them begin with another thing.
    """
    dates, numbers = [], []
    for i, cell in enumerate(map(str.strip, top)):
        fields = _fields(below, i)
        dated = [_is_date(field) for field in fields]
        if 3 * sum(dated) >= 2 * len(dated) > 0:
            dates.append(not _is_date(cell))
        elif looks_numeric(fields) and not is_missing(cell):
            numbers.append(not is_number(cell))
    for unlike in (dates, numbers):
        if unlike:
            return 2 * sum(unlike) > len(unlike)
    return not any(is_number(cell) or _is_date(cell) for cell in map(str.strip, top))


def _is_units(cells: list[str], below: list[list[str]]) -> bool:
    """Return whether the row under the header holds units: no number where those below are."""
    texts = [
        cell.strip()
        for i, cell in enumerate(cells)
        if looks_numeric(_fields(below, i)) or any(map(_is_date, _fields(below, i, 1)))
    ]
    return (
        any(not is_missing(text) for text in texts)
        and not any(is_number(text) or _is_date(text) for text in texts)
        and all(len(text) <= _LONGEST_UNIT for text in texts)
    )


def _is_series(header: tuple[str, ...], below: list[list[str]]) -> bool:
    """Return whether a table may be a series: it has numbers, or times without any value yet."""
    names = [name.lower() for name in header]
    if set(names) >= _EVENT_LIST:
        return False
    columns = [_fields(below, i) for i in range(len(header))]
    if any(looks_numeric(column) for column in columns):
        return True
    named = any(word in name for name in names for word in _TIME_HEADERS)
    return named and any(not column for column in columns)


def _has_times(header: tuple[str, ...], below: list[list[str]]) -> bool:
    """Return whether rows may be counted by their times: a column of dates or numbers."""
    columns = [_fields(below, i) for i in range(len(header))]
    return any(looks_numeric(column) or any(map(_is_date, column)) for column in columns)


def _is_bare(rows: list[list[str]]) -> bool:
    """Return whether rows without a header are samples: two or more, of a time or number first."""
    first = _fields(rows, 0)
    return len(rows) > 1 and (looks_numeric(first) or any(map(_is_date, first)))
