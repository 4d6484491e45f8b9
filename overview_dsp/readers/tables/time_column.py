"""A time column into seconds, chunk by chunk."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import dataclass, field
from datetime import UTC, datetime, timedelta, timezone
from typing import Any

import numpy as np
from numpy.typing import NDArray

from overview_dsp.errors import InputError, shown
from overview_dsp.readers.tables.cells import are_written_in, is_missing
from overview_dsp.readers.tables.table import Cells, as_list
from overview_dsp.readers.tables.time_format import (
    CLOCKS,
    EPOCHS,
    FORMATS,
    PLAIN,
    Format,
    as_number,
    as_text,
)
from overview_dsp.timeline import written_times
from overview_dsp.timeline.written_times import DAY_NS, NS, WAYS

_EXCEL_ZERO = -25_569
"""Day 0 of a spreadsheet (1899-12-30), days from 1970-01-01."""

_UNIT_NS = {
    "W": 7 * DAY_NS, "D": DAY_NS, "h": 3600 * NS, "m": 60 * NS, "s": NS, "ms": 1_000_000,
    "us": 1_000, "ns": 1,
}  # fmt: skip
_FIRST_S, _LAST_S = -62_135_596_800.0, 253_402_300_799.999999
"""The calendar's first and last moment, s from 1970."""

_ISO_SHAPE = re.compile(r"dddd-dd-dd([T ]dd:dd(:dd(\.d{1,9})?)?)?Z?")
_AS_SHAPE = str.maketrans("0123456789", "dddddddddd")


@dataclass
class TimeColumn:
    """Makes seconds of a column, chunk by chunk, counted from its first time.

    After the first chunk `anchor_ns` is that time (None for plain time, which counts from 0) and
    `offset_min` its zone's offset from UTC, None where times name no zone.
    """

    format: Format
    anchor_ns: int | None = None
    offset_min: int | None = None
    _zoned: bool | None = field(default=None, init=False)

    def seconds(self, cells: Cells, place: Callable[[int], str]) -> NDArray[np.float64]:
        """Return float64 of the cells' length, NaN where there is no time.

        Parameters
        ----------
        cells
            A chunk's column.
        place
            Called with the index of a wrong cell, gives how the error line begins.

        Raises
        ------
        InputError
            A cell that isn't written this way, a moment outside the years 1 to 9999, or a mixture
            of times with and without a zone.
        """
        seconds = self._seconds(cells, place)
        if self.anchor_ns is not None:
            since = seconds + self.anchor_ns / NS
            outside = np.flatnonzero((since < _FIRST_S) | (since > _LAST_S))
            if outside.size:
                raise InputError(
                    f"{place(int(outside[0]))}: the time lies outside the years 1 to 9999; say how "
                    "times are written with time (--time COLUMN:FORMAT)"
                )
        return seconds

    def _seconds(self, cells: Cells, place: Callable[[int], str]) -> NDArray[np.float64]:
        if isinstance(cells, np.ndarray) and cells.dtype.kind == "M":
            return self._of_datetimes(cells, place)
        listed = as_list(cells)
        name, fast = self.format.name, None
        if name == "iso":
            datetimes = self._fast_iso(listed)
            fast = None if datetimes is None else self._of_datetimes(datetimes, place)
        elif name in EPOCHS:
            fast = self._fast_whole(listed, EPOCHS[name])
        elif name in PLAIN:
            plain = self._fast_plain(listed)
            fast = None if plain is None else plain * PLAIN[name]
        if fast is not None:
            return fast
        return np.array([self._one(cell, i, place) for i, cell in enumerate(listed)], np.float64)

    def start(self, first_s: float) -> datetime | None:
        """Return the calendar moment `first_s` seconds after the anchor; None for plain time.

        Raises
        ------
        InputError
            It lies outside the years 1 to 9999.
        """
        if self.anchor_ns is None:
            return None
        # a datetime holds microseconds: the anchor is cut to them
        micros = (self.anchor_ns + round(first_s * NS)) // 1000
        try:
            moment = datetime(1970, 1, 1) + timedelta(microseconds=micros)
            if self.offset_min is not None:
                zone = timezone(timedelta(minutes=self.offset_min)) if self.offset_min else UTC
                moment = moment.replace(tzinfo=UTC).astimezone(zone)
        except OverflowError as error:
            raise InputError("the times lie outside the years 1 to 9999") from error
        return moment

    def _since(self, ns: int) -> float:
        if self.anchor_ns is None:
            self.anchor_ns = ns
        return (ns - self.anchor_ns) / NS

    def _one(self, cell: Any, i: int, place: Callable[[int], str]) -> float:
        if is_missing(cell):
            return math.nan
        name = self.format.name
        if isinstance(cell, np.datetime64):
            return float(self._of_datetimes(np.array([cell]), place)[0])
        if name in WAYS:
            moment = WAYS[name](as_text(cell))
            if moment is None:
                raise InputError(self._wrong(cell, place(i)))
            self._check_zone(moment.offset_min, cell, place(i))
            return self._since(moment.ns)
        if name in CLOCKS:
            way = written_times.clock_seconds
            if name == "hhmm":
                way = written_times.day_clock_seconds
            seconds = way(cell.strip()) if isinstance(cell, str) else None
            if seconds is None:
                raise InputError(self._wrong(cell, place(i)))
            return seconds
        return self._oneas_number(cell, i, place)

    def _oneas_number(self, cell: Any, i: int, place: Callable[[int], str]) -> float:
        name = self.format.name
        number = as_number(cell)
        if number is None or not math.isfinite(number) or abs(number) > 1e25:
            raise InputError(self._wrong(cell, place(i)))
        if name in PLAIN:
            return float(number) * PLAIN[name]
        if name in EPOCHS:
            self._check_zone(0, cell, place(i))
            return self._since(round(number * EPOCHS[name]))
        if name == "excel":
            return self._since(round((number + _EXCEL_ZERO) * DAY_NS))
        year = math.floor(number)
        if not 1 <= year <= 9998:
            raise InputError(self._wrong(cell, place(i)))
        begin, end = (written_times.iso(f"{y:04d}") for y in (year, year + 1))
        assert begin is not None
        assert end is not None
        return self._since(begin.ns + round((number - year) * (end.ns - begin.ns)))

    def _check_zone(self, offset_min: int | None, cell: Any, place: str) -> None:
        zoned = offset_min is not None
        if self._zoned is None:
            self._zoned, self.offset_min = zoned, offset_min
        elif self._zoned != zoned:
            has, others = ("a", "none") if zoned else ("no", "one")
            raise InputError(
                f"{place}: {shown(cell)} has {has} time zone, times before it have "
                f"{others}; write all of them in one way"
            )

    def _wrong(self, cell: Any, place: str) -> str:
        return (
            f"{place}: {shown(cell)} isn't a time as the column's others "
            f"({self.format.words}); correct it, or say how times are written "
            f"with time (--time COLUMN:FORMAT; {', '.join(FORMATS)})"
        )

    def _of_datetimes(
        self, cells: NDArray[Any], place: Callable[[int], str]
    ) -> NDArray[np.float64]:
        """Seconds of datetime64 cells, exact whatever their unit."""
        missing = np.isnat(cells)
        known = cells[~missing]
        seconds = np.full(cells.shape, np.nan)
        if not known.size:
            return seconds
        unit, count = np.datetime_data(cells.dtype)
        if unit in ("Y", "M"):
            cells, unit, count = cells.astype("datetime64[D]"), "D", 1
            known = cells[~missing]
        if unit not in _UNIT_NS:
            raise InputError(f"{place(0)}: times finer than a nanosecond; round them")
        step_ns = _UNIT_NS[unit] * count
        if self.anchor_ns is None:
            self.anchor_ns = int(known.astype(np.int64)[0]) * step_ns
        whole, rest = divmod(self.anchor_ns, step_ns)
        span = known.astype(np.int64)
        # the difference is what has to fit an int64, and a float after it
        wide = abs(int(span.max()) - whole) >= 2**62 or abs(int(span.min()) - whole) >= 2**62
        if wide:
            raise InputError(f"{place(0)}: times lie outside the years 1 to 9999")
        # a division is exact to the last place, a factor of 1e-9 isn't
        since = (span - whole) / (NS // step_ns) if step_ns < NS else (span - whole) * step_ns / NS
        seconds[~missing] = since - rest / NS
        return seconds

    def _fast_iso(self, cells: list[Any]) -> NDArray[Any] | None:
        """The cells as datetime64 if all are plain ISO of one shape, zone none or Z."""
        if not cells or not isinstance(cells[0], str):
            return None
        shape = cells[0].translate(_AS_SHAPE)
        if not _ISO_SHAPE.fullmatch(shape):
            return None
        try:
            if set(map(len, cells)) != {len(shape)}:
                return None
            letters = np.frombuffer("".join(cells).encode("ascii"), np.uint8)
        except (TypeError, ValueError):  # a cell that's no text, a letter of another script
            return None
        # one row a place of the text
        letters = np.ascontiguousarray(letters.reshape(len(cells), len(shape)).T)
        digits = [at for at, mark in enumerate(shape) if mark == "d"]
        marks = [at for at, mark in enumerate(shape) if mark != "d"]
        if any((letters[at] != ord(shape[at])).any() for at in marks):
            return None
        letters = letters - np.uint8(48)  # what was below "0" is far above 9 now
        if letters[digits].max() > 9:
            return None
        zoned = shape.endswith("Z")
        if self._zoned is None:
            self._zoned, self.offset_min = zoned, 0 if zoned else None
        elif self._zoned != zoned:
            return None  # the slow way names the cell
        return _moments_of(letters, len(shape.rstrip("Z")))

    def _fast_whole(self, cells: list[Any], unit_ns: int) -> NDArray[np.float64] | None:
        """Seconds of cells that are all whole numbers."""
        try:
            if isinstance(cells[0], str):
                if not are_written_in(cells, "0123456789"):
                    return None
                cells = list(map(int, cells))
            elif not all(type(cell) is int for cell in cells):
                return None
            whole = np.array(cells, dtype=np.int64)
        except (TypeError, ValueError, IndexError, OverflowError):
            return None
        if abs(int(whole.max())) >= 2**62 or abs(int(whole.min())) >= 2**62:
            return None
        self._check_zone(0, cells[0], "")
        if self.anchor_ns is None:
            self.anchor_ns = int(whole[0]) * unit_ns
        begin, rest = divmod(self.anchor_ns, unit_ns)
        return (whole - begin) / (NS // unit_ns) - rest / NS

    def _fast_plain(self, cells: list[Any]) -> NDArray[np.float64] | None:
        try:
            if isinstance(cells[0], str):
                if not are_written_in(cells, "0123456789.+-e"):
                    return None
                return np.fromiter(map(float, cells), np.float64, len(cells))
            if not all(type(cell) in (int, float) for cell in cells):
                return None
            found = np.array(cells, dtype=np.float64)
        except (TypeError, ValueError, IndexError, OverflowError):
            return None
        return None if np.isinf(found).any() else found


def _moments_of(digits: NDArray[np.uint8], length: int) -> NDArray[Any] | None:
    """Moments of the digits of ISO texts, shape (places, n); None where a field is out of range."""

    def number(at: int, end: int) -> NDArray[np.int64]:
        value: NDArray[np.int64] = digits[at].astype(np.int64)
        for place in range(at + 1, end):
            value *= 10
            value += digits[place]
        return value

    month, day = number(5, 7), number(8, 10)
    months = (number(0, 4) - 1970) * 12 + month - 1
    first = months.astype("datetime64[M]").astype("datetime64[D]").astype(np.int64)
    after = (months + 1).astype("datetime64[M]").astype("datetime64[D]").astype(np.int64)
    wrong = (month < 1) | (month > 12) | (day < 1) | (day > after - first)
    seconds = (first + day - 1) * 86_400
    for at, most, unit in ((11, 23, 3600), (14, 59, 60), (17, 59, 1)):
        if at < length:
            value = number(at, at + 2)
            wrong |= value > most
            seconds += value * unit
    places = max(length - 20, 0)
    fine, per_second = ("ns", 9) if places > 6 else ("us", 6)
    if fine == "ns" and np.abs(seconds).max() > 2**63 // NS - 1:
        wrong[:] = True
    if wrong.any():
        return None
    part = number(20, length) * 10 ** (per_second - places) if places else 0
    moments: NDArray[Any] = (seconds * 10**per_second + part).astype(f"datetime64[{fine}]")
    return moments
