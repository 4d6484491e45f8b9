"""What is read from a table, as asked for or detected from its first rows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from overview_dsp.data.analysis.curve_maps import Map
from overview_dsp.data.readers.series.prices import Worth, split_wish, worth_of
from overview_dsp.data.readers.series.rows import settled
from overview_dsp.data.readers.source import LoadOptions
from overview_dsp.data.readers.tables import column_roles
from overview_dsp.data.readers.tables.cells import Style, detected_style
from overview_dsp.data.readers.tables.column_roles import TimeChoice, choose_time, choose_value
from overview_dsp.data.readers.tables.table import Column, Table, column_named, first_rows
from overview_dsp.errors import InputError

HEAD_ROWS = 500

_BESIDE = (
    column_roles.adjusted_close,
    column_roles.close_price,
    column_roles.opening_price,
    column_roles.share_volume,
)


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
    wish, kind = split_wish(options.value, table.columns)
    value = choose_value(table, head, wish, time.columns)
    worth = worth_of(table.columns, head, value.column, name, kind)
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
    if worth.kind == "share":
        for find in _BESIDE:
            beside = find(table.columns)
            if beside is not None and beside not in (*columns, *time.columns):
                columns.append(beside)
    notes = tuple(note for note in (*table.notes, *time.notes, value.note, worth.note) if note)
    style = _style(table, head, columns)
    return Plan(table, time, value.column, mapped, wanted, tuple(columns), style, notes, worth)


def _style(table: Table, head: Sequence[list[object]], columns: Sequence[int]) -> Style:
    """The way numbers are written: detected from the columns that are read, else by any other."""
    style = detected_style(cell for i in columns for cell in head[i])
    if style is None:
        style = detected_style(cell for cells in head for cell in cells)
    if style is None and getattr(table, "separator", ",") not in (",", None):
        # 1,234 or 1.234? semicolons come from where a comma is the decimal mark
        has_comma = any(isinstance(c, str) and "," in c for i in columns for c in head[i])
        style = Style(",") if has_comma else None
    return style or Style()
