"""How a table of samples is written: separator, header, units, and which column is what."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass
from itertools import islice

from overview_dsp.timeline.times import Moment, clock_s, moment

LINE_ENDS = re.compile(r"\r\n|\r|\n")
"""What a file opened as text ends lines at."""

COMMENTS = ("#", "%", "//")
MISSING = frozenset({"", "-", ".", "na", "n/a", "nan", "null", "none", "inf", "-inf", "+inf"})
"""What stands for no value, in small letters."""

_HEAD_ROWS = 60
_NUMBER = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)(e[-+]?\d+)?", re.ASCII | re.I)
_COMMA_NUMBER = re.compile(r"[-+]?\d+,\d+(e[-+]?\d+)?", re.ASCII | re.I)
_BRACKETED = re.compile(r"\[?([\d:.]+)(?: [\d/]+)?\]?", re.ASCII)
_HEART = re.compile(
    r"ecg|ekg|ppg|pleth|bvp|pulse|\bheart|^hart$|^hr$"
    r"|^(lead[ _]?)?(i{1,3}|av[rlf]|v[1-6]|ml(i{1,3}|\d))$",
    re.I,
)
_TIME = re.compile(
    r"^(t|time|timer|timestamp|date|datetime|elapsed( time)?|zeit|temps|tiempo|sec|secs|seconds?|ms"
    r"|msec|milliseconds?)([ _\[(/].*)?$|.*[ _](time|timestamp)$|^time.*",
    re.I,
)
_INDEX = re.compile(r"^(|index|sample|samples|sample ?#|#|n|no\.?|unnamed: ?0)$", re.I)


@dataclass(frozen=True)
class Layout:
    """How a table is written.

    Parameters
    ----------
    delimiter
        What separates the columns; None = blanks.
    names
        Of the columns, `column 1` and so on where there is no header.
    units
        A word for each column where a row of units follows the header, else empty.
    first_row
        The line number of the first row of data, from 1.
    numeric
        Whether each column holds numbers.
    first
        The first row's fields.
    decimal_comma
        Whether numbers are written with one.
    headed
        Whether the names come from a header.
    """

    delimiter: str | None
    names: tuple[str, ...]
    units: tuple[str, ...]
    first_row: int
    numeric: tuple[bool, ...]
    first: tuple[str, ...]
    decimal_comma: bool
    headed: bool

    def time_column(self) -> int | None:
        """Return the first column that holds times, by its name or its clock or date."""
        for i, name in enumerate(self.names):
            if self.headed and _TIME.match(name) and (self.numeric[i] or is_moment(self.first[i])):
                return i
        return next((i for i, entry in enumerate(self.first) if is_moment(entry)), None)

    def index_column(self) -> int | None:
        """Return the column that counts the samples."""
        found = (i for i, name in enumerate(self.names) if self.headed and _INDEX.match(name))
        return next((i for i in found if self.numeric[i]), None)

    def heart_columns(self) -> list[int]:
        """Return the columns called like an ECG lead or a pulse wave."""
        return [
            i
            for i, name in enumerate(self.names)
            if self.headed and self.numeric[i] and _HEART.search(name)
        ]

    def column(self, wanted: str) -> int | None:
        """Return the column of a name, or of a number from 1."""
        low = [name.lower() for name in self.names]
        if wanted.strip().lower() in low:
            return low.index(wanted.strip().lower())
        if re.fullmatch(r"[1-9]\d{0,5}", wanted, re.ASCII) and int(wanted) <= len(low):
            return int(wanted) - 1
        return None


def fields_of(line: str, delimiter: str | None) -> list[str]:
    """Return a row's fields without blanks and quotes around them."""
    parts = line.split(delimiter) if delimiter else line.split()
    return [part.strip().strip("\"'").strip() for part in parts]


def is_row(line: str) -> bool:
    """Return whether a line is a row, neither blank nor a comment."""
    return bool(line.strip()) and not line.lstrip().startswith(COMMENTS)


def is_moment(entry: str) -> bool:
    """Return whether a field is a clock time or a date."""
    return moment_of(entry) is not None


def moment_of(entry: str) -> float | Moment | None:
    """Return a clock time as seconds, an ISO date as such; None for what is neither."""
    bracketed = _BRACKETED.fullmatch(entry)
    clock = clock_s(bracketed[1] if bracketed else entry)
    if clock is not None:
        return clock
    return moment(entry, "iso") if entry[4:5] == "-" and len(entry) >= 10 else None


def is_number(entry: str, decimal_comma: bool = False) -> bool:
    """Return whether a field is a number."""
    return _NUMBER.fullmatch(entry.replace(",", ".") if decimal_comma else entry) is not None


def layout_of(lines: Iterable[str]) -> Layout | None:
    """Return how the table that begins with these lines is written, None if it is none."""
    rows = list(
        islice(((n, line) for n, line in enumerate(lines, start=1) if is_row(line)), _HEAD_ROWS)
    )
    if not rows:
        return None
    # a title or remark above the table needn't have the separator
    table = rows[len(rows) // 2 :]
    for delimiter in ("\t", ";", ","):
        if all(delimiter in line for _, line in table):
            break
    else:
        delimiter = None
    comma = delimiter != "," and any(
        _COMMA_NUMBER.fullmatch(entry) for _, line in table for entry in fields_of(line, delimiter)
    )
    return _layout(rows, delimiter, comma)


def _layout(rows: list[tuple[int, str]], delimiter: str | None, comma: bool) -> Layout | None:
    split = [(number, fields_of(line, delimiter)) for number, line in rows]

    def holds_data(fields: list[str]) -> bool:
        return any(is_number(entry, comma) for entry in fields) and all(
            is_number(entry, comma) or entry.lower() in MISSING or is_moment(entry)
            for entry in fields
        )

    first = next((i for i, (_, fields) in enumerate(split) if holds_data(fields)), None)
    if first is None:
        return None
    number, fields = split[first]
    above = [row for _, row in split[:first] if len(row) == len(fields)][-2:]
    if not above and first > 0 and delimiter is not None:
        return None
    names = tuple(above[0]) if above else tuple(f"column {i + 1}" for i in range(len(fields)))
    units = tuple(above[1]) if len(above) > 1 else ()
    data = [row for _, row in split[first:] if len(row) == len(fields)]
    numeric = tuple(
        any(is_number(row[i], comma) for row in data)
        and all(is_number(row[i], comma) or row[i].lower() in MISSING for row in data)
        for i in range(len(fields))
    )
    return Layout(delimiter, names, units, number, numeric, tuple(fields), comma, bool(above))
