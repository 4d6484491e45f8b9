"""Which columns of a table hold the times and the values: as asked, or detected from them."""

from __future__ import annotations

import itertools
import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from overview_dsp.errors import InputError, shown
from overview_dsp.readers.series import prices
from overview_dsp.readers.tables.cells import is_missing, looks_numeric
from overview_dsp.readers.tables.table import Column, Table, as_list, column_named, listed
from overview_dsp.readers.tables.time_column import CLOCKS, Format, detected_format, split_wish
from overview_dsp.timeline.times import moment

_DATE_NAMES = (
    "date", "datetime", "timestamp", "time", "ts", "t", "datum", "zeit", "zeitstempel", "fecha",
    "data", "jour", "day", "month", "year", "period", "quarter", "week", "observationdate",
    "opentime", "epoch", "unix", "unixtime", "unixtimestamp", "times", "seconds", "secs", "sec",
    "minutes", "hours", "elapsed", "elapsedtime", "valid", "dateutc", "timeutc", "localtime",
    "createdat", "recordedat", "index", "", "yyyymmdd", "decimaldate", "decimalyear", "jahr",
    "anno", "ano", "año", "mes", "monat", "tag",
)  # fmt: skip
_DATE_WORDS = ("date", "time", "datum", "zeit", "fecha", "epoch", "unix", "seconds", "elapsed")
_COUNTER_NAMES = ("", "index", "id", "no", "nr", "row", "unnamed0", "rownum", "record", "obs")
_OFFSET_NAMES = ("utcoffset", "offset", "gmtoffset", "tz", "timezone", "zone", "tzoffset")
_OFFSET = re.compile(r"[+\-−]\d{2}:?\d{2}|Z|UTC", re.ASCII)
_CLOCK_NAMES = ("time", "zeit", "hora", "heure", "uhrzeit", "clock", "timeofday")


@dataclass(frozen=True)
class TimeChoice:
    """The columns whose cells, joined, are the times, and how those are written.

    Several columns are joined by `joint`: a date and a clock by a blank, year, month and day by
    hyphens. No column: rows are evenly spaced (`rate`).
    """

    columns: tuple[int, ...]
    format: Format
    joint: str = ""
    notes: tuple[str, ...] = ()


@dataclass(frozen=True)
class ValueChoice:
    """The column of values, and a note on the choice."""

    column: int
    note: str = ""


def choose_time(
    table: Table, head: Sequence[list[Any]], wish: str | None, rated: bool
) -> TimeChoice:
    """Choose the time column.

    Parameters
    ----------
    table
        The table.
    head
        Its first rows, a list a column.
    wish
        `COLUMN`, `COLUMN:FORMAT` or `:FORMAT`.
    rated
        Rows are evenly spaced at a rate that was given.

    Raises
    ------
    InputError
        No such column, or none that looks like times; the line names the columns.
    """
    columns = table.columns
    named, written = (None, None) if wish is None else split_wish(wish, columns)
    if named is not None:
        index = column_named(columns, named)
        if index is None:
            raise InputError(
                f"no column {shown(named)} for the times; columns are {listed(columns)}"
            )
        form = Format(written) if written else detected_format(columns[index], head[index])
        if form is None and looks_numeric(head[index]):  # asked for: numbers are seconds then
            header = shown(columns[index].header)
            form = Format("s", f"the numbers of column {header} are read as seconds")
        if form is None:
            first = next((c for c in head[index] if not is_missing(c)), None)
            raise InputError(
                f"column {shown(columns[index].header)} holds "
                f"{shown(first) if first is not None else 'no values'}, which isn't a time "
                "in any known way; name another column, or say how times are written "
                "with time (--time COLUMN:FORMAT)"
            )
        return TimeChoice((index,), form, notes=_form_notes(form))
    if rated:
        return TimeChoice((), Format("s"))
    found = _best(columns, head)
    if found is None:
        parts = _year_month_day(columns, head)
        if parts is not None:
            return parts
        raise InputError(
            f"no column looks like times; columns are {listed(columns)}: name one with time "
            "(--time COLUMN:FORMAT; numbers that only count rows are no times), or give the "
            "samples a second of evenly spaced rows with rate (--rate)"
        )
    index, form = found
    if written:
        form = Format(written)
    clock = _clock_beside(columns, head, index, form)
    offset = _offset_beside(columns, head, index, form)
    beside = tuple(i for i in (clock, offset) if i is not None)
    if beside:
        return TimeChoice((index, *beside), form, " ", _form_notes(form))
    if form.name == "year":
        parts = _year_month_day(columns, head)
        if parts is not None:
            return parts
    notes = _form_notes(form)
    if columns[index].plain not in _DATE_NAMES:
        notes = (*notes, f"times are taken from column {shown(columns[index].header)}")
    return TimeChoice((index,), form, "", notes)


def _form_notes(form: Format) -> tuple[str, ...]:
    return (form.note,) if form.note else ()


def _best(columns: Sequence[Column], head: Sequence[list[Any]]) -> tuple[int, Format] | None:
    """The first column of the best rank: named and dated, dated, named, first and rising."""
    ranked: list[tuple[int, int, Format]] = []
    for i, (column, cells) in enumerate(zip(columns, head, strict=True)):
        form = detected_format(column, cells)
        if form is None:
            continue
        fixed = form.name != "year" and _is_constant(cells)  # a station's number, a table's date
        if fixed and _clock_beside(columns, head, i, form) is None:
            continue
        name = column.plain
        named = name in _DATE_NAMES or any(word in name for word in _DATE_WORDS)
        dated = form.calendar and form.name != "year"
        if dated and form.name.startswith("epoch") and not named:
            dated = i == 0  # large numbers elsewhere are volumes and the like
        if dated and form.name == "iso" and not named and looks_numeric(cells):
            dated = i == 0
        named = named or form.name == "hhmm"  # a heading that names a time of day
        if form.name in CLOCKS and not named:
            continue
        if dated:
            rank = 0 if named and name != "" else 1
        elif named and name not in _COUNTER_NAMES:
            rank = 2 if form.calendar else 3
        elif i == 0 and len(columns) > 1 and _rising(cells):
            rank = 4
        else:
            continue
        ranked.append((rank, i, form))
    if not ranked:
        return None
    _, index, form = min(ranked, key=lambda entry: entry[:2])
    return index, form


def _rising(cells: list[Any]) -> bool:
    values = [_float(cell) for cell in cells]
    known = [value for value in values if value is not None]
    return len(known) == len(cells) and all(b > a for a, b in itertools.pairwise(known))


def _float(cell: Any) -> float | None:
    try:
        return float(cell)
    except (TypeError, ValueError, OverflowError):
        return None


def _clock_beside(
    columns: Sequence[Column], head: Sequence[list[Any]], date: int, form: Format
) -> int | None:
    """A column of clock times that completes one of days."""
    if form.name not in ("iso", "dmy", "mdy", "dmy or mdy", "month names"):
        return None
    known = [cell for cell in head[date] if isinstance(cell, str) and not is_missing(cell)]
    if not known or any(":" in cell for cell in known):
        return None
    for i, (column, cells) in enumerate(zip(columns, head, strict=True)):
        texts = [cell for cell in cells if isinstance(cell, str) and not is_missing(cell)]
        if i == date or not texts or not any(name in column.plain for name in _CLOCK_NAMES):
            continue
        if all(moment(f"2000-01-01 {text.strip()}", "iso") is not None for text in texts):
            return i
    return None


def _offset_beside(
    columns: Sequence[Column], head: Sequence[list[Any]], date: int, form: Format
) -> int | None:
    """A column of offsets from UTC, which tells the hours apart that clock changes repeat."""
    if form.name not in ("iso", "dmy", "mdy", "dmy or mdy", "month names"):
        return None
    for i, (column, cells) in enumerate(zip(columns, head, strict=True)):
        texts = [cell.strip() for cell in cells if isinstance(cell, str) and not is_missing(cell)]
        named = column.plain in _OFFSET_NAMES
        if i != date and named and texts and all(map(_OFFSET.fullmatch, texts)):
            return i
    return None


def _year_month_day(columns: Sequence[Column], head: Sequence[list[Any]]) -> TimeChoice | None:
    """Columns `year`, `month` and maybe `day` (and `hour`) together."""
    names = [column.plain for column in columns]
    wanted = (("year", "yr", "jahr"), ("month", "mo", "mon", "monat"), ("day", "dy", "tag"))
    found: list[int] = []
    for options in wanted:
        index = next((i for i, name in enumerate(names) if name in options), None)
        if index is None:
            break
        found.append(index)
    if len(found) < 2:
        return None
    rows = list(zip(*(head[i] for i in found), strict=True))
    texts = ["-".join(_whole(cell) for cell in row) for row in rows]
    if not texts or any(moment(text, "iso") is None for text in texts):
        return None
    joined = " and ".join(shown(columns[i].header) for i in found)
    return TimeChoice(tuple(found), Format("iso"), "-", (f"times are made of columns {joined}",))


def _whole(cell: Any) -> str:
    number = _float(cell)
    return str(int(number)) if number is not None and number.is_integer() else str(cell).strip()


def joined_cells(columns: Sequence[Any], joint: str) -> list[Any]:
    """Return the cells of several columns as one text a row; missing where any is."""
    lists = [as_list(cells) for cells in columns]
    return [
        None
        if any(is_missing(cell) for cell in row)
        else joint.join(_whole(cell) if joint == "-" else str(cell).strip() for cell in row)
        for row in zip(*lists, strict=True)
    ]


def choose_value(
    table: Table, head: Sequence[list[Any]], wish: str | None, times: tuple[int, ...]
) -> ValueChoice:
    """Choose the column of values.

    The one asked for; else the only one of numbers; else, of a table of prices, the adjusted
    close or the close, with a note.

    Raises
    ------
    InputError
        No such column, none of numbers, or several: the line names them.
    """
    columns = table.columns
    if wish is not None:
        index = column_named(columns, wish)
        if index is None:
            raise InputError(
                f"no column {shown(wish)} for the values; columns are {listed(columns)}"
            )
        return ValueChoice(index)
    numeric = [
        i
        for i in range(len(columns))
        if i not in times and looks_numeric(head[i]) and not _is_time_too(columns[i], head[i])
    ]
    if not numeric:
        raise InputError(
            f"no column of numbers besides the times; columns are {listed(columns)}: name the "
            "values with value (--value)"
        )
    offered = [columns[i] for i in numeric]
    price = prices.preferred(offered)
    if price is not None and len(numeric) > 1:
        adjusted = prices.is_adjusted(offered[price])
        why = "the close adjusted for splits and dividends" if adjusted else "the last price"
        return ValueChoice(
            numeric[price],
            f"the value is column {shown(offered[price].header)}, {why} in a table of "
            f"prices; others can be named: {listed(offered)}",
        )
    series = [
        i
        for i in numeric
        if not _is_counter(columns[i], head[i]) and not _is_constant(head[i], zero=False)
    ] or numeric
    if len(series) == 1:
        left = [columns[i] for i in numeric if i not in series]
        note = f"left out, as row counts or one number throughout: {listed(left)}"
        return ValueChoice(series[0], note if left else "")
    offered = [columns[i] for i in series]
    raise InputError(
        f"which column is the value? {len(series)} hold numbers: {listed(offered)}; name one "
        f"with value (--value), such as {shown(offered[0].header)}"
    )


def _is_constant(cells: list[Any], zero: bool = True) -> bool:
    """Return whether three or more cells are all the same: a station's number, a table's date."""
    known = [cell for cell in cells if not is_missing(cell)]
    if len(known) < 3 or any(cell != known[0] for cell in known):
        return False
    return zero or _float(known[0]) != 0.0


def _is_time_too(column: Column, cells: list[Any]) -> bool:
    """A second column of times isn't a value: `date` beside `unix`."""
    form = detected_format(column, cells)
    name = column.plain
    named = name in _DATE_NAMES[1:8] or any(word in name for word in _DATE_WORDS)
    return form is not None and form.calendar and named and name != ""


def _is_counter(column: Column, cells: list[Any]) -> bool:
    """Return whether a column counts rows."""
    if column.plain not in _COUNTER_NAMES:
        return False
    known = [_float(cell) for cell in cells]
    return all(
        a is not None and b is not None and b - a == 1.0 for a, b in itertools.pairwise(known)
    )
