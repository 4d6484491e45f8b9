"""Incremental splitting of bytes at separators, and decoding of text lines."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping

from overview_dsp.devices.sensors.reading import Counters, Decoder, Reading


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
            elif len(piece) > self._longest or not all(
                32 <= byte < 127 or byte == 9 for byte in text
            ):
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
