"""Layout of a text table, detected from its first lines: separator, header, units, comments.

Fields are separated by commas, semicolons, tabs, `|` or blanks. There may be lines before the
table, a header, a row of units below it, and comment lines that begin with `#` (the last of which
may be the header). For readers that know the column names, `header_dialect` detects the header.
"""

from __future__ import annotations

import codecs
import contextlib
import csv
import io
import re
from collections import Counter
from collections.abc import Callable, Collection
from dataclasses import dataclass, replace
from functools import lru_cache

from overview_dsp.data.readers.data_file import CONTROL, DataFile
from overview_dsp.data.readers.tables.cells import is_missing, is_number, looks_numeric
from overview_dsp.data.readers.tables.column_names import NAMES
from overview_dsp.data.readers.tables.table import MAX_COLUMNS
from overview_dsp.data.timeline.time_parsing import FORMS, moment
from overview_dsp.public import counted

SEPARATORS = (";", "\t", "|", ",")
"""Separators of fields, in addition to blanks (`None`); first those that numbers never contain."""

COMMENTS = ("#",)
"""Prefixes of comment lines."""

SAMPLE_LINES = 400
"""Number of lines from which the layout is detected."""

_COLUMN_ROWS = 50
_BLANKS_COST = 0.25
_LONGEST_UNIT = 24
_TITLES = 10  # maximum number of rows above the header of a sheet
_SEPARATOR_LINE = re.compile(r'"?sep=.?"?\s*', re.IGNORECASE)  # first line of some spreadsheets
_WIDTH = re.compile(r"\d+[sdn]", re.ASCII)  # column widths and types of an RDB file
_COMMA_OF_TIME = re.compile(
    r"\S*[ T]?\d\d:\d\d:\d\d,\d{3} +[^\d\s]|\[?[\d./-]+, \d\d?:\d\d(:\d\d)?(\s?[AP]M)?( -|\]) ",
    re.A,
)
"""Lines of logs and chats, in which a comma is a part of the time."""
_EVENT_LIST = {"time_s", "kind"}

Rows = list[tuple[int, list[str]]]
"""Line number, from 1, and fields of each row."""


@dataclass(frozen=True)
class Dialect:
    """Layout of a text table.

    `encoding`, `separator`: encoding of the text, and character between fields: one of
    `SEPARATORS`, None for blanks.
    `header`: names of the columns; `column 1` and so on if the file has no header.
    `units`: units from a row below the header, or empty texts.
    `first`: line number of the first row.
    `comments`: prefixes of comment lines.
    `notes`: messages about how the layout was detected.
    """

    encoding: str
    separator: str | None
    header: tuple[str, ...]
    units: tuple[str, ...]
    first: int
    comments: tuple[str, ...]
    notes: tuple[str, ...] = ()


Accepts = Callable[[tuple[str, ...], list[list[str]]], bool]
"""Function that decides whether a table with this header and these first rows is acceptable."""


def encoding_of(source: DataFile) -> str | None:
    """Return the encoding of a text file, detected from its first bytes, None for other files."""
    text = source.head_text
    return None if text is None or CONTROL & set(text) else source.encoding


def head_lines(source: DataFile, encoding: str) -> list[str]:
    """Return the whole lines of the head, without their ends."""
    decoder = io.IncrementalNewlineDecoder(codecs.getincrementaldecoder(encoding)(), True)
    whole = source.size <= len(source.head)
    lines: list[str] = decoder.decode(source.head, final=whole).split("\n")
    return lines if whole else lines[:-1]


def split(lines: list[tuple[int, str]], separator: str | None) -> list[tuple[int, list[str]]]:
    """Return the fields of numbered lines; a row of several lines has the number of the first.

    Lines after a field that is too long are left out.
    """
    if separator is None:
        return [(number, line.split()) for number, line in lines]
    reader = csv.reader(
        (f"{line}\n" for _, line in lines), delimiter=separator, skipinitialspace=separator != "\t"
    )
    rows: list[tuple[int, list[str]]] = []
    begin = 0
    with contextlib.suppress(csv.Error):
        for row in reader:
            rows.append((lines[begin][0], row))
            begin = reader.line_num
    return rows


def header_dialect(text: str, known: Collection[str] = ()) -> Dialect | None:
    """Return the dialect of a text from its header, the first line that is not blank or a comment.

    The separator is the one with the most names in `known`, then the most fields. Names become
    lower case and are trimmed. None if there is no header.
    """
    for number, line in enumerate(io.StringIO(text, newline=""), start=1):
        if line.strip() and not line.startswith(COMMENTS):
            found = [(mark, _names(line, mark)) for mark in (",", ";", "\t", "|")]
            mark, names = max(found, key=lambda f: (sum(n in known for n in f[1]), len(f[1])))
            return Dialect("utf-8", mark, names, ("",) * len(names), number + 1, COMMENTS)
    return None


def _names(line: str, separator: str) -> tuple[str, ...]:
    rows = split([(1, line)], separator)
    return tuple(name.strip().lower() for name in rows[0][1]) if rows else ()


def detect(source: DataFile, accepts: Accepts | None = None) -> Dialect | None:
    """Detect the layout of a text table; None without numbers, or if `accepts` returns False."""
    encoding = None if source.looks_like_json else encoding_of(source)
    if encoding is None:
        return None
    found = _layout(tuple(head_lines(source, encoding)[:SAMPLE_LINES]))
    if found is None:
        return None
    dialect, below, named = found
    # rows without a header must begin with a time or a number
    begins = named or (len(below) > 1 and _has_times(dialect.header[:1], below))
    if accepts is None and not begins:
        return None
    is_table = accepts or (_has_times if source.options.counts else _is_series)
    return replace(dialect, encoding=encoding) if is_table(dialect.header, below) else None


@lru_cache(maxsize=1)  # several formats ask for it
def _layout(head: tuple[str, ...]) -> tuple[Dialect, list[list[str]], bool] | None:
    """Return the layout of these lines, the rows below the header, and whether there is one."""
    lines = [(i, line) for i, line in enumerate(head, 1) if line.strip()]
    if lines and _SEPARATOR_LINE.fullmatch(lines[0][1]):
        del lines[0]
    # if most lines begin with # (a rank, a hash tag), they are rows, and so is a header "#,name"
    ranked = bool(lines) and re.match(r'"?#"?[,;\t|]', lines[0][1]) is not None
    comments = not ranked and 2 * sum(line.startswith(COMMENTS) for _, line in lines) <= len(lines)
    kept = [entry for entry in lines if not (comments and entry[1].startswith(COMMENTS))]
    separation = _separation(kept)
    if separation is None:
        return None
    separator, width = separation
    rows = split(kept, separator)
    begin = _begin(rows, width)
    if begin is None or width > MAX_COLUMNS:
        return None
    begin = _after_titles(rows, begin)
    before = [
        line for i, line in lines if comments and i < rows[begin][0] and line.startswith(COMMENTS)
    ]
    named = split([(0, line.lstrip("#%/").strip()) for line in before[-1:]], separator)
    comment = named[0][1] if named else []
    left = f"{counted(begin, 'line')} before the table (line {rows[begin][0]}) left out"
    notes = [left] * bool(begin)
    header, units, first, note = _header(rows[begin:], comment)
    below = [row for i, row in rows[begin:] if i >= first]
    marks = COMMENTS if comments else ()
    shown = tuple(filter(None, (*notes, note)))
    return Dialect("", separator, header, units, first, marks, shown), below, not note


def _separation(lines: list[tuple[int, str]]) -> tuple[str | None, int] | None:
    """Return separator and usual number of fields, None without lines."""
    best: tuple[float, int, str | None, int] | None = None
    timed = sum(_COMMA_OF_TIME.match(line) is not None for _, line in lines)
    if 0 < 2 * len(lines) <= 3 * timed:
        return None
    for rank, separator in enumerate((*SEPARATORS, None)):
        widths = Counter(len(row) for _, row in split(lines, separator))
        widths.pop(0, None)
        if not widths:
            continue
        width, count = max(widths.items(), key=lambda item: (item[1], item[0]))
        if width < 2 and separator is not None:
            continue
        # blanks rank last: dates, names and units contain them too
        share = round(count / len(lines), 1) - (_BLANKS_COST if separator is None else 0.0)
        if best is None or share > best[0]:
            best = (share, -rank, separator, width)
    if best is None:
        return None
    _, _, separator, width = best
    return ("," if width == 1 else separator), width


def _begin(rows: Rows, width: int) -> int | None:
    """Return the index where several rows of the table's width begin, None without such rows."""
    least = max(min(width, 2), width - 1)  # a header may omit the column of row names
    lengths = [len(row) for _, row in rows]
    for k in range(len(rows)):
        if all(least <= length <= width + 1 for length in lengths[k : k + 3]):
            return k
    return next((k for k, length in enumerate(lengths) if length >= least), None)


def _after_titles(rows: Rows, begin: int) -> int:
    """Return the index of the header, below titles and names of several columns.

    A row above a whole row of names is left out if it has text in the first cell only, two or more
    empty cells, or an empty row below it. Under other rows, those names are units.
    """
    for k in range(begin, min(begin + _TITLES, len(rows) - 1)):
        cells, below = rows[k][1], [row for _, row in rows[k + 1 :]]
        missing, is_last = [*map(is_missing, cells)], all(map(is_missing, below[0]))
        if not any(missing) and not is_last:
            named = not any(is_number(cell) or is_date(cell) for cell in cells)
            return k if named and len(cells) > 1 and _is_header(cells, below) else begin
        if sum(missing) < 2 and not all(missing[1:]) and not is_last:
            return begin
    return begin


def _header(rows: Rows, comment: list[str]) -> tuple[tuple[str, ...], tuple[str, ...], int, str]:
    """Return header, units, line of the first row, and a note."""
    (first, top), below = rows[0], [row for _, row in rows[1:]]
    units: list[str] = []
    note = ""
    if _is_header(top, below):
        header, first = top, first + 1
        if len(below) > 1 and _is_units(below[0], below[1:]):
            units, first, below = below[0], rows[1][0] + 1, below[1:]
            if len(below) > 1 and _is_units(below[0], below[1:]):  # how a logger made each value
                first, below = rows[2][0] + 1, below[1:]
        elif len(below) > 1 and all(_WIDTH.fullmatch(cell.strip()) for cell in below[0]):
            first, below = rows[1][0] + 1, below[1:]
    else:
        below = [top, *below]
        header = comment
        if len(comment) != len(top):
            header = [f"column {i}" for i in range(1, len(top) + 1)]
            note = "the file has no header: columns are called column 1, column 2 ..."
    named = bool(below) and all(len(row) == len(header) + 1 for row in below)
    if named and any(row[-1].strip() for row in below):
        # rows begin with a name that the header omits
        header, units = ["", *header], ["", *units] if units else []
    if len(header) > 1 and not header[-1].strip() and not _fields(below, len(header) - 1, 1):
        header = header[:-1]  # every line ends with a separator
    units = (units + [""] * len(header))[: len(header)]
    return _stripped(header), _stripped(units), first, note


def _stripped(cells: list[str]) -> tuple[str, ...]:
    return tuple(cell.strip() for cell in cells)


def _fields(rows: list[list[str]], i: int, most: int = _COLUMN_ROWS) -> list[str]:
    """Return the first fields of a column that have a value."""
    found = [row[i].strip() for row in rows[:_COLUMN_ROWS] if i < len(row)]
    return [cell for cell in found if not is_missing(cell)][:most]


def is_date(cell: str) -> bool:
    """Return whether a cell is a date, and not only digits."""
    return moment(cell.strip(), *FORMS) is not None and not cell.isdigit()


def _is_header(top: list[str], below: list[list[str]]) -> bool:
    """Return whether a row is a header: it differs from the rows below it.

    Columns of dates decide, else columns of numbers: most of them have another type in this row.
    """
    dates, numbers = [], []
    years = [int(cell) for cell in top if re.fullmatch(r"\s*(1[89]|20)\d\d\s*", cell, re.A)]
    whole = 1 < len(years) == sum(map(is_number, top)) < len(top)
    if whole and years == [*range(years[0], years[0] + len(years))]:
        return not any(is_date(cell) for cell in top)  # a column for each year
    for i, cell in enumerate(map(str.strip, top)):
        fields = _fields(below, i)
        dated = [is_date(field) for field in fields]
        if 3 * sum(dated) >= 2 * len(dated) > 0:
            dates.append(not is_date(cell))
        elif looks_numeric(fields) and not is_missing(cell):
            numbers.append(not is_number(cell))
    for unlike in (dates, numbers):
        if unlike:
            return 2 * sum(unlike) > len(unlike)
    return not any(is_number(cell) or is_date(cell) for cell in map(str.strip, top))


def _is_units(cells: list[str], below: list[list[str]]) -> bool:
    """Return whether the row below the header has units: no numbers in columns of numbers."""
    texts = [
        cell.strip()
        for i, cell in enumerate(cells)
        if looks_numeric(_fields(below, i)) or any(map(is_date, _fields(below, i, 1)))
    ]
    return (
        any(not is_missing(text) for text in texts)
        and not any(is_number(text) or is_date(text) for text in texts)
        and all(len(text) <= _LONGEST_UNIT for text in texts)
    )


def _is_series(header: tuple[str, ...], below: list[list[str]]) -> bool:
    """Return whether a table may be a series: it has numbers, or times and no value yet."""
    names = [name.lower() for name in header]
    if set(names) >= _EVENT_LIST:
        return False
    columns = [_fields(below, i) for i in range(len(header))]
    if any(looks_numeric(column) for column in columns):
        return True
    named = any(word in name for name in names for word in NAMES["time_header_parts"])
    return named and any(not column for column in columns)


def _has_times(header: tuple[str, ...], below: list[list[str]]) -> bool:
    """Return whether there is a column of dates or numbers, by which rows can be counted."""
    columns = [_fields(below, i) for i in range(len(header))]
    return any(looks_numeric(column) or any(map(is_date, column)) for column in columns)
