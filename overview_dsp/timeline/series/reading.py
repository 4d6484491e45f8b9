"""Series: a table with a column of times and one of values becomes a Timeline.

The times of samples stay exact: time 0 is the first row's, the duration reaches to the last row's,
and no step is added for what the last sample covers. The curve is the mapped column (`mapping`) in
its own unit; its percentiles say what becomes 0 and 1. Events are found by rule in the value column
(`events`), gaps are missing values and holes (`holes`).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from overview_dsp.errors import InputError
from overview_dsp.timeline import checks
from overview_dsp.timeline.gaps import Gaps
from overview_dsp.timeline.model import Intensity, Timeline
from overview_dsp.timeline.series import (
    mapping,
    prices,
    table_csv,
    table_json,
    table_json_lines,
    table_parquet,
)
from overview_dsp.timeline.series.choosing import TimeChoice, choose_time, choose_value
from overview_dsp.timeline.series.events import Series, find_events
from overview_dsp.timeline.series.grouping import chosen_group, refuse_groups
from overview_dsp.timeline.series.holes import find_holes, gaps_of
from overview_dsp.timeline.series.mapping import PERCENTILES, Map
from overview_dsp.timeline.series.numbers import Style, told_style
from overview_dsp.timeline.series.samples import RowReader, Samples, gather, settled
from overview_dsp.timeline.series.splits import Split, find_splits
from overview_dsp.timeline.series.table import Column, Table, column_named, first_rows
from overview_dsp.timeline.series.words import Calendar, value_text
from overview_dsp.timeline.source import LoadOptions, Source

OPTIONS = frozenset({"value", "time", "map", "rate", "match", "max_mb"})
"""The load options a series takes."""

MAX_MB = 8192.0
"""Largest table that is read, MB (2**20 bytes), unless `max_mb` says otherwise."""

HEAD_ROWS = 500
"""Rows that tell what columns hold."""

MANY_REPEATS = 0.02
"""Share of rows with the time of another from which a table may hold several series."""

sniff_csv = table_csv.sniff
sniff_json = table_json.sniff
sniff_json_lines = table_json_lines.sniff
sniff_parquet = table_parquet.sniff


def read_csv(source: Source, options: LoadOptions) -> Timeline:
    """Read text with separated fields; InputError names file, line and column."""
    return _read(source, options, table_csv.open_table)


def read_json(source: Source, options: LoadOptions) -> Timeline:
    """Read a JSON document; InputError names file, record and column."""
    return _read(source, options, table_json.open_table)


def read_json_lines(source: Source, options: LoadOptions) -> Timeline:
    """Read one JSON object a line; InputError names file, line and column."""
    return _read(source, options, table_json_lines.open_table)


def read_parquet(source: Source, options: LoadOptions) -> Timeline:
    """Read Parquet; InputError names file, row and column, or says how to install pyarrow."""
    return _read(source, options, table_parquet.open_table)


def _read(source: Source, options: LoadOptions, open_table: Callable[[Source], Table]) -> Timeline:
    limit = options.max_mb if options.max_mb is not None else MAX_MB
    if source.size > limit * 2**20:
        raise InputError(
            f"{source.where}: {source.size / 2**20:.0f} MB, more than the {limit:g} MB that are "
            "read; keep fewer columns or rows, or raise the limit (max_mb)"
        )
    with checks.located(f"{source.where}: "):
        return series_of(open_table(source), options, source.stem)


@dataclass(frozen=True)
class _Chosen:
    """What is read from a table."""

    time: TimeChoice
    value: int
    mapped: int
    map: Map
    columns: tuple[int, ...]
    notes: tuple[str, ...]


def series_of(table: Table, options: LoadOptions, title: str = "") -> Timeline:
    """Make a Timeline of a table.

    Parameters
    ----------
    table
        Any `Table`.
    options
        `value`, `time`, `map`, `rate`, `match`.
    title
        Words for a person; the value column's name is added.

    Raises
    ------
    InputError
        A column to choose, a bad cell (its row and column named), too little data.
    """
    if options.match is not None:
        table = chosen_group(table, options.match)
    chosen, style = _chosen(table, options)
    reader = RowReader(table, chosen.time, chosen.columns, style, options.rate, options.tell)
    samples = gather(reader)
    repeats = reader.rows - len(samples.time_s)
    if options.match is None and repeats > MANY_REPEATS * reader.rows:
        refuse_groups(table, chosen.time.columns, chosen.value)
    return _timeline(table, chosen, samples, title)


def _chosen(table: Table, options: LoadOptions) -> tuple[_Chosen, Style]:
    head = first_rows(table, HEAD_ROWS)
    time = choose_time(table, head, options.time, options.rate is not None)
    if options.rate is not None and time.columns:
        raise InputError("rate and time are both given; leave one out")
    time = settled(table, time)
    value = choose_value(table, head, options.value, time.columns)
    headers = frozenset(
        word for c in table.columns for word in (c.header.lower(), c.name.lower()) if word
    )
    wanted = Map.of(options.map, headers)
    mapped = value.column
    if wanted.name == "column":
        found = column_named(table.columns, wanted.argument)
        assert found is not None  # Map.of saw it
        mapped = found
    columns = [value.column]
    if mapped != value.column:
        columns.append(mapped)
    if _is_price(table, value.column):
        for find in (prices.adjusted, prices.opening, prices.volume):
            beside = find(table.columns)
            if beside is not None and beside not in (*columns, *time.columns):
                columns.append(beside)
    style = _style(table, head, columns)
    notes = tuple(note for note in (*table.notes, *time.notes, value.note) if note)
    return _Chosen(time, value.column, mapped, wanted, tuple(columns), notes), style


def _is_price(table: Table, column: int) -> bool:
    return prices.is_price(table.columns[column])


def _style(table: Table, head: list[list[object]], columns: list[int]) -> Style:
    """The way numbers are written: told by the columns that are read, else by any other."""
    told = told_style(cell for i in columns for cell in head[i])
    if told is None:
        told = told_style(cell for cells in head for cell in cells)
    if told is None and getattr(table, "separator", ",") not in (",", None):
        # nothing tells 1,234 from 1.234: semicolons come from where a comma is the decimal mark
        has_comma = any(isinstance(c, str) and "," in c for i in columns for c in head[i])
        told = Style(",") if has_comma else None
    return told or Style()


def _timeline(table: Table, chosen: _Chosen, samples: Samples, title: str) -> Timeline:
    column = table.columns[chosen.value]
    by_column = dict(zip(chosen.columns, samples.values, strict=True))
    units = dict(zip(chosen.columns, samples.units, strict=True))
    value = by_column[chosen.value]
    unit = column.unit or units[chosen.value]
    time_s = samples.time_s
    duration_s = float(time_s[-1])
    notes = [*chosen.notes, *samples.notes]

    holes = find_holes(time_s, samples.start)
    mapped_level = by_column[chosen.mapped]
    gaps = gaps_of(time_s, np.where(np.isnan(mapped_level), np.nan, value), holes.after)
    missing = int(np.isnan(value).sum())
    if missing:
        notes.append(f"{missing} of {len(value)} values are missing: gaps")
    notes.append(_gap_note(gaps, holes.rule))

    price = prices.is_price(column) or unit in prices.CURRENCIES
    relative = price or mapping.grows_like_a_price(value)
    splits = _splits(table, chosen, by_column) if relative else []
    dates_only = samples.start is not None and not np.any(np.mod(np.round(time_s, 6), 86_400.0))
    calendar = Calendar(samples.start, bool(dates_only) and _at_midnight(samples))
    notes += _split_notes(table, chosen, value, time_s, splits, calendar)

    step = mapping.steps(value, holes.after, relative, {s.index: s.factor for s in splits})
    known = ~np.isnan(value)
    index = np.cumsum(known) - 1
    series = Series(
        time_s[known],
        value[known],
        step[known],
        relative,
        unit,
        calendar,
        tuple(Split(int(index[s.index]), s.ratio, s.factor) for s in splits),
    )
    events, event_notes = find_events(series, duration_s)
    if relative and not price:
        event_notes.append("it grows like a price: steps are per cent, prominence is relative")

    curve, curve_unit, words = _curve(table, chosen, by_column, units, step, time_s, relative)
    intensity = _intensity(time_s, curve, curve_unit)
    low, high = intensity.scale(np.ones(len(intensity.value), np.bool_))
    notes.append(
        f"friction follows {words}: 0 at {value_text(low, curve_unit)} and 1 at "
        f"{value_text(high, curve_unit)} (percentiles {PERCENTILES[0]:g} and {PERCENTILES[1]:g}); "
        "values beyond are clipped in that scale alone"
    )
    notes += event_notes
    header = checks.shown(column.header)
    times = " and ".join(checks.shown(table.columns[i].header) for i in chosen.time.columns)
    times = f"over {times} ({chosen.time.format.words})" if times else "evenly spaced"
    return Timeline(
        title=f"{title}: {column.name}" if column.name else title,
        duration_s=duration_s,
        events=tuple(events),
        intensity=intensity,
        gaps=gaps,
        provenance=f"a {table.kind} table, column {header} {times}; events by rule",
        notes=tuple(notes),
        start=samples.start,
    )


def _at_midnight(samples: Samples) -> bool:
    start = samples.start
    return start is not None and (start.hour, start.minute, start.second) == (0, 0, 0)


def _gap_note(gaps: Gaps, rule: str) -> str:
    if not gaps:
        return f"no gaps ({rule})"
    longest = max(end - start for start, end in gaps)
    total = sum(end - start for start, end in gaps)
    days = f"{longest / 86_400:.4g} days" if longest >= 2 * 86_400 else f"{longest:.6g} s"
    share = f"{len(gaps)} gap{'s' if len(gaps) > 1 else ''}, the longest {days}"
    return f"{share}, {total:.6g} s in all, from the last value to the next ({rule})"


def _splits(
    table: Table, chosen: _Chosen, by_column: dict[int, NDArray[np.float64]]
) -> list[Split]:
    column = table.columns[chosen.value]
    if prices.is_adjusted(column):
        return []

    def beside(found: int | None) -> NDArray[np.float64] | None:
        return None if found is None else by_column.get(found)

    opening = beside(prices.opening(table.columns))
    if prices.opening(table.columns) == chosen.value:
        opening = None
    return find_splits(
        by_column[chosen.value],
        beside(prices.adjusted(table.columns)),
        opening,
        beside(prices.volume(table.columns)),
    )


def _split_notes(
    table: Table,
    chosen: _Chosen,
    value: NDArray[np.float64],
    time_s: NDArray[np.float64],
    splits: list[Split],
    calendar: Calendar,
) -> list[str]:
    if not splits:
        return []
    adjusted = prices.adjusted(table.columns)
    header = checks.shown(table.columns[chosen.value].header)
    if adjusted is not None:
        advice = f"use value={checks.shown(table.columns[adjusted].header)}, which is"
    else:
        advice = "the table has no adjusted column; get prices that are"
    shown = []
    known = np.flatnonzero(~np.isnan(value))
    for split in splits[:6]:
        before = value[known[np.searchsorted(known, split.index) - 1]]
        shown.append(
            f"{split.ratio} on {calendar.text(float(time_s[split.index]))} "
            f"({value_text(float(before))} to {value_text(float(value[split.index]))})"
        )
    more = f" and {len(splits) - 6} more" if len(splits) > 6 else ""
    return [
        f"column {header} isn't adjusted for share splits: {', '.join(shown)}{more}; these steps "
        f"are no moves, but the level jumps: {advice}"
    ]


def _curve(
    table: Table,
    chosen: _Chosen,
    by_column: dict[int, NDArray[np.float64]],
    units: dict[int, str],
    step: NDArray[np.float64],
    time_s: NDArray[np.float64],
    relative: bool,
) -> tuple[NDArray[np.float64], str, str]:
    """The mapped values (NaN = missing), their unit, and what they are in words."""
    column: Column = table.columns[chosen.mapped]
    unit = column.unit or units[chosen.mapped]
    level = by_column[chosen.mapped]
    header = checks.shown(column.header)
    name, wish = chosen.map.name, chosen.map
    if name in ("level", "column"):
        return level, unit, f"the level of {header}"
    if wish.argument in ("percent", "difference") and (wish.argument == "percent") != relative:
        relative = wish.argument == "percent"
        breaks = np.flatnonzero(np.isnan(step[1:]) & ~np.isnan(level[1:]) & ~np.isnan(level[:-1]))
        step = mapping.steps(level, breaks, relative)
    change_unit = "%" if relative else unit
    wanted = ~np.isnan(level)
    if name == "volatility":
        window, seconds = wish.window()
        curve = mapping.volatility(step, time_s, window, seconds)
        span = f"{wish.argument or f'{window:g} samples'}"
        curve = mapping.filled(np.where(wanted, curve, np.nan), wanted)
        words = f"the volatility of {header} (standard deviation of changes, last {span})"
        return curve, change_unit, words
    change = mapping.filled(step, wanted)
    if name == "change":
        return change, change_unit, f"the change of {header} from one sample to the next"
    return np.abs(change), change_unit, f"the activity of {header} (size of its changes)"


def _intensity(time_s: NDArray[np.float64], curve: NDArray[np.float64], unit: str) -> Intensity:
    known = ~np.isnan(curve)
    if not known.any():
        raise InputError("the mapped column has no value in any row; name another")
    return Intensity(time_s[known], curve[known], unit, PERCENTILES)
