"""JSON lines as a table: one object a line, streamed."""

from __future__ import annotations

import itertools
import json
from collections.abc import Iterator, Sequence
from typing import Any

from overview_dsp.errors import InputError, shown
from overview_dsp.readers.source import Source
from overview_dsp.readers.tables.delimited import Lines
from overview_dsp.readers.tables.dialect import encoding_of
from overview_dsp.readers.tables.formats.json import is_single
from overview_dsp.readers.tables.table import (
    CHUNK_ROWS,
    MAX_COLUMNS,
    Chunk,
    Column,
    check_single,
)

_SAMPLE = 50


class JsonLinesTable:
    """One JSON object a line."""

    kind = "JSON lines"
    row_word = "line"
    notes: tuple[str, ...] = ()

    def __init__(self, source: Source) -> None:
        self._source = source
        encoding = encoding_of(source) or "utf-8"
        self._lines = Lines(source, encoding)
        sample = itertools.islice(self._records(), _SAMPLE)
        keys = (key for _, record in sample for key, v in record.items() if is_single(v))
        self._names = list(dict.fromkeys(keys))
        if not self._names:
            raise InputError("line 1: an object without values; give times and values")
        if len(self._names) > MAX_COLUMNS:
            raise InputError(f"{len(self._names)} columns, more than {MAX_COLUMNS}; keep fewer")
        self.columns = tuple(map(Column.of, self._names))

    def chunks(self, columns: Sequence[int]) -> Iterator[Chunk]:
        """Read these columns; InputError names a broken line."""
        names = [self._names[i] for i in columns]
        records = self._records()
        while part := list(itertools.islice(records, CHUNK_ROWS)):
            numbers = [number for number, _ in part]
            cells = tuple([record.get(name) for _, record in part] for name in names)
            chunk = Chunk(cells, numbers[0], numbers, self._lines.part)
            check_single(self, chunk, columns)
            yield chunk

    def _records(self) -> Iterator[tuple[int, dict[str, Any]]]:
        for number, line in enumerate(self._lines, 1):
            if not line.strip():
                continue
            try:
                record = json.loads(line)
            except (ValueError, RecursionError) as error:
                raise InputError(
                    f"line {number}: broken JSON ({error}); one object a line is read"
                ) from error
            if not isinstance(record, dict):
                raise InputError(f"line {number}: {shown(record)} isn't an object {{...}}")
            yield number, record


def sniff(source: Source) -> bool:
    """Return whether the file is one JSON object a line."""
    text = source.head_text
    if text is None or not text.lstrip().startswith("{"):
        return False
    lines = [line for line in text.split("\n")[:3] if line.strip()]
    if len(lines) < 2 or not all(line.lstrip().startswith("{") for line in lines):
        return False
    try:
        return isinstance(json.loads(lines[0]), dict)
    except (ValueError, RecursionError):
        return False


def open_table(source: Source) -> JsonLinesTable:
    """Return the file's table; InputError names a broken line."""
    return JsonLinesTable(source)
