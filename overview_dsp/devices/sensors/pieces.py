"""What a separator ends, frames or lines, from bytes that come in any cuts."""

from __future__ import annotations

from collections.abc import Iterator


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
