"""Reader of series: a table with a column of times and one of values becomes a Timeline."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from overview_dsp import validation
from overview_dsp.data.readers.data_file import DataFile, LoadOptions
from overview_dsp.data.readers.series import counting
from overview_dsp.data.readers.series.read_plan import make_read_plan
from overview_dsp.data.readers.series.rows import RowReader
from overview_dsp.data.readers.series.sample_scan import scan_samples
from overview_dsp.data.readers.tables.groups import (
    MANY_REPEATS,
    require_single_series,
    selected_group,
)
from overview_dsp.data.readers.tables.table import Table, headers_of
from overview_dsp.data.timeline.model import Timeline

OPTIONS = frozenset({"value", "time", "map", "rate", "match", "max_mb"})
"""Load options of series."""

MAX_MB = 8192.0
"""Maximum size of a table, MB (2**20 bytes), unless `max_mb` is set."""

_TRACKS = ("GPX", "TCX", "FIT")  # kinds of tables with positions


def reading(open_table: Callable[[DataFile], Table]) -> Callable[[DataFile, LoadOptions], Timeline]:
    """Return a reader for files of series; its InputError names file, row and column."""

    def read(source: DataFile, options: LoadOptions) -> Timeline:
        limit = options.max_mb if options.max_mb is not None else MAX_MB
        source.require_size(limit, "keep fewer columns or rows")
        with validation.prefix_errors(f"{source.where}: "):
            return series_timeline(open_table(source), options, source.stem)

    return read


def series_timeline(table: Table, options: LoadOptions, title: str = "") -> Timeline:
    """Return the Timeline of a table.

    `table`: any `Table`.
    `options`: `value`, `time`, `map`, `rate`, `match`.
    `title`: title, to which the name of the value column is added.

    InputError: an ambiguous choice of columns, a wrong cell (with its row and column), too few
    rows.
    """
    group = selected_group(table, options)
    if group is not None:
        table = group
        texts = [text for text in group.texts.values() if text is not None]
        title = ", ".join((title, *texts)) if title else title
    # a column may be called `count`
    if options.counts and (options.map or "").strip().lower() not in headers_of(table.columns):
        return counting.count_rows(table, options, title)
    if options.value is None and table.kind in _TRACKS:
        options = replace(options, value=table.columns[1].header)  # speed, if known
    plan = make_read_plan(table, options, title)
    require_single_series(table, plan.time, plan.columns)
    reader = RowReader(
        table, plan.time, plan.columns, plan.decimal_mark, options.rate, options.report_progress
    )
    scan = scan_samples(plan, reader)
    if reader.rows - scan.count > MANY_REPEATS * reader.rows:
        require_single_series(table, plan.time, plan.columns, numbers=True)
    return scan.timeline(title)
