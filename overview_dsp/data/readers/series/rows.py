"""Conversion of table rows to seconds and values, chunk by chunk."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from overview_dsp.arrays import FloatArray
from overview_dsp.data.readers.tables.cells import NumberColumn
from overview_dsp.data.readers.tables.column_roles import TimeChoice
from overview_dsp.data.readers.tables.table import CellLocation, Table, cell_locator
from overview_dsp.data.readers.tables.time_column import CLOCKS, Format, TimeColumn, settle_order
from overview_dsp.errors import InputError, quoted

Rows = FloatArray
"""Rows with a time, shape (2 + columns, n): row number from 1, seconds, and the value of each
requested column, NaN = missing."""


@dataclass
class RowReader:
    """Iterator over the selected columns of a table as seconds and values, chunk by chunk.

    `time` and `numbers` are the parsers of the columns; units are known after the last chunk.
    """

    table: Table
    choice: TimeChoice
    columns: Sequence[int]
    decimal_mark: str
    rate: float | None = None
    progress: Callable[[float], None] = lambda part: None
    time: TimeColumn = field(init=False)
    numbers: list[NumberColumn] = field(init=False)
    skipped: int = field(default=0, init=False)
    rows: int = field(default=0, init=False)

    def __post_init__(self) -> None:
        zones = [c.offset_min for i in self.choice.columns if (c := self.table.columns[i]).zoned]
        zone = zones[0] if zones else None
        self.time = TimeColumn(self.choice.format, None, zone, self.decimal_mark)
        self.numbers = [NumberColumn(self.decimal_mark) for _ in self.columns]

    def __iter__(self) -> Iterator[Rows]:
        count = len(self.choice.columns)
        seen = 0
        # freed at once: from then on glibc keeps freed memory of arrays up to this size, so that
        # those of the next chunk need no new pages
        np.empty(1 << 23, np.uint8)
        for chunk in self.table.chunks((*self.choice.columns, *self.columns)):
            self.progress(chunk.part)
            values = [
                number.values(cells, cell_locator(self.table, chunk, index))
                for number, cells, index in zip(
                    self.numbers, chunk.cells[count:], self.columns, strict=True
                )
            ]
            if count:
                locate = cell_locator(self.table, chunk, self.choice.columns[0])
                seconds = self.time.seconds(self.choice.cells(chunk), locate)
            else:
                assert self.rate is not None
                seconds = (seen + np.arange(len(chunk))) / self.rate
            seen += len(chunk)
            numbers = chunk.numbers or np.arange(chunk.first, chunk.first + len(chunk))
            read = np.array([numbers, seconds, *values])
            timeless = np.isnan(seconds)
            if timeless.any():
                valued = timeless & ~np.all([np.isnan(value) for value in values], axis=0)
                if valued.any():
                    i = int(np.flatnonzero(valued)[0])
                    raise locate(i).missing("give the time, or leave the row out")
                self.skipped += int(timeless.sum())
                read = read[:, ~timeless]
            self.rows += read.shape[1]
            yield read


def with_settled_order(table: Table, choice: TimeChoice) -> TimeChoice:
    """Return the choice with `dmy or mdy` resolved by the whole column.

    InputError: day and month can't be distinguished; the message says how to set the format.
    """
    if choice.format.name != "dmy or mdy":
        return choice
    column = table.columns[choice.columns[0]]
    example = ""

    def texts() -> Iterator[tuple[int, str]]:
        nonlocal example
        for chunk in table.chunks(choice.columns):
            for i, cell in enumerate(choice.cells(chunk)):
                if isinstance(cell, str) and cell.strip():
                    example = example or cell.strip()
                    yield chunk.number(i), cell.strip()

    name, row = settle_order(texts())
    header = quoted(column.header)
    if not name:
        raise InputError(
            f"column {header}: {quoted(example)} may be day/month or month/day, no row shows "
            f"which; choose with time (--time-column): '{column.header}:dmy' or "
            f"'{column.header}:mdy'"
        )
    description = Format(name).description
    evidence = (
        f"{table.row_word} {row}"
        if row is not None
        else "the order of rows (only then are they ascending)"
    )
    note = f"column {header} is read as {description}, detected from {evidence}"
    return replace(choice, format=Format(name, note), notes=(*choice.notes, note))


def in_order(reader: RowReader, read: Rows) -> tuple[Rows, list[str]]:
    """Sort rows and keep the last row of each time; return notes on this, too.

    InputError: a clock time earlier than the one before it.
    """
    number, seconds = read[:2]
    word = reader.table.row_word
    notes = [skipped_note(reader)] if reader.skipped else []
    step = np.diff(seconds)
    order = None
    if step.size and bool((step <= 0.0).all()) and bool((step < 0.0).any()):
        order = np.arange(len(seconds))[::-1]
        if (step == 0.0).any():  # equal times keep their order
            order = np.argsort(seconds, kind="stable")
        notes.append("rows were in descending order; they were reversed")
    elif (step < 0.0).any():
        back = int(np.flatnonzero(step < 0.0)[0]) + 1
        if reader.choice.format.name in CLOCKS:
            raise CellLocation(int(number[back]), word=word).fault(
                "the clock goes back; give dates too, or cut the file there"
            )
        order = np.argsort(seconds, kind="stable")
        notes.append(
            f"{int((step < 0.0).sum())} rows were earlier than the row before them (first "
            f"{word} {int(number[back])}); rows were sorted by time"
        )
    ordered = read if order is None else read[:, order]
    single = last_of_each_time(ordered)
    if repeats := ordered.shape[1] - single.shape[1]:
        rows = "1 row repeats" if repeats == 1 else f"{repeats} rows repeat"
        notes.append(f"{rows} a time; the last value of each time counts")
    return single, notes


def skipped_note(reader: RowReader) -> str:
    """Return a note on the rows that were left out."""
    return f"{reader.skipped} rows without time and value were left out"


def last_of_each_time(rows: Rows) -> Rows:
    """Return the last row of each time, with missing values from earlier rows of that time.

    `rows`: rows sorted by time.
    """
    begins = np.flatnonzero(np.diff(rows[1], prepend=-np.inf) > 0.0)
    count = rows.shape[1]
    if len(begins) == count:
        return rows
    merged = rows[:, np.append(begins[1:], count) - 1]
    for value, kept in zip(rows[2:], merged[2:], strict=True):
        known = np.where(np.isnan(value), -1, np.arange(count))
        last = np.maximum.reduceat(known, begins)
        kept[:] = np.where(last >= 0, value[np.maximum(last, 0)], np.nan)
    return merged
