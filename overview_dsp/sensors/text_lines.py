"""Lines of numbers: `ax,ay,az[,gx,gy,gz]`, `roll_deg`, an encoder's count, a potentiometer's wiper.

Numbers stand apart by commas, semicolons, tabs or spaces. A line has no check: a byte that is lost
or changed within a number gives another number (the binary frame and the sensor's ranges catch it).
"""

from __future__ import annotations

import math
import re

from overview_dsp.sensors.reading import COLUMNS, Reading

_APART = re.compile(r"\s*[,;]\s*|\s+")
_NUMBER = re.compile(r"[+-]?(\d+(\.\d*)?|\.\d+)([eE][+-]?\d{1,3})?")


def numbers_of(line: str) -> tuple[float, ...] | None:
    """The numbers of a line; None if anything else is in it."""
    cells = _APART.split(line)
    if not all(_NUMBER.fullmatch(cell) for cell in cells):
        return None
    numbers = tuple(float(cell) for cell in cells)
    return numbers if all(map(math.isfinite, numbers)) else None


def columns_of(line: str) -> tuple[str, ...] | None:
    """The columns that a line of their names announces; None if it is none."""
    names = tuple(_APART.split(line))
    known = all(name in COLUMNS for name in names) and len(set(names)) == len(names)
    return names if known else None


def reading_of(line: str, columns: tuple[str, ...]) -> Reading | None:
    """The reading of a line with these columns: empty if it names them again, None if it is none.

    Parameters
    ----------
    columns : tuple of str
        Names of `COLUMNS`, in the order of the line.
    """
    numbers = numbers_of(line)
    if numbers is not None and len(numbers) == len(columns):
        return dict(zip(columns, numbers, strict=True))
    return {} if columns_of(line) == columns else None
