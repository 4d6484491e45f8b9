"""Roles of the columns of a table: times, values, prices, kinds and labels.

Roles are requested by options, or detected from names and first cells.

A table of prices has a close, and an open, high or low; it may have volume and an adjusted close.
"""

from __future__ import annotations

import contextlib
import itertools
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

from overview_dsp.data.readers.data_file import LoadOptions
from overview_dsp.data.readers.tables.cells import is_missing, looks_numeric
from overview_dsp.data.readers.tables.column_names import NAMES, UNIT_SUFFIX
from overview_dsp.data.readers.tables.table import (
    Cells,
    Chunk,
    Column,
    Columns,
    Head,
    Table,
    as_list,
    column_named,
    listed,
)
from overview_dsp.data.readers.tables.time_column import (
    CLOCKS,
    Format,
    detected_format,
    requested_format,
)
from overview_dsp.data.timeline.time_parsing import match_minute, moment
from overview_dsp.errors import InputError, quoted

_DAYS = ("iso", "dmy", "mdy", "dmy or mdy", "month names")
_PRICE_OF = re.compile(r"Close [A-Z0-9.^=-]{1,12}")
"""Price of one of several shares."""
_OFFSET = re.compile(r"[+\-−]\d{2}:?\d{2}|Z|UTC", re.ASCII)


# --- columns of a series


@dataclass(frozen=True)
class TimeChoice:
    """Columns whose joined cells are the times, and the format of the times.

    Several columns are joined by `joint`: a date and a clock by a blank, year, month, day, hour and
    minute by hyphens. `unmarked` clocks are numbers: HHMM (100), or hours (1). Without columns,
    rows are evenly spaced (`rate`).
    """

    columns: tuple[int, ...]
    format: Format
    joint: str = ""
    notes: tuple[str, ...] = ()
    unmarked: int = 0

    def cells(self, chunk: Chunk) -> Cells:
        """Return the times in the first columns of a chunk; None if a part is missing."""
        if len(self.columns) == 1:
            return chunk.cells[0]
        lists = list(map(as_list, chunk.cells[: len(self.columns)]))
        if self.joint == "-":
            rows = zip(*lists, strict=True)
            return [None if any(map(is_missing, row)) else _date_of(row) for row in rows]
        if self.unmarked:
            dates, clocks, *others = lists
            lists = [list(map(_whole, dates)), [_marked(c, self.unmarked) for c in clocks], *others]
        return [
            None if any(map(is_missing, row)) else self.joint.join(map(_stripped, row))
            for row in zip(*lists, strict=True)
        ]


def choose_time(
    table: Table, head: Head, requested: str | None, rated: bool, value: str | None = None
) -> TimeChoice:
    """Choose the time column.

    `table`: the table.
    `head`: its first rows, one list per column.
    `requested`: `COLUMN`, `COLUMN:FORMAT` or `:FORMAT`.
    `rated`: whether rows are evenly spaced at a requested rate.
    `value`: requested column of values. It does not contain clocks.

    InputError: no such column, or no column of times; the message lists the columns.
    """
    columns = table.columns
    name, written = requested_format(requested, columns)
    if name is not None:
        index = _require_column(columns, name, "times")
        form = _form_of(columns[index], head[index], written, True)
        return TimeChoice((index,), form, notes=_form_notes(form))
    if rated:
        return TimeChoice((), Format("s"))
    found = _best(columns, head)
    if found is None:
        if (parts := _year_month_day(columns, head)) is not None:
            return parts
        raise InputError(
            f"no column looks like times; columns are {listed(columns)}: name one with time "
            "(--time-column COLUMN:FORMAT; row numbers are not times), or give the "
            "samples per second of evenly spaced rows with rate (--read rate=HZ)"
        )
    index, form = found
    if written:
        form = Format(written)
    values = None if value is None else column_named(columns, value)
    clock, unmarked = _clock_column(columns, head, index, form, values)
    offsets = [  # from UTC, which make the hour of a clock change unique
        i
        for i, column in enumerate(columns)
        if i != index and column.plain in NAMES["utc_offsets"] and form.name in _DAYS
        if _all(head[i], _OFFSET.fullmatch)
    ]
    beside = tuple(i for i in (clock, *offsets[:1]) if i is not None)
    notes = _form_notes(form)
    if beside:
        if unmarked and clock is not None:
            notes = (*notes, clock_note(columns, index, clock))
        return TimeChoice((index, *beside), form, " ", notes, unmarked)
    if form.name == "year" and (parts := _year_month_day(columns, head)) is not None:
        return parts
    if columns[index].plain not in NAMES["series_times"]:
        notes = (*notes, f"times are taken from column {quoted(columns[index].header)}")
    return TimeChoice((index,), form, "", notes)


def _require_column(columns: Columns, name: str, what: str) -> int:
    """Return the index of a named column; InputError lists the columns."""
    index = column_named(columns, name)
    if index is None:
        raise InputError(f"no column {quoted(name)} for the {what}; columns are {listed(columns)}")
    return index


def _form_of(column: Column, cells: Sequence[Any], written: str, is_requested: bool) -> Format:
    """Return the format of a column's times; requested columns of numbers are seconds."""
    if written:
        return Format(written)
    form = detected_format(column, cells)
    header = quoted(column.header)
    if form is None and is_requested and looks_numeric(cells):
        form = Format("s", f"the numbers of column {header} are read as seconds")
    if form is None:
        first = next((cell for cell in cells if not is_missing(cell)), None)
        remedy = (
            "name another column, or say how times are written with time (--time-column "
            "COLUMN:FORMAT)"
        )
        if first is not None and match_minute(str(first)) is not None:
            remedy = (
                "minutes of a football match need goals, cards or fouls beside them; write 47 for "
                "45+2 in other lists"
            )
        raise InputError(
            f"column {header} holds {quoted(first) if first is not None else 'no values'}, which "
            f"isn't a time in any known way; {remedy}"
        )
    return form


def _form_notes(form: Format) -> tuple[str, ...]:
    return (form.note,) if form.note else ()


def _best(columns: Columns, head: Head) -> tuple[int, Format] | None:
    """Return the column of dates (a named one first), or a named one, or the first if it rises."""
    ranked: list[tuple[int, int, Format]] = []
    for i, (column, cells) in enumerate(zip(columns, head, strict=True)):
        form = detected_format(column, cells)
        if form is None:
            continue
        fixed = form.name != "year" and _is_constant(cells)  # a station's number, a table's date
        if fixed and _clock_column(columns, head, i, form)[0] is None:
            continue
        name = column.plain
        named = _is_named(name, NAMES["series_times"])
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
        elif named and name not in NAMES["row_counters"]:
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


def _rising(cells: Sequence[Any]) -> bool:
    values = [_float(cell) for cell in cells]
    known = [value for value in values if value is not None]
    return len(known) == len(cells) and all(b > a for a, b in itertools.pairwise(known))


def _float(cell: Any) -> float | None:
    try:
        return float(cell)
    except (TypeError, ValueError, OverflowError):
        return None


def _clock_column(
    columns: Columns, head: Head, date: int, form: Format, value: int | None = None
) -> tuple[int | None, int]:
    """Return the column of clocks that belongs to a column of days, and its `unmarked`."""
    days = [_whole(cell) for cell in head[date] if not is_missing(cell)]
    if form.name not in _DAYS or not days or any(":" in text for text in days):
        return None, 0
    others = [(i, column) for i, column in enumerate(columns) if i not in (date, value)]
    for i, column in others:
        named = any(word in column.plain for word in NAMES["clock_parts"])
        if named and _all(head[i], _is_day_clock):
            return i, 0
    for i, column in others:
        if unmarked := _unmarked_clock(column, head[i], days):
            return i, unmarked
    return None, 0


def _unmarked_clock(column: Column, cells: Sequence[Any], days: list[str]) -> int:
    """Return 100 for a column of clocks HHMM without marks, 1 for hours of days, 0 for others."""
    texts = [_whole(cell) for cell in cells if not is_missing(cell)]
    if column.plain not in NAMES["clocks_without_marks"] or len(texts) != len(days):
        return 0
    is_hour = column.plain in NAMES["hours"] and all(len(text) < 3 for text in texts)
    factor = 1 if is_hour else 100
    if not all(t.isdigit() and len(t) <= 4 and _is_day_clock(_marked(t, factor)) for t in texts):
        return 0
    formats = [name for name in _DAYS if "or" not in name]
    whole_days = all(any(moment(f"{day} 00:00", name) for name in formats) for day in days)
    # a number beside each day may be a duration: hours of a day come in several rows
    has_clocks = len(set(days)) < len(days) if is_hour else any(int(text) >= 100 for text in texts)
    return factor if whole_days and has_clocks else 0


def clock_note(columns: Columns, date: int, clock: int) -> str:
    """Return the note about a column of clocks without marks."""
    names = " and ".join(quoted(columns[i].header) for i in (date, clock))
    return f"times are made of columns {names}"


def _marked(cell: Any, factor: int) -> str:
    """Return a clock such as 1230 (factor 100) or 12 (factor 1) as `12:30` or `12:00`."""
    text = _whole(cell)
    if is_missing(cell) or not text.isdigit():
        return text
    hours, minutes = divmod(int(text) * 100 // factor, 100)
    return f"{hours:02}:{minutes:02}"


def _all(cells: Sequence[Any], fits: Callable[[str], object]) -> bool:
    texts = [cell.strip() for cell in cells if isinstance(cell, str) and not is_missing(cell)]
    return bool(texts) and all(map(fits, texts))


def _is_day_clock(text: str) -> bool:
    return moment(f"2000-01-01 {text}", "iso") is not None


def _year_month_day(columns: Columns, head: Head) -> TimeChoice | None:
    """Return the columns `year`, `month` and, if there are any, smaller parts as one time."""
    names = [column.plain for column in columns]
    wanted = (("year", "yr", "jahr"), ("month", "mo", "mon", "monat"), ("day", "dy", "tag"),
              NAMES["hours"], ("minute", "min", "mn"))  # fmt: skip
    found: list[int] = []
    for options in wanted:
        index = next((i for i, name in enumerate(names) if name in options), None)
        if index is None:
            break
        found.append(index)
    if len(found) < 2:
        return None
    rows = list(zip(*(head[i] for i in found), strict=True))
    texts = [_date_of(row) for row in rows]
    if not texts or any(moment(text, "iso") is None for text in texts):
        return None
    joined = " and ".join(quoted(columns[i].header) for i in found)
    return TimeChoice(tuple(found), Format("iso"), "-", (f"times are made of columns {joined}",))


def _date_of(parts: Sequence[Any]) -> str:
    """Return year, month, day, hour and minute, as far as they are given, as a date."""
    texts = [*map(_whole, parts)]
    clock = ":".join(f"{text:0>2}" for text in [*texts[3:], "00"][:2])
    return "-".join(texts[:3]) + (f" {clock}" if len(texts) > 3 else "")


def _whole(cell: Any) -> str:
    number = _float(cell)
    return str(int(number)) if number is not None and number.is_integer() else _stripped(cell)


def _stripped(cell: Any) -> str:
    return str(cell).strip()


def is_code(column: Column, cells: Sequence[Any]) -> bool:
    """Return whether a column is called like a group, with texts or whole numbers that repeat."""
    known = [cell for cell in cells if not is_missing(cell)]
    numbers = [_float(cell) for cell in known]
    readings = all(n is not None for n in numbers) and (
        len(set(numbers)) == len(numbers) or any(n != n // 1 for n in numbers if n is not None)
    )
    return column.plain in NAMES["groups"] and not (known and readings)


def choose_value(
    table: Table, head: Head, requested: str | None, times: tuple[int, ...]
) -> tuple[int, str]:
    """Return the index of the column of values and a note on the choice.

    This is the requested column, else the only column of numbers, else the adjusted close or the
    close in a table of prices.

    InputError: no such column, no column of numbers, or several; the message lists them.
    """
    columns = table.columns
    if requested is not None:
        return _require_column(columns, requested, "values"), ""
    numeric = [
        i
        for i in range(len(columns))
        if i not in times
        and not columns[i].key
        and looks_numeric(head[i])
        and not _is_time_too(columns[i], head[i])
    ]
    numeric = [i for i in numeric if not is_code(columns[i], head[i])] or numeric
    if not numeric:
        raise InputError(
            f"no column of numbers besides the times; columns are {listed(columns)}: for events, "
            "call the column of their texts event; for a series, name its values with value "
            "(--value-column)"
        )
    offered = [columns[i] for i in numeric]
    price = preferred_price(offered)
    if price is not None and len(numeric) > 1:
        adjusted = is_adjusted(offered[price])
        why = "the close adjusted for splits and dividends" if adjusted else "the last price"
        return (
            numeric[price],
            f"the value is column {quoted(offered[price].header)}, {why} in a table of "
            f"prices; others can be named: {listed(offered)}",
        )
    series = [
        i
        for i in numeric
        if not _is_counter(columns[i], head[i]) and not _is_constant(head[i], zero=False)
    ] or numeric
    if len(series) == 1:
        left = [columns[i] for i in numeric if i not in series]
        note = f"left out, as row numbers or constants: {listed(left)}"
        return series[0], note if left else ""
    offered = [columns[i] for i in series]
    raise InputError(
        f"which column is the value? {len(series)} hold numbers: {listed(offered)}; name one "
        f"with value (--value-column), such as {quoted(offered[0].header)}"
    )


def _is_constant(cells: Sequence[Any], zero: bool = True) -> bool:
    """Return whether three or more cells are equal; `zero` allows 0."""
    known = [cell for cell in cells if not is_missing(cell)]
    if len(known) < 3 or any(cell != known[0] for cell in known):
        return False
    return zero or _float(known[0]) != 0.0


def _is_time_too(column: Column, cells: Sequence[Any]) -> bool:
    """Return whether a column has times too, and so no values: `date` in addition to `unix`."""
    form = detected_format(column, cells)
    named = _is_named(column.plain, NAMES["series_times"][1:8])
    return form is not None and form.calendar and named and column.plain != ""


def _is_named(name: str, names: Sequence[str]) -> bool:
    """Return whether a column is called one of `names`, or by a part of a name of times."""
    return name in names or any(word in name for word in NAMES["series_time_parts"])


def _is_counter(column: Column, cells: Sequence[Any]) -> bool:
    """Return whether a column counts rows."""
    if column.plain not in NAMES["row_counters"]:
        return False
    known = [_float(cell) for cell in cells]
    return all(
        a is not None and b is not None and b - a == 1.0 for a, b in itertools.pairwise(known)
    )


# --- columns of prices


def _key(column: Column) -> str:
    # Alpha Vantage numbers its columns: "5. adjusted close"
    return re.sub(r"^\d+", "", column.plain)


def is_adjusted(column: Column) -> bool:
    """Return whether a column is a price adjusted for splits (and mostly dividends)."""
    name = _key(column)
    return name in ("adj", "adjusted") or ("adj" in name and ("clos" in name or "pric" in name))


def is_price(column: Column, columns: Columns) -> bool:
    """Return whether a column is named like a price; a high or low requires a close."""
    name = _key(column)
    prices = NAMES["close"] + NAMES["open"] + NAMES["high_low"]
    if is_price_table(columns) and name in prices:
        return True
    return (
        is_adjusted(column)
        or _PRICE_OF.fullmatch(column.name) is not None
        or name in NAMES["prices_alone"]
        or name.endswith(("price", "close", "quote"))
        or name.startswith("price")
    )


def is_close(column: Column) -> bool:
    """Return whether a column is named like a closing price of an exchange."""
    name = _key(column)
    return is_adjusted(column) or (name in NAMES["close"] and name not in NAMES["other_prices"])


def _first(columns: Columns, names: Sequence[str]) -> int | None:
    return next((i for name in names for i, c in enumerate(columns) if _key(c) == name), None)


def is_price_table(columns: Columns) -> bool:
    """Return whether there is a close and also an open, high or low."""
    return _first(columns, NAMES["close"]) is not None and (
        _first(columns, NAMES["open"]) is not None or _first(columns, NAMES["high_low"]) is not None
    )


def price_columns(columns: Columns) -> dict[str, int]:
    """Return the indices of the columns `adjusted`, `close`, `open` and `volume`, if present."""
    found = {
        "adjusted": next((i for i, column in enumerate(columns) if is_adjusted(column)), None),
        "close": _first(columns, NAMES["close"]),
        "open": _first(columns, NAMES["open"]),
        "volume": _first(columns, NAMES["volume"]),
    }
    return {name: i for name, i in found.items() if i is not None}


def preferred_price(columns: Columns) -> int | None:
    """Return the index of the adjusted close, else of the close; None without prices."""
    if is_price_table(columns):
        found = price_columns(columns)
        return found.get("adjusted", found["close"])
    # a close and its volume alone
    rest = [column for column in columns if _key(column) not in NAMES["volume"]]
    if len(rest) == 1 and len(columns) == 2 and is_price(rest[0], columns):
        return columns.index(rest[0])
    return None


# --- columns of a list of events


@dataclass(frozen=True)
class Roles:
    """Index of the column for each role, None without such a column."""

    time: int
    kind: int | None
    label: int | None
    format: Format
    clock: int | None = None
    unmarked: int = 0
    weight: int | None = None
    end: int | None = None
    length: int | None = None
    id: int | None = None
    side: int | None = None
    notes: tuple[str, ...] = field(default=())


def named(columns: Columns, names: Sequence[str]) -> int | None:
    """Return the index of a column with one of these names, earlier names first."""
    plain = [column.plain for column in columns]
    return next((plain.index(name) for name in names if name in plain), None)


def named_time_column(columns: Columns) -> int | None:
    """Return the index of a column named like times, with or without a unit."""
    found = named(columns, NAMES["event_times"])
    if found is not None:
        return found
    for i, column in enumerate(columns):
        stem = UNIT_SUFFIX.sub("", column.plain)
        if stem in NAMES["event_times"] and stem != column.plain:
            return i
    return None


def kind_and_label_columns(columns: Columns) -> tuple[int | None, int | None]:
    """Return the indices of the columns of kinds and of labels."""
    return named(columns, NAMES["event_kinds"]), named(columns, NAMES["event_labels"])


def is_wordy(cells: Sequence[Any]) -> bool:
    """Return whether cells are texts other than numbers."""
    known = [cell for cell in cells if not is_missing(cell)]
    return not looks_numeric(known) and any(isinstance(c, str) for c in known)


def is_event_table(columns: Columns, head: Head, options: LoadOptions) -> bool:
    """Return whether a table lists events: it has times and texts, and no series of numbers.

    A requested column of kinds or labels makes any table a list of events.
    """
    if len(columns) < 2:
        return False
    if options.kind is not None or options.label is not None:
        return True
    time = _time_column(columns, options.time)
    kind, label = kind_and_label_columns(columns)
    if time is None or (kind is None and label is None):
        return False
    words = [i for i in (kind, label) if i is not None and i != time]
    if not any(is_wordy(head[i]) for i in words):
        return False
    roles = ("event_extras", "event_times", "event_kinds", "event_labels")
    for i, column in enumerate(columns):
        if i in (time, *words) or any(column.plain in NAMES[role] for role in roles):
            continue
        numeric = [cell for cell in head[i] if not is_missing(cell)]
        named = UNIT_SUFFIX.search(column.plain)
        if looks_numeric(numeric) and not (named and detected_format(column, numeric)):
            return False  # a quantity: a series with additional texts
    return True


def _time_column(columns: Columns, requested: str | None) -> int | None:
    """Return the requested column of times, else a column named like times."""
    if requested is not None:
        with contextlib.suppress(InputError):  # raised again when the table is read
            name, _ = requested_format(requested, columns)
            if name is not None:
                return column_named(columns, name)
    return named_time_column(columns)


def roles_of(columns: Columns, head: Head, options: LoadOptions) -> Roles:
    """Assign roles to the columns of an event table.

    `columns`, `head`: columns of the table, and its first rows, one list per column.
    `options`: `time` (`COLUMN`, `COLUMN:FORMAT` or `:FORMAT`), `kind` and `label`.

    InputError: no such column, or cells that are not times.
    """
    name, written = requested_format(options.time, columns)
    if name is not None:
        time = _require_column(columns, name, "times")
    else:
        found = _best_time(columns, head)
        if found is None:
            raise InputError(
                f"no column is called time, date, start or minute; columns are {listed(columns)}: "
                "name one with time (--time-column)"
            )
        time = found
    form = _form_of(columns[time], head[time], written, name is not None)
    kind, label = kind_and_label_columns(columns)
    if options.kind is not None:
        kind = _require_column(columns, options.kind, "kinds")
        label = None if label == kind else label
    if options.label is not None:
        label = _require_column(columns, options.label, "labels")
        kind = None if kind == label and options.kind is None else kind
    if kind is None and label is None:
        raise InputError(
            "no column of kinds or labels (event, what, kind, type, name); columns are "
            f"{listed(columns)}: name one with kind or label (--read kind=COLUMN, label=COLUMN)"
        )
    return Roles(
        time,
        kind,
        label,
        form,
        *_clock_column(columns, head, time, form),
        named(columns, NAMES["event_weights"]),
        named(columns, NAMES["event_ends"]),
        named(columns, NAMES["event_lengths"]),
        named(columns, NAMES["event_ids"]),
        named(columns, ["side"]),
        _form_notes(form),
    )


def _best_time(columns: Columns, head: Head) -> int | None:
    """Return the index of a column named like times, dates before clocks."""
    for i, column in enumerate(columns):
        if column.plain in NAMES["event_times"]:
            form = detected_format(column, head[i])
            if form is not None and form.calendar:
                return i
    return named_time_column(columns)
