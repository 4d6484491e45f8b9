"""JSON Lines as a table: one object per line, streamed.

Most files have the same keys in each line. Their values are found in a block at a time, and only
those that are asked for are converted; in other blocks each line is parsed by itself.
"""

from __future__ import annotations

import itertools
import json
import re
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from overview_dsp.arrays import IntArray
from overview_dsp.data.readers.data_file import DataFile
from overview_dsp.data.readers.tables.delimited import Lines, as_text
from overview_dsp.data.readers.tables.dialect import encoding_of
from overview_dsp.data.readers.tables.json import names_in
from overview_dsp.data.readers.tables.table import (
    CellLocation,
    Cells,
    Chunk,
    Column,
    Table,
    require_few_columns,
    single_cells,
)
from overview_dsp.data.readers.tables.text_cells import PAD, TextCells, padded

_SAMPLE = 50
_COLON = re.compile(r"\s*:\s*")
_VALUE = re.compile(r"null|true|false|-?\d[\d.eE+-]*")


class JsonLinesTable(Table):
    """JSON Lines: one object per line; InputError names a broken line."""

    kind = "JSON lines"
    row_word = "line"

    def __init__(self, source: DataFile) -> None:
        self._source = source
        self._lines = Lines(source, encoding_of(source) or "utf-8")
        records = itertools.chain.from_iterable(itertools.starmap(_records, self._blocks()))
        self._names = names_in(record for _, record in itertools.islice(records, _SAMPLE))
        if not self._names:
            raise CellLocation(1).fault("an object without values; give times and values")
        require_few_columns(len(self._names))
        self.columns = tuple(map(Column.of, self._names))

    def chunks(self, columns: Sequence[int]) -> Iterator[Chunk]:
        """Read these columns; InputError names a broken line."""
        names = [self._names[i] for i in columns]
        for first, block in self._blocks():
            cells = cells_of(block, names)
            if cells is not None:
                yield Chunk(cells, first, None, self._lines.part)
            elif records := list(_records(first, block)):
                numbers = [number for number, _ in records]
                found = tuple([record.get(name) for _, record in records] for name in names)
                chunk = Chunk(found, numbers[0], numbers, self._lines.part)
                yield single_cells(self, chunk, columns)

    def _blocks(self) -> Iterator[tuple[int, bytes]]:
        """Yield blocks of lines, with the number of their first line."""
        first = 1
        for block in self._lines.blocks():
            yield first, block
            first += block.count(b"\n")


def sniff(source: DataFile) -> bool:
    """Return whether each line of the file is a JSON object."""
    lines = [line for line in (source.head_text or "").split("\n")[:3] if line.strip()]
    if len(lines) < 2 or not all(line.lstrip().startswith("{") for line in lines):
        return False
    try:
        return isinstance(json.loads(lines[0]), dict)
    except (ValueError, RecursionError):
        return False


def _records(first: int, block: bytes) -> Iterator[tuple[int, dict[str, Any]]]:
    for number, line in enumerate(as_text(block).split("\n"), first):
        if not line.strip():
            continue
        try:
            record = json.loads(line)
        except (ValueError, RecursionError) as error:
            note = f"broken JSON ({error}); each line must be one object"
            raise CellLocation(number).fault(note) from error
        if not isinstance(record, dict):
            raise CellLocation(number).error(record, "isn't an object {...}")
        yield number, record


def cells_of(block: bytes, names: Sequence[str]) -> tuple[Cells, ...] | None:
    """Return the values of these keys, None if lines differ in more than their values.

    `block`: whole lines.
    `names`: keys in all lines.
    """
    if b"\\" in block or not block.isascii():
        return None
    head = as_text(block.partition(b"\n")[0])
    try:
        pairs = json.loads(head, object_pairs_hook=tuple)
    except (ValueError, RecursionError):
        return None
    if not isinstance(pairs, tuple) or not pairs:
        return None
    data = padded(block if block.endswith(b"\n") else block + b"\n")
    ends = np.flatnonzero(data == ord("\n"))
    marks = np.flatnonzero(data == ord('"'))
    places = [i for i, letter in enumerate(head) if letter == '"']
    if len(dict(pairs)) < len(pairs) or len(marks) != len(places) * len(ends):
        return None
    if np.count_nonzero(data[PAD:-PAD] < ord(" ")) > len(ends):
        return None  # control characters are allowed between values only
    # one row per line: the quotes, the line's end
    at = np.column_stack((marks.reshape(-1, len(places)), ends))
    begins = np.concatenate(([PAD], ends[:-1] + 1))
    if (at[:, 0] - begins != places[0]).any() or not _have(data, begins, head[: places[0]]):
        return None
    places.append(len(head))
    found: dict[str, Cells | None] = {}
    quote = 0
    for key, value in pairs:
        is_text = isinstance(value, str)
        colon = _COLON.match(head, places[quote + 1] + 1)
        written = None if is_text or colon is None else _VALUE.match(head, colon.end())
        if colon is None or not (is_text or written):
            return None
        start = at[:, quote] + (colon.end() - places[quote])
        following = quote + (4 if is_text else 2)
        stop_in_head = written.end() if written else places[quote + 3]
        tail = head[stop_in_head : places[following]]
        stop = at[:, following] - len(tail)
        if not (
            _have(data, at[:, quote], head[places[quote] : colon.end()])
            and _have(data, stop, tail)
            and (stop > start).all()
        ):
            return None
        if is_text:
            if (at[:, quote + 2] != start).any() or (at[:, quote + 3] != stop).any():
                return None
            found[key] = TextCells(data, start + 1, stop)
        elif key in names:
            found[key] = _numbers(data, start, stop)
        quote = following
    cells = tuple(cell for name in names if (cell := found.get(name)) is not None)
    return cells if len(cells) == len(names) and quote + 1 == len(places) else None


def _have(data: NDArray[np.uint8], begins: IntArray, text: str) -> bool:
    """Return whether a text stands at all positions."""
    return all((data[begins + i] == byte).all() for i, byte in enumerate(text.encode()))


def _numbers(data: NDArray[np.uint8], starts: IntArray, stops: IntArray) -> Cells | None:
    """Return numbers as integers or floats, null as NaN; None for other values."""
    first = data[starts]
    null = first == ord("n")
    if null.any():
        if not _have(data, starts[null], "null") or (stops - starts != 4)[null].any():
            return None
        stops = np.where(null, starts, stops)
    first = data[starts + (first == ord("-"))]
    second = data[starts + (data[starts] == ord("-")) + 1]
    zeros = (first == ord("0")) & _is_digit(second)
    if not (_is_digit(first) & _is_digit(data[stops - 1]) & ~zeros | null).all():
        return None
    cells = TextCells(data, starts, stops)
    whole, good = cells.wholes()
    if good.all():
        return whole
    found, good = cells.decimals(".")
    return found if good.all() and not (np.abs(found) > 2**53).any() else None


def _is_digit(letters: NDArray[np.uint8]) -> NDArray[np.bool_]:
    return (letters >= ord("0")) & (letters <= ord("9"))
