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

from dataclasses import replace

from overview_dsp import validation
from overview_dsp.analysis.heart_signal import Samples, recorded
from overview_dsp.analysis.heartbeats import MIN_RATE, find_beats
from overview_dsp.errors import InputError, shown
from overview_dsp.readers.cardiac.build import (
    MAPS,
    About,
    check_map,
    detected,
    gaps_of,
    heart_timeline,
)
from overview_dsp.readers.cardiac.sample_times import on_a_grid, rate_of_rows, unit_of
from overview_dsp.readers.cardiac.table_columns import read_columns
from overview_dsp.readers.cardiac.table_layout import LINE_ENDS, Layout, is_moment, layout_of
from overview_dsp.readers.cardiac.wfdb_signal import best_signal
from overview_dsp.readers.source import LoadOptions, Source
from overview_dsp.timeline.model import Timeline

MAX_RATE = 100_000.0
"""Samples a second; no electrode delivers more."""


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
    rate = rate_of_rows(_rows(source, layout), layout, time)
    return rate is not None and rate >= MIN_RATE


def read(source: Source, options: LoadOptions) -> Timeline:
    """Read a table of samples (takes `rate`, `value`, `time`, `map`, `max_mb`, `progress`).

    Raises
    ------
    InputError
        Names line and column: a word for a number, times that run backwards; the columns to choose
        from; no rate; no heartbeat.
    """
    with validation.located(f"{source.where}: "):
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
            unit = unit_of(layout, time, times)
            rate, values, notes = on_a_grid(times * unit[0], values, unit[1])
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
    lines = LINE_ENDS.split(source.head_text)
    # the last one may be cut
    return layout_of(lines if source.size <= len(source.head) else lines[:-1])


def _time_column(layout: Layout, options: LoadOptions) -> int | None:
    if options.time is not None:
        found = layout.column(options.time)
        if found is None or not (layout.numeric[found] or is_moment(layout.first[found])):
            raise InputError(
                f"no column of times is called {shown(options.time)}; there is "
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
                f"no column of samples is called {shown(options.value)}; there is "
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


def _rows(source: Source, layout: Layout) -> list[str]:
    """Return the lines of data in the file's head."""
    assert source.head_text is not None
    return LINE_ENDS.split(source.head_text)[layout.first_row - 1 :]
