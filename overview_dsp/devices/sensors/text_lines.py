"""Lines of numbers: `ax,ay,az[,gx,gy,gz]`, `roll_deg`, an encoder's count, a potentiometer's wiper.

Commas, semicolons, bars, tabs or spaces separate the numbers. A line has no check: a lost or wrong
byte within a number gives another number. Binary frames detect that, and so do the sensor's ranges.
"""

from __future__ import annotations

import math
import re

from overview_dsp.devices.sensors.reading import COLUMNS, INERTIAL, SKIPPED, Reading

_SEPARATORS = re.compile(r"\s*[,;|]\s*|\s+")
_WIDE_SEPARATORS = re.compile(r"[\s,;:=|()\[\]{}]+")
_LEADING = "([{ \t"
_TRAILING = ")]} \t,;|"
_NUMBER = re.compile(r"[+-]?(\d+(\.\d*)?|\.\d+)([eE][+-]?\d{1,3})?")

WORD = "="  # before a word as the name of a column: lines with another word there are skipped

_LOGGED = dict(zip(INERTIAL, INERTIAL, strict=True)) | {"q6_1": "qx", "q6_2": "qy", "q6_3": "qz"}
"""Column names that loggers (OpenLog Artemis) write, in lower case, to names of `COLUMNS`."""


def parse_numbers(line: str) -> tuple[float, ...] | None:
    """Return the numbers of a line; None if it holds anything else."""
    cells = split_cells(line)
    if not all(_NUMBER.fullmatch(cell) for cell in cells):
        return None
    numbers = tuple(map(float, cells))
    return numbers if all(map(math.isfinite, numbers)) else None


def parse_header(line: str) -> tuple[str, ...] | None:
    """Return the columns that a header line names; None if the line isn't a header.

    A logger's header may have other names too; those columns are skipped.
    """
    names = split_cells(line)
    if all(name in COLUMNS for name in names):
        return names if len(set(names)) == len(names) else None
    logged = tuple(_LOGGED.get(name.lower(), SKIPPED) for name in names)
    known = [name for name in logged if name != SKIPPED]
    # three known names make a header; one or two words may be any line
    return logged if len(set(known)) == len(known) >= 3 else None


def split_cells(line: str, wide: bool = False) -> tuple[str, ...]:
    """Return the cells of a line; with `wide`, colons, equals signs and bars separate too.

    A separator at the end of a line ends its last cell. Brackets may surround the line.
    """
    separators = _WIDE_SEPARATORS if wide else _SEPARATORS
    return tuple(separators.split(line.lstrip(_LEADING).rstrip(_TRAILING)))


def parse_row(line: str, columns: tuple[str, ...]) -> Reading | None:
    """Return the reading of a line; empty if it repeats the header, None if it is invalid.

    `columns` are names of `COLUMNS`, in the order of the line; a skipped column may hold anything.
    """
    words = {n: name[1:] for n, name in enumerate(columns) if name.startswith(WORD)}
    if SKIPPED not in columns and not words:
        numbers = parse_numbers(line)
        if numbers is not None and len(numbers) == len(columns):
            return dict(zip(columns, numbers, strict=True))
        return {} if parse_header(line) == columns else None
    for wide in (False, True):
        cells = split_cells(line, wide)
        if len(cells) != len(columns):
            continue
        if any(cells[n] != word for n, word in words.items()):
            return {}
        read = {name: cell for n, (name, cell) in enumerate(zip(columns, cells, strict=True))
                if name != SKIPPED and n not in words}  # fmt: skip
        if all(map(_NUMBER.fullmatch, read.values())):
            reading = {name: float(cell) for name, cell in read.items()}
            return reading if all(map(math.isfinite, reading.values())) else None
    other = any(not line.lstrip(_LEADING).startswith(word) for word in words.values())
    return {} if other or parse_header(line) == columns else None
