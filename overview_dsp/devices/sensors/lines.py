"""Text lines: incremental splitting of bytes at separators, and lines of numbers.

The lines are `ax,ay,az[,gx,gy,gz]`, `roll_deg`, an encoder's count, a potentiometer's wiper.
Commas, semicolons, bars, tabs or spaces separate the numbers. A line has no check: a lost or wrong
byte within a number gives another number. Binary frames detect that, and so do the sensor's ranges.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Mapping

from overview_dsp.devices.sensors.reading import (
    COLUMNS,
    INERTIAL,
    SKIPPED,
    Counters,
    Decoder,
    Reading,
)


class StreamSplitter:
    """Splits bytes at a separator and keeps the unfinished piece, in bounded memory."""

    def __init__(self, longest: int) -> None:
        """Keep at most one byte more than `longest` of a piece, which shows that it is too long."""
        self._limit = longest + 1
        self._pending = bytearray()
        self._omitted = 0
        self._first = True

    def split(self, data: bytes, separator: bytes) -> Iterator[tuple[bytes, int, bool]]:
        """Yield each finished piece, its number of omitted bytes, and whether it is the first.

        The first piece may be incomplete. Exhaust the iterator.
        """
        *finished, rest = data.split(separator)
        for part in finished:
            self._append(part)
            yield bytes(self._pending), self._omitted, self._first
            self._pending.clear()
            self._omitted, self._first = 0, False
        self._append(rest)

    def _append(self, part: bytes) -> None:
        space = self._limit - len(self._pending)
        self._pending += part[:space]
        self._omitted += max(0, len(part) - space)


LONGEST = 512  # maximum length of a line, bytes; a longer one is noise

_PRINTABLE = re.compile(rb"[\t -~]*")
_COMMENT = re.compile(rb"#(?![A-Za-z-]+=)")  # Razor's readings begin with #YPR=

_SIGNS = ((b"\xc2\xb0", b"deg"), (b"\xc2\xb2", b"2"))
"""The signs for degrees and squares in UTF-8, and words for them."""


class LineSplitter:
    """Splits at CR and LF. Text before the first line end may be an incomplete line."""

    def __init__(self, counters: Counters, longest: int = LONGEST) -> None:
        """Count faults in `counters`; lines of more than `longest` bytes are noise."""
        self._counters = counters
        self._longest = longest
        self._splitter = StreamSplitter(longest)

    def feed(self, data: bytes) -> list[str]:
        """Return the lines that these bytes end, stripped, without empty ones and comments (#)."""
        return [line for line, _ in self.feed_with_bytes(data)]

    def feed_with_bytes(self, data: bytes) -> list[tuple[str, bytes]]:
        """Return the lines as `feed` does, each with the bytes received for it."""
        lines = []
        for piece, omitted, first in self._splitter.split(data.replace(b"\r", b"\n"), b"\n"):
            text = received = piece.strip()
            for sign, word in _SIGNS:
                text = text.replace(sign, word)
            if first:
                self._counters.fragments += bool(piece)
            elif len(piece) > self._longest or not _PRINTABLE.fullmatch(text):
                self._counters.reject(piece)
                self._counters.noise_bytes += omitted
            elif text and not _COMMENT.match(text):
                lines.append((text.decode("ascii"), received))
        return lines


class LineDecoder(Decoder):
    """Readings from text lines."""

    def __init__(
        self,
        counters: Counters,
        parse: Callable[[str], Reading | list[Reading] | str | None],
        longest: int = LONGEST,
    ) -> None:
        """Decode each line by `parse`, which returns readings, or None for an invalid line.

        For a line without usable data it returns an empty reading or a reason.
        """
        super().__init__(counters)
        self._parse = parse
        self._lines = LineSplitter(counters, longest)

    def _decode(self, data: bytes) -> Iterator[Reading]:
        for line, received in self._lines.feed_with_bytes(data):
            found = self._parse(line)
            if found is None:
                self._counters.reject(received)
            elif isinstance(found, list):
                yield from found
            elif found and isinstance(found, Mapping):
                yield found


_SEPARATORS = re.compile(r"\s*[,;|]\s*|\s+")
_WIDE_SEPARATORS = re.compile(r"[\s,;:=|()\[\]{}]+")
_LEADING = "([{ \t"
_TRAILING = ")]} \t,;|"
_NUMBER = re.compile(r"[+-]?(\d+(\.\d*)?|\.\d+)([eE][+-]?\d{1,3})?")

WORD = "="  # before a word as the name of a column: lines with another word there are skipped

_LOGGED = dict(zip(INERTIAL, INERTIAL, strict=True)) | {"q6_1": "qx", "q6_2": "qy", "q6_3": "qz"}
"""Column names that loggers (OpenLog Artemis) write, in lower case, to names of `COLUMNS`."""


def parse_numbers(line: str) -> tuple[float, ...] | None:
    """Return the numbers of a line; None if it holds anything else."""
    cells = split_cells(line)
    if not all(_NUMBER.fullmatch(cell) for cell in cells):
        return None
    numbers = tuple(map(float, cells))
    return numbers if all(map(math.isfinite, numbers)) else None


def parse_header(line: str) -> tuple[str, ...] | None:
    """Return the columns that a header line names; None if the line isn't a header.

    A logger's header may have other names too; those columns are skipped.
    """
    names = split_cells(line)
    if all(name in COLUMNS for name in names):
        return names if len(set(names)) == len(names) else None
    logged = tuple(_LOGGED.get(name.lower(), SKIPPED) for name in names)
    known = [name for name in logged if name != SKIPPED]
    # three known names make a header; one or two words may be any line
    return logged if len(set(known)) == len(known) >= 3 else None


def split_cells(line: str, wide: bool = False) -> tuple[str, ...]:
    """Return the cells of a line; with `wide`, colons, equals signs and bars separate too.

    A separator at the end of a line ends its last cell. Brackets may surround the line.
    """
    separators = _WIDE_SEPARATORS if wide else _SEPARATORS
    return tuple(separators.split(line.lstrip(_LEADING).rstrip(_TRAILING)))


def parse_row(line: str, columns: tuple[str, ...]) -> Reading | None:
    """Return the reading of a line; empty if it repeats the header, None if it is invalid.

    `columns` are names of `COLUMNS`, in the order of the line; a skipped column may hold anything.
    """
    words = {n: name[1:] for n, name in enumerate(columns) if name.startswith(WORD)}
    if SKIPPED not in columns and not words:
        numbers = parse_numbers(line)
        if numbers is not None and len(numbers) == len(columns):
            return dict(zip(columns, numbers, strict=True))
        return {} if parse_header(line) == columns else None
    for wide in (False, True):
        cells = split_cells(line, wide)
        if len(cells) != len(columns):
            continue
        if any(cells[n] != word for n, word in words.items()):
            return {}
        read = {name: cell for n, (name, cell) in enumerate(zip(columns, cells, strict=True))
                if name != SKIPPED and n not in words}  # fmt: skip
        if all(map(_NUMBER.fullmatch, read.values())):
            reading = {name: float(cell) for name, cell in read.items()}
            return reading if all(map(math.isfinite, reading.values())) else None
    other = any(not line.lstrip(_LEADING).startswith(word) for word in words.values())
    return {} if other or parse_header(line) == columns else None
