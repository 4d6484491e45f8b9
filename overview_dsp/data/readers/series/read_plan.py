"""Plan for reading a table: columns, number format and type of values.

The plan follows the options, or is detected from the first rows. Values are the price of a share,
another price, or plain. The type comes from header, symbol, currency or option, never from the size
of the numbers. Steps of prices are in per cent, and only shares have splits. A note states the type
and the option for another one (`--value-column COLUMN:share`, `COLUMN:price`, `COLUMN:plain`).

A share has a close and an adjusted close, or a close in a table with volume or a ticker symbol (in
a column `symbol`, or in the name of the file). Commodities, currencies, indices and futures
(`CL=F`, `EURUSD=X`, `^GSPC`, `BTC-USD`, `coffee`) are other prices.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from overview_dsp.data.analysis.curve_maps import Map
from overview_dsp.data.readers.data_file import LoadOptions
from overview_dsp.data.readers.series.rows import with_settled_order
from overview_dsp.data.readers.tables.cells import choose_decimal_mark, parse
from overview_dsp.data.readers.tables.column_names import PATTERNS
from overview_dsp.data.readers.tables.column_roles import (
    TimeChoice,
    choose_time,
    choose_value,
    is_close,
    is_price,
    is_price_table,
    price_columns,
)
from overview_dsp.data.readers.tables.table import (
    Column,
    Columns,
    Head,
    Table,
    column_named,
    first_rows,
    headers_of,
    split_column_option,
)
from overview_dsp.errors import InputError, quoted

HEAD_ROWS = 500

KINDS = ("share", "price", "plain")
"""Types of values."""

CURRENCIES = frozenset("$€£¥₹₽₩")
"""Signs that mark a number as a price."""

_CODES = frozenset({"usd", "eur", "gbp", "chf", "jpy", "cad", "aud", "cny", "inr", "sek", "nok"})
_SYMBOLS = ("symbol", "ticker", "instrument", "isin", "ric")
_TICKER = re.compile(r"[A-Za-z]{1,5}([.\-][A-Za-z]{1,3})?(_[A-Za-z]{1,5})?")


@dataclass(frozen=True)
class ValueType:
    """Type of a column of values, one of `KINDS`, and a note on the reason, or empty."""

    kind: str
    note: str = ""

    @property
    def relative(self) -> bool:
        """True if steps are in per cent."""
        return self.kind != "plain"


@dataclass(frozen=True)
class ReadPlan:
    """Columns of a table to be read, and their roles and formats.

    `table`: the table.
    `time`: columns of the times, and their format.
    `value`, `mapped`: indices of the value column and of the column that becomes friction.
    `map`: mapping of that column to friction.
    `columns`: all columns except the times: the value first, then the mapped one if it is another,
    then the columns that reveal share splits.
    `decimal_mark`: decimal mark of the numbers, "." or ",".
    `notes`: messages about the choices.
    `value_type`: type of the values.
    """

    table: Table
    time: TimeChoice
    value: int
    mapped: int
    map: Map
    columns: tuple[int, ...]
    decimal_mark: str
    notes: tuple[str, ...]
    value_type: ValueType

    @property
    def value_column(self) -> Column:
        """Column of the values."""
        return self.table.columns[self.value]

    @property
    def mapped_column(self) -> Column:
        """Column that becomes friction."""
        return self.table.columns[self.mapped]


def make_read_plan(table: Table, options: LoadOptions, name: str = "") -> ReadPlan:
    """Plan how to read a table; `name` is that of the file.

    InputError: no such column, an ambiguous choice, an unknown map, or both rate and time.
    """
    head = first_rows(table, HEAD_ROWS)
    time = choose_time(table, head, options.time, options.rate is not None, options.value)
    if options.rate is not None and time.columns:
        raise InputError("rate and time are both given; leave one out")
    time = with_settled_order(table, time)
    column, kind = requested_value_type(options.value, table.columns)
    value, chosen = choose_value(table, head, column, time.columns)
    value_type = detect_value_type(table.columns, head, value, name, kind)
    mapping = Map.of(options.map, headers_of(table.columns))
    mapped = value
    if mapping.name == "column":
        found = column_named(table.columns, mapping.argument)
        assert found is not None  # checked in Map.of
        mapped = found
    columns = list(dict.fromkeys((value, mapped)))
    if value_type.kind == "share":
        beside = price_columns(table.columns).values()
        columns += dict.fromkeys(i for i in beside if i not in (*columns, *time.columns))
    notes = tuple(note for note in (*table.notes, *time.notes, chosen, value_type.note) if note)
    separator = getattr(table, "separator", None)
    decimal_mark = choose_decimal_mark(head, columns, separator)
    return ReadPlan(
        table, time, value, mapped, mapping, tuple(columns), decimal_mark, notes, value_type
    )


def requested_value_type(option: str | None, columns: Columns) -> tuple[str | None, str | None]:
    """Return column and type of a `--value-column` option, None for a part that is left out.

    InputError: the text after a column and a colon is not one of `KINDS`.
    """
    name, kind = split_column_option(option or "", columns)
    if kind in KINDS:
        return name or None, kind
    if name != option and name.lower() in headers_of(columns):
        raise InputError(
            f"value {quoted(option)}: {quoted(kind)} is not a type of value; "
            f"allowed: {', '.join(KINDS)}"
        )
    return option, None


def detect_value_type(
    columns: Columns, head: Head, value: int, name: str, requested: str | None
) -> ValueType:
    """Return the type of a column of values.

    `columns`, `head`: columns of the table, and its first rows, one list per column.
    `value`: index of the column.
    `name`: name of the file, without suffix.
    `requested`: requested type, one of `KINDS`, or None.
    """
    if requested is not None:
        return ValueType(requested)
    column = columns[value]
    named = is_price(column, columns)
    money = _is_money(column, head[value])
    if not named and not money:
        return ValueType("plain")
    why = "its header says so" if named else "it is in a currency"
    symbols = [name]
    for other, cells in zip(columns, head, strict=True):
        if other.plain in _SYMBOLS and cells and isinstance(cells[0], str):
            symbols.append(cells[0].strip())
    no_share = PATTERNS["no_share"].search
    if not named or any(no_share(symbol.replace("_", " ")) for symbol in symbols):
        return _with_note("price", column, why)
    if "adjusted" in price_columns(columns):
        return _with_note("share", column, "there is a close adjusted for splits")
    if is_close(column):
        if is_price_table(columns) and "volume" in price_columns(columns):
            return _with_note("share", column, "a close in a table of prices and volume")
        ticker = next((s for s in reversed(symbols) if _TICKER.fullmatch(s)), None)
        if ticker is not None:
            return _with_note("share", column, f"a close of {quoted(ticker)}")
    return _with_note("price", column, why)


def _with_note(kind: str, column: Column, why: str) -> ValueType:
    header = quoted(column.header)
    what, splits, other = "a price", "aren't", "share"
    if kind == "share":
        what, splits, other = "the price of a share", "are", "price"
    return ValueType(
        kind,
        f"{header} is {what} ({why}): steps are in per cent, splits {splits} looked for; "
        f"value='{column.header}:{other}' or '{column.header}:plain' (--value-column) selects "
        "another type",
    )


def _is_money(column: Column, cells: Sequence[Any]) -> bool:
    unit = column.unit.strip().lower()
    if (unit[:1] in CURRENCIES and unit) or re.split(r"[^a-z]", unit)[0] in _CODES:
        return True
    for cell in cells:
        found = parse(cell.strip(), ".") if isinstance(cell, str) else None
        if found is not None:
            return found[1] in CURRENCIES and bool(found[1])
    return False
