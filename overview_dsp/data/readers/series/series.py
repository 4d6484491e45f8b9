"""From a table to a timeline: what is read, how, and what came of it.

Series: a table with a column of times and one of values becomes a Timeline.

The times of samples stay exact: time 0 is the first row's, the duration reaches to the last row's,
and no step is added for what the last sample covers. The curve is the mapped column (`curve_maps`)
in its own unit; its percentiles say what becomes 0 and 1. Events are found by rule in the value
column (`series_events`), gaps are missing values and holes (`series_gaps`).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from overview_dsp import validation
from overview_dsp.data.analysis.curve_maps import PERCENTILES
from overview_dsp.data.analysis.series_events import find_events
from overview_dsp.data.analysis.series_labels import value_text
from overview_dsp.data.analysis.window_rules import PartRules
from overview_dsp.data.readers.series import counting
from overview_dsp.data.readers.series.plan import (
    Found,
    Plan,
    plan_of,
)
from overview_dsp.data.readers.series.rows import RowReader
from overview_dsp.data.readers.series.samples import look_at
from overview_dsp.data.readers.source import LoadOptions, Source
from overview_dsp.data.readers.tables.groups import chosen_group, refuse_groups
from overview_dsp.data.readers.tables.table import Table
from overview_dsp.data.timeline.intensity import LONG
from overview_dsp.data.timeline.model import Timeline
from overview_dsp.errors import InputError, shown

OPTIONS = frozenset({"value", "time", "map", "rate", "match", "max_mb"})
"""The load options a series takes."""

MAX_MB = 8192.0
"""Largest table that is read, MB (2**20 bytes), unless `max_mb` says otherwise."""

_TRACKS = ("GPX", "TCX")

MANY_REPEATS = 0.02
"""Share of rows with the time of another from which a table may hold several series."""


def reading(open_table: Callable[[Source], Table]) -> Callable[[Source, LoadOptions], Timeline]:
    """Return what reads a series from the table of a file; InputError names file, row, column."""

    def read(source: Source, options: LoadOptions) -> Timeline:
        limit = options.max_mb if options.max_mb is not None else MAX_MB
        if source.size > limit * 2**20:
            raise InputError(
                f"{source.where}: {source.size / 2**20:.0f} MB, more than the {limit:g} MB that "
                "are read; keep fewer columns or rows, or raise the limit with max_mb (--max-mb)"
            )
        with validation.located(f"{source.where}: "):
            return series_of(open_table(source), options, source.stem)

    return read


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
    if counting.asked_of(table, options):
        return counting.counted(table, options, title)
    if options.value is None and table.kind in _TRACKS:
        options = replace(options, value=table.columns[1].header)  # speed, or what there is
    plan = plan_of(table, options, title)
    reader = RowReader(
        table, plan.time, plan.columns, plan.style, options.rate, options.report_progress
    )
    found = look_at(plan, reader)
    repeats = reader.rows - found.count
    if options.match is None and repeats > MANY_REPEATS * reader.rows:
        refuse_groups(table, plan.time.columns, plan.value)
    return _timeline(plan, found, title)


def _timeline(plan: Plan, found: Found, title: str) -> Timeline:
    column = plan.value_column
    events, event_notes = find_events(found.series, found.duration_s)
    notes = [*plan.notes, *found.notes]
    if found.missing:
        notes.append(f"{found.missing} of {found.count} values are missing: gaps")
    notes += [_gap_note(found), _scale_note(found), *event_notes]
    names = " and ".join(shown(plan.table.columns[i].header) for i in plan.time.columns)
    times = f"over {names} ({plan.time.format.words})" if names else "evenly spaced"
    return Timeline(
        title=": ".join(filter(None, (title, column.name))),
        duration_s=found.duration_s,
        events=tuple(events),
        intensity=found.intensity,
        gaps=found.gaps,
        provenance=(
            f"a {plan.table.kind} table, column {shown(column.header)} {times}; events by rule"
        ),
        notes=tuple(notes),
        start=found.series.calendar.start,
        rules=_rules(plan, found),
    )


def _rules(plan: Plan, found: Found) -> PartRules:
    """What finds events in windows: in all samples, also where the series has but some of them."""
    is_level = plan.map.name == "level" and not found.series.every
    curve = found.intensity if is_level else None
    return PartRules(found.series, 0.0, found.duration_s, curve, found.gaps)


def _scale_note(found: Found) -> str:
    curve = found.intensity
    if curve.count > LONG:
        low, high = curve.scale_outside(found.gaps)
    else:
        low, high = curve.scale(np.ones(curve.count, np.bool_))
    return (
        f"friction follows {found.words}: 0 at {value_text(low, curve.unit)} and 1 at "
        f"{value_text(high, curve.unit)} (percentiles {PERCENTILES[0]:g} and {PERCENTILES[1]:g}); "
        "values beyond are clipped in that scale alone"
    )


def _gap_note(found: Found) -> str:
    if not found.gaps:
        return f"no gaps ({found.gap_rule})"
    longest = max(end - start for start, end in found.gaps)
    total = sum(end - start for start, end in found.gaps)
    days = f"{longest / 86_400:.4g} days" if longest >= 2 * 86_400 else f"{longest:.6g} s"
    share = f"{len(found.gaps)} gap{'s' if len(found.gaps) > 1 else ''}, the longest {days}"
    return f"{share}, {total:.6g} s in all, from the last value to the next ({found.gap_rule})"
