"""ECG and pulse waves as tables of samples (CSV, TSV, columns of numbers).

Claimed if `rate` is given (50 a second or more), or a column is called like an ECG lead or a pulse
wave and a column of times shows 50 samples a second or more. (A series of numbers with times, also
of heart rates, is no such signal.) Times may be seconds, milliseconds or microseconds, clock times
or ISO dates; what lies between them decides the rate, and a hole between them is a gap.

Known quirks: no header; a second row of units (PhysioNet's `rdsamp -c -v`), names in single quotes,
a column that counts the samples, decimal commas where semicolons or tabs separate, comment lines
(`#`, `%`, `//`), columns separated by blanks.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from datetime import datetime

import numpy as np
from numpy.typing import NDArray

from overview_dsp import validation
from overview_dsp.data.analysis.heart_signal import Samples
from overview_dsp.data.analysis.heartbeats import MIN_RATE, find_beats
from overview_dsp.data.readers.cardiac.build import (
    MAPS,
    About,
    check_map,
    detected,
    find_gaps,
    heart_timeline,
)
from overview_dsp.data.readers.cardiac.wfdb_signal import best_signal, name_or_number
from overview_dsp.data.readers.data_file import MAX_TEXT_BYTES, DataFile, LoadOptions
from overview_dsp.data.readers.tables.cells import TOKENS, parse
from overview_dsp.data.readers.tables.decimal_mark import choose_decimal_mark
from overview_dsp.data.readers.tables.delimited import DelimitedTable
from overview_dsp.data.readers.tables.dialect import Dialect, detect, head_lines
from overview_dsp.data.readers.tables.table import CellLocation, Cells, cell_locator, first_rows
from overview_dsp.data.timeline.model import Timeline
from overview_dsp.data.timeline.time_parsing import NS, Moment, clock_s, moment
from overview_dsp.errors import InputError, shown

MAX_RATE = 100_000.0
"""Samples a second; no electrode delivers more."""

MAX_ROWS = 1 << 26
"""Most samples that are read: 37 hours at 500 a second."""

MAX_SAMPLE = 1e12
"""A larger sample is no electrode's, in whatever unit, and counts as missing."""

COMMENTS = ("#", "%", "//")
_HEAD_ROWS = 60
_RATE_ROWS = 1000
_MISSING = TOKENS | {"inf", "-inf", "+inf"}
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
_HOLE_STEPS = 1.5
_UNITS = (
    (re.compile(r"\bus\b|µs|μs|micro", re.I), 1e-6),
    (re.compile(r"\bms\b|msec|milli|_ms$", re.I), 1e-3),
    (re.compile(r"\bmin(ute)?s?\b", re.I), 60.0),
    (re.compile(r"\bs\b|\bsec|_s$", re.I), 1.0),
)


@dataclass(frozen=True)
class _Layout:
    """How a table of samples is written: its dialect, first rows, and which columns hold what."""

    dialect: Dialect
    head: list[list[str | None]]
    decimal_mark: str
    numeric: tuple[bool, ...]

    @property
    def names(self) -> tuple[str, ...]:
        return self.dialect.header

    @property
    def headed(self) -> bool:
        return not all(re.fullmatch(r"column \d+", name) for name in self.names)

    def holds_times(self, i: int) -> bool:
        """Return whether a column begins with a clock time or a date."""
        first = next((cell for cell in self.head[i] if cell), "")
        return _moment_of(_bare(first)) is not None

    def time_column(self) -> int | None:
        """Return the first column that holds times, by its name or its clock or date."""
        for i, name in enumerate(self.names):
            if self.headed and _TIME.match(name) and (self.numeric[i] or self.holds_times(i)):
                return i
        return next((i for i in range(len(self.names)) if self.holds_times(i)), None)

    def index_column(self) -> int | None:
        """Return the column that counts the samples."""
        found = (i for i, name in enumerate(self.names) if self.headed and _INDEX.match(name))
        return next((i for i in found if self.numeric[i]), None)

    def heart_columns(self) -> list[int]:
        """Return the columns called like an ECG lead or a pulse wave."""
        found = (i for i, name in enumerate(self.names) if self.headed and _HEART.search(name))
        return [i for i in found if self.numeric[i]]


def sniff(source: DataFile) -> bool:
    """Return whether the file is a table of heart samples, by the rate given or its columns."""
    layout = _layout_of(source)
    if layout is None or not any(layout.numeric):
        return False
    options = source.options
    if options.map is not None and options.map not in MAPS:
        return False  # what a series takes
    if options.rate is not None:
        return options.rate >= MIN_RATE
    if not layout.heart_columns():
        return False
    time = layout.time_column()
    if time is None:
        # samples without times, called a heart's: the reader asks for the rate
        others = {layout.index_column(), *layout.heart_columns()}
        return all(i in others for i, numeric in enumerate(layout.numeric) if numeric)
    rate = _rate_of(source, layout, time)
    return rate is not None and rate >= MIN_RATE


def read(source: DataFile, options: LoadOptions) -> Timeline:
    """Read a table of samples (takes `rate`, `value`, `time`, `map`, `max_mb`, `progress`).

    Raises
    ------
    InputError
        Names line and column: a word for a number, times that run backwards; the columns to choose
        from; no rate; no heartbeat.
    """
    with validation.located(f"{source.where}: "):
        check_map(options)
        limit = MAX_TEXT_BYTES if options.max_mb is None else int(options.max_mb * 2**20)
        if source.size > limit:
            raise InputError(
                f"{source.size / 2**20:.0f} MB, more than the {limit / 2**20:g} MB that are read; "
                "cut it into parts or raise the limit with max_mb"
            )
        layout = _layout_of(source)
        assert layout is not None  # sniffed
        time = _time_column(layout, options)
        value = _value_column(layout, options, time)
        table = DelimitedTable(source, layout.dialect)
        values, times, start = _columns(
            table, layout, value, time, lambda part: options.report_progress(part / 2.0)
        )
        notes: tuple[str, ...] = ()
        if times is not None:
            unit = _unit_of(layout, time, times)
            rate, values, notes = _on_a_grid(times * unit[0], values, unit[1])
        elif options.rate is not None:
            rate = options.rate
            if time is None and (unused := layout.time_column()) is not None:
                notes = (f"the rate was given; the column '{layout.names[unused]}' was not used",)
        else:
            raise InputError(
                f"the column '{layout.names[value]}' has no times; give the rate, samples a second"
            )
        if not MIN_RATE <= rate <= MAX_RATE:
            raise InputError(
                f"{rate:.6g} samples a second; a heart's signal has {MIN_RATE:g} to {MAX_RATE:g}"
            )
        signal = Samples(layout.names[value], rate, values)
        detection = find_beats(signal, None, lambda part: options.report_progress(0.5 + part / 2.0))
        duration_s = len(values) / rate
        if detection.lost:
            notes = (*notes, f"{detection.lost} single samples are missing")
        about = About(
            source.stem,
            duration_s,
            f"{detection.what}, {signal.name} at {rate:.6g} Hz; beats found in it",
            notes,
            start,
        )
        gaps = find_gaps(detection.silent, detection.noisy, rate, duration_s)
        return heart_timeline(about, detected(detection, rate), gaps, (), options, signal)


def _layout_of(source: DataFile) -> _Layout | None:
    """Return the layout of a table of samples, None if the file is none."""
    dialect = detect(source, lambda header, below: bool(below), COMMENTS)
    if dialect is None:
        return None
    header, units = (tuple(map(_bare, names)) for names in (dialect.header, dialect.units))
    dialect = replace(dialect, header=header, units=units)
    try:
        head = first_rows(_head_table(source, dialect), _HEAD_ROWS)
    except InputError:  # it is for the reader of series to say what is broken
        return None
    decimal_mark = choose_decimal_mark(head, range(len(head)), dialect.separator)
    numeric = tuple(_is_numeric(column, decimal_mark) for column in head)
    if not all(known or _are_times(column) for known, column in zip(numeric, head, strict=True)):
        return None  # words beside the numbers: a series of something else
    return _Layout(dialect, head, decimal_mark, numeric)


def _head_table(source: DataFile, dialect: Dialect) -> DelimitedTable:
    return DelimitedTable("\n".join(head_lines(source, dialect.encoding)), dialect)


def _is_numeric(cells: Sequence[str | None], decimal_mark: str) -> bool:
    known = _known(cells)
    return bool(known) and all(_number(cell, decimal_mark) is not None for cell in known)


def _are_times(cells: Sequence[str | None]) -> bool:
    """Return whether cells are clock times and dates, missing ones aside."""
    return all(_moment_of(cell) is not None for cell in _known(cells))


def _known(cells: Sequence[str | None]) -> list[str]:
    return [cell for cell in map(_bare, cells) if cell.lower() not in _MISSING]


def _bare(cell: str | None) -> str:
    """A cell without blanks and single quotes around it."""
    return (cell or "").strip().strip("'\"").strip()


def _number(text: str, decimal_mark: str) -> float | None:
    found = parse(text, decimal_mark)
    return None if found is None or found[1] else found[0]


def _time_column(layout: _Layout, options: LoadOptions) -> int | None:
    if options.time is None:
        return None if options.rate is not None else layout.time_column()
    columns = range(len(layout.names))
    timed = [i for i in columns if layout.numeric[i] or layout.holds_times(i)]
    return _named_column(layout, options.time, "times", timed, columns)


def _value_column(layout: _Layout, options: LoadOptions, time: int | None) -> int:
    numeric = [i for i, is_numeric in enumerate(layout.numeric) if is_numeric and i != time]
    if options.value is not None:
        return _named_column(layout, options.value, "samples", numeric, numeric)
    hearts = [i for i in layout.heart_columns() if i != time]
    if hearts:
        return hearts[best_signal([layout.names[i] for i in hearts])]
    left = [i for i in numeric if i not in (layout.time_column(), layout.index_column())]
    if len(left) != 1:
        raise InputError(
            f"{len(left)} columns may be the signal: "
            f"{', '.join(layout.names[i] for i in left[:20]) or 'none'}; choose one with value"
        )
    return left[0]


def _named_column(
    layout: _Layout, wanted: str, what: str, fitting: Sequence[int], listed: Sequence[int]
) -> int:
    """Return the column that a caller names; InputError if it isn't one of those that fit."""
    found = name_or_number(layout.names, wanted)
    if found is None or found not in fitting:
        raise InputError(
            f"no column of {what} is called {shown(wanted)}; there is "
            f"{', '.join(layout.names[i] for i in listed[:20])}"
        )
    return found


def _columns(
    table: DelimitedTable,
    layout: _Layout,
    value: int,
    time: int | None,
    progress: Callable[[float], None],
) -> tuple[NDArray[np.float32], NDArray[np.float64] | None, datetime | None]:
    """Read a column of values and one of times.

    Returns
    -------
    values : float32 (n,), NaN = missing
    times : float64 (n,) in the column's own unit, dates in seconds from the first; None if not read
    start : the first date, None if the times are no dates

    Raises
    ------
    InputError
        Names line and column: a word for a number, a time that is none or missing, too few fields.
    """
    values: list[NDArray[np.float32]] = []
    times: list[NDArray[np.float64]] = []
    clock = _Clock()
    count = 0
    for chunk in table.chunks([value] if time is None else [value, time]):
        samples = _numbers(chunk.cells[0], cell_locator(table, chunk, value), layout.decimal_mark)
        samples[~(np.abs(samples) <= MAX_SAMPLE)] = np.nan
        values.append(samples.astype(np.float32))
        if time is not None:
            place = cell_locator(table, chunk, time)
            times.append(_times(layout, time, chunk.cells[1], place, clock))
        count += len(chunk)
        if count > MAX_ROWS:
            raise InputError(f"more than {MAX_ROWS} rows; cut the file into parts")
        progress(chunk.part)
    start = clock.start.to_datetime() if clock.start is not None else None
    return (
        np.concatenate(values) if values else np.zeros(0, np.float32),
        np.concatenate(times) if times else None,
        start,
    )


def _numbers(
    cells: Cells, place: Callable[[int], CellLocation], decimal_mark: str, needed: bool = False
) -> NDArray[np.float64]:
    """Return a column's numbers: all at once where they are plain, else one by one."""
    try:
        plain = np.array(cells, dtype=np.float64)
    except ValueError:
        plain = None
    if plain is not None and None not in cells:
        finite = np.isfinite(plain)
        if finite.all() or not needed:
            plain[~finite] = np.nan
            return plain
    found = np.full(len(cells), np.nan)
    for i, cell in enumerate(cells):
        text = _bare(cell)
        if cell is None:
            raise place(i).missing("complete the row or take it out")
        if text.lower() in _MISSING:
            if needed:
                raise place(i).missing("take the row out or give the rate instead of the times")
            continue
        number = _number(text, decimal_mark)
        if number is None:
            raise place(i).error(text, "isn't a number")
        found[i] = number if math.isfinite(number) else np.nan
    return found


class _Clock:
    """Reads dates and clock times as seconds, dates from the first one."""

    start: Moment | None = None

    def read(self, cells: Cells, place: Callable[[int], CellLocation]) -> NDArray[np.float64]:
        found = np.empty(len(cells))
        for i, cell in enumerate(cells):
            at = _moment_of(_bare(cell))
            if self.start is None and isinstance(at, Moment):
                self.start = at
            seconds = _seconds_of(at, self.start)
            if seconds is None:
                raise place(i).error(
                    cell,
                    "is no time like the others; write hh:mm:ss.sss or ISO dates, or give the rate "
                    "instead",
                )
            found[i] = seconds
        return found


def _times(
    layout: _Layout, time: int, cells: Cells, place: Callable[[int], CellLocation], clock: _Clock
) -> NDArray[np.float64]:
    """Return a column's times, numbers in its own unit."""
    if layout.numeric[time]:
        return _numbers(cells, place, layout.decimal_mark, needed=True)
    return clock.read(cells, place)


def _moment_of(entry: str) -> float | Moment | None:
    """Return a clock time as seconds, an ISO date as such; None for what is neither."""
    bracketed = _BRACKETED.fullmatch(entry)
    clock = clock_s(bracketed[1] if bracketed else entry)
    if clock is not None:
        return clock
    return moment(entry, "iso") if entry[4:5] == "-" and len(entry) >= 10 else None


def _seconds_of(moment: float | Moment | None, start: Moment | None) -> float | None:
    """Return a moment as seconds from the start; None for what doesn't go with the others."""
    if not isinstance(moment, Moment):
        return moment if start is None else None
    if start is None or (moment.offset_min is None) != (start.offset_min is None):
        return None
    return (moment.ns - start.ns) / NS


def _rate_of(source: DataFile, layout: _Layout, time: int) -> float | None:
    """Return the samples a second that the first rows show."""
    cells = first_rows(_head_table(source, layout.dialect), _RATE_ROWS)[time]
    try:
        times = _times(layout, time, cells, CellLocation, _Clock())
    except InputError:
        return None
    if len(times) < 3:
        return None
    mean = float(np.mean(np.diff(times * _unit_of(layout, time, times)[0])))
    return 1.0 / mean if mean > 0.0 else None


def _unit_of(
    layout: _Layout, time: int | None, times: NDArray[np.float64]
) -> tuple[float, str | None]:
    """Return what a time is in seconds, and its name where it was guessed from the steps."""
    assert time is not None
    if not layout.numeric[time]:
        return 1.0, None
    words = layout.names[time] if layout.headed else ""
    words += " " + layout.dialect.units[time]
    for pattern, seconds in _UNITS:
        if pattern.search(words):
            return seconds, None
    steps = np.diff(times[:10_000])
    step = float(np.median(steps[steps > 0.0])) if (steps > 0.0).any() else math.nan
    for seconds, name in ((1.0, None), (1e-3, "milliseconds"), (1e-6, "microseconds")):
        if MIN_RATE * 0.99 <= 1.0 / (step * seconds) <= 5000.0:
            return seconds, name
    return 1.0, None


def _on_a_grid(
    times: NDArray[np.float64], values: NDArray[np.float32], guessed: str | None
) -> tuple[float, NDArray[np.float32], tuple[str, ...]]:
    """Return the rate, the values at even steps (NaN in the holes), and notes."""
    notes = [f"the times were taken as {guessed}"] if guessed else []
    steps = np.diff(times)
    if len(steps) == 0:
        raise InputError("one row of data; a heartbeat takes a second or more")
    if (steps < 0.0).any():
        row = int(np.argmax(steps < 0.0)) + 2
        raise InputError(
            f"the time of row {row} of the data is before that of the row above; sort the rows, or "
            "give the rate instead"
        )
    usual = float(np.median(steps))
    if usual <= 0.0:
        raise InputError(
            "most rows have the time of the row above; give the rate, samples a second, instead"
        )
    # the mean, not the median: times written in whole milliseconds take turns of 2 and 3
    step = float(np.mean(steps[steps < _HOLE_STEPS * usual]))
    place = np.rint((times - times[0]) / step)
    if place[-1] >= MAX_ROWS:
        raise InputError(
            f"the times reach over {times[-1] - times[0]:.6g} s in steps of {step:.3g} s, more "
            f"than the {MAX_ROWS} samples that are read; cut the file into parts"
        )
    index = place.astype(np.int64)
    if np.array_equal(index, np.arange(len(index))):
        return 1.0 / step, values, tuple(notes)
    grid = np.full(int(index[-1]) + 1, np.nan, np.float32)
    grid[index] = values
    # a sample that rounding put into its neighbour's place leaves a hole of one; it isn't missing
    empty = np.ones(len(grid), np.bool_)
    empty[index] = False
    alone = np.flatnonzero(empty[1:-1] & ~empty[:-2] & ~empty[2:]) + 1
    grid[alone] = (grid[alone - 1] + grid[alone + 1]) / 2.0
    holes = int(np.count_nonzero(steps >= _HOLE_STEPS * usual + step))
    if holes:
        notes.append(f"{holes} holes between the times")
    return 1.0 / step, grid, tuple(notes)
