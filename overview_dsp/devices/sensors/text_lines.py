"""Lines of numbers: `ax,ay,az[,gx,gy,gz]`, `roll_deg`, an encoder's count, a potentiometer's wiper.

Numbers stand apart by commas, semicolons, tabs or spaces. A line has no check: a byte that is lost
or changed within a number gives another number (the binary frame and the sensor's ranges catch it).
"""

from __future__ import annotations

import math
import re

from overview_dsp.devices.sensors.reading import COLUMNS, SKIPPED, Reading

_APART = re.compile(r"\s*[,;]\s*|\s+")
_APART_WIDELY = re.compile(r"[\s,;:=|()\[\]{}]+")
_AROUND = "([{ \t"
_BEHIND = ")]} \t,;|"
_NUMBER = re.compile(r"[+-]?(\d+(\.\d*)?|\.\d+)([eE][+-]?\d{1,3})?")

_LOGGED = {
    **{f"{short}{axis}".lower(): f"{short}{axis}".lower() for short in "ag" for axis in "xyz"},
    **{f"q6_{n}": f"q{axis}" for n, axis in enumerate("xyz", 1)},
}
"""Names that loggers (OpenLog Artemis) write above their columns, in lower case."""


def numbers_of(line: str) -> tuple[float, ...] | None:
    """The numbers of a line; None if anything else is in it."""
    cells = cells_of(line)
    if not all(_NUMBER.fullmatch(cell) for cell in cells):
        return None
    numbers = tuple(float(cell) for cell in cells)
    return numbers if all(map(math.isfinite, numbers)) else None


def columns_of(line: str) -> tuple[str, ...] | None:
    """The columns that a line of their names announces; None if it is none.

    Other names may stand between those of a logger, and are columns that are skipped.
    """
    names = cells_of(line)
    if all(name in COLUMNS for name in names):
        return names if len(set(names)) == len(names) else None
    logged = tuple(_LOGGED.get(name.lower(), SKIPPED) for name in names)
    known = [name for name in logged if name != SKIPPED]
    # three names that are known make a header; a word or two may be any line
    return logged if len(set(known)) == len(known) >= 3 else None


def cells_of(line: str, widely: bool = False) -> tuple[str, ...]:
    """What stands between separators; `widely`: colons, equals signs and bars part too.

    A separator at the end of a line ends its last cell; brackets may be around all of it.
    """
    return tuple((_APART_WIDELY if widely else _APART).split(line.lstrip(_AROUND).rstrip(_BEHIND)))


def reading_of(line: str, columns: tuple[str, ...]) -> Reading | None:
    """The reading of a line with these columns: empty if it names them again, None if it is none.

    Parameters
    ----------
    columns : tuple of str
        Names of `COLUMNS`, in the order of the line; in a column that is skipped may be anything.
    """
    if SKIPPED not in columns:
        numbers = numbers_of(line)
        if numbers is not None and len(numbers) == len(columns):
            return dict(zip(columns, numbers, strict=True))
        return {} if columns_of(line) == columns else None
    for widely in (False, True):
        cells = cells_of(line, widely)
        if len(cells) != len(columns):
            continue
        wanted = [(name, cell) for name, cell in zip(columns, cells, strict=True) if name != "_"]
        if all(_NUMBER.fullmatch(cell) for _, cell in wanted):
            reading = {name: float(cell) for name, cell in wanted}
            return reading if all(map(math.isfinite, reading.values())) else None
    return {} if columns_of(line) == columns else None
