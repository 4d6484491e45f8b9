"""ECG and pulse waves as tables of samples (CSV, TSV, columns of numbers).

A table is searched for heartbeats if the option `rate` is at least 50 Hz, and refused without any.
Without the option, a column must have the name of an ECG lead or a pulse wave, and the times must
show a rate of at least 50 Hz. Other tables, also of heart rates, are series. Times are seconds,
milliseconds, microseconds, clock times or ISO dates. Their mean interval determines the rate, and
larger intervals are gaps.

Supported variants: no header; a second row of units (PhysioNet's `rdsamp -c -v`); names in single
quotes; a column of sample numbers; decimal commas if semicolons or tabs separate the columns;
comment lines (`#`, `%`, `//`); columns separated by spaces.
"""

from __future__ import annotations

import contextlib
import math
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from datetime import datetime

import numpy as np
from numpy.typing import NDArray

from overview_dsp import validation
from overview_dsp.arrays import FloatArray
from overview_dsp.data.analysis.heart_signal import Samples
from overview_dsp.data.analysis.heartbeats import MIN_RATE, find_beats
from overview_dsp.data.readers.cardiac.build import MAPS, Description, check_map, detected_timeline
from overview_dsp.data.readers.cardiac.wfdb_signal import best_signal, index_of
from overview_dsp.data.readers.data_file import MAX_TEXT_BYTES, DataFile, LoadOptions
from overview_dsp.data.readers.tables.cells import TOKENS, choose_decimal_mark, parse
from overview_dsp.data.readers.tables.column_names import PATTERNS
from overview_dsp.data.readers.tables.delimited import DelimitedTable
from overview_dsp.data.readers.tables.dialect import Dialect, detect, head_lines
from overview_dsp.data.readers.tables.table import (
    CellLocation,
    Cells,
    Column,
    as_list,
    cell_locator,
    first_rows,
)
from overview_dsp.data.readers.tables.time_column import (
    PLAIN,
    Format,
    requested_format,
    written_unit,
)
from overview_dsp.data.timeline.model import Timeline
from overview_dsp.data.timeline.time_parsing import NS, Moment, clock_s, moment
from overview_dsp.errors import InputError, quoted

MAX_RATE = 100_000.0
"""Maximum sample rate, Hz, above that of any recorder."""

MAX_ROWS = 1 << 26
"""Maximum number of samples: 37 hours at 500 Hz."""

MAX_SAMPLE = 1e12
"""Maximum magnitude of a sample in any unit; larger samples count as missing."""

COMMENTS = ("#", "%", "//")
_HEAD_ROWS = 60
_RATE_ROWS = 1000
_MISSING = TOKENS | {"inf", "-inf", "+inf"}
_BRACKETED = re.compile(r"\[?([\d:.]+)(?: [\d/]+)?\]?", re.ASCII)
_GAP_STEPS = 1.5


@dataclass(frozen=True)
class _Layout:
    """Layout of a table of samples: its dialect, its first rows, and the roles of its columns."""

    dialect: Dialect
    head: list[list[str | None]]
    decimal_mark: str
    numeric: tuple[bool, ...]

    @property
    def names(self) -> tuple[str, ...]:
        return self.dialect.header

    @property
    def has_header(self) -> bool:
        return not all(re.fullmatch(r"column \d+", name) for name in self.names)

    def holds_times(self, i: int) -> bool:
        """Return whether a column begins with a clock time or a date."""
        first = next((cell for cell in self.head[i] if cell), "")
        return _moment_of(_bare(first)) is not None

    def time_column(self) -> int | None:
        """Return the first column of times, by its name or its first cell; None without one."""
        for i, name in enumerate(self.names):
            if (
                self.has_header
                and PATTERNS["sample_time"].match(name)
                and (self.numeric[i] or self.holds_times(i))
            ):
                return i
        return next((i for i in range(len(self.names)) if self.holds_times(i)), None)

    def index_column(self) -> int | None:
        """Return the column of sample numbers; None without one."""
        return next(iter(self._named("sample_number")), None)

    def heart_columns(self) -> list[int]:
        """Return the columns with the name of an ECG lead or a pulse wave."""
        return self._named("heart_signal")

    def _named(self, pattern: str) -> list[int]:
        columns = enumerate(zip(self.names, self.numeric, strict=True))
        return [
            i
            for i, (name, numeric) in columns
            if self.has_header and numeric and PATTERNS[pattern].search(name)
        ]


def sniff(source: DataFile) -> bool:
    """Return whether the file is a table of heart samples, by the option `rate` or its columns."""
    layout = _layout_of(source)
    if layout is None or not any(layout.numeric):
        return False
    options = source.options
    if options.map is not None and options.map not in MAPS:
        return False  # an option for series
    if options.rate is not None:
        return options.rate >= MIN_RATE
    if not layout.heart_columns():
        return False
    time, unit = layout.time_column(), ""
    if options.time is not None:
        with contextlib.suppress(InputError):  # raised again by the reader
            time, unit = _time_column(layout, options)
    if time is None:
        # the reader reports the missing rate
        others = {layout.index_column(), *layout.heart_columns()}
        return all(i in others for i, numeric in enumerate(layout.numeric) if numeric)
    rate = _rate_of(source, layout, time, unit)
    return rate is not None and rate >= MIN_RATE


def read(source: DataFile, options: LoadOptions) -> Timeline:
    """Read a table of samples (takes `rate`, `value`, `time`, `map`, `max_mb`, `progress`).

    InputError: a cell is not a number, the times are not ascending, the column of samples is
    ambiguous, the rate is unknown, or there are no heartbeats. The message contains line and
    column.
    """
    with validation.prefix_errors(f"{source.where}: "):
        check_map(options)
        limit = MAX_TEXT_BYTES if options.max_mb is None else int(options.max_mb * 2**20)
        if source.size > limit:
            raise InputError(
                f"size {source.size / 2**20:.0f} MB, more than the {limit / 2**20:g} MB allowed: "
                "cut it into parts, or raise the limit with max_mb"
            )
        layout = _layout_of(source)
        assert layout is not None  # checked by `sniff`
        time, unit = _time_column(layout, options)
        value = _value_column(layout, options, time)
        table = DelimitedTable(source, layout.dialect)
        values, times, start = _columns(
            table, layout, value, time, lambda part: options.report_progress(part / 2.0)
        )
        notes: tuple[str, ...] = ()
        origin = ""
        if times is not None:
            assert time is not None
            form, why = _format_of(layout, time, times, unit)
            rate, values, notes = _resample(times * PLAIN.get(form.name, 1.0), values)
            origin = f"; times from column {quoted(layout.names[time])} ({form.description}{why})"
        elif options.rate is not None:
            rate = options.rate
            if time is None and (unused := layout.time_column()) is not None:
                notes = (f"the column '{layout.names[unused]}' was not used: rate replaces it",)
        else:
            raise InputError(
                f"the column '{layout.names[value]}' has no times; set the option rate (Hz)"
            )
        if not MIN_RATE <= rate <= MAX_RATE:
            raise InputError(
                f"the rate is {rate:.6g} Hz; must be {MIN_RATE:g} to {MAX_RATE:g} for a heart "
                "recording"
            )
        signal = Samples(layout.names[value], rate, values)
        try:
            detection = find_beats(
                signal, None, lambda part: options.report_progress(0.5 + part / 2.0)
            )
            duration_s = len(values) / rate
            if detection.lost:
                notes = (*notes, f"{detection.lost} single samples are missing")
            found = f"{detection.what}, {signal.name} at {rate:.6g} Hz; beats found in it"
            description = Description(source.stem, duration_s, found + origin, notes, start)
            return detected_timeline(description, detection, signal, (), options)
        except InputError as error:
            if layout.heart_columns():
                raise
            raise InputError(f"{error}, or read a series with map='level' (--map level)") from error


def _layout_of(source: DataFile) -> _Layout | None:
    """Return the layout of a table of samples; None for any other file."""
    dialect = detect(source, lambda header, below: bool(below))
    if dialect is None:
        return None
    header, units = (tuple(map(_bare, names)) for names in (dialect.header, dialect.units))
    dialect = replace(dialect, header=header, units=units)
    try:
        head = first_rows(_head_table(source, dialect), _HEAD_ROWS)
    except InputError:  # the reader of series reports the error
        return None
    decimal_mark = choose_decimal_mark(head, range(len(head)), dialect.separator)
    numeric = []
    for known in map(_known, head):
        numbers = [_number(cell, decimal_mark) for cell in known]
        numeric.append(bool(known) and None not in numbers)
        if not numeric[-1] and any(_moment_of(cell) is None for cell in known):
            return None  # a column of text: a series, not samples
    return _Layout(dialect, head, decimal_mark, tuple(numeric))


def _head_table(source: DataFile, dialect: Dialect) -> DelimitedTable:
    return DelimitedTable("\n".join(head_lines(source, dialect.encoding)), dialect)


def _known(cells: Sequence[str | None]) -> list[str]:
    return [cell for cell in map(_bare, cells) if cell.lower() not in _MISSING]


def _bare(cell: str | None) -> str:
    """Return a cell without spaces and quotes around it."""
    return (cell or "").strip().strip("'\"").strip()


def _number(text: str, decimal_mark: str) -> float | None:
    found = parse(text, decimal_mark)
    return None if found is None or found[1] else found[0]


def _time_column(layout: _Layout, options: LoadOptions) -> tuple[int | None, str]:
    """Return the column of times, and its requested unit or format, or an empty text."""
    if options.time is None:
        return None if options.rate is not None else layout.time_column(), ""
    name, unit = requested_format(options.time, [Column.of(name) for name in layout.names])
    if name is None:
        return layout.time_column(), unit
    columns = range(len(layout.names))
    timed = [i for i in columns if layout.numeric[i] or layout.holds_times(i)]
    return _named_column(layout, name, "times", timed, columns), unit


def _value_column(layout: _Layout, options: LoadOptions, time: int | None) -> int:
    numeric = [i for i, is_numeric in enumerate(layout.numeric) if is_numeric and i != time]
    if options.value is not None:
        return _named_column(layout, options.value, "samples", numeric, numeric)
    hearts = [i for i in layout.heart_columns() if i != time]
    if hearts:
        return hearts[best_signal([layout.names[i] for i in hearts])]
    candidates = [i for i in numeric if i not in (layout.time_column(), layout.index_column())]
    if len(candidates) != 1:
        raise InputError(
            f"{len(candidates)} columns may be the signal: "
            f"{', '.join(layout.names[i] for i in candidates[:20]) or 'none'}; choose one with "
            "value"
        )
    return candidates[0]


def _named_column(
    layout: _Layout, name: str, content: str, allowed: Sequence[int], listed: Sequence[int]
) -> int:
    """Return the column with a name or number; InputError if it is not one of `allowed`."""
    index = index_of(layout.names, name)
    if index is None or index not in allowed:
        raise InputError(
            f"no column of {content} is called {quoted(name)}; available: "
            f"{', '.join(layout.names[i] for i in listed[:20])}"
        )
    return index


def _columns(
    table: DelimitedTable,
    layout: _Layout,
    value: int,
    time: int | None,
    progress: Callable[[float], None],
) -> tuple[NDArray[np.float32], FloatArray | None, datetime | None]:
    """Return a column of values (NaN if missing), one of times, and the first date.

    Times are in the unit of the column, dates in s from the first. They are None without a column,
    and the first date is None if they are not dates.

    InputError: a cell is invalid or missing. The message contains line and column.
    """
    values: list[NDArray[np.float32]] = []
    times: list[FloatArray] = []
    clock = _Clock()
    count = 0
    for chunk in table.chunks([value] if time is None else [value, time]):
        samples = _numbers(chunk.cells[0], cell_locator(table, chunk, value), layout.decimal_mark)
        samples[~(np.abs(samples) <= MAX_SAMPLE)] = np.nan
        values.append(samples.astype(np.float32))
        if time is not None:
            locate = cell_locator(table, chunk, time)
            times.append(_times(layout, time, chunk.cells[1], locate, clock))
        count += len(chunk)
        if count > MAX_ROWS:
            raise InputError(
                f"the file has more than {MAX_ROWS} rows, the maximum; cut it into parts"
            )
        progress(chunk.part)
    start = clock.start.to_datetime() if clock.start is not None else None
    return (
        np.concatenate(values) if values else np.zeros(0, np.float32),
        np.concatenate(times) if times else None,
        start,
    )


def _numbers(
    cells: Cells, locate: Callable[[int], CellLocation], decimal_mark: str, needed: bool = False
) -> FloatArray:
    """Return the numbers of a column; `needed`: a missing number is an error."""
    cells = as_list(cells)
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
            raise locate(i).missing("complete or remove the row")
        if text.lower() in _MISSING:
            if needed:
                raise locate(i).missing(
                    "remove the row, or set the option rate to ignore the times"
                )
            continue
        number = _number(text, decimal_mark)
        if number is None:
            raise locate(i).error(text, "isn't a number")
        found[i] = number if math.isfinite(number) else np.nan
    return found


class _Clock:
    """Parser of clock times and dates as seconds; dates count from the first one."""

    start: Moment | None = None

    def read(self, cells: Cells, locate: Callable[[int], CellLocation]) -> FloatArray:
        found = np.empty(len(cells))
        for i, cell in enumerate(cells):
            time = _moment_of(_bare(cell))
            if self.start is None and isinstance(time, Moment):
                self.start = time
            seconds = _seconds_of(time, self.start)
            if seconds is None:
                raise locate(i).error(
                    cell,
                    "differs in format from the other times; write hh:mm:ss.sss or ISO dates, or "
                    "set the option rate",
                )
            found[i] = seconds
        return found


def _times(
    layout: _Layout, time: int, cells: Cells, locate: Callable[[int], CellLocation], clock: _Clock
) -> FloatArray:
    """Return the times of a column, numbers in the unit of the column."""
    if layout.numeric[time]:
        return _numbers(cells, locate, layout.decimal_mark, needed=True)
    return clock.read(cells, locate)


def _moment_of(entry: str) -> float | Moment | None:
    """Return a clock time in seconds or an ISO date; None for any other text."""
    bracketed = _BRACKETED.fullmatch(entry)
    clock = clock_s(bracketed[1] if bracketed else entry)
    if clock is not None:
        return clock
    return moment(entry, "iso") if entry[4:5] == "-" and len(entry) >= 10 else None


def _seconds_of(moment: float | Moment | None, start: Moment | None) -> float | None:
    """Return seconds from the start; None if the format differs from that of the start."""
    if not isinstance(moment, Moment):
        return moment if start is None else None
    if start is None or (moment.offset_min is None) != (start.offset_min is None):
        return None
    return (moment.ns - start.ns) / NS


def _rate_of(source: DataFile, layout: _Layout, time: int, unit: str) -> float | None:
    """Return the sample rate, Hz, of the first rows; None if it is unknown."""
    cells = first_rows(_head_table(source, layout.dialect), _RATE_ROWS)[time]
    try:
        times = _times(layout, time, cells, CellLocation, _Clock())
    except InputError:
        return None
    if len(times) < 3:
        return None
    try:
        form, _ = _format_of(layout, time, times, unit)
    except InputError:
        return MIN_RATE  # the reader reports the format
    mean = float(np.mean(np.diff(times * PLAIN.get(form.name, 1.0))))
    return 1.0 / mean if mean > 0.0 else None


def _format_of(layout: _Layout, time: int, times: FloatArray, unit: str) -> tuple[Format, str]:
    """Return the format of the times, and how it was found if neither header nor option name it."""
    if not layout.numeric[time]:
        return Format("clock" if _is_clock(layout.head[time]) else "iso"), ""
    column = Column.of(layout.names[time], layout.dialect.units[time])
    unit = unit or (written_unit(column) if layout.has_header else "")
    if unit and unit not in PLAIN:
        raise InputError(
            f"time {quoted(unit)}: numbers of a heart recording are in one of {', '.join(PLAIN)}"
        )
    if unit:
        return Format(unit), ""
    steps = np.diff(times[:10_000])
    step = float(np.median(steps[steps > 0.0])) if (steps > 0.0).any() else math.nan
    for name in ("s", "ms", "us"):
        if MIN_RATE * 0.99 <= 1.0 / (step * PLAIN[name]) <= 5000.0:
            return Format(name), "" if name == "s" else ", detected from the intervals"
    return Format("s"), ""


def _is_clock(cells: Sequence[str | None]) -> bool:
    return any(isinstance(_moment_of(cell), float) for cell in _known(cells)[:1])


def _resample(
    times: FloatArray, values: NDArray[np.float32]
) -> tuple[float, NDArray[np.float32], tuple[str, ...]]:
    """Return the rate, the values at regular intervals (NaN in gaps), and notes."""
    steps = np.diff(times)
    if len(steps) == 0:
        raise InputError("the file has one row of data; must be several seconds of samples")
    if (steps < 0.0).any():
        row = int(np.argmax(steps < 0.0)) + 2
        raise InputError(
            f"the time in row {row} of the data is before that in the previous row; sort the rows, "
            "or set the option rate"
        )
    usual = float(np.median(steps))
    if usual <= 0.0:
        raise InputError(
            "most rows have the same time as the previous row; set the option rate (Hz)"
        )
    # the mean, because times in whole milliseconds may alternate between intervals of 2 and 3 ms
    step = float(np.mean(steps[steps < _GAP_STEPS * usual]))
    rounded = np.rint((times - times[0]) / step)
    if rounded[-1] >= MAX_ROWS:
        raise InputError(
            f"the times span {times[-1] - times[0]:.6g} s at intervals of {step:.3g} s, more than "
            f"the {MAX_ROWS} samples allowed; cut the file into parts"
        )
    index = rounded.astype(np.int64)
    if np.array_equal(index, np.arange(len(index))):
        return 1.0 / step, values, ()
    grid = np.full(int(index[-1]) + 1, np.nan, np.float32)
    grid[index] = values
    # rounding can put two samples into one interval, which leaves a single empty one beside it
    empty = np.ones(len(grid), np.bool_)
    empty[index] = False
    single = np.flatnonzero(empty[1:-1] & ~empty[:-2] & ~empty[2:]) + 1
    grid[single] = (grid[single - 1] + grid[single + 1]) / 2.0
    gaps = int(np.count_nonzero(steps >= _GAP_STEPS * usual + step))
    return 1.0 / step, grid, (f"the times have {gaps} gaps",) if gaps else ()
