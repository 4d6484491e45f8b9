"""Text with separated fields, read in constant memory: its encoding, its lines, its rows."""

from __future__ import annotations

import codecs
import contextlib
import csv
import io
import itertools
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from overview_dsp.errors import InputError
from overview_dsp.readers.source import CONTROL, Source

BLOCK_BYTES = 1 << 20
"""Bytes read at a time."""

MAX_LINE = 1 << 20
"""Longest line, characters: a row of a table isn't a megabyte."""

SEPARATORS = (";", "\t", "|", ",")
"""What may separate fields, besides blanks (`None`), those asked first that numbers don't hold."""

_UTF8 = "utf-8"


def encoding_of(source: Source) -> str | None:
    """Return the encoding of a text file by its head, None for what is no text."""
    text = source.head_text
    return None if text is None or CONTROL & set(text) else source.encoding


def head_lines(source: Source, encoding: str) -> list[str]:
    """Return the whole lines of the head, without their ends."""
    decoder = io.IncrementalNewlineDecoder(codecs.getincrementaldecoder(encoding)(), True)
    whole = source.size <= len(source.head)
    lines: list[str] = decoder.decode(source.head, final=whole).split("\n")
    return lines if whole else lines[:-1]


@dataclass
class Lines:
    """Iterates over a file's lines with their ends as "\\n"; comment lines become blank ones.

    A byte that isn't text in a UTF-8 file becomes a lone surrogate, so that only a cell which is
    used is an error.
    """

    source: Source
    encoding: str
    comments: bool = True
    part: float = 0.0

    def __iter__(self) -> Iterator[str]:
        for block in self.blocks():
            if self.comments and (block.startswith("#") or "\n#" in block):
                lines = io.StringIO(block)
                yield from ("\n" if line.startswith("#") else line for line in lines)
            else:
                yield from io.StringIO(block)

    def blocks(self) -> Iterator[str]:
        """Read whole lines together, comment lines too; InputError for one that is too long."""
        errors = "surrogateescape" if self.encoding.startswith(_UTF8) else "replace"
        decoder = codecs.getincrementaldecoder(self.encoding)(errors)
        newlines = io.IncrementalNewlineDecoder(decoder, True)
        rest, seen, count = "", 0, 0
        for data in self._data():
            seen += len(data)
            text = rest + newlines.decode(data, final=not data)
            cut = text.rfind("\n") + 1 if data else len(text)
            block, rest = text[:cut], text[cut:]
            count += block.count("\n")
            if len(rest) > MAX_LINE:
                raise InputError(
                    f"line {count + 1} is longer than {MAX_LINE} characters; a table has one "
                    "row a line: save it as CSV"
                )
            self.part = min(1.0, seen / max(1, self.source.size))
            yield block

    def _data(self) -> Iterator[bytes]:
        """The file's bytes, an empty block at the end."""
        try:
            with open(self.source.path, "rb") as stream:
                while data := stream.read(BLOCK_BYTES):
                    yield data
        except OSError as error:
            raise InputError(f"can't be read ({error.strerror})") from error
        yield b""


@dataclass
class Rows:
    """Iterates over blocks of rows: (number of the first row's line, line numbers or None, rows).

    Line numbers are None where each row is one line. Blank lines are empty rows.
    """

    lines: Lines
    separator: str | None
    block: int

    def __iter__(self) -> Iterator[tuple[int, list[int] | None, list[list[str]]]]:
        first = 1
        if self.separator is None:
            lines = iter(self.lines)
            while rows := [line.split() for line in itertools.islice(lines, self.block)]:
                yield first, None, rows
                first += len(rows)
            return
        reader = self._reader(self.separator)
        while True:
            try:
                rows = list(itertools.islice(reader, self.block))
            except csv.Error as error:
                raise InputError(
                    f"line {self._broken_row()}: {error}; check the quotes from there on"
                ) from error
            if not rows:
                return
            numbers = None
            if reader.line_num - first + 1 != len(rows):
                numbers = list(
                    itertools.accumulate(
                        (1 + sum(cell.count("\n") for cell in row) for row in rows[:-1]),
                        initial=first,
                    )
                )
            yield first, numbers, rows
            first = reader.line_num + 1

    def _reader(self, separator: str) -> Any:
        return csv.reader(
            self.lines, delimiter=separator, strict=True, skipinitialspace=separator != "\t"
        )

    def _broken_row(self) -> int:
        """Read once more, row by row, and return the line at which the broken one begins."""
        assert self.separator is not None
        reader = self._reader(self.separator)
        first = 1
        try:
            for _ in reader:
                first = reader.line_num + 1
        except csv.Error:
            pass
        return first


def split(lines: list[tuple[int, str]], separator: str | None) -> list[tuple[int, list[str]]]:
    """Return the fields of numbered lines; a row that spans lines has the number of its first.

    What comes after a field too long to be one is left out.
    """
    if separator is None:
        return [(number, line.split()) for number, line in lines]
    reader = csv.reader(
        (f"{line}\n" for _, line in lines),
        delimiter=separator,
        skipinitialspace=separator != "\t",
    )
    rows: list[tuple[int, list[str]]] = []
    begin = 0
    with contextlib.suppress(csv.Error):
        for row in reader:
            rows.append((lines[begin][0], row))
            begin = reader.line_num
    return rows
