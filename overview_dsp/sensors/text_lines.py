"""Lines of numbers: `ax,ay,az[,gx,gy,gz]`, `roll_deg`, an encoder's count, a potentiometer's wiper.

Numbers stand apart by commas, semicolons, tabs or spaces. A line has no check: a byte that is lost
or changed within a number gives another number (the binary frame and the sensor's ranges catch it).
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence

from overview_dsp.sensors.line_splitter import LineSplitter
from overview_dsp.sensors.reading import COLUMNS, Counters, Reading

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


class TextDecoder:
    """Readings from lines of numbers with known columns."""

    def __init__(self, counters: Counters, columns: Sequence[str]) -> None:
        """`columns` are names of `COLUMNS`, in the order of the line."""
        self._counters = counters
        self._columns = tuple(columns)
        self._lines = LineSplitter(counters)

    def feed(self, data: bytes) -> list[Reading]:
        """The readings that these bytes complete."""
        readings: list[Reading] = []
        for line in self._lines.feed(data):
            numbers = numbers_of(line)
            if numbers is not None and len(numbers) == len(self._columns):
                readings.append(dict(zip(self._columns, numbers, strict=True)))
            elif columns_of(line) != self._columns:  # a header, sent again
                self._counters.refuse(line.encode())
        self._counters.readings += len(readings)
        return readings
