"""A table as text: a header and rows, each with its line number."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator

from overview_dsp.errors import InputError

DELIMITERS = (",", ";", "\t", "|")
MAX_ROWS = 200_000
"""Most rows that are read: a hundred times those of a match."""

MAX_COLUMNS = 1000
"""Most columns of a table that is read."""


def header_of(text: str) -> tuple[list[str], str] | None:
    """Return the names of the columns (small letters, blanks trimmed) and the separator.

    The header is the first line that isn't blank; None if there is none. The separator is the one
    that splits it into most fields.
    """
    for line in io.StringIO(text, newline=""):
        if line.strip() and not line.startswith("#"):
            found = [(split(line, mark), mark) for mark in DELIMITERS]
            return max(found, key=lambda entry: len(entry[0]))
    return None


def split(line: str, delimiter: str) -> list[str]:
    """Return the fields of one line, in small letters and trimmed; none if it can't be split."""
    try:
        row = next(csv.reader([line], delimiter=delimiter), [])
    except csv.Error:  # a line of more than 131072 characters
        return []
    return [name.strip().lower() for name in row]


def rows(text: str) -> Iterator[tuple[int, dict[str, str]]]:
    """Yield (line number, {column: field, trimmed}) of each row below the header.

    Blank lines and, before the header, lines that begin with `#` are skipped; missing fields at
    the end of a row are empty.

    Raises
    ------
    InputError
        No header, a column named twice, more fields than columns, broken quotes, too many rows.
    """
    found = header_of(text)
    if found is None:
        raise InputError("no header; the first row names the columns")
    header, delimiter = found
    if len(header) > MAX_COLUMNS:
        raise InputError(f"{len(header)} columns in the header, more than {MAX_COLUMNS}")
    named = [name for name in header if name]
    for name in named:
        if named.count(name) > 1:
            raise InputError(f"the header names the column '{name}' twice; rename one")
    lines = io.StringIO(text, newline="")
    skipped = 0
    for line in lines:
        skipped += 1
        if line.strip() and not line.startswith("#"):
            break
    reader = csv.reader(lines, delimiter=delimiter, strict=True)
    count = 0
    while True:
        start = skipped + reader.line_num + 1
        try:
            row = next(reader)
        except StopIteration:
            return
        except csv.Error as error:
            raise InputError(f"line {start}: {error}; check the quotes from there on") from error
        if not any(field.strip() for field in row):
            continue
        if any(field.strip() for field in row[len(header) :]):
            raise InputError(
                f"line {start}: {len(row)} fields for {len(header)} columns; put quotes around a "
                "field that holds the separator"
            )
        count += 1
        if count > MAX_ROWS:
            raise InputError(
                f"line {start}: more than {MAX_ROWS} rows; keep those of one match or season"
            )
        fields = [field.strip() for field in row]
        fields += [""] * (len(header) - len(fields))
        yield start, {name: field for name, field in zip(header, fields, strict=False) if name}
