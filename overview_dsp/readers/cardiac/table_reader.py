"""ECG and pulse waves as tables of samples (CSV, TSV, columns of numbers).

Claimed if `rate` is given (50 a second or more), or a column is called like an ECG lead or a pulse
wave and a column of times shows 50 samples a second or more. (A series of numbers with times, also
of heart rates, is no such signal.) Times may be seconds, milliseconds or microseconds, clock times
or ISO dates; what lies between them decides the rate, and a hole between them is a gap.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from datetime import datetime

import numpy as np
from numpy.typing import NDArray

from overview_dsp.errors import InputError
from overview_dsp.readers.cardiac.build import (
    MAPS,
    About,
    check_map,
    detected,
    heart_timeline,
    in_seconds,
)
from overview_dsp.readers.cardiac.detection import MIN_RATE, find_beats
from overview_dsp.readers.cardiac.table_layout import (
    Layout,
    fields_of,
    is_moment,
    is_number,
    is_row,
    layout_of,
    moment_of,
)
from overview_dsp.readers.cardiac.table_rows import MAX_ROWS, read_columns, seconds_of
from overview_dsp.readers.cardiac.wfdb_signal import best_signal
from overview_dsp.readers.source import LoadOptions, Source
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
    """Tell whether the file is a table of samples of a heart, by the rate given or its columns."""
    layout = _layout(source)
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
        from; no rate; no heartbeat; SleepECG isn't installed.
    """
    with checks.located(f"{source.where}: "):
        check_map(options)
        layout = _layout(source)
        assert layout is not None  # sniffed
        time = _time_column(layout, options)
        value = _value_column(layout, options, time)
        values, times, start = read_columns(
            source, layout, value, time, options.max_mb, lambda part: options.tell(part / 2.0)
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
        detection = find_beats(signal, None, lambda part: options.tell(0.5 + part / 2.0))
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
        gaps = in_seconds(detection.silent, rate, duration_s)
        return heart_timeline(about, detected(detection, rate), gaps, (), options)


def _layout(source: Source) -> Layout | None:
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
