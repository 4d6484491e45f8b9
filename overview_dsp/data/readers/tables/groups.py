"""Tables with several series, distinguished by a column such as `symbol` or `station`."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from overview_dsp.data.readers.tables.cells import is_missing
from overview_dsp.data.readers.tables.table import (
    Cells,
    Chunk,
    Column,
    Table,
    as_list,
    column_named,
)
from overview_dsp.errors import InputError, shown

MAX_GROUPS = 5_000
"""Maximum number of series that a column may distinguish."""

MAX_ROWS = 2_000_000
"""Number of rows examined to find the column."""


class OneGroup(Table):
    """Rows of a table in which a column has a given text."""

    def __init__(self, table: Table, column: int, text: str) -> None:
        self._table, self._column, self._text_of_group = table, column, text
        self.kind, self.row_word = table.kind, table.row_word
        self.columns: tuple[Column, ...] = table.columns
        header = shown(table.columns[column].header)
        self.notes = (*table.notes, f"the rows whose column {header} is {shown(text)}")

    def chunks(self, columns: Sequence[int]) -> Iterator[Chunk]:
        """Read these columns of the group's rows."""
        for chunk in self._table.chunks((*columns, self._column)):
            names = as_list(chunk.cells[-1])
            kept = [i for i, name in enumerate(names) if _text(name) == self._text_of_group]
            if not kept:
                continue
            numbers = [chunk.number(i) for i in kept]
            cells = tuple(_select(cells, kept) for cells in chunk.cells[:-1])
            yield Chunk(cells, numbers[0], numbers, chunk.part)


def _select(cells: Cells, indices: list[int]) -> Cells:
    return cells[indices] if isinstance(cells, np.ndarray) else [cells[i] for i in indices]


def _text(cell: Any) -> str:
    if isinstance(cell, float) and cell.is_integer():
        cell = int(cell)
    return str(cell).strip()


def select_group(table: Table, option: str) -> OneGroup:
    """Return the rows selected by `COLUMN=TEXT`, or by a text in only one column.

    Raises
    ------
    InputError
        No row matches, or several columns contain the text.
    """
    name, equals, text = option.partition("=")
    index = column_named(table.columns, name) if equals else None
    if index is not None:
        wanted, candidates = text.strip(), [index]
    else:
        wanted, candidates = option.strip(), list(range(len(table.columns)))
    found: dict[int, str] = {}
    examples: dict[str, None] = {}
    for chunk in table.chunks(candidates):
        for i, cells in zip(candidates, chunk.cells, strict=True):
            if isinstance(cells, np.ndarray) and cells.dtype.kind == "f":
                continue
            for text in dict.fromkeys(map(_text, as_list(cells))):
                if len(candidates) == 1 and len(examples) < 8 and not is_missing(text):
                    examples[text] = None
                if text.lower() == wanted.lower():
                    found.setdefault(i, text)
    if len(found) == 1:
        column, exact = next(iter(found.items()))
        return OneGroup(table, column, exact)
    if found:
        names = ", ".join(shown(table.columns[i].header) for i in found)
        raise InputError(
            f"match {shown(option)}: columns {names} contain this text; give match (--select) as "
            f"'COLUMN={wanted}'"
        )
    there = f"; texts are {', '.join(examples)}" if examples else ""
    raise InputError(f"match {shown(option)}: no row contains this text{there}")


def require_single_series(table: Table, times: Sequence[int], value: int) -> None:
    """Raise InputError if a column distinguishes several series with the same times.

    This is called for a table with repeated times.

    Raises
    ------
    InputError
        There is such a column; the message names it and its first texts.
    """
    others = [i for i in range(len(table.columns)) if i not in times and i != value]
    if not others:
        return
    pairs: dict[int, set[tuple[str, ...]]] = {i: set() for i in others}
    names: dict[int, dict[str, None]] = {i: {} for i in others}
    left = dict.fromkeys(others)
    rows = 0
    for chunk in table.chunks((*times, *others)):
        lists = [list(map(_text, as_list(cells))) for cells in chunk.cells]
        rows += len(chunk)
        moments = list(zip(*lists[: len(times)], strict=True))
        for i, texts in zip(others, lists[len(times) :], strict=True):
            if i not in left:
                continue
            names[i].update(dict.fromkeys(texts))
            before = len(pairs[i])
            pairs[i].update((*moment, text) for moment, text in zip(moments, texts, strict=True))
            if len(pairs[i]) - before < len(chunk) or len(names[i]) > MAX_GROUPS:
                del left[i]  # times repeat within a group, or each row is a group
        if rows > MAX_ROWS or not left:
            break
    several = [i for i in left if 1 < len(names[i]) <= max(2, rows // 2)]
    if not several:
        return
    column = min(several, key=lambda i: len(names[i]))
    texts = list(names[column])
    names_shown = ", ".join(shown(text) for text in texts[:6])
    more = f" and {len(texts) - 6} more" if len(texts) > 6 else ""
    header = table.columns[column].header
    raise InputError(
        f"column {shown(header)} distinguishes {len(texts)} series ({names_shown}{more}); choose "
        f"one with match (--select), such as {shown(texts[0])}"
    )
