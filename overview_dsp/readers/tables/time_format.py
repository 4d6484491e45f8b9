"""How a column's times are written: detected from its cells and its heading, or given.

`--time COLUMN`, `--time COLUMN:FORMAT` or `--time :FORMAT`, where FORMAT is one of `FORMATS`.
"""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from overview_dsp.errors import InputError, shown
from overview_dsp.readers.tables.cells import is_missing
from overview_dsp.readers.tables.table import Column
from overview_dsp.timeline import written_times
from overview_dsp.timeline.written_times import NS, WAYS

EPOCHS = {"epoch": NS, "epoch_ms": 1_000_000, "epoch_us": 1_000, "epoch_ns": 1}
"""Units of time since 1970-01-01T00:00Z, ns."""

PLAIN = {"ns": 1e-9, "us": 1e-6, "ms": 1e-3, "s": 1.0, "min": 60.0, "h": 3600.0, "d": 86_400.0}
"""Units of plain time, s."""

FORMATS = ("iso", "dmy", "mdy", *EPOCHS, *PLAIN, "clock", "hhmm", "year", "excel")
"""What may be given as the way times are written; `clock` is m:ss or h:mm:ss, `hhmm` h:mm."""

CLOCKS = ("clock", "hhmm")
"""Formats of clocks: the first of a recording, the second of the day."""

_YEARS = (1500.0, 2200.0)
_UNIT_WORDS = {
    "nanoseconds": "ns", "µs": "us", "microseconds": "us", "msec": "ms", "milliseconds": "ms",
    "sec": "s", "secs": "s", "second": "s", "seconds": "s", "mins": "min", "minute": "min",
    "minutes": "min", "hr": "h", "hrs": "h", "hour": "h", "hours": "h", "day": "d", "days": "d",
}  # fmt: skip
_DIGITS = re.compile(r"[+-]?\d{1,19}", re.ASCII)
_DECIMAL = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?", re.ASCII | re.IGNORECASE)

_CALENDAR_NAMES = ("date", "year", "yr", "jahr", "period", "datum", "month", "yyyymm", "decimal")
_DAY_NAMES = (
    "timeofday", "tod", "hour", "hora", "heure", "uhrzeit", "localtime", "clocktime", "daytime",
    "hhmm", "walltime", "wallclock", "departure", "arrival", "timeutc", "timelocal", "opening",
)  # fmt: skip
"""Beginnings of headings that name a time of day."""

_TIME_NAMES = (
    "t", "ts", "tc", "start", "begin", "onset", "end", "stop", "from", "to", "in", "out", "at",
    "when", "position", "offset", "zeit", "temps", "tiempo", "tempo", "beginn", "clock", "x",
)  # fmt: skip
"""Names of columns whose plain numbers are seconds, besides those with `time` in them."""

_EXCEL_DAYS = (20_000.0, 60_000.0)
"""Days of a spreadsheet from 1954 to 2064."""

_EPOCH_NAMES = ("epoch", "unix", "timestamp", "posix")


@dataclass(frozen=True)
class Format:
    """How a column's times are written.

    Parameters
    ----------
    name
        One of `FORMATS`, or a key of `written_times.WAYS`.
    note
        What a person should know about the choice, or empty.
    """

    name: str
    note: str = ""

    @property
    def calendar(self) -> bool:
        """True if times are moments of the calendar, False if they are plain seconds."""
        return self.name not in PLAIN and self.name not in CLOCKS

    @property
    def words(self) -> str:
        """What the column holds, in words for a person."""
        names = {
            "iso": "ISO dates", "dmy": "dates d/m/y", "mdy": "dates m/d/y",
            "yyyymm": "months", "month names": "dates with names of months",
            "quarters, months or weeks": "quarters, months or weeks",
            "epoch": "seconds since 1970", "epoch_ms": "milliseconds since 1970",
            "epoch_us": "microseconds since 1970", "epoch_ns": "nanoseconds since 1970",
            "clock": "m:ss or h:mm:ss", "hhmm": "h:mm, the time of day", "year": "years",
            "excel": "spreadsheet days",
        }  # fmt: skip
        return names.get(self.name, f"plain time in {self.name}")


def split_wish(wish: str, columns: tuple[Column, ...]) -> tuple[str | None, str | None]:
    """Return the column and the format of a `--time` value; a header with a colon outranks.

    Raises
    ------
    InputError
        The words after the last colon are no format.
    """
    asked = " ".join(wish.split())
    if any(asked.lower() in (column.header.lower(), column.name.lower()) for column in columns):
        return wish, None
    name, colon, written = wish.rpartition(":")
    if not colon:
        return wish, None
    written = written.strip().lower()
    if written not in FORMATS:
        raise InputError(
            f"time {shown(wish)}: {shown(written)} is no way of writing times; "
            f"known are {', '.join(FORMATS)}"
        )
    return name.strip() or None, written


def detected_format(column: Column, cells: list[Any]) -> Format | None:
    """Detect how times are written from a column's first cells; None if they are no times.

    Day or month first is left as `dmy or mdy` where both fit all cells.
    """
    known = [cell for cell in cells if not is_missing(cell)]
    if not known or any(isinstance(cell, bool) for cell in known):
        return None
    if all(isinstance(cell, np.datetime64) for cell in known):
        return Format("iso")

    def most(count: int) -> bool:
        # one in three may be a mistake, to be named when it is read
        return 3 * count >= 2 * len(known)

    numbers = [(cell, number) for cell in known if (number := as_number(cell)) is not None]
    if most(len(numbers)):
        return _numeric_format(column, *map(list, zip(*numbers, strict=True)))
    texts = [cell.strip() for cell in known if isinstance(cell, str)]
    if not most(len(texts)):
        return None
    ways = [name for name in WAYS if name != "yyyymm"]
    fits = {name: sum(WAYS[name](text) is not None for text in texts) for name in ways}
    best = max(fits, key=fits.__getitem__)
    if most(fits[best]):
        if not fits["dmy"] == fits["mdy"] == fits[best]:
            return Format(best)
        # points between the parts: day first wherever they are used
        return Format("dmy" if all("." in text.split()[0] for text in texts) else "dmy or mdy")
    return _clock_format(column, texts, most)


def _clock_format(column: Column, texts: list[str], most: Callable[[int], bool]) -> Format | None:
    """Distinguish clocks of the day from those of a recording, and say so where both would do."""
    of_day = most(sum(written_times.day_clock_seconds(text) is not None for text in texts))
    halves = most(sum(text[-1:] in "mM." for text in texts))
    running = most(sum(written_times.clock_seconds(text) is not None for text in texts))
    if of_day and (halves or _names_time_of_day(column)):
        form, other, reads = "hhmm", "clock", "minutes:seconds"
    elif running:
        form, other, reads = "clock", "hhmm", "hours:minutes"
    else:
        return None
    if not (of_day and running) or any(text.count(":") > 1 for text in texts):
        return Format(form)
    example = shown(texts[0])
    as_read = "hours:minutes" if form == "hhmm" else "minutes:seconds"
    return Format(
        form,
        f"times such as {example} are read as {as_read}; "
        f"time='{column.header}:{other}' (--time) reads them as {reads}",
    )


def _names_time_of_day(column: Column) -> bool:
    unit = re.sub(r"[^a-z0-9]", "", column.unit.lower())
    return column.plain.startswith(_DAY_NAMES) or unit in ("hhmm", "hmm", "24h", "12h", "localtime")


def settle_order(texts: Iterator[tuple[int, str]]) -> tuple[str, int | None]:
    """Distinguish `dmy` and `mdy` by all cells of a column, (row number, text) each.

    A part above 12 is the day. Where there is none in the whole column, the order in which the
    times increase (or decrease) throughout is taken if just one does.

    Returns
    -------
    tuple
        `dmy` or `mdy` and the number of the row that proves it (None: the order of rows does), or
        an empty text if nothing decides it.
    """
    order = {"dmy": [True, True], "mdy": [True, True]}  # still increasing, still decreasing
    last: dict[str, int] = {}
    moved = False
    for number, text in texts:
        both = {name: WAYS[name](text) for name in order}
        possible = [name for name, moment in both.items() if moment is not None]
        if len(possible) == 1:
            return possible[0], number
        for name in possible:
            moment = both[name]
            assert moment is not None
            if name in last and moment.ns != last[name]:
                moved = True
                order[name][0] &= moment.ns > last[name]
                order[name][1] &= moment.ns < last[name]
            last[name] = moment.ns
    steady = [name for name, ways in order.items() if any(ways)]
    return (steady[0], None) if moved and len(steady) == 1 else ("", None)


def as_text(cell: Any) -> str:
    """A cell as text: 20120919 may be a number, with a fraction of 0 too."""
    if isinstance(cell, float) and cell.is_integer():
        cell = int(cell)
    return str(cell).strip()


def as_number(cell: Any) -> int | float | None:
    """The number a cell is, exact if it is whole."""
    if isinstance(cell, bool):
        return None
    if isinstance(cell, int | float):
        return cell
    if not isinstance(cell, str):
        return None
    text = cell.strip()
    if _DIGITS.fullmatch(text):
        return int(text)
    if not _DECIMAL.fullmatch(text) or len(text) > 40:
        return None
    value = float(text)
    return value if math.isfinite(value) else None


def _numeric_format(column: Column, cells: list[Any], numbers: list[int | float]) -> Format | None:
    """Detect what a time column's numbers mean from their size and its name."""
    name, size = column.plain, max(abs(number) for number in numbers)
    low = min(numbers)
    whole = all(isinstance(n, int) or float(n).is_integer() for n in numbers)
    dated = any(word in name for word in _CALENDAR_NAMES)
    if whole and _all_dates(cells, 8):
        return Format("iso")
    if dated and whole and _all_dates(cells, 6):
        return Format("yyyymm")
    if dated and _YEARS[0] <= low and size <= _YEARS[1]:
        return Format("year")
    if ("date" in name or "datum" in name) and _EXCEL_DAYS[0] <= low and size <= _EXCEL_DAYS[1]:
        return Format("excel", "numbers under a date are read as a spreadsheet's days")
    unit = _UNIT_WORDS.get(column.unit.lower(), column.unit.lower())
    tail = re.search(r"_(ns|us|ms|s|sec|seconds|min|h)$", column.name.lower())
    if unit not in PLAIN and tail:
        unit = _UNIT_WORDS.get(tail[1], tail[1])
    # by size: between 1990 and 2100 in just one of the units
    for epoch, unit_ns in EPOCHS.items():
        per_second = NS // unit_ns
        if 631_152_000 * per_second <= low and size < 4_102_444_800 * per_second:
            return Format(epoch, f"times {_of(epoch)} were detected from their size")
    if any(word in name for word in _EPOCH_NAMES) and low >= 0 and size < 2**62:
        per = next((e for e, u in EPOCHS.items() if size < 4_102_444_800 * (NS // u)), "epoch_ns")
        return Format(per, f"times {_of(per)} were detected from the column's name and their size")
    if unit not in PLAIN:
        unit = _UNIT_WORDS.get(name, "")
    if unit in PLAIN:
        return Format(unit)
    if whole and _YEARS[0] <= low and size <= _YEARS[1] and len(set(numbers)) == len(numbers):
        note = f"whole numbers from {low:g} to {size:g} are read as years"
        return Format("year", f"{note}; time='{column.header}:s' (--time) reads them as seconds")
    bare = re.fullmatch(r"column\d+", name)
    if bare or name in _TIME_NAMES or any(word in name for word in ("time", "elapsed", "date")):
        return Format("s")
    return None


def _of(epoch: str) -> str:
    return f"in {Format(epoch).words}"


def _all_dates(cells: list[Any], length: int) -> bool:
    texts = [as_text(cell) for cell in itertools.islice(cells, 1000)]
    if not all(len(text) == length and text.isdigit() for text in texts):
        return False
    days = [text if length == 8 else text + "01" for text in texts]
    return all(1000 <= int(day[:4]) <= 2500 and written_times.iso(day) is not None for day in days)
