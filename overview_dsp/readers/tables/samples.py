"""Rows into samples: seconds and values in order, and what was done to get there.

Rows without time and value are skipped and counted. Times that decrease or don't increase are
sorted (equal ones stay in the file's order); of rows of one time the last with a value counts.
"""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime

import numpy as np
from numpy.typing import NDArray

from overview_dsp.errors import InputError, shown
from overview_dsp.readers.tables.cells import sentinel
from overview_dsp.readers.tables.rows import RowReader, Rows
from overview_dsp.readers.tables.time_column import CLOCKS


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
    """

    time_s: NDArray[np.float64]
    values: tuple[NDArray[np.float64], ...]
    start: datetime | None
    units: tuple[str, ...]
    notes: tuple[str, ...]


def in_order(reader: RowReader, read: Rows) -> Samples:
    """Sort rows, merge equal times, count from the first, and say so.

    Raises
    ------
    InputError
        Fewer than two times, no value at all, a clock that goes back.
    """
    seconds, values, rows = read.seconds, read.values, read.number
    word = reader.table.row_word
    notes: list[str] = []
    if reader.skipped:
        notes.append(f"{reader.skipped} rows without time and value were left out")
    step = np.diff(seconds)
    order = None
    if step.size and bool((step <= 0.0).all()) and bool((step < 0.0).any()):
        order = np.arange(len(seconds))[::-1]
        if (step == 0.0).any():  # equal times stay in the file's order
            order = np.argsort(seconds, kind="stable")
        notes.append("rows were in descending order; they were turned round")
    elif (step < 0.0).any():
        back = int(np.flatnonzero(step < 0.0)[0]) + 1
        if reader.choice.format.name in CLOCKS:
            raise InputError(
                f"{word} {int(rows[back])}: the clock goes back; give dates too, or cut the file "
                "there"
            )
        order = np.argsort(seconds, kind="stable")
        notes.append(
            f"{int((step < 0.0).sum())} rows were earlier than the row before them (first "
            f"{word} {int(rows[back])}); rows were sorted by time"
        )
    ordered = read
    if order is not None:
        ordered = Rows(seconds[order], [value[order] for value in values], rows[order])
    single = last_of_each_time(ordered)
    seconds, values, rows = single.seconds, list(single.values), single.number
    if len(single) < len(ordered):
        notes.append(
            f"{len(ordered) - len(single)} rows repeat a time; of rows of one time the last with a "
            "value counts"
        )
    for i, column in enumerate(reader.columns):
        absent = sentinel(values[i])
        if absent is not None:
            found = values[i] == absent
            values[i] = np.where(found, np.nan, values[i])
            notes.append(
                f"{int(found.sum())} values of {absent:g} in column "
                f"{shown(reader.table.columns[column].header)} count as missing"
            )
    if not len(seconds) or np.isnan(values[0]).all():
        header = shown(reader.table.columns[reader.columns[0]].header)
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
        raise InputError("times lie too close together to be distinguished; count them from 0")
    units = tuple(number.unit or "" for number in reader.numbers)
    return Samples(time_s, tuple(values), start, units, tuple(notes))


def last_of_each_time(rows: Rows) -> Rows:
    """Keep one row of each time: the last, its missing values filled from the rows before it.

    Parameters
    ----------
    rows
        In order of their times.
    """
    begins = np.flatnonzero(np.diff(rows.seconds, prepend=-np.inf) > 0.0)
    if len(begins) == len(rows):
        return rows
    ends = np.append(begins[1:], len(rows)) - 1
    merged = []
    for value in rows.values:
        known = np.where(np.isnan(value), -1, np.arange(len(value)))
        last = np.maximum.reduceat(known, begins)
        merged.append(np.where(last >= 0, value[np.maximum(last, 0)], np.nan))
    return Rows(rows.seconds[begins], merged, rows.number[ends])
