"""Numbers and missing values in the cells of a table.

Numbers have a decimal point or comma, thousands in groups of three, a currency sign, a per cent
sign or a unit after the number, K, M and B for thousand, million and 10^9, and brackets for
negative values. The decimal mark, point or comma, is detected from the first rows of a file, and
holds for the whole file. Where cells fit both marks, a comma is chosen if columns have a
separator other than a comma: programs that write semicolons also write a decimal comma.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from overview_dsp.arrays import FloatArray
from overview_dsp.data.readers.tables.column_names import NAMES
from overview_dsp.data.readers.tables.table import CellLocation, Cells, Head
from overview_dsp.data.readers.tables.text_cells import TextCells
from overview_dsp.data.timeline.curve_points import MAX_VALUE
from overview_dsp.errors import quoted

_CURRENCIES = "$€£¥₹₽₩"
_MULTIPLIERS = {"k": 1e3, "K": 1e3, "M": 1e6, "B": 1e9, "bn": 1e9, "T": 1e12}
_GROUPS = "'’ \u00a0\u202f_"
NUMBER = re.compile(
    rf"(?P<open>\()?\s*(?P<sign1>[+\-−]?)\s*(?P<currency>[{_CURRENCIES}]?)\s*(?P<sign>[+\-−]?)"
    rf"(?P<digits>\d(?:[\d.,{_GROUPS}]*\d)?[.,]?|[.,]\d+)(?P<power>[eE][+\-]?\d+)?"
    r"(?P<space>\s*)(?P<unit>[^\d\s().,+\-:/][^\d\s():/]{0,7})?\s*(?(open)\))",
    re.ASCII,
)
_SIXTIETHS = re.compile(r"(\d{1,3}):([0-5]\d)(?::([0-5]\d(?:\.\d+)?))?", re.ASCII)
"""A pace or a length such as 5:12, 5.2 of its first unit: minutes if others have hours, too."""

_GROUP = re.compile(rf"[{_GROUPS}]")


def parse(text: str, decimal_mark: str) -> tuple[float, str] | None:
    """Return number and unit (or currency) of a cell, None if it is not a number."""
    found = NUMBER.fullmatch(text)
    if found is None or (found["sign1"] and found["sign"]):
        return None
    digits = found["digits"]
    whole, mark, part = digits.partition(decimal_mark)
    if "." in part or "," in part:
        return None
    separators = set(whole) - set("0123456789")
    if len(separators) > 1:
        return None
    if separators:
        groups = whole.split(separators.pop())
        # groups of three, or lakhs (12,34,567): three digits in the last, two or three before it
        if len(groups[-1]) != 3 or not all(2 <= len(g) <= 3 for g in groups[1:-1]):
            return None
        if not 1 <= len(groups[0]) <= 3:
            return None
        whole = "".join(groups)
    if _GROUP.search(part):
        return None
    value = float(f"{whole or '0'}{'.' if mark else ''}{part}{found['power'] or ''}")
    unit = (found["unit"] or "").strip("*†‡§")  # marks of footnotes
    # a lone surrogate for a byte that is not text; an exponent without digits
    if not unit.isprintable() or unit in ("e", "E"):
        return None
    # with a space these are kelvin, bytes and tesla
    is_unit = unit in ("K", "B", "T") and found["space"] and not found["currency"]
    if unit in _MULTIPLIERS and not is_unit:
        value, unit = value * _MULTIPLIERS[unit], ""
    negative = "-" in (found["sign1"] + found["sign"]).replace("−", "-")
    if negative and found["open"]:
        return None
    if negative or found["open"]:
        value = -value
    return value, unit or found["currency"]


@dataclass
class NumberColumn:
    """Parser for a column of numbers, chunk by chunk; `unit` is the unit found in the cells."""

    decimal_mark: str = "."
    unit: str | None = None
    _lengths: dict[int, list[int]] = field(default_factory=dict, init=False)
    _in_minutes: bool | None = field(default=None, init=False)

    def values(self, cells: Cells, locate: Callable[[int], CellLocation]) -> FloatArray:
        """Return float64 of the cells' length, NaN where there is no value.

        `cells`: a chunk's column.
        `locate`: function from the index of a cell to its location, for errors.

        InputError: a text, infinity, a magnitude above 1e300, or a unit other than that of earlier
        cells.
        """
        if isinstance(cells, np.ndarray):
            if cells.dtype.kind not in "iuf":
                raise locate(0).error(cells[0], "is a date; name a column of numbers")
            values = cells.astype(np.float64)
        else:
            self._lengths = {2: [], 3: []}  # cells of a chunk with two and with three parts
            values = self._numbers(cells, locate)
            short, long = self._lengths.values()
            if short and self._in_minutes is False:
                raise locate(short[0]).error(
                    cells[short[0]], "has no hours, those before it do; write all in one way"
                )
            if long:
                self._in_minutes = self._in_minutes or bool(short)
                values[long] *= 60.0 if self._in_minutes else 1.0
            elif short:
                self._in_minutes = True
        size = np.abs(values)
        if np.fmax.reduce(size, initial=0.0) > MAX_VALUE:
            i = int(np.flatnonzero(size > MAX_VALUE)[0])
            raise locate(i).error(
                float(values[i]),
                f"isn't a finite number up to {MAX_VALUE:g}; leave a missing value empty",
            )
        return values

    def _numbers(
        self, cells: list[Any] | TextCells, locate: Callable[[int], CellLocation]
    ) -> FloatArray:
        """Return the numbers of texts and other values: of plain ones as columns."""
        texts = cells if isinstance(cells, TextCells) else TextCells.of(cells)
        if texts is None:
            return np.array([self._one(cell, i, locate) for i, cell in enumerate(cells)])
        found, good = texts.decimals(self.decimal_mark)
        if self.unit is None and not np.isnan(found[good]).all():
            self.unit = ""
        for i in np.flatnonzero(~good).tolist():
            found[i] = self._one(texts[i], i, locate)
        return found

    def _one(self, cell: Any, i: int, locate: Callable[[int], CellLocation]) -> float:
        if is_missing(cell):
            return math.nan
        if isinstance(cell, bool):
            raise locate(i).error(cell, "isn't a number; name a column of numbers")
        if isinstance(cell, int | float):
            try:
                return float(cell)
            except OverflowError:
                return math.inf
        text = cell.strip() if isinstance(cell, str) else ""
        found = parse(text, self.decimal_mark)
        if found is None and (sixtieths := _SIXTIETHS.fullmatch(text)):
            parts = [float(part) for part in sixtieths.groups() if part]
            self._lengths[len(parts)].append(i)
            found = sum(part / 60.0**n for n, part in enumerate(parts)), ""
        if found is None:
            other, name = (",", "point") if self.decimal_mark == "." else (".", "comma")
            hint = f" with a decimal {name}" if parse(text, other) is not None else ""
            raise locate(i).error(
                cell, f"isn't a number{hint}; correct it, or leave it empty if there is no value"
            )
        value, unit = found
        if self.unit is None or (unit and not self.unit):
            self.unit = unit
        elif unit and unit != self.unit:
            raise locate(i).error(
                cell,
                f"is in {quoted(unit)}, cells before it in {quoted(self.unit)}; give one unit for "
                "the column",
            )
        return value


def is_number(cell: Any) -> bool:
    """Return whether a cell is a number with either decimal mark."""
    if isinstance(cell, str):
        text = cell.strip()
        return parse(text, ".") is not None or parse(text, ",") is not None
    return isinstance(cell, int | float) and not isinstance(cell, bool)


def looks_numeric(cells: Iterable[Any]) -> bool:
    """Return whether at least two thirds of a column's cells, without missing ones, are numbers.

    The others are mistakes; reading them raises an error with their location.
    """
    found = [is_number(cell) for cell in cells if not is_missing(cell)]
    return any(found) and 3 * sum(found) >= 2 * len(found)


TOKENS = frozenset(NAMES["missing_values"])
"""Cells that mean "no value", in lower case, without surrounding blanks."""

SENTINELS = (-99.0, -99.9, -99.99, -999.0, -999.9, -999.99, -9999.0, -9999.9, -99999.0, -32768.0)
"""Numbers that loggers and archives write for "no value"."""


def is_missing(cell: Any) -> bool:
    """Return whether a cell holds no value: None, NaN, NaT or one of `TOKENS`."""
    if cell is None:
        return True
    if isinstance(cell, str):
        return cell.strip().lower() in TOKENS
    if isinstance(cell, float):
        return math.isnan(cell)
    return isinstance(cell, np.datetime64) and bool(np.isnat(cell))


def sentinels(value: FloatArray) -> list[float]:
    """Return the numbers that mean "no value" in a column.

    Each is the smallest value without those before it, one of `SENTINELS`, and further below all
    others than their range: -9999 among temperatures qualifies, -99 among depths from 0 to -120
    does not.

    `value`: values of the column, NaN if missing.
    """
    found: list[float] = []
    known = value[~np.isnan(value)]
    while known.size and (low := float(known.min())) in SENTINELS:
        known = known[known != low]
        spread = float(known.max(initial=low)) - float(known.min(initial=np.inf))
        if not known.size or float(known.min()) - low <= max(spread, 0.5 * abs(low)):
            break
        found.append(low)
    return found


def choose_decimal_mark(head: Head, columns: Sequence[int], separator: str | None) -> str:
    """Return "." or ",", the decimal mark of a table.

    `head`: the first rows, one list per column.
    `columns`: indices of the columns that are read; they decide before the others.
    `separator`: character between fields; None for blanks, or where there are no fields.
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
