"""CSV, TSV and their relatives as a table.

Separated by commas, semicolons, tabs, bars or blanks; UTF-8, UTF-16/32 with a mark, or
Windows-1252; with or without a header, a row of units below it, lines before it, and comment lines
that begin with `#`. The file is streamed: its size doesn't matter.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from operator import itemgetter
from typing import Any

from overview_dsp.errors import InputError
from overview_dsp.timeline.series import delimited
from overview_dsp.timeline.series.missing import is_missing
from overview_dsp.timeline.series.moments import WAYS
from overview_dsp.timeline.series.numbers import looks_numeric
from overview_dsp.timeline.series.table import CHUNK_ROWS, MAX_COLUMNS, Chunk, Column
from overview_dsp.timeline.source import Source

SAMPLE_LINES = 400
"""Lines of the head that tell the layout."""

_TIME_HEADERS = ("date", "time", "timestamp", "datetime", "datum", "year")
_EVENT_LIST = {"time_s", "kind"}


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


def layout_of(source: Source) -> Layout | None:
    """Tell how a file holds a table by its head; None if it is no table of numbers."""
    if source.looks_like_json:
        return None
    encoding = delimited.encoding_of(source)
    if encoding is None:
        return None
    lines = delimited.head_lines(source, encoding)[:SAMPLE_LINES]
    numbered = [(i, line) for i, line in enumerate(lines, 1) if line.strip()]
    comments = True
    if numbered and numbered[0][1].startswith("#"):
        numbered, commented = _without_comments(numbered)
    else:
        commented = None
        comments = not (numbered and _hash_rows(numbered))
        numbered = [entry for entry in numbered if not (comments and entry[1].startswith("#"))]
    if not numbered:
        return None
    best: tuple[float, int, str | None, int] | None = None
    for rank, separator in enumerate((*delimited.SEPARATORS, None)):
        widths = Counter(len(delimited.split(line, separator)) for _, line in numbered)
        widths.pop(0, None)
        if not widths:
            continue
        width, count = max(widths.items(), key=lambda item: (item[1], item[0]))
        if width < 2 and separator is not None:
            continue
        # blanks last: dates, names and units hold them too
        share = round(count / len(numbered), 1) - (0.25 if separator is None else 0.0)
        if best is None or share > best[0]:
            best = (share, -rank, separator, width)
    if best is None:
        return None
    _, _, separator, width = best
    if width == 1:
        separator = ","
    return _found(encoding, separator, width, numbered, comments, commented)


def _without_comments(
    numbered: list[tuple[int, str]],
) -> tuple[list[tuple[int, str]], str | None]:
    """Drop comment lines; the last one before the rows may be the header."""
    rows = [entry for entry in numbered if not entry[1].startswith("#")]
    if not rows:
        return rows, None
    before = [line for i, line in numbered if i < rows[0][0]]
    return rows, before[-1].lstrip("#").strip() if before else None


def _hash_rows(numbered: list[tuple[int, str]]) -> bool:
    """Tell whether lines that begin with # are rows: most of them are such."""
    marked = sum(line.startswith("#") for _, line in numbered[1:])
    return marked * 2 > len(numbered)


def _found(
    encoding: str,
    separator: str | None,
    width: int,
    numbered: list[tuple[int, str]],
    comments: bool,
    commented: str | None,
) -> Layout | None:
    rows = [(i, delimited.split(line, separator)) for i, line in numbered]
    wide = [k for k, (_, row) in enumerate(rows) if len(row) >= max(1, width - 1)]
    if not wide or width > MAX_COLUMNS:
        return None
    # the table begins where rows of its width follow each other to the end of the sample
    begin = wide[0]
    for k in wide:
        after = rows[k : k + 3]
        if all(len(row) >= max(1, width - 1) for _, row in after) and len(rows[k][1]) > 0:
            near = [len(row) for _, row in after]
            if max(near) <= width + 1:
                begin = k
                break
    first_line, top = rows[begin]
    below = [row for _, row in rows[begin + 1 :]]
    notes = []
    if begin:
        notes.append(f"{begin} lines before the table (line {first_line}) were left out")
    if encoding == "cp1252":
        notes.append("the file isn't UTF-8; read as Windows-1252")
    units: list[str] = []
    start = first_line
    if _is_header(top):
        header, start = [cell.strip() for cell in top], first_line + 1
        if below and len(below) > 1 and _is_units(below[0], below[1:]):
            units = [cell.strip() for cell in below[0]]
            start = rows[begin + 1][0] + 1
            below = below[1:]
    else:
        below = [top, *below]
        named = delimited.split(commented, separator) if commented else []
        if len(named) == len(top):
            header = [cell.strip() for cell in named]
        else:
            header = [f"column {i}" for i in range(1, len(top) + 1)]
            notes.append("the file has no header: columns are called column 1, column 2 ...")
    if (
        below
        and all(len(row) == len(header) + 1 for row in below)
        and any(row[-1].strip() for row in below)
    ):
        header = ["", *header]  # rows carry a name that the header doesn't count
        units = ["", *units] if units else []
    if header and not header[-1] and not any(row[len(header) - 1 :] != [""] for row in below):
        header = header[:-1]  # every line ends with a separator
    names = [name.lower() for name in header]
    if set(names) >= _EVENT_LIST:
        return None
    if not below:
        if not any(word in name for name in names for word in _TIME_HEADERS):
            return None
    else:
        columns = [[row[i] for row in below[:50] if i < len(row)] for i in range(len(header))]
        if not any(looks_numeric(column) for column in columns):
            return None
        if len(header) == 1 and len(below) < 2:
            return None  # a lone number
    units = (units + [""] * len(header))[: len(header)]
    if len(header) > MAX_COLUMNS:
        return None
    return Layout(encoding, separator, tuple(header), tuple(units), start, comments, tuple(notes))


def _is_header(cells: list[str]) -> bool:
    """Tell whether a row names columns: some text, and neither numbers nor dates."""
    known = [cell.strip() for cell in cells if not is_missing(cell)]
    if not known:
        return False
    return not any(
        looks_numeric([cell]) or any(way(cell) is not None for way in WAYS.values())
        for cell in known
    )


def _is_units(cells: list[str], below: list[list[str]]) -> bool:
    """Tell whether the row under the header holds units: no number where all below are."""
    numeric = [
        i
        for i in range(len(cells))
        if looks_numeric([row[i] for row in below[:50] if i < len(row)])
    ]
    texts = [cells[i].strip() for i in numeric]
    return (
        bool(texts)
        and not any(looks_numeric([text]) for text in texts)
        and not all(is_missing(text) for text in texts)
        and all(len(text) <= 24 for text in texts)
        and _is_header(cells)
    )


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
