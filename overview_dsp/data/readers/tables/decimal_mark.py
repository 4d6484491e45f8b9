"""The decimal mark of a table's numbers, point or comma, detected from its first rows.

One mark holds for a whole file. Where cells fit both marks, a comma is chosen if columns have a
separator other than a comma: programs that write semicolons also write a decimal comma.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from typing import Any

from overview_dsp.data.readers.tables.cells import NUMBER
from overview_dsp.data.readers.tables.table import Head


def choose_decimal_mark(head: Head, columns: Sequence[int], separator: str | None) -> str:
    """Return "." or ",", the decimal mark of a table.

    Parameters
    ----------
    head
        The first rows, one list per column.
    columns
        Indices of the columns that are read; they decide before the others.
    separator
        Character between fields; None for blanks, or where there are no fields.
    """
    used = [cell for i in columns for cell in head[i]]
    mark = detect_decimal_mark(used) or detect_decimal_mark(
        cell for cells in head for cell in cells
    )
    if mark is None and separator not in (",", None):
        mark = "," if any(isinstance(cell, str) and "," in cell for cell in used) else None
    return mark or "."


def detect_decimal_mark(cells: Iterable[Any]) -> str | None:
    """Return the decimal mark that most deciding cells have, None if no cell decides.

    A cell decides if it has both marks (the last is the decimal one), a mark that repeats (it
    groups thousands), or one mark that does not stand before exactly three digits (`12,5`), or
    a number that begins with 0 (`0.250`).
    """
    votes = {".": 0, ",": 0}
    for cell in cells:
        found = NUMBER.fullmatch(cell.strip()) if isinstance(cell, str) else None
        if found is None:
            continue
        digits = found["digits"]
        point, comma = digits.rfind("."), digits.rfind(",")
        if point < 0 and comma < 0:
            continue
        mark, other = (".", ",") if point > comma else (",", ".")
        if digits.count(mark) > 1:
            votes[other] += 1
        elif other in digits or not re.fullmatch(r"[1-9]\d{0,2}[.,]\d{3}", digits, re.ASCII):
            votes[mark] += 1
    if votes["."] == votes[","]:
        return None
    return max(votes, key=votes.__getitem__)
