"""Columns of ASCII text, kept as positions in a buffer, and the numbers that are written in them.

Eight characters at a time are one whole number of 64 bits, in which all digits are converted at
once. Results are those of `int` and `float`.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from overview_dsp.arrays import BoolArray, FloatArray, IntArray

Positions = IntArray
Words = NDArray[np.uint64]

PAD = 48
"""Bytes around the text in a buffer, so that characters are read before and after each cell."""

_BYTES = 0x0101_0101_0101_0101
_ZEROS = np.uint64(ord("0") * _BYTES)
_KEEP = np.array([(2**64 - 1) >> 8 * (8 - n) << 8 * (8 - n) for n in range(9)], np.uint64)
"""Masks of the last n of eight characters."""

_FIGURES = 16
"""Most digits of a number."""

_POWERS = 10 ** np.arange(_FIGURES + 1, dtype=np.uint64)


def padded(text: bytes | memoryview) -> NDArray[np.uint8]:
    """Return a buffer that holds a text from `PAD` on."""
    return np.frombuffer(b"".join((bytes(PAD), text, bytes(PAD))), np.uint8)


class TextCells(Sequence[str]):
    """Texts between `starts` and `stops` in a buffer of ASCII characters."""

    def __init__(self, data: NDArray[np.uint8], starts: Positions, stops: Positions) -> None:
        self.data, self.starts, self.stops = data, starts, stops
        self._eights: Words = np.ndarray(len(data) - 7, "<u8", data, strides=(1,))

    @classmethod
    def of(cls, cells: list[Any]) -> TextCells | None:
        """Return a list of texts as cells; None if there is another type or character in it."""
        try:
            text = "\n".join([*cells, ""])
        except TypeError:
            return None
        if not text.isascii():
            return None
        data = padded(text.encode())
        stops = np.flatnonzero(data == ord("\n"))
        starts = np.concatenate(([PAD], stops + 1))[:-1]
        return cls(data, starts, stops) if len(stops) == len(cells) else None

    def __len__(self) -> int:
        return len(self.starts)

    def __getitem__(self, index: Any) -> Any:
        """Return one text, or the cells at a slice or at indices."""
        if isinstance(index, int):
            return self.data[self.starts[index] : self.stops[index]].tobytes().decode("ascii")
        return TextCells(self.data, self.starts[index], self.stops[index])

    def __iter__(self) -> Iterator[str]:
        return iter(self.tolist())

    def tolist(self) -> list[str]:
        """Return the texts."""
        low = int(self.starts.min(initial=len(self.data)))
        text = self.data[low : int(self.stops.max(initial=0))].tobytes().decode("ascii")
        both = zip((self.starts - low).tolist(), (self.stops - low).tolist(), strict=True)
        return [text[start:stop] for start, stop in both]

    def shapes(self, longest: int) -> list[NDArray[Any]] | None:
        """Return arrays that are equal for cells that differ in digits only, None for long ones."""
        length = self.stops - self.starts
        if length.max(initial=0) > longest:
            return None
        found: list[NDArray[Any]] = [length]
        for begin in range(0, int(length.max(initial=0)), 8):
            words = self._eights[self.starts + begin] & ~_KEEP[8 - np.clip(length - begin, 0, 8)]
            # 0x80 in each byte that is no digit, then 0xff
            others = ((words ^ _ZEROS) + np.uint64(0x76 * _BYTES)) & np.uint64(0x80 * _BYTES)
            others = (others >> np.uint64(7)) * np.uint64(0xFF)
            found.append((words & others) | (_ZEROS & ~others))
        return found

    def number(self, begin: int, end: int) -> Positions:
        """Return the numbers at a fixed place in all cells, which has only digits there."""
        stops = self.starts + end
        return _whole(self._eights, stops - (end - begin), stops)[0].astype(np.int64)

    def wholes(self) -> tuple[Positions, BoolArray]:
        """Return whole numbers without sign, and which cells are such, of 1 to 16 digits."""
        found, good = _whole(self._eights, self.starts, self.stops)
        return found.astype(np.int64), good & (self.stops > self.starts)

    def decimals(self, mark: str) -> tuple[FloatArray, BoolArray]:
        """Return numbers with a decimal mark, and which cells are such; empty cells are NaN."""
        first = self.data[self.starts]
        negative = first == ord("-")
        starts = self.starts + (negative | (first == ord("+")))
        points = np.append(np.flatnonzero(self.data == ord(mark)), len(self.data))
        point = np.minimum(points[np.searchsorted(points, starts)], self.stops)
        after = np.minimum(point + 1, self.stops)
        whole, good = _whole(self._eights, starts, point)
        part, good_part = _whole(self._eights, after, self.stops)
        figures = np.minimum(self.stops - after, _FIGURES)
        count = point - starts + figures
        whole = whole * _POWERS[figures] + part
        # quotients of exact numbers are rounded as `float` does
        found = whole.astype(np.float64) / _POWERS[figures].astype(np.float64)
        found = np.where(negative, -found, found)
        good &= good_part & (count > 0) & (count <= _FIGURES) & (whole <= 2**53)
        empty = self.starts == self.stops
        if empty.any():
            found[empty] = np.nan
        good |= empty
        if not good.all():  # more digits, an exponent
            cells = self[np.flatnonzero(~good)].tolist()
            if set("".join(cells)) <= set(f"0123456789+-eE{mark}"):
                try:
                    found[~good] = [float(cell.replace(mark, ".")) for cell in cells]
                except ValueError:  # a second mark, a lone sign
                    return found, good
                good[:] = True
        return found, good


def _whole(eights: Words, starts: Positions, stops: Positions) -> tuple[Words, BoolArray]:
    """Return the numbers between positions, and whether these have only digits, 16 or fewer."""
    length = stops - starts
    found, good = _eight(eights, stops, length)
    if length.max(initial=0) > 8:
        upper, also = _eight(eights, stops - 8, length - 8)
        found = found + upper * _POWERS[8]
        good &= also & (length <= _FIGURES)
    return found, good


def _eight(eights: Words, stops: Positions, length: Positions) -> tuple[Words, BoolArray]:
    """Return the numbers of up to eight characters before `stops`, and whether all are digits."""
    keep = _KEEP[np.clip(length, 0, 8)]
    word = (eights[stops - 8] & keep) | (_ZEROS & ~keep)
    high = np.uint64(0xF0 * _BYTES)
    good = (word & high == _ZEROS) & ((word + np.uint64(6 * _BYTES)) & high == _ZEROS)
    # pairs of digits, then fours, then all eight; the first is the lowest byte
    word = (word & np.uint64(0x0F * _BYTES)) * np.uint64(10 * 2**8 + 1) >> np.uint64(8)
    word = (word & np.uint64(0x00FF_00FF_00FF_00FF)) * np.uint64(100 * 2**16 + 1) >> np.uint64(16)
    word = (word & np.uint64(0x0000_FFFF_0000_FFFF)) * np.uint64(10_000 * 2**32 + 1)
    return word >> np.uint64(32), good
