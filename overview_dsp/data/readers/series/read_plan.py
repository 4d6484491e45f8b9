"""What is read from a table, as asked for or detected from its first rows.

Whether a column is a price, and of a share, is told by header, symbol, currency or option.
Per cent fit prices only, and splits are a share's. Nothing is guessed from the numbers: what isn't
called a price is plain, and what was decided is said, with the option that decides otherwise
(`--value-column COLUMN:share`, `COLUMN:price`, `COLUMN:plain`).

A share's is a close beside an adjusted close, or a close in a table with volume or a ticker symbol
(a column `symbol`, or the file's name). A symbol or name of a commodity, a currency, an index or a
future (`CL=F`, `EURUSD=X`, `^GSPC`, `BTC-USD`, `coffee`) makes it a price with nothing to split.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from overview_dsp.data.analysis.curve_maps import Map
from overview_dsp.data.readers.data_file import LoadOptions
from overview_dsp.data.readers.series.rows import with_settled_order
from overview_dsp.data.readers.tables.cells import parse
from overview_dsp.data.readers.tables.column_roles import (
    TimeChoice,
    choose_time,
    choose_value,
    is_close,
    is_price,
    is_price_table,
    price_columns,
)
from overview_dsp.data.readers.tables.decimal_mark import choose_decimal_mark
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
from overview_dsp.errors import InputError, shown

HEAD_ROWS = 500

KINDS = ("share", "price", "plain")
"""What a column of values may be."""

CURRENCIES = frozenset("$€£¥₹₽₩")
"""Signs that make a number a price."""

_CODES = frozenset({"usd", "eur", "gbp", "chf", "jpy", "cad", "aud", "cny", "inr", "sek", "nok"})
_SYMBOLS = ("symbol", "ticker", "instrument", "isin", "ric")
_TICKER = re.compile(r"[A-Za-z]{1,5}([.\-][A-Za-z]{1,3})?(_[A-Za-z]{1,5})?")
_NO_SHARE = re.compile(
    r"=[FX]$|^\^|[-_/](usdt?|eur|btc)$"
    r"|\b(gold|silver|platinum|palladium|copper|alumini?um|nickel|zinc|iron|steel|oil|crude|brent"
    r"|wti|gas|gasoline|diesel|coal|power|electricity|wheat|corn|maize|rice|soy\w*|coffee|cocoa"
    r"|sugar|cotton|lumber|cattle|hogs|rubber|uranium|bitcoin|btc|eth|ether\w*|crypto\w*|futures?"
    r"|commodit\w+|forex|fx|currency|exchange|index|commodity|price|prices|eur|usd|gbp|jpy|chf)\b",
    re.IGNORECASE,
)


@dataclass(frozen=True)
class ValueType:
    """One of `KINDS`, and a note on why; empty where there is nothing to say."""

    kind: str
    note: str = ""

    @property
    def relative(self) -> bool:
        """Whether steps are per cent."""
        return self.kind != "plain"


@dataclass(frozen=True)
class ReadPlan:
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
    decimal_mark
        How numbers are written.
    notes
        What was decided.
    value_type
        Whether the values are prices.
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
        """The column of values."""
        return self.table.columns[self.value]

    @property
    def mapped_column(self) -> Column:
        """The column that becomes friction."""
        return self.table.columns[self.mapped]


def make_read_plan(table: Table, options: LoadOptions, name: str = "") -> ReadPlan:
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
    time = with_settled_order(table, time)
    wish, kind = requested_value_type(options.value, table.columns)
    value, chosen = choose_value(table, head, wish, time.columns)
    value_type = detect_value_type(table.columns, head, value, name, kind)
    wanted = Map.of(options.map, headers_of(table.columns))
    mapped = value
    if wanted.name == "column":
        found = column_named(table.columns, wanted.argument)
        assert found is not None  # Map.of saw it
        mapped = found
    columns = [value]
    if mapped != value:
        columns.append(mapped)
    if value_type.kind == "share":
        beside = price_columns(table.columns).values()
        columns += dict.fromkeys(i for i in beside if i not in (*columns, *time.columns))
    notes = tuple(note for note in (*table.notes, *time.notes, chosen, value_type.note) if note)
    separator = getattr(table, "separator", None)
    decimal_mark = choose_decimal_mark(head, columns, separator)
    return ReadPlan(
        table, time, value, mapped, wanted, tuple(columns), decimal_mark, notes, value_type
    )


def requested_value_type(wish: str | None, columns: Columns) -> tuple[str | None, str | None]:
    """Return the column and the kind of a `--value-column` value, None where it isn't asked for.

    Raises
    ------
    InputError
        The words after a column and a colon are none of `KINDS`.
    """
    name, kind = split_column_option(wish or "", columns)
    if kind in KINDS:
        return name or None, kind
    if name != wish and name.lower() in headers_of(columns):
        raise InputError(
            f"value {shown(wish)}: {shown(kind)} is no kind of value; known are {', '.join(KINDS)}"
        )
    return wish, None


def detect_value_type(
    columns: Columns, head: Head, value: int, name: str, wish: str | None
) -> ValueType:
    """Decide what a column of values is.

    Parameters
    ----------
    columns, head
        The table's, and its first rows, a list a column.
    value
        The column's index.
    name
        The file's name without its suffix.
    wish
        One of `KINDS`, if it was asked for.
    """
    if wish is not None:
        return ValueType(wish)
    column = columns[value]
    named = is_price(column, columns)
    money = _is_money(column, head[value])
    if not named and not money:
        return ValueType("plain")
    why = "its header says so" if named else "it is in a currency"
    symbols = [name, *_symbols(columns, head)]
    if not named or any(_NO_SHARE.search(symbol.replace("_", " ")) for symbol in symbols):
        return _said("price", column, why)
    if "adjusted" in price_columns(columns):
        return _said("share", column, "there is a close adjusted for splits")
    if is_close(column):
        if is_price_table(columns) and "volume" in price_columns(columns):
            return _said("share", column, "a close in a table of prices and volume")
        ticker = next((s for s in reversed(symbols) if _TICKER.fullmatch(s)), None)
        if ticker is not None:
            return _said("share", column, f"a close of {shown(ticker)}")
    return _said("price", column, why)


def _said(kind: str, column: Column, why: str) -> ValueType:
    header = shown(column.header)
    other = "price" if kind == "share" else "share"
    what = "the price of a share" if kind == "share" else "a price"
    splits = "are" if kind == "share" else "aren't"
    return ValueType(
        kind,
        f"{header} is {what} ({why}): steps are per cent, splits {splits} looked for; "
        f"value='{column.header}:{other}' or '{column.header}:plain' (--value-column) says "
        "otherwise",
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


def _symbols(columns: Columns, head: Head) -> Iterable[str]:
    for column, cells in zip(columns, head, strict=True):
        if column.plain in _SYMBOLS and cells and isinstance(cells[0], str):
            yield cells[0].strip()
