"""Which cells say that there is no value."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

TOKENS = frozenset(
    {"", ".", "..", "...", "-", "--", "---", "–", "—", "?", "*", "m", "na", "n/a", "#n/a", "n.a."}
    | {"#na", "#n/a n/a", "<na>", "nan", "-nan", "nat", "nil", "none", "null", "missing", "\\n"}
    | {"#value!", "#ref!", "#div/0!", "no data", "nodata", "unavailable", "unknown"}
)
"""Cells that mean "no value", in small letters, without the blanks around them."""

SENTINELS = (-99.0, -99.9, -99.99, -999.0, -999.9, -999.99, -9999.0, -9999.9, -99999.0, -32768.0)
"""Numbers that loggers and archives write where they have none."""


def is_missing(cell: Any) -> bool:
    """Tell whether a cell holds no value: None, NaN, NaT or a word of `TOKENS`."""
    if cell is None:
        return True
    if isinstance(cell, str):
        return cell.strip().lower() in TOKENS
    if isinstance(cell, float):
        return math.isnan(cell)
    return isinstance(cell, np.datetime64) and bool(np.isnat(cell))


def sentinel(value: NDArray[np.float64]) -> float | None:
    """Return the number that stands for "no value" in a column, if there is one.

    It is the column's smallest value, one of `SENTINELS`, and further below all others than these
    spread: -9999 among temperatures is one, -99 among depths from 0 to -120 isn't.

    Parameters
    ----------
    value
        Shape (n,), NaN = missing.
    """
    known = value[~np.isnan(value)]
    if not known.size:
        return None
    low = float(known.min())
    if low not in SENTINELS:
        return None
    rest = known[known != low]
    if not rest.size:
        return None
    spread = float(rest.max()) - float(rest.min())
    return low if float(rest.min()) - low > max(spread, 0.5 * abs(low)) else None
