"""ECG and pulse waves as tables of samples (CSV, TSV, columns of numbers).

Claimed if `rate` is given (50 a second or more), or a column is called like an ECG lead or a pulse
wave and a column of times shows 50 samples a second or more. (A series of numbers with times, also
of heart rates, is no such signal.) Times may be seconds, milliseconds or microseconds, clock times
or ISO dates; what lies between them decides the rate, and a hole between them is a gap.

Known quirks: no header; a second row of units (PhysioNet's `rdsamp -c -v`), names in single quotes,
a column that counts the samples, decimal commas where semicolons or tabs separate, comment lines
(`#`, `%`), columns separated by blanks. Columns are read line by line in bounded memory.
"""

from __future__ import annotations

import io
import math
import re
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from datetime import datetime
from itertools import islice

import numpy as np
from numpy.typing import NDArray

from overview_dsp.errors import InputError
from overview_dsp.readers.cardiac.build import (
    MAPS,
    About,
    check_map,
    detected,
    gaps_of,
    heart_timeline,
)
from overview_dsp.readers.cardiac.detection import MIN_RATE, find_beats
from overview_dsp.readers.cardiac.signal import recorded
from overview_dsp.readers.cardiac.wfdb_signal import best_signal
from overview_dsp.readers.source import MAX_TEXT_BYTES, LoadOptions, Source, text_encoding
from overview_dsp.timeline import checks
from overview_dsp.timeline.model import Timeline

MAX_RATE = 100_000.0
"""Samples a second; no electrode delivers more."""

_HOLE_STEPS = 1.5
_LINE_ENDS = re.compile(r"\r\n|\r|\n")  # what a file opened as text ends lines at
_UNITS = (
    (re.compile(r"\bus\b|µs|μs|micro", re.I), 1e-6, "microseconds"),
    (re.compile(r"\bms\b|msec|milli|_ms$", re.I), 1e-3, "milliseconds"),
    (re.compile(r"\bmin(ute)?s?\b", re.I), 60.0, "minutes"),
    (re.compile(r"\bs\b|\bsec|_s$", re.I), 1.0, "seconds"),
)


@dataclass(frozen=True, eq=False)
class Samples:
    """A signal in memory (`heart.signal.Signal`)."""

    name: str
    rate: float
    values: NDArray[np.float32]

    @property
    def length(self) -> int:
        """How many samples."""
        return len(self.values)

    def read(self, first: int, end: int) -> NDArray[np.float64]:
        """Return samples, NaN = missing."""
        return self.values[first:end].astype(np.float64)


def sniff(source: Source) -> bool:
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
    rate = _rate_of_head(source, layout, time)
    return rate is not None and rate >= MIN_RATE


def read(source: Source, options: LoadOptions) -> Timeline:
    """Read a table of samples (takes `rate`, `value`, `time`, `map`, `max_mb`, `progress`).

    Raises
    ------
    InputError
        Names line and column: a word for a number, times that run backwards; the columns to choose
        from; no rate; no heartbeat.
    """
    with checks.located(f"{source.where}: "):
        check_map(options)
        layout = _layout_of(source)
        assert layout is not None  # sniffed
        time = _time_column(layout, options)
        value = _value_column(layout, options, time)
        values, times, start = read_columns(
            source,
            layout,
            value,
            time,
            options.max_mb,
            lambda part: options.report_progress(part / 2.0),
        )
        notes: tuple[str, ...] = ()
        if times is not None:
            unit = _unit(layout, time, times)
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
        gaps = gaps_of(detection.silent, detection.noisy, rate, duration_s)
        timeline = heart_timeline(about, detected(detection, rate), gaps, (), options)
        return replace(timeline, signal=recorded(signal))


def _layout_of(source: Source) -> Layout | None:
    if source.head_text is None or source.looks_like_json:
        return None
    lines = _LINE_ENDS.split(source.head_text)
    # the last one may be cut
    return layout_of(lines if source.size <= len(source.head) else lines[:-1])


def _time_column(layout: Layout, options: LoadOptions) -> int | None:
    if options.time is not None:
        found = layout.column(options.time)
        if found is None or not (layout.numeric[found] or is_moment(layout.first[found])):
            raise InputError(
                f"no column of times is called {checks.shown(options.time)}; there is "
                f"{', '.join(layout.names[:20])}"
            )
        return found
    return None if options.rate is not None else layout.time_column()


def _value_column(layout: Layout, options: LoadOptions, time: int | None) -> int:
    numeric = [i for i, is_numeric in enumerate(layout.numeric) if is_numeric]
    if options.value is not None:
        found = layout.column(options.value)
        if found is None or found not in numeric or found == time:
            raise InputError(
                f"no column of samples is called {checks.shown(options.value)}; there is "
                f"{', '.join(layout.names[i] for i in numeric[:20] if i != time)}"
            )
        return found
    hearts = [i for i in layout.heart_columns() if i != time]
    if hearts:
        return hearts[best_signal([layout.names[i] for i in hearts])]
    aside = {time, layout.time_column(), layout.index_column()}
    left = [i for i in numeric if i not in aside]
    if len(left) != 1:
        raise InputError(
            f"{len(left)} columns may be the signal: "
            f"{', '.join(layout.names[i] for i in left[:20]) or 'none'}; choose one with value"
        )
    return left[0]


def _unit(layout: Layout, time: int | None, times: NDArray[np.float64]) -> tuple[float, str | None]:
    """Return what a time is in seconds, and its name where it was guessed from the steps."""
    assert time is not None
    if not layout.numeric[time]:
        return 1.0, None
    words = layout.names[time] if layout.headed else ""
    if layout.units:
        words += " " + layout.units[time]
    for pattern, seconds, _ in _UNITS:
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


def _rate_of_head(source: Source, layout: Layout, time: int) -> float | None:
    """Return the samples a second the first rows show."""
    assert source.head_text is not None
    lines = _LINE_ENDS.split(source.head_text)[layout.first_row - 1 :]
    rows = [fields_of(line, layout.delimiter) for line in lines[:1000] if is_row(line)]
    entries = [row[time] for row in rows if len(row) == len(layout.names)]
    if layout.numeric[time]:
        comma = layout.decimal_comma
        times = [float(e.replace(",", ".") if comma else e) for e in entries if is_number(e, comma)]
    else:
        moments = [moment_of(entry) for entry in entries]
        start = next((moment for moment in moments if isinstance(moment, datetime)), None)
        seconds = [seconds_of(moment, start) for moment in moments]
        times = [second for second in seconds if second is not None]
    known = np.array(times)
    if len(known) < 3 or not np.isfinite(known).all():
        return None
    steps = np.diff(known * _unit(layout, time, known)[0])
    mean = float(np.mean(steps))
    return 1.0 / mean if mean > 0.0 else None


COMMENTS = ("#", "%", "//")
MISSING = frozenset({"", "-", ".", "na", "n/a", "nan", "null", "none", "inf", "-inf", "+inf"})
"""What stands for no value, in small letters."""

_HEAD_ROWS = 60
_NUMBER = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)(e[-+]?\d+)?", re.ASCII | re.I)
_COMMA_NUMBER = re.compile(r"[-+]?\d+,\d+(e[-+]?\d+)?", re.ASCII | re.I)
_CLOCK = re.compile(
    r"\[?(?:(\d{1,6}):)?(\d{1,6}):(\d{1,6}(?:\.\d{0,12})?)(?: [\d/]+)?\]?", re.ASCII
)
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


def moment_of(entry: str) -> float | datetime | None:
    """Return a clock time as seconds, an ISO date as such; None for what is neither."""
    clock = _CLOCK.fullmatch(entry)
    if clock is not None:
        hours, minutes, seconds = clock.groups()
        return float(hours or 0) * 3600.0 + float(minutes) * 60.0 + float(seconds)
    if len(entry) < 10 or entry[4] != "-":  # also "20200101" is a date to Python
        return None
    try:
        return datetime.fromisoformat(entry)
    except ValueError:
        return None


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


MAX_ROWS = 1 << 26
"""Most samples that are read: 37 hours at 500 a second."""

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
        clock.start,
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
            raise InputError(f"{place}: {checks.shown(entry)} isn't a number")
        given = float(entry.replace(",", ".") if layout.decimal_comma else entry)
        found[i] = given if math.isfinite(given) else np.nan
    return found


def seconds_of(moment: float | datetime | None, start: datetime | None) -> float | None:
    """Return a moment as seconds from the start; None for what doesn't go with the others."""
    if not isinstance(moment, datetime):
        return moment if start is None else None
    if start is None or (moment.tzinfo is None) != (start.tzinfo is None):
        return None
    return (moment - start).total_seconds()


class _Clock:
    """Reads dates and clock times as seconds, dates from the first one."""

    def __init__(self) -> None:
        self.start: datetime | None = None

    def read(
        self, rows: list[list[str]], numbered: list[tuple[int, str]], column: int, name: str
    ) -> NDArray[np.float64]:
        found = np.empty(len(rows))
        for i, row in enumerate(rows):
            entry = row[column] if column < len(row) else ""
            moment = moment_of(entry)
            if self.start is None and isinstance(moment, datetime):
                self.start = moment
            seconds = seconds_of(moment, self.start)
            if seconds is None:
                raise InputError(
                    f"line {numbered[i][0]}, column '{name}': {checks.shown(entry)} is no time "
                    "like the others; write hh:mm:ss.sss or ISO dates, or give the rate instead"
                )
            found[i] = seconds
        return found
