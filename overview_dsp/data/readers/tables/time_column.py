"""Columns of times: detection of their format, and conversion to seconds, chunk by chunk.

`--time-column COLUMN`, `--time-column COLUMN:FORMAT` or `--time-column :FORMAT`, where FORMAT is
one of `FORMATS`.
"""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from datetime import datetime
from typing import Any

import numpy as np
from numpy.typing import NDArray

from overview_dsp.arrays import FloatArray
from overview_dsp.data.readers.tables.cells import detect_decimal_mark, is_missing
from overview_dsp.data.readers.tables.column_names import NAMES, TIME_FORMATS, TIME_UNITS
from overview_dsp.data.readers.tables.table import (
    CellLocation,
    Cells,
    Column,
    Columns,
    as_list,
    split_column_option,
)
from overview_dsp.data.readers.tables.text_cells import PAD, TextCells
from overview_dsp.data.timeline.time_parsing import (
    DAY_NS,
    FORMS,
    NS,
    Moment,
    clock_s,
    day_clock_s,
    moment,
    moments,
)
from overview_dsp.errors import InputError, quoted

EPOCHS = {"epoch": NS, "epoch_ms": 1_000_000, "epoch_us": 1_000, "epoch_ns": 1}
"""Units of time since 1970-01-01T00:00Z, in ns."""

PLAIN = {"ns": 1e-9, "us": 1e-6, "ms": 1e-3, "s": 1.0, "min": 60.0, "h": 3600.0, "d": 86_400.0}
"""Units of plain time, in s."""

FORMATS = ("iso", "dmy", "mdy", *EPOCHS, *PLAIN, "clock", "hhmm", "year", "excel")
"""Formats that the user can request; `clock` is m:ss or h:mm:ss, `hhmm` is h:mm."""

CLOCKS = ("clock", "hhmm")
"""Clock formats: time in a recording, and time of day."""

_LARGEST = 1e25
_LONGEST_NUMBER, _LONGEST_DATE = 40, PAD
"""Maximum lengths of a number and of a date that are converted as arrays, in characters."""

_MOST_SHAPES = 200
"""Maximum number of texts per chunk that differ in more than digits: in months, or weekdays."""

_YEARS = (1500.0, 2200.0)
_DIGITS = re.compile(r"[+-]?\d{1,19}", re.ASCII)
_DECIMAL = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?", re.ASCII | re.IGNORECASE)

_EXCEL_DAYS = (20_000.0, 60_000.0)
"""Spreadsheet days of the years 1954 to 2064."""

_EXCEL_ZERO = -25_569
"""Spreadsheet day 0 (1899-12-30), in days from 1970-01-01."""

_FIRST_S, _LAST_S = -62_135_596_800.0, 253_402_300_799.999999
"""First and last moment of the calendar, in s from 1970."""


@dataclass(frozen=True)
class Format:
    """Format of a column of times.

    `name`: one of `FORMATS`, or a key of `time_parsing.FORMS`.
    `note`: message about the choice, or empty.
    """

    name: str
    note: str = ""

    @property
    def calendar(self) -> bool:
        """True for moments of the calendar, False for plain times and clocks."""
        return self.name not in PLAIN and self.name not in CLOCKS

    @property
    def description(self) -> str:
        """Description of the times, for messages."""
        return TIME_FORMATS.get(self.name, f"plain time in {self.name}")


def requested_format(option: str | None, columns: Columns) -> tuple[str | None, str]:
    """Return column (or None) and format (or "") of a `--time-column` option.

    InputError: the text after the last colon is not a format.
    """
    if option is None:
        return None, ""
    name, written = split_column_option(option, columns)
    if name != option and written not in FORMATS:
        raise InputError(
            f"time {quoted(option)}: {quoted(written)} is not a format of times; "
            f"allowed: {', '.join(FORMATS)}"
        )
    return name if name or not option else None, written


def detected_format(column: Column, cells: Sequence[Any]) -> Format | None:
    """Detect the format of times from the first cells of a column; None for other cells.

    The format is `dmy or mdy` if both fit all cells.
    """
    known = [cell for cell in cells if not is_missing(cell)]
    if not known or any(isinstance(cell, bool) for cell in known):
        return None
    if all(isinstance(cell, np.datetime64) for cell in known):
        return Format("iso")

    def most(count: int) -> bool:
        # up to a third of the cells may be mistakes, which are errors when they are read
        return 3 * count >= 2 * len(known)

    mark = detect_decimal_mark(known[:100]) or "."
    numbers = [(cell, number) for cell in known if (number := as_number(cell, mark)) is not None]
    if most(len(numbers)):
        return _numeric_format(column, *map(list, zip(*numbers, strict=True)))
    texts = [cell.strip() for cell in known if isinstance(cell, str)]
    if not most(len(texts)):
        return None
    forms = [name for name in FORMS if name != "yyyymm"]
    fits = {name: sum(moment(text, name) is not None for text in texts) for name in forms}
    best = max(fits, key=fits.__getitem__)
    if most(fits[best]):
        if not fits["dmy"] == fits["mdy"] == fits[best]:
            return Format(best)
        # dates with points have the day first
        return Format("dmy" if all("." in text.split()[0] for text in texts) else "dmy or mdy")
    return _clock_format(column, texts, most)


def _clock_format(column: Column, texts: list[str], most: Callable[[int], bool]) -> Format | None:
    """Distinguish times of day from times in a recording; a note explains ambiguous cases."""
    of_day = most(sum(day_clock_s(text) is not None for text in texts))
    has_am_pm = most(sum(text[-1:] in "mM." for text in texts))
    running = most(sum(clock_s(text) is not None for text in texts))
    unit = re.sub(r"[^a-z0-9]", "", column.unit.lower())
    is_named = unit in ("hhmm", "hmm", "24h", "12h", "localtime")
    is_named = is_named or column.plain.startswith(NAMES["time_of_day_prefixes"])
    if of_day and (has_am_pm or is_named):
        form, as_read, other, as_other = "hhmm", "hours:minutes", "clock", "minutes:seconds"
    elif running:
        form, as_read, other, as_other = "clock", "minutes:seconds", "hhmm", "hours:minutes"
    else:
        return None
    if not (of_day and running) or any(text.count(":") > 1 for text in texts):
        return Format(form)
    example = quoted(texts[0])
    return Format(
        form,
        f"times such as {example} are read as {as_read}; "
        f"time='{column.header}:{other}' (--time-column) reads them as {as_other}",
    )


def settle_order(texts: Iterator[tuple[int, str]]) -> tuple[str, int | None]:
    """Distinguish `dmy` and `mdy` by all cells of a column, as pairs of row number and text.

    A number above 12 is the day. Without any, the format is chosen with which the times always
    increase, or always decrease, if only one format does. The number of the row that decides is
    returned too (None if the order of rows does). The text is empty if nothing decides.
    """
    order = {"dmy": [True, True], "mdy": [True, True]}  # still increasing, still decreasing
    last: dict[str, int] = {}
    moved = False
    for number, text in texts:
        both = {name: moment(text, name) for name in order}
        possible = [name for name, read in both.items() if read is not None]
        if len(possible) == 1:
            return possible[0], number
        for name in possible:
            read = both[name]
            assert read is not None
            if name in last and read.ns != last[name]:
                moved = True
                order[name][0] &= read.ns > last[name]
                order[name][1] &= read.ns < last[name]
            last[name] = read.ns
    steady = [name for name, directions in order.items() if any(directions)]
    return (steady[0], None) if moved and len(steady) == 1 else ("", None)


def as_text(cell: Any) -> str:
    """Return a cell as text; 20120919.0 becomes 20120919."""
    if isinstance(cell, float) and cell.is_integer():
        cell = int(cell)
    text = str(cell).strip()
    return text[:-2] if text.endswith(".0") and text[:-2].isdigit() else text


def as_number(cell: Any, decimal_mark: str = ".") -> int | float | None:
    """Return the number in a cell, as int if it is whole, else None."""
    if isinstance(cell, bool):
        return None
    if isinstance(cell, int | float):
        return cell
    if not isinstance(cell, str):
        return None
    text = cell.strip().replace(decimal_mark, ".")
    if _DIGITS.fullmatch(text):
        return int(text)
    if not _DECIMAL.fullmatch(text) or len(text) > _LONGEST_NUMBER:
        return None
    value = float(text)
    return value if math.isfinite(value) else None


def _numeric_format(column: Column, cells: list[Any], numbers: list[int | float]) -> Format | None:
    """Detect the format of a column of numbers from their size and its name."""
    name, size = column.plain, max(abs(number) for number in numbers)
    low = min(numbers)
    whole = all(isinstance(n, int) or float(n).is_integer() for n in numbers)
    dated = any(word in name for word in NAMES["calendar_parts"])
    if whole and (length := _compact_dates(cells)):
        written = "YYYYMMDDHHMMSS"[:length]
        return Format("iso", f"numbers are read as dates {written}" if length > 8 else "")
    if dated and whole and _compact_dates(cells, (6,)):
        return Format("yyyymm")
    if dated and _YEARS[0] <= low and size <= _YEARS[1]:
        return Format("year")
    if ("date" in name or "datum" in name) and _EXCEL_DAYS[0] <= low and size <= _EXCEL_DAYS[1]:
        return Format("excel", "numbers under a date are read as a spreadsheet's days")
    # numbers from 1990 to 2100 in only one of the units
    for epoch, unit_ns in EPOCHS.items():
        per_second = NS // unit_ns
        if 631_152_000 * per_second <= low and size < 4_102_444_800 * per_second:
            return Format(epoch, f"times {_of(epoch)} were detected from their size")
    if any(word in name for word in NAMES["epoch_parts"]) and low >= 0 and size < 2**62:
        per = next((e for e, u in EPOCHS.items() if size < 4_102_444_800 * (NS // u)), "epoch_ns")
        return Format(per, f"times {_of(per)} were detected from the column's name and their size")
    if unit := written_unit(column):
        return Format(unit)
    if whole and _YEARS[0] <= low and size <= _YEARS[1] and len(set(numbers)) == len(numbers):
        note = f"whole numbers from {low:g} to {size:g} are read as years"
        return Format(
            "year", f"{note}; time='{column.header}:s' (--time-column) reads them as seconds"
        )
    bare = re.fullmatch(r"(column)?\d+", name)
    if (
        bare
        or name in NAMES["seconds"]
        or any(word in name for word in ("time", "elapsed", "date"))
    ):
        return Format("s")
    return None


def written_unit(column: Column) -> str:
    """Return the unit of plain time that a header names, one of `PLAIN`, else an empty text."""
    tail = re.search(r"[_ ](ns|us|ms|msec|s|sec|seconds|min|h)$", column.name.lower())
    for written in (column.unit.lower(), tail[1] if tail else "", column.plain):
        unit = TIME_UNITS.get(written, written)
        if unit in PLAIN and (unit != written or written != column.plain):
            return unit
    return ""


def _of(epoch: str) -> str:
    return f"in {Format(epoch).description}"


def _compact_dates(cells: list[Any], lengths: Sequence[int] = (8, 10, 12, 14)) -> int:
    """Return the number of digits of dates without marks (YYYYMMDDHH), 0 for other numbers.

    Numbers of ten digits and more also count from 1970. They are dates of the years 1900 to 2100 if
    at least two thirds, two or more, are: one in a hundred others is.
    """
    texts = [as_text(cell) for cell in itertools.islice(cells, 1000)]
    length = len(texts[0])
    if length not in lengths or not all(len(t) == length and t.isdigit() for t in texts):
        return 0
    low, high = (1000, 2500) if length <= 8 else (1900, 2100)
    days = [text if length > 6 else text + "01" for text in texts]
    dates = [low <= int(day[:4]) <= high and moment(day, "iso") is not None for day in days]
    most = all(dates) if length <= 8 else len(dates) > 1 and 3 * sum(dates) >= 2 * len(dates)
    return length if most else 0


@dataclass
class TimeColumn:
    """Converter of a column to seconds from its first time, chunk by chunk.

    After the first chunk, `anchor_ns` is the first time (None for plain time, which counts from 0).
    `offset_min` is its offset from UTC, None without a zone. `decimal_mark`: that of numbers.
    """

    format: Format
    anchor_ns: int | None = None
    offset_min: int | None = None
    decimal_mark: str = "."
    _zoned: bool | None = field(default=None, init=False)

    def seconds(self, cells: Cells, locate: Callable[[int], CellLocation]) -> FloatArray:
        """Return float64 of the cells' length, NaN where there is no time.

        `cells`: a chunk's column.
        `locate`: function from the index of a cell to its location, for errors.

        InputError: a cell in another format, a moment outside the years 1 to 9999, or a mixture of
        times with and without a zone.
        """
        seconds = self._seconds(cells, locate)
        if self.anchor_ns is not None:
            since_s = self.anchor_ns / NS
            low, high = (f.reduce(seconds, initial=np.nan) + since_s for f in (np.fmin, np.fmax))
            if low < _FIRST_S or high > _LAST_S:
                since = seconds + since_s
                i = int(np.flatnonzero((since < _FIRST_S) | (since > _LAST_S))[0])
                raise locate(i).error(
                    as_list(cells)[i],
                    "is a time outside the years 1 to 9999; give their format with time "
                    "(--time-column COLUMN:FORMAT)",
                )
        return seconds

    def _seconds(self, cells: Cells, locate: Callable[[int], CellLocation]) -> FloatArray:
        if isinstance(cells, np.ndarray) and cells.dtype.kind == "M":
            return self._of_datetimes(cells, locate)
        name, fast = self.format.name, None
        if name in FORMS:
            dates = self._dates(cells)
            fast = None if dates is None else self._of_datetimes(dates, locate)
        elif name in EPOCHS or name in PLAIN:
            fast = self._numbers(cells)
        if fast is not None:
            return fast
        listed = as_list(cells)
        return np.array(
            [self._seconds_of(cell, i, locate) for i, cell in enumerate(listed)], np.float64
        )

    def start(self, first_s: float) -> datetime | None:
        """Return the calendar moment `first_s` seconds after the anchor; None for plain time.

        InputError: it lies outside the years 1 to 9999.
        """
        if self.anchor_ns is None:
            return None
        try:
            return Moment(self.anchor_ns + round(first_s * NS), self.offset_min).to_datetime()
        except OverflowError as error:
            raise InputError("the times lie outside the years 1 to 9999") from error

    def _since(self, ns: int) -> float:
        if self.anchor_ns is None:
            self.anchor_ns = ns
        return (ns - self.anchor_ns) / NS

    def _seconds_of(self, cell: Any, i: int, locate: Callable[[int], CellLocation]) -> float:
        if is_missing(cell):
            return math.nan
        if isinstance(cell, np.datetime64):
            return float(self._of_datetimes(np.array([cell]), locate)[0])
        name = self.format.name
        if name in FORMS:
            read = moment(as_text(cell), name)
            if read is None:
                raise self._wrong(cell, locate(i))
            self._check_zone(read.offset_min, cell, locate(i))
            return self._since(read.ns)
        if name in CLOCKS:
            clock = day_clock_s if name == "hhmm" else clock_s
            seconds = clock(cell.strip()) if isinstance(cell, str) else None
            if seconds is None:
                raise self._wrong(cell, locate(i))
            return seconds
        return self._of_number(cell, i, locate)

    def _of_number(self, cell: Any, i: int, locate: Callable[[int], CellLocation]) -> float:
        name = self.format.name
        number = as_number(cell, self.decimal_mark)
        if number is None or not math.isfinite(number) or abs(number) > _LARGEST:
            raise self._wrong(cell, locate(i))
        if name in PLAIN:
            return float(number) * PLAIN[name]
        if name in EPOCHS:
            self._check_zone(0, cell, locate(i))
            return self._since(round(number * EPOCHS[name]))
        if name == "excel":
            return self._since(round((number + _EXCEL_ZERO) * DAY_NS))
        year = math.floor(number)
        if not 1 <= year <= 9998:
            raise self._wrong(cell, locate(i))
        begin, end = (moment(f"{y:04d}", "iso") for y in (year, year + 1))
        assert begin is not None
        assert end is not None
        return self._since(begin.ns + round((number - year) * (end.ns - begin.ns)))

    def _check_zone(self, offset_min: int | None, cell: Any, location: CellLocation) -> None:
        zoned = offset_min is not None
        if self._zoned is None:
            self._zoned, self.offset_min = zoned, offset_min
        elif self._zoned != zoned:
            has, others = ("a", "none") if zoned else ("no", "one")
            raise location.error(
                cell,
                f"has {has} time zone, times before it have {others}; write all of them in one way",
            )

    def _wrong(self, cell: Any, location: CellLocation) -> InputError:
        return location.error(
            cell,
            f"isn't a time like others in the column ({self.format.description}); correct it, or "
            f"give the format with time (--time-column COLUMN:FORMAT; {', '.join(FORMATS)})",
        )

    def _of_datetimes(
        self, cells: NDArray[Any], locate: Callable[[int], CellLocation]
    ) -> FloatArray:
        """Return the seconds of datetime64 cells, exact in any unit."""
        missing = np.isnat(cells)
        known = cells[~missing] if missing.any() else cells
        seconds = np.full(cells.shape, np.nan)
        if not known.size:
            return seconds
        unit, count = np.datetime_data(cells.dtype)
        if unit in ("Y", "M"):
            known, unit, count = known.astype("datetime64[D]"), "D", 1
        step_ns = int(np.array(1, f"m8[{unit}]") / np.timedelta64(1, "ns")) * count
        if not step_ns:
            raise locate(0).error(cells[0], "is finer than a nanosecond; round the times")
        span = known.astype(np.int64)
        if self.anchor_ns is None:
            self.anchor_ns = int(span[0]) * step_ns
        whole, rest = divmod(self.anchor_ns, step_ns)
        # only the difference has to fit an int64, and later a float
        if max(abs(int(span.max()) - whole), abs(int(span.min()) - whole)) >= 2**62:
            raise locate(0).error(cells[0], "or a later time lies outside the years 1 to 9999")
        # a division is exact to the last digit, a factor of 1e-9 isn't
        since = (
            (span - whole) / (NS // step_ns) if step_ns < NS else (span - whole) * (step_ns // NS)
        )
        if len(known) == len(cells):
            return np.asarray(since - rest / NS)
        seconds[~missing] = since - rest / NS
        return seconds

    def _dates(self, cells: Cells) -> NDArray[Any] | None:
        """Return texts as datetime64 in UTC, None if a cell has to be read by `_seconds_of`.

        Texts that differ only in digits are read together.
        """
        if not isinstance(cells, TextCells):
            listed = as_list(cells)
            whole = all(type(cell) is int for cell in listed)
            found = TextCells.of(list(map(str, listed)) if whole else listed)
            if found is None:
                return None
            cells = found
        if int((cells.stops - cells.starts).max(initial=0)) > _LONGEST_DATE:
            return None
        at, after = np.full((2, len(cells)), 0)
        known = np.ones(len(cells), np.bool_)
        zoned, offset_min = self._zoned, self.offset_min
        left = np.arange(len(cells))
        for _ in range(_MOST_SHAPES):
            if not left.size:
                break
            same = cells.like_first(left)
            rows, left = left[same], left[~same]
            # consecutive cells as a slice, which isn't copied
            begin, end = int(rows[0]), int(rows[-1]) + 1
            place: Any = slice(begin, end) if end - begin == len(rows) else rows
            texts = cells[place]
            if is_missing(texts[0]):
                known[place] = False
                continue
            if as_text(texts[0]) != texts[0]:
                return None
            read = moments(texts[0], self.format.name, texts)
            if read is None:
                return None
            at[place], after[place], offset = read
            if zoned is None:
                zoned = offset is not None
                offset_min = None if offset is None else int(np.ravel(offset)[0])
            elif zoned != (offset is not None):
                return None
        if left.size:
            return None
        self._zoned, self.offset_min = zoned, offset_min
        fine = "s"
        if after.any():
            fine, per_second = ("us", 10**6) if not (after % 1000).any() else ("ns", NS)
            furthest = max(int(np.abs(at).max()) * NS, abs(self.anchor_ns or 0))
            if fine == "ns" and furthest >= 2**61 - NS:  # differences have to fit too
                return None
            at = at * per_second + after // (NS // per_second)
        at[~known] = np.iinfo(np.int64).min
        return at.view(f"datetime64[{fine}]")

    def _numbers(self, cells: Cells) -> FloatArray | None:
        """Return the seconds of numbers, None if a cell has to be read by `_seconds_of`.

        Times since 1970 have to be whole numbers.
        """
        plain = PLAIN.get(self.format.name)
        texts = TextCells.of(cells) if isinstance(cells, list) else cells
        if isinstance(texts, TextCells):
            if not len(texts) or int((texts.stops - texts.starts).max()) > _LONGEST_NUMBER:
                return None
            is_whole = plain is None or bool(texts[:64].wholes()[1].all())
            found, good = texts.wholes() if is_whole else texts.decimals(self.decimal_mark)
            if plain is not None and not good.all():
                found, good = texts.decimals(self.decimal_mark)
            known = texts.stops > texts.starts
            if not (good | ~known).all():
                return None
        else:
            if isinstance(cells, list) and not set(map(type, cells)) <= {int, float}:
                return None
            found = np.asarray(cells)
            known = np.ones(len(found), np.bool_)
        if found.dtype.kind not in "if" or not known.any():
            return None
        if plain is not None:
            size = np.abs(found[known].astype(np.float64))
            return None if (size > _LARGEST).any() else found.astype(np.float64) * plain
        whole, unit_ns = found[known], EPOCHS[self.format.name]
        other = whole.dtype.kind != "i" or (self.anchor_ns or 0) % unit_ns  # or a first fraction
        if other or max(-int(whole.min()), int(whole.max())) >= 2**62:
            return None
        self._check_zone(0, "", CellLocation(0))
        if self.anchor_ns is None:
            self.anchor_ns = int(whole[0]) * unit_ns
        seconds = np.full(len(found), np.nan)
        seconds[known] = (whole - self.anchor_ns // unit_ns) / (NS // unit_ns)
        return seconds
