"""From the times of samples to a steady rate: their unit, the steps between them, holes."""

from __future__ import annotations

import math
import re

import numpy as np
from numpy.typing import NDArray

from overview_dsp.analysis.heartbeats import MIN_RATE
from overview_dsp.errors import InputError
from overview_dsp.readers.cardiac.table_layout import (
    Layout,
    fields_of,
    is_number,
    is_row,
    moment_of,
)
from overview_dsp.timeline.times import NS, Moment

MAX_ROWS = 1 << 26
"""Most samples that are read: 37 hours at 500 a second."""

_HOLE_STEPS = 1.5
_UNITS = (
    (re.compile(r"\bus\b|µs|μs|micro", re.I), 1e-6, "microseconds"),
    (re.compile(r"\bms\b|msec|milli|_ms$", re.I), 1e-3, "milliseconds"),
    (re.compile(r"\bmin(ute)?s?\b", re.I), 60.0, "minutes"),
    (re.compile(r"\bs\b|\bsec|_s$", re.I), 1.0, "seconds"),
)


def unit_of(
    layout: Layout, time: int | None, times: NDArray[np.float64]
) -> tuple[float, str | None]:
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


def on_a_grid(
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


def rate_of_rows(lines: list[str], layout: Layout, time: int) -> float | None:
    """Return the samples a second that the first lines of data show."""
    rows = [fields_of(line, layout.delimiter) for line in lines[:1000] if is_row(line)]
    entries = [row[time] for row in rows if len(row) == len(layout.names)]
    if layout.numeric[time]:
        comma = layout.decimal_comma
        times = [float(e.replace(",", ".") if comma else e) for e in entries if is_number(e, comma)]
    else:
        moments = [moment_of(entry) for entry in entries]
        start = next((moment for moment in moments if isinstance(moment, Moment)), None)
        seconds = [seconds_of(moment, start) for moment in moments]
        times = [second for second in seconds if second is not None]
    known = np.array(times)
    if len(known) < 3 or not np.isfinite(known).all():
        return None
    steps = np.diff(known * unit_of(layout, time, known)[0])
    mean = float(np.mean(steps))
    return 1.0 / mean if mean > 0.0 else None


def seconds_of(moment: float | Moment | None, start: Moment | None) -> float | None:
    """Return a moment as seconds from the start; None for what doesn't go with the others."""
    if not isinstance(moment, Moment):
        return moment if start is None else None
    if start is None or (moment.offset_min is None) != (start.offset_min is None):
        return None
    return (moment.ns - start.ns) / NS
