"""What a table of prices (open, high, low, close, volume, adjusted close) looks like."""

from __future__ import annotations

import re
from collections.abc import Sequence

from overview_dsp.readers.tables.table import Column

CURRENCIES = frozenset("$€£¥₹₽₩")
"""Signs that make a number a price."""

_CLOSE = (
    "close", "closelast", "closeprice", "last", "lastprice", "closing", "settle", "price",
    "schlusskurs", "schluss", "zuletzt", "cierre", "dernier", "c",
)  # fmt: skip
_OPEN = ("open", "openprice", "eröffnung", "eröffn", "apertura", "ouverture", "o")
_HIGH_LOW = (
    "high", "low", "highprice", "lowprice", "dayhigh", "daylow", "hoch", "tief", "h", "l",
)  # fmt: skip
_VOLUME = ("volume", "vol", "shares", "sharestraded", "v")


def _key(column: Column) -> str:
    # Alpha Vantage numbers its columns: "5. adjusted close"
    return re.sub(r"^\d+", "", column.plain)


def is_adjusted(column: Column) -> bool:
    """Tell whether a column is a price adjusted for splits (and mostly dividends)."""
    name = _key(column)
    return name in ("adj", "adjusted") or ("adj" in name and ("clos" in name or "pric" in name))


def is_price(column: Column) -> bool:
    """Tell by its name whether a column is a price."""
    name = _key(column)
    return (
        is_adjusted(column)
        or name in (*_CLOSE[:-1], *_OPEN[:-1], *_HIGH_LOW[:-2])
        or name.endswith(("price", "close", "quote"))
        or name.startswith("price")
    )


def _first(columns: Sequence[Column], names: Sequence[str]) -> int | None:
    return next((i for name in names for i, c in enumerate(columns) if _key(c) == name), None)


def is_table(columns: Sequence[Column]) -> bool:
    """Tell whether these columns are a table of prices: a close, and an open, high or low."""
    return _first(columns, _CLOSE) is not None and (
        _first(columns, _OPEN) is not None or _first(columns, _HIGH_LOW) is not None
    )


def adjusted(columns: Sequence[Column]) -> int | None:
    """Return the adjusted column."""
    return next((i for i, column in enumerate(columns) if is_adjusted(column)), None)


def preferred(columns: Sequence[Column]) -> int | None:
    """Return the column of a table of prices that is the value: adjusted close, else close."""
    if is_table(columns):
        found = adjusted(columns)
        return found if found is not None else _first(columns, _CLOSE)
    # a close and its volume alone
    rest = [column for column in columns if _key(column) not in _VOLUME]
    if len(rest) == 1 and len(columns) == 2 and is_price(rest[0]):
        return columns.index(rest[0])
    return None


def opening(columns: Sequence[Column]) -> int | None:
    """Return the opening price."""
    return _first(columns, _OPEN)


def volume(columns: Sequence[Column]) -> int | None:
    """Return the shares traded."""
    return _first(columns, _VOLUME)
