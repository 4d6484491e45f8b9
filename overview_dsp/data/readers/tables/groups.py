"""Tables with several series, distinguished by columns such as `country`, `station` or `subject`.

A column distinguishes series if the times repeat and its texts tell their rows apart, if the times
start again where its text changes, or if it is called so (`groups` in column_names.toml). Such a
table is read after `select_group`: `country=Norway`, `country=Norway, sex=f`, a text that is in one
column only, or `country=*` for all rows as one series, if their times differ.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from overview_dsp.arrays import FloatArray, IntArray
from overview_dsp.data.readers.data_file import LoadOptions
from overview_dsp.data.readers.tables.cells import looks_numeric
from overview_dsp.data.readers.tables.column_names import NAMES
from overview_dsp.data.readers.tables.column_roles import TimeChoice, is_code
from overview_dsp.data.readers.tables.table import (
    Cells,
    Chunk,
    Column,
    Columns,
    Table,
    as_list,
    cell_locator,
    column_named,
    first_rows,
    listed,
)
from overview_dsp.data.readers.tables.time_column import TimeColumn, detected_format
from overview_dsp.errors import InputError, quoted, warn

MAX_GROUPS = 5_000
"""Maximum number of series that a column may distinguish."""

MAX_ROWS = 2_000_000
"""Number of rows examined to find the column."""

MANY_REPEATS = 0.02
"""Minimum share of repeated times at which any column may distinguish series."""

ALL = "*"
"""Text that selects all rows as one series."""

_HEAD_ROWS = 200
_SHOWN = 6
_MOST_KEYS = 3

Codes = IntArray


class OneGroup(Table):
    """Rows of a table in which columns have given texts, by index; None stands for any text."""

    def __init__(self, table: Table, texts: Mapping[int, str | None]) -> None:
        self._table, self.texts = table, texts
        self.kind, self.row_word, self.sheet = table.kind, table.row_word, table.sheet
        self.columns: tuple[Column, ...] = table.columns
        self._only = {i: text for i, text in texts.items() if text is not None}
        named = [f"{quoted(self.columns[i].header)} is {quoted(t)}" for i, t in self._only.items()]
        note = f"the rows whose column {' and '.join(named)}" if named else "all rows as one series"
        self.notes = (*table.notes, note)

    def chunks(self, columns: Sequence[int]) -> Iterator[Chunk]:
        """Read these columns of the group's rows."""
        for chunk in self._table.chunks((*columns, *self._only)):
            kept = np.ones(len(chunk), np.bool_)
            keys = chunk.cells[len(columns) :]
            for text, cells in zip(self._only.values(), map(as_list, keys), strict=True):
                same = {cell for cell in dict.fromkeys(cells) if _text(cell) == text}
                kept &= np.fromiter((cell in same for cell in cells), np.bool_, len(cells))
            indices = np.flatnonzero(kept).tolist()
            if indices:
                numbers = [chunk.number(i) for i in indices]
                selected: tuple[Cells, ...] = tuple(
                    cells[indices] if isinstance(cells, np.ndarray) else [cells[i] for i in indices]
                    for cells in chunk.cells[: len(columns)]
                )
                yield Chunk(selected, numbers[0], numbers, chunk.part)


def _text(cell: Any) -> str:
    if isinstance(cell, float) and cell.is_integer():
        cell = int(cell)
    return str(cell).strip()


def selected_group(table: Table, options: LoadOptions) -> OneGroup | None:
    """Return the rows that the options `group` or `match` select; None without them."""
    if options.group is not None:
        return OneGroup(table, options.group)
    return None if options.match is None else select_group(table, options.match)


def select_group(table: Table, option: str) -> OneGroup:
    """Return the rows selected by `COLUMN=TEXT`, several of them, or a text in only one column.

    InputError: no row matches, or several columns contain the text.
    """
    texts: dict[int, str | None] = {}
    end_of_option = (len(option) + 1, 0, 0)
    for (_, begin, index), (end, *_) in pairwise([*_parts(table.columns, option), end_of_option]):
        texts |= _found(table, option, [index], option[begin : end - 1].strip())
    return OneGroup(
        table, texts or _found(table, option, range(len(table.columns)), option.strip())
    )


def _parts(columns: Columns, option: str) -> Iterator[tuple[int, int, int]]:
    """Yield where each `COLUMN=` begins and ends in an option, and the column.

    Names and texts may contain commas: a name is the longest text before `=` that is one.
    """
    begin = 0
    for equals in (i for i, letter in enumerate(option) if letter == "="):
        commas = (i + 1 for i in range(begin, equals) if option[i] == ",")
        for start in (*((0,) if begin == 0 else ()), *commas):
            index = column_named(columns, option[start:equals])
            if index is not None:
                yield start, equals + 1, index
                begin = equals + 1
                break


def _found(
    table: Table, option: str, columns: Sequence[int], text: str
) -> Mapping[int, str | None]:
    """Return the column that contains a text, and the text as it is written there."""
    if text == ALL:
        return dict.fromkeys(columns)
    found: dict[int, str | None] = {}
    examples: dict[str, None] = {}
    for chunk in table.chunks(columns):
        for i, cells in zip(columns, chunk.cells, strict=True):
            if isinstance(cells, np.ndarray) and cells.dtype.kind == "f" and len(columns) > 1:
                continue
            for one in dict.fromkeys(map(_text, dict.fromkeys(as_list(cells)))):
                if len(columns) == 1 and len(examples) < 8 and one:
                    examples[one] = None
                if one == text or (one.lower() == text.lower() and i not in found):
                    found[i] = one
    if len(found) > 1:
        raise InputError(
            f"match {quoted(option)}: columns {listed([table.columns[i] for i in found])} contain "
            f"this text; give match (--select) as 'COLUMN={text}'"
        )
    if not found:
        there = f"; texts are {', '.join(examples)}" if examples else ""
        if len(table.sheets) > 1 and not table.sheet:
            there += f"; sheets are {', '.join(map(quoted, table.sheets[:_SHOWN]))}"
        raise InputError(f"match {quoted(option)}: no row contains this text{there}")
    return found


def groups_of(table: Table, group: str) -> dict[str, dict[int, str]]:
    """Return the series of a column (or of several: `country, sex`), and their texts by column.

    Rows without a text in a column belong to no series; a warning counts them.

    InputError: there is no such column, or it has too many texts.
    """
    whole = column_named(table.columns, group)
    names = group.split(",") if whole is None else [group]
    columns = [column_named(table.columns, name) for name in names]
    if None in columns:
        raise InputError(f"group {quoted(group)}: no such column; columns are "
                         f"{listed(table.columns)}")  # fmt: skip
    found = [i for i in columns if i is not None]
    rows: Counter[tuple[Any, ...]] = Counter()
    for chunk in table.chunks(found):
        rows.update(zip(*map(as_list, chunk.cells), strict=True))
        if len(rows) > MAX_GROUPS:
            raise InputError(f"group {quoted(group)}: more than {MAX_GROUPS} series")
    known: dict[str, dict[int, str]] = {}
    missing = 0
    for row, count in rows.items():
        # "m", which stands for a missing number, is a text here
        texts = ["" if cell is None or cell != cell else _text(cell) for cell in row]
        if all(texts):
            known.setdefault(", ".join(texts), dict(zip(found, texts, strict=True)))
        else:
            missing += count
    if missing:
        headers = listed([table.columns[i] for i in found])
        warn(f"{missing} rows have no text in {headers}; they are left out", 3)
    return known


def require_single_series(
    table: Table, time: TimeChoice, used: Sequence[int], numbers: bool = False, events: bool = False
) -> None:
    """Raise InputError if columns distinguish several series; the message lists them.

    `table`, `time`: the table, and its times.
    `used`: columns of values, which distinguish no series.
    `numbers`: whether columns of numbers may distinguish series, too.
    `events`: whether rows are events, which may have one time: only times that start again count,
    in a column that is called so.
    """
    texts_of = table.texts if isinstance(table, OneGroup) else {}
    selected = {i: text for i, text in texts_of.items() if text is not None}
    head = first_rows(table, _HEAD_ROWS)
    others = [
        i
        for i, column in enumerate(table.columns)
        if i not in (*time.columns, *used, *selected)
        and column.plain not in NAMES["utc_offsets"]
        and (is_group(column, head[i]) or (not events and (numbers or _is_wordy(column, head[i]))))
    ]
    if not others:
        return
    seconds, codes, names = _coded(table, time, others)
    rows = len(seconds)
    candidates = {i: code for i, code in codes.items() if 1 < len(names[i]) <= max(2, rows // 2)}
    named = [i for i in candidates if is_group(table.columns[i], head[i])]
    keys = [] if events else _keys(seconds, candidates, named, numbers)
    share_times = bool(keys)  # rows of one time can't be one series
    if not keys and None not in texts_of.values():
        keys = _restarts(seconds, candidates)
        if not keys and not events:
            keys = named[:1]
    if not keys:
        return
    combined = list(dict.fromkeys(zip(*(codes[i].tolist() for i in keys), strict=True)))
    texts = [[names[i][code] for i, code in zip(keys, row, strict=True)] for row in combined]
    examples = ", ".join(quoted(", ".join(text)) for text in texts[:_SHOWN])
    more = f" and {len(texts) - _SHOWN} more" if len(texts) > _SHOWN else ""
    headers = [table.columns[i].header for i in keys]
    column = f"column{'s' * (len(keys) > 1)} {' and '.join(map(quoted, headers))}"
    first = zip((*selected, *keys), (*selected.values(), *texts[0]), strict=True)
    chosen = ", ".join(f"{table.columns[i].header}={text}" for i, text in first)
    joined = "" if share_times else f", or {quoted(headers[0] + '=*')} for all rows as one series"
    several = f", or convert each with --group {quoted(', '.join(headers))} (ov.load_timelines)"
    if table.sheet:  # the sheet is selected, too
        chosen, joined, several = f"{table.sheet}, {chosen}", "", ""
    raise InputError(
        f"{column} distinguish{'es' * (len(keys) == 1)} {len(texts)} series ({examples}{more}); "
        f"choose one with match (--select {quoted(chosen)}{joined}){several}"
    )


def is_group(column: Column, cells: Sequence[Any]) -> bool:
    """Return whether a column is called like one that distinguishes series, without readings."""
    return column.key or is_code(column, cells)


def _is_wordy(column: Column, cells: Sequence[Any]) -> bool:
    return not looks_numeric(cells) and detected_format(column, cells) is None


def _coded(
    table: Table, time: TimeChoice, columns: Sequence[int]
) -> tuple[FloatArray, dict[int, Codes], dict[int, list[str]]]:
    """Return the times of the first rows, and the columns as numbers of their texts."""
    times = TimeColumn(time.format)
    parts: dict[int, list[Codes]] = {i: [] for i in columns}
    names: dict[int, dict[str, int]] = {i: {} for i in columns}
    seconds: list[FloatArray] = []
    rows = 0
    for chunk in table.chunks((*time.columns, *columns)):
        at = np.arange(rows, rows + len(chunk), dtype=np.float64)
        if time.columns:
            at = times.seconds(time.cells(chunk), cell_locator(table, chunk, time.columns[0]))
        known = ~np.isnan(at)
        seconds.append(at[known])
        for i, cells in zip(columns, chunk.cells[len(time.columns) :], strict=True):
            if i not in parts:
                continue
            found = as_list(cells)
            code = {c: names[i].setdefault(_text(c), len(names[i])) for c in dict.fromkeys(found)}
            parts[i].append(np.fromiter(map(code.__getitem__, found), np.int64, len(found))[known])
            if len(names[i]) > MAX_GROUPS:
                del parts[i]
        rows += len(chunk)
        if rows > MAX_ROWS or not parts:
            break
    codes = {i: np.concatenate(part) for i, part in parts.items()}
    return np.concatenate(seconds or [np.empty(0)]), codes, {i: list(names[i]) for i in codes}


def _keys(
    seconds: FloatArray, codes: dict[int, Codes], named: Sequence[int], exact: bool
) -> list[int]:
    """Return the columns that tell rows of equal times apart; with `exact`, all such rows.

    `named` are those that are called like groups.
    """
    rows, moments = len(seconds), _numbered(seconds)
    distinct = _count(moments)
    repeats = rows - distinct
    keys: list[int] = []
    best = 0  # number of repeated times whose rows the keys tell apart
    while best < repeats and len(keys) < _MOST_KEYS:
        others = [i for i in codes if i not in keys]
        told = {i: _count(moments, *(codes[k] for k in (*keys, i))) - distinct for i in others}
        # of columns that tell as much, one that is called so, then the first
        i = max(told, key=lambda i: (told[i], i in named, -i), default=-1)
        if told.get(i, 0) <= best:
            break
        keys, best = [*keys, i], told[i]
    enough = best == repeats if exact else 2 * best >= repeats
    if enough and (not set(named).isdisjoint(keys) or repeats > MANY_REPEATS * rows):
        return sorted(keys)
    return []


def _restarts(seconds: FloatArray, codes: dict[int, Codes]) -> list[int]:
    """Return the column at whose changes, and nowhere else, the times start again."""
    step = np.sign(np.diff(seconds))
    wrong = step != (1.0 if np.count_nonzero(step > 0.0) * 2 >= len(step) else -1.0)
    for i, code in codes.items():
        change = np.diff(code) != 0
        runs = np.count_nonzero(change) + 1
        if runs == len(np.unique(code)) and wrong.any() and not wrong[~change].any():
            return [i]
    return []


def _numbered(*arrays: NDArray[Any]) -> Codes:
    """Return a number for each distinct row of arrays, from 0."""
    found = np.zeros(len(arrays[0]), np.int64)
    for array in arrays:
        _, inverse = np.unique(array, return_inverse=True)
        _, found = np.unique(
            found * (int(inverse.max(initial=0)) + 1) + inverse, return_inverse=True
        )
    return found


def _count(*arrays: NDArray[Any]) -> int:
    return int(_numbered(*arrays).max(initial=-1)) + 1
