"""Lines of text from bytes that come in any pieces."""

from __future__ import annotations

from overview_dsp.sensors.reading import Counters

LONGEST = 512
"""Bytes of a line; a longer one is noise."""


class LineSplitter:
    """Splits at CR and LF. What comes before the first end of a line may be half of one."""

    def __init__(self, counters: Counters) -> None:
        """What is wrong is counted in `counters`."""
        self._counters = counters
        self._pending = bytearray()
        self._too_long = 0
        self._synchronised = False

    def feed(self, data: bytes) -> list[str]:
        """The lines that these bytes end, stripped; empty ones and comments (#) left out."""
        self._counters.received_bytes += len(data)
        lines = []
        *ended, rest = data.replace(b"\r", b"\n").split(b"\n")
        for piece in ended:
            self._append(piece)
            line = self._end()
            if line:
                lines.append(line)
        self._append(rest)
        return lines

    def _append(self, piece: bytes) -> None:
        space = LONGEST + 1 - len(self._pending)
        self._pending += piece[:space]
        self._too_long += max(0, len(piece) - space)

    def _end(self) -> str:
        piece, self._pending = self._pending, bytearray()
        too_long, self._too_long = self._too_long, 0
        first, self._synchronised = not self._synchronised, True
        if first:
            self._counters.fragments += bool(piece)
            return ""
        text = bytes(piece).strip()
        if len(piece) > LONGEST or not all(32 <= byte < 127 or byte == 9 for byte in text):
            self._counters.refuse(piece)
            self._counters.noise_bytes += too_long
            return ""
        return "" if text.startswith(b"#") else text.decode("ascii")
