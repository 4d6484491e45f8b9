"""What is read from a table, as asked for or detected from its first rows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from overview_dsp.data.analysis.curve_maps import Map
from overview_dsp.data.readers.series.prices import Worth, asked_kind, worth_of
from overview_dsp.data.readers.series.rows import settled
from overview_dsp.data.readers.source import LoadOptions
from overview_dsp.data.readers.tables.cells import Style, detected_style
from overview_dsp.data.readers.tables.column_roles import (
    TimeChoice,
    choose_time,
    choose_value,
    price_columns,
)
from overview_dsp.data.readers.tables.table import (
    Column,
    Head,
    Table,
    column_named,
    first_rows,
    headers_of,
)
from overview_dsp.errors import InputError

HEAD_ROWS = 500


@dataclass(frozen=True)
class Plan:
    """Which columns are read, and as what.

    Parameters
    ----------
    table
        The table.
    time
        Its times.
    value, mapped
        Indices of the columns of values and of what becomes friction.
    map
        How the mapped column becomes friction.
    columns
        All columns that are read besides the times: the value first, then the mapped one if it is
        another, then what shows share splits.
    style
        How numbers are written.
    notes
        What was decided.
    worth
        Whether the values are prices.
    """

    table: Table
    time: TimeChoice
    value: int
    mapped: int
    map: Map
    columns: tuple[int, ...]
    style: Style
    notes: tuple[str, ...]
    worth: Worth

    @property
    def value_column(self) -> Column:
        """The column of values."""
        return self.table.columns[self.value]

    @property
    def mapped_column(self) -> Column:
        """The column that becomes friction."""
        return self.table.columns[self.mapped]


def plan_of(table: Table, options: LoadOptions, name: str = "") -> Plan:
    """Decide what is read; `name` is the file's.

    Raises
    ------
    InputError
        No such column, columns to choose from, an unknown map, rate and time both given.
    """
    head = first_rows(table, HEAD_ROWS)
    time = choose_time(table, head, options.time, options.rate is not None)
    if options.rate is not None and time.columns:
        raise InputError("rate and time are both given; leave one out")
    time = settled(table, time)
    wish, kind = asked_kind(options.value, table.columns)
    value, chosen = choose_value(table, head, wish, time.columns)
    worth = worth_of(table.columns, head, value, name, kind)
    wanted = Map.of(options.map, headers_of(table.columns))
    mapped = value
    if wanted.name == "column":
        found = column_named(table.columns, wanted.argument)
        assert found is not None  # Map.of saw it
        mapped = found
    columns = [value]
    if mapped != value:
        columns.append(mapped)
    if worth.kind == "share":
        beside = price_columns(table.columns).values()
        columns += dict.fromkeys(i for i in beside if i not in (*columns, *time.columns))
    notes = tuple(note for note in (*table.notes, *time.notes, chosen, worth.note) if note)
    style = _style(table, head, columns)
    return Plan(table, time, value, mapped, wanted, tuple(columns), style, notes, worth)


def _style(table: Table, head: Head, columns: Sequence[int]) -> Style:
    """The way numbers are written: detected from the columns that are read, else by any other."""
    style = detected_style(cell for i in columns for cell in head[i])
    if style is None:
        style = detected_style(cell for cells in head for cell in cells)
    if style is None and getattr(table, "separator", ",") not in (",", None):
        # 1,234 or 1.234? semicolons come from where a comma is the decimal mark
        has_comma = any(isinstance(c, str) and "," in c for i in columns for c in head[i])
        style = Style(",") if has_comma else None
    return style or Style()
