"""Rows into samples: seconds and values in order, and what was done to get there.

Rows without time and value are skipped and counted. Times that decrease or don't increase are
sorted (equal ones stay in the file's order); of rows of one time the last with a value counts.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from datetime import datetime
from typing import Any

import numpy as np
from numpy.typing import NDArray

from overview_dsp.errors import InputError
from overview_dsp.timeline import checks
from overview_dsp.timeline.series.choosing import TimeChoice, joined_cells
from overview_dsp.timeline.series.missing import sentinel
from overview_dsp.timeline.series.numbers import NumberColumn, Style
from overview_dsp.timeline.series.table import Chunk, Column, Table
from overview_dsp.timeline.series.time_column import Format, TimeColumn, settle_order


@dataclass(frozen=True, eq=False)
class Samples:
    """A series in order.

    Parameters
    ----------
    time_s
        Seconds from the first time, shape (n,), strictly increasing from 0.
    values
        Shape (n,) for each column asked for, NaN = missing.
    start
        The calendar moment of time 0, or None.
    units
        What the cells of each column carry (a currency, %).
    notes
        What was sorted, merged, left out.
    row
        The number of each sample's row in the file, shape (n,).
    """

    time_s: NDArray[np.float64]
    values: tuple[NDArray[np.float64], ...]
    start: datetime | None
    units: tuple[str, ...]
    notes: tuple[str, ...]
    row: NDArray[np.int64]


@dataclass
class RowReader:
    """Reads the chosen columns of a table, chunk by chunk, into seconds and values.

    `time` and `numbers` are the columns' parsers, whose findings stand after the last chunk.
    """

    table: Table
    choice: TimeChoice
    columns: Sequence[int]
    style: Style
    rate: float | None = None
    progress: Callable[[float], None] = lambda part: None
    time: TimeColumn = field(init=False)
    numbers: list[NumberColumn] = field(init=False)
    skipped: int = field(default=0, init=False)
    rows: int = field(default=0, init=False)

    def __post_init__(self) -> None:
        zoned = any(self.table.columns[i].zoned for i in self.choice.columns)
        self.time = TimeColumn(self.choice.format, offset_min=0 if zoned else None)
        self.numbers = [
            NumberColumn(self.table.columns[i].header, self.style) for i in self.columns
        ]

    def __iter__(
        self,
    ) -> Iterator[tuple[NDArray[np.float64], list[NDArray[np.float64]], NDArray[np.int64]]]:
        count = len(self.choice.columns)
        seen = 0
        for chunk in self.table.chunks((*self.choice.columns, *self.columns)):
            self.progress(chunk.part)
            values = [
                number.values(cells, _place(self.table, chunk, self.table.columns[index]))
                for number, cells, index in zip(
                    self.numbers, chunk.cells[count:], self.columns, strict=True
                )
            ]
            if count:
                cells = chunk.cells[0]
                if count > 1:
                    cells = joined_cells(chunk.cells[:count], self.choice.joint)
                header = self.table.columns[self.choice.columns[0]]
                place = _place(self.table, chunk, header)
                seconds = self.time.seconds(cells, place)
            else:
                assert self.rate is not None
                seconds = (seen + np.arange(len(chunk))) / self.rate
            seen += len(chunk)
            if chunk.numbers is None:
                rows = np.arange(chunk.first, chunk.first + len(chunk))
            else:
                rows = np.array(chunk.numbers, dtype=np.int64)
            timeless = np.isnan(seconds)
            if timeless.any():
                valued = timeless & ~np.all([np.isnan(value) for value in values], axis=0)
                if valued.any():
                    i = int(np.flatnonzero(valued)[0])
                    raise InputError(
                        f"{place(i)}: the time is missing; give it, or leave the row out"
                    )
                self.skipped += int(timeless.sum())
                seconds, rows = seconds[~timeless], rows[~timeless]
                values = [value[~timeless] for value in values]
            self.rows += len(seconds)
            yield seconds, values, rows


def _place(table: Table, chunk: Chunk, column: Column) -> Callable[[int], str]:
    def words(i: int) -> str:
        return f"{table.row_word} {chunk.number(i)}, column {checks.shown(column.header)}"

    return words


def settled(table: Table, choice: TimeChoice) -> TimeChoice:
    """Tell day from month where the head left it open, by the whole column.

    Raises
    ------
    InputError
        It can't be told; the line says how to give it.
    """
    if choice.format.name != "dmy or mdy":
        return choice
    column = table.columns[choice.columns[0]]
    example = ""

    def texts() -> Iterator[tuple[int, str]]:
        nonlocal example
        for chunk in table.chunks(choice.columns):
            cells: Any = chunk.cells[0]
            if len(choice.columns) > 1:
                cells = joined_cells(chunk.cells, choice.joint)
            for i, cell in enumerate(cells):
                if isinstance(cell, str) and cell.strip():
                    example = example or cell.strip()
                    yield chunk.number(i), cell.strip()

    name, row = settle_order(texts())
    header = checks.shown(column.header)
    if not name:
        raise InputError(
            f"column {header}: {checks.shown(example)} may be day/month or month/day, and no row "
            f"tells; say which (time='{column.header}:dmy' or time='{column.header}:mdy')"
        )
    words = Format(name).words
    told = (
        f"{table.row_word} {row}" if row is not None else "the order of rows (only so do they rise)"
    )
    note = f"column {header} is read as {words}, told by {told}"
    return TimeChoice(choice.columns, Format(name, note), choice.joint, (*choice.notes, note))


def gather(reader: RowReader) -> Samples:
    """Read all rows into memory and put them in order.

    Raises
    ------
    InputError
        Bad cells (line and column named), fewer than two times, no value at all.
    """
    times: list[NDArray[np.float64]] = []
    rows: list[NDArray[np.int64]] = []
    values: list[list[NDArray[np.float64]]] = [[] for _ in reader.columns]
    for seconds, chunk_values, numbers in reader:
        times.append(seconds)
        rows.append(numbers)
        for kept, value in zip(values, chunk_values, strict=True):
            kept.append(value)
    if not times:
        raise InputError("no rows with a time; a series has one row a time")
    return in_order(
        reader,
        np.concatenate(times),
        [np.concatenate(kept) for kept in values],
        np.concatenate(rows),
    )


def in_order(
    reader: RowReader,
    seconds: NDArray[np.float64],
    values: list[NDArray[np.float64]],
    rows: NDArray[np.int64],
) -> Samples:
    """Sort, merge equal times, count from the first, and say so."""
    word = reader.table.row_word
    notes: list[str] = []
    if reader.skipped:
        notes.append(f"{reader.skipped} rows without time and value were left out")
    step = np.diff(seconds)
    if step.size and bool((step <= 0.0).all()) and bool((step < 0.0).any()):
        order = np.arange(len(seconds))[::-1]
        if (step == 0.0).any():  # equal times stay in the file's order
            order = np.argsort(seconds, kind="stable")
        notes.append("rows were in descending order; they were turned round")
    elif (step < 0.0).any():
        back = int(np.flatnonzero(step < 0.0)[0]) + 1
        if reader.choice.format.name == "clock":
            raise InputError(
                f"{word} {int(rows[back])}: the clock goes back; give dates too, or cut the file "
                "there"
            )
        order = np.argsort(seconds, kind="stable")
        notes.append(
            f"{int((step < 0.0).sum())} rows were earlier than the row before them (first "
            f"{word} {int(rows[back])}); rows were sorted by time"
        )
    else:
        order = np.arange(len(seconds))
    seconds, rows = seconds[order], rows[order]
    values = [value[order] for value in values]
    same = np.flatnonzero(np.diff(seconds) <= 0.0) + 1
    if same.size:
        seconds, values, rows = _merged(seconds, values, rows)
        notes.append(
            f"{same.size} rows repeat a time; of rows of one time the last with a value counts"
        )
    for i, column in enumerate(reader.columns):
        absent = sentinel(values[i])
        if absent is not None:
            found = values[i] == absent
            values[i] = np.where(found, np.nan, values[i])
            notes.append(
                f"{int(found.sum())} values of {absent:g} in column "
                f"{checks.shown(reader.table.columns[column].header)} count as missing"
            )
    if not len(seconds) or np.isnan(values[0]).all():
        header = checks.shown(reader.table.columns[reader.columns[0]].header)
        raise InputError(f"column {header} has no value in any row; name another")
    if len(seconds) < 2:
        raise InputError(
            f"only one time ({word} {int(rows[0])}); a series has two or more, name another time "
            "column if this isn't it"
        )
    if not np.isfinite(seconds).all() or seconds[-1] - seconds[0] > 1e15:
        raise InputError("the times span more than 30 million years; check their unit")
    first = float(seconds[0])
    start = reader.time.start(first)
    if start is None and first != 0.0:
        notes.append(f"times begin at {first:g} s; the timeline counts from there")
    time_s = seconds - first
    if (np.diff(time_s) <= 0.0).any():
        raise InputError("times lie too close together to tell apart; count them from 0")
    units = tuple(number.unit or "" for number in reader.numbers)
    return Samples(time_s, tuple(values), start, units, tuple(notes), rows)


def _merged(
    seconds: NDArray[np.float64], values: list[NDArray[np.float64]], rows: NDArray[np.int64]
) -> tuple[NDArray[np.float64], list[NDArray[np.float64]], NDArray[np.int64]]:
    """Keep one row of each time: the last, its missing values filled from the rows before it."""
    begins = np.flatnonzero(np.diff(seconds, prepend=-np.inf) > 0.0)
    ends = np.append(begins[1:], len(seconds)) - 1
    merged = []
    for value in values:
        known = np.where(np.isnan(value), -1, np.arange(len(value)))
        last = np.maximum.reduceat(known, begins)
        merged.append(np.where(last >= 0, value[np.maximum(last, 0)], np.nan))
    return seconds[begins], merged, rows[ends]
