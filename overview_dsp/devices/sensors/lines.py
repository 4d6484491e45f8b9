"""Lines of text from bytes that come in any cuts, and readings from lines.

What a separator ends, frames or lines, from bytes that come in any cuts.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping

from overview_dsp.devices.sensors.reading import Counters, Decoder, Reading


class Pieces:
    """Keeps what no separator has ended yet, in bounded memory."""

    def __init__(self, longest: int) -> None:
        """One byte more than `longest` is kept of a piece: it says that it is too long."""
        self._most = longest + 1
        self._pending = bytearray()
        self._left_out = 0
        self._first = True

    def ended(self, data: bytes, separator: bytes) -> Iterator[tuple[bytes, int, bool]]:
        """Each piece that these bytes end: itself, bytes left out, whether it is the first.

        The first may be half of one. To be run to its end.
        """
        *ended, rest = data.split(separator)
        for part in ended:
            self._append(part)
            yield bytes(self._pending), self._left_out, self._first
            self._pending.clear()
            self._left_out, self._first = 0, False
        self._append(rest)

    def _append(self, part: bytes) -> None:
        space = self._most - len(self._pending)
        self._pending += part[:space]
        self._left_out += max(0, len(part) - space)


LONGEST = 512
"""Bytes of a line; a longer one is noise."""

_SIGNS = ((b"\xc2\xb0", b"deg"), (b"\xc2\xb2", b"2"))
"""Degrees and squares as UTF-8 writes them."""


class LineSplitter:
    """Splits at CR and LF. What comes before the first end of a line may be half of one."""

    def __init__(self, counters: Counters, longest: int = LONGEST) -> None:
        """What is wrong is counted in `counters`; `longest`: bytes of a line, more are noise."""
        self._counters = counters
        self._longest = longest
        self._pieces = Pieces(longest)

    def feed(self, data: bytes) -> list[str]:
        """The lines that these bytes end, stripped; empty ones and comments (#) left out."""
        return [line for line, _ in self.with_bytes(data)]

    def with_bytes(self, data: bytes) -> list[tuple[str, bytes]]:
        """As `feed`, each with the bytes it came as: signs are words in a line, and longer."""
        lines = []
        for piece, left_out, first in self._pieces.ended(data.replace(b"\r", b"\n"), b"\n"):
            text = came = piece.strip()
            for sign, word in _SIGNS:
                text = text.replace(sign, word)
            if first:
                self._counters.fragments += bool(piece)
            elif len(piece) > self._longest or not all(
                32 <= byte < 127 or byte == 9 for byte in text
            ):
                self._counters.refuse(piece)
                self._counters.noise_bytes += left_out
            elif text and not text.startswith(b"#"):
                lines.append((text.decode("ascii"), came))
        return lines


class LineDecoder(Decoder):
    """Readings from lines."""

    def __init__(
        self,
        counters: Counters,
        read: Callable[[str], Reading | list[Reading] | str | None],
        longest: int = LONGEST,
    ) -> None:
        """`read` gives the reading of a line, or several: None if it is none, empty or a text if
        there is nothing of use in it."""
        super().__init__(counters)
        self._read = read
        self._lines = LineSplitter(counters, longest)

    def _decode(self, data: bytes) -> Iterator[Reading]:
        for line, came in self._lines.with_bytes(data):
            found = self._read(line)
            if found is None:
                self._counters.refuse(came)
            elif isinstance(found, list):
                yield from found
            elif found and isinstance(found, Mapping):
                yield found
