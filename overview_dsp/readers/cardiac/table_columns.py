"""Two columns of a table of samples, read line by line in bounded memory."""

from __future__ import annotations

import io
import math
from collections.abc import Callable, Iterator
from datetime import datetime

import numpy as np
from numpy.typing import NDArray

from overview_dsp.errors import InputError, shown
from overview_dsp.readers.cardiac.sample_times import MAX_ROWS, seconds_of
from overview_dsp.readers.cardiac.table_layout import (
    MISSING,
    Layout,
    fields_of,
    is_number,
    is_row,
    moment_of,
)
from overview_dsp.readers.source import MAX_TEXT_BYTES, Source, text_encoding
from overview_dsp.timeline.times import Moment

MAX_SAMPLE = 1e12
"""A larger sample is no electrode's, in whatever unit, and counts as missing."""

_LINES_BYTES = 1 << 20
_MAX_LINE = 1 << 20

Columns = tuple[NDArray[np.float32], NDArray[np.float64] | None, datetime | None]


def read_columns(
    source: Source,
    layout: Layout,
    value: int,
    time: int | None,
    max_mb: float | None,
    progress: Callable[[float], None],
) -> Columns:
    """Read a column of values and one of times.

    Returns
    -------
    values : float32 (n,), NaN = missing
    times : float64 (n,) in the column's own unit, dates in seconds from the first; None if not read
    start : the first date, None if the times are no dates

    Raises
    ------
    InputError
        Names line and column: a word for a number, a time that is none or missing, too few fields;
        a file too large.
    """
    limit = MAX_TEXT_BYTES if max_mb is None else int(max_mb * 2**20)
    if source.size > limit:
        raise InputError(
            f"{source.size / 2**20:.0f} MB, more than the {limit / 2**20:g} MB that are read; cut "
            "it into parts or raise the limit with max_mb"
        )
    values: list[NDArray[np.float32]] = []
    times: list[NDArray[np.float64]] = []
    clock = _Clock()
    count = 0
    try:
        for first, lines, done in _pieces(source, layout.first_row):
            numbered = [(first + i, line) for i, line in enumerate(lines) if is_row(line)]
            rows = [fields_of(line, layout.delimiter) for _, line in numbered]
            samples = _numbers(rows, numbered, layout, value)
            samples[~(np.abs(samples) <= MAX_SAMPLE)] = np.nan
            values.append(samples.astype(np.float32))
            if time is not None and layout.numeric[time]:
                times.append(_numbers(rows, numbered, layout, time, needed=True))
            elif time is not None:
                times.append(clock.read(rows, numbered, time, layout.names[time]))
            count += len(rows)
            if count > MAX_ROWS:
                raise InputError(f"more than {MAX_ROWS} rows; cut the file into parts")
            progress(done)
    except UnicodeDecodeError as error:
        raise InputError(
            f"isn't {error.encoding} text ({error.reason}); save it as UTF-8"
        ) from error
    except OSError as error:
        raise InputError(f"can't be read ({error.strerror})") from error
    return (
        np.concatenate(values) if values else np.zeros(0, np.float32),
        np.concatenate(times) if times else None,
        clock.start.to_datetime() if clock.start is not None else None,
    )


def _pieces(source: Source, first_row: int) -> Iterator[tuple[int, list[str], float]]:
    """Yield (number of the first line, lines, part of the file done)."""
    number = 1
    with (
        open(source.path, "rb") as file,
        io.TextIOWrapper(file, text_encoding(source.head), newline=None) as stream,
    ):
        while lines := stream.readlines(_LINES_BYTES):
            if any(len(line) > _MAX_LINE for line in lines):
                raise InputError(f"line {number} or later has over {_MAX_LINE} characters")
            skipped = max(0, first_row - number)
            yield number + skipped, lines[skipped:], min(1.0, file.tell() / source.size)
            number += len(lines)


def _numbers(
    rows: list[list[str]],
    numbered: list[tuple[int, str]],
    layout: Layout,
    column: int,
    needed: bool = False,
) -> NDArray[np.float64]:
    """Return a column's numbers: all at once where they are plain, else one by one."""
    try:
        plain = np.array([row[column] for row in rows], dtype=np.float64)
    except (ValueError, IndexError):
        plain = None
    if plain is not None and not needed:
        plain[~np.isfinite(plain)] = np.nan
        return plain
    if plain is not None and np.isfinite(plain).all():
        return plain
    found = np.full(len(rows), np.nan)
    name = layout.names[column]
    for i, row in enumerate(rows):
        place = f"line {numbered[i][0]}, column '{name}'"
        entry = row[column] if column < len(row) else None
        if entry is None:
            raise InputError(
                f"line {numbered[i][0]} has {len(row)} fields and no column '{name}'; complete it "
                "or take it out"
            )
        if entry.lower() in MISSING:
            if needed:
                raise InputError(f"{place}: no time; take the row out or give the rate instead")
            continue
        if not is_number(entry, layout.decimal_comma):
            raise InputError(f"{place}: {shown(entry)} isn't a number")
        given = float(entry.replace(",", ".") if layout.decimal_comma else entry)
        found[i] = given if math.isfinite(given) else np.nan
    return found


class _Clock:
    """Reads dates and clock times as seconds, dates from the first one."""

    def __init__(self) -> None:
        self.start: Moment | None = None

    def read(
        self, rows: list[list[str]], numbered: list[tuple[int, str]], column: int, name: str
    ) -> NDArray[np.float64]:
        found = np.empty(len(rows))
        for i, row in enumerate(rows):
            entry = row[column] if column < len(row) else ""
            moment = moment_of(entry)
            if self.start is None and isinstance(moment, Moment):
                self.start = moment
            seconds = seconds_of(moment, self.start)
            if seconds is None:
                raise InputError(
                    f"line {numbered[i][0]}, column '{name}': {shown(entry)} is no time "
                    "like the others; write hh:mm:ss.sss or ISO dates, or give the rate instead"
                )
            found[i] = seconds
        return found
