"""Share charts as web interfaces give them in JSON: their columns get the names of a price table.

- Yahoo: `{"timestamp": [...], "indicators": {"quote": [{"close": [...], ...}], "adjclose": ...}}`,
  with the currency in `meta`
- TradingView (UDF), Polygon: `t`, `o`, `h`, `l`, `c`, `v` as lists or in records
- candles: rows of time, open, high, low, close, volume (Highcharts, Binance)
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

_LETTERS = {
    "t": "time", "o": "open", "h": "high", "l": "low", "c": "close", "v": "volume",
}  # fmt: skip
_CANDLE = ("time", "open", "high", "low", "close", "volume")
_QUOTES = ("open", "high", "low", "close", "volume")


def yahoo(value: dict[str, Any]) -> tuple[dict[str, list[Any]], dict[str, str]] | None:
    """Return the columns and units of Yahoo's chart; None for anything else."""
    times, indicators = value.get("timestamp"), value.get("indicators")
    if not isinstance(times, list) or not times or not isinstance(indicators, dict):
        return None
    quote, adjusted = (_first(indicators.get(key)) for key in ("quote", "adjclose"))
    columns = {"time": times}
    columns |= {name: quote[name] for name in _QUOTES if _fits(quote.get(name), times)}
    if _fits(adjusted.get("adjclose"), times):
        columns["adj close"] = adjusted["adjclose"]
    about = value.get("meta")
    currency = about.get("currency") if isinstance(about, dict) else None
    units = dict.fromkeys(columns, currency) if isinstance(currency, str) else {}
    return columns, {name: unit for name, unit in units.items() if name not in ("time", "volume")}


def _first(value: Any) -> dict[str, Any]:
    return value[0] if isinstance(value, list) and value and isinstance(value[0], dict) else {}


def _fits(column: Any, times: list[Any]) -> bool:
    return isinstance(column, list) and len(column) == len(times)


def spelled_out(names: Sequence[str]) -> tuple[str, ...]:
    """Return the names of columns, single letters of a price chart written out."""
    if not {"t", "o", "h", "l", "c"} <= set(names):
        return tuple(names)
    return tuple(_LETTERS.get(name, name) for name in names)


def candle_names(rows: Sequence[Sequence[Any]]) -> tuple[str, ...] | None:
    """Return names of the columns of candles; None where the rows are none.

    In a candle the third number is the highest and the fourth the lowest of four.
    """
    if not rows or not len(rows[0]) >= 5:
        return None
    moved = False
    for row in rows:
        try:
            begin, high, low, end = (float(cell) for cell in row[1:5])
        except (TypeError, ValueError):
            return None
        if not (low <= min(begin, end) and max(begin, end) <= high):
            return None
        moved = moved or high > low
    width = len(rows[0])
    return (*_CANDLE[:width], *(f"column {i}" for i in range(7, width + 1))) if moved else None
