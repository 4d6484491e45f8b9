"""Columns of ASCII text, kept as positions in a buffer, and the numbers that are written in them.

Eight characters at a time are one whole number of 64 bits, in which all digits are converted at
once. Results are those of `int` and `float`.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
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
_HIGH = np.uint64(0x80 * _BYTES)
_KEEP = np.array([(2**64 - 1) >> 8 * (8 - n) << 8 * (8 - n) for n in range(9)], np.uint64)
"""Masks of the last n of eight characters."""

_POWERS = 10 ** np.arange(17, dtype=np.uint64)
_SCALES = 10.0 ** np.arange(23)


def padded(text: bytes | memoryview) -> NDArray[np.uint8]:
    """Return a buffer that holds a text from `PAD` on."""
    return np.frombuffer(b"".join((bytes(PAD), text, bytes(PAD))), np.uint8)


class TextCells(Sequence[str]):
    """Texts between `starts` and `stops` in a buffer of ASCII characters."""

    def __init__(self, data: NDArray[np.uint8], starts: Positions, stops: Positions) -> None:
        self.data, self.starts, self.stops = data, starts, stops
        self._eights: Words = np.ndarray(len(data) - 7, "<u8", data, strides=(1,))
        self._words: dict[int, Words] = {}

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

    def like_first(self, rows: Positions) -> BoolArray:
        """Return which of these cells differ from the first of them in digits only."""
        whole = len(rows) == len(self)
        sample = self[int(rows[0])].encode()
        lengths = self.stops - self.starts
        same: BoolArray = (lengths if whole else lengths[rows]) == len(sample)
        for begin in range(0, len(sample), 8):
            part = sample[begin : begin + 8]
            digits = _word_of(255 * (ord("0") <= byte <= ord("9")) for byte in part)
            others = _word_of(255 for _ in part) & ~digits
            words = self._word(begin) if whole else self._word(begin)[rows]
            wrong = (words ^ _word_of(part)) & others
            # 0x80 in each byte that is no digit
            wrong |= (((words ^ _ZEROS) & digits) + np.uint64(0x76 * _BYTES)) & (digits & _HIGH)
            same &= wrong == 0
        return same

    def number(self, begin: int, end: int) -> Positions | int:
        """Return the numbers at a fixed place in all cells, which has only digits there.

        A number that is the same in all cells is an int.
        """
        numbers: Positions = np.zeros(len(self), np.int64)
        for stop in range(end, begin, -8):
            start = max(stop - 8, begin)
            first = start if start // 8 < (stop - 1) // 8 else start // 8 * 8
            word = self._word(first) << np.uint64(8 * (first + 8 - stop))
            word &= _KEEP[stop - start] & np.uint64(0x0F * _BYTES)
            numbers += (_value(word, stop - start) * _POWERS[end - stop]).astype(np.int64)
        low = int(numbers.min(initial=0))
        return low if low == numbers.max(initial=0) else numbers

    def _word(self, begin: int) -> Words:
        """Return the eight characters from `begin` on of all cells."""
        if begin not in self._words:
            self._words[begin] = self._eights[self.starts + begin]
        return self._words[begin]

    def _after_sign(self) -> tuple[Positions, BoolArray]:
        """Return where the cells begin after their sign, and which have a minus sign."""
        first = self.data[self.starts]
        negative = first == ord("-")
        return self.starts + (negative | (first == ord("+"))), negative

    def wholes(self) -> tuple[Positions, BoolArray]:
        """Return whole numbers, and which cells are such, of 1 to 16 digits."""
        starts, negative = self._after_sign()
        found, good, _ = _numbers(self._eights, starts, self.stops)
        whole = found.astype(np.int64)
        return np.where(negative, -whole, whole) if negative.any() else whole, good

    def decimals(self, mark: str) -> tuple[FloatArray, BoolArray]:
        """Return numbers with a decimal mark, and which cells are such; empty cells are NaN."""
        starts, negative = self._after_sign()
        whole, good, figures = _numbers(self._eights, starts, self.stops, mark)
        # quotients of exact numbers are rounded as `float` does
        found = whole.astype(np.float64) / _SCALES[figures]
        np.negative(found, out=found, where=negative)
        good &= whole <= 2**53
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


def _word_of(letters: Iterable[int]) -> np.uint64:
    return np.uint64(int.from_bytes(bytes(letters), "little"))


def _numbers(
    eights: Words, starts: Positions, stops: Positions, mark: str = ""
) -> tuple[Words, BoolArray, Words | int]:
    """Return numbers without their mark, which texts are such, and their digits after the mark.

    A number has 1 to 16 characters, at least one digit, and at most one mark.
    """
    length = stops - starts
    longest = int(length.max(initial=0))
    if longest == length.min(initial=longest):
        length = length[:1]  # a mask for all
    word = _eight(eights, stops, length)
    marked: Any = False
    figures: Any = 0
    if mark:
        word, marked, figures = _without(word, mark)
    found, good = _value(word, 8), _are_digits(word)
    if longest > 8:
        word = _eight(eights, stops - 8, length - 8)
        if mark:
            word, higher, more = _without(word, mark)
            good &= ~(marked & higher)
            figures = figures + more + np.uint64(8) * higher
            found = found + _value(word, 8) * np.where(marked, _POWERS[7], _POWERS[8])
            marked = marked | higher
        else:
            found = found + _value(word, longest - 8) * _POWERS[8]
        good &= _are_digits(word) & (length <= 16)
    return found, good & (length > marked), figures


def _eight(eights: Words, stops: Positions, length: Positions) -> Words:
    """Return up to eight characters before `stops`; the bytes of digits are their values."""
    return (eights[stops - 8] ^ _ZEROS) & _KEEP[np.clip(length, 0, 8)]


def _are_digits(word: Words) -> BoolArray:
    digits: BoolArray = (word + np.uint64(0x76 * _BYTES)) & _HIGH == 0
    return digits


def _without(word: Words, mark: str) -> tuple[Words, BoolArray, Words]:
    """Return words without their first mark, which had one, and the number of digits after it."""
    byte = ord(mark) ^ ord("0")
    others = word ^ np.uint64(byte * _BYTES)
    place = (others - np.uint64(_BYTES)) & ~others & _HIGH
    place = (place & (~place + np.uint64(1))) >> np.uint64(7)  # 1 in the byte of the mark
    marked = place > 0
    before = word & (place - marked)
    # what stands before the mark moves over it
    word = word + before * np.uint64(255) - place * np.uint64(byte)
    return word, marked, place * np.uint64(0x0706_0504_0302_0100) >> np.uint64(56)


def _value(word: Words, count: int) -> Words:
    """Return the number of the last `count` of eight digits; those before are 0."""
    # pairs of digits, then fours, then all eight; the first is the lowest byte
    word = word * np.uint64(10 * 2**8 + 1)
    if count <= 2:
        return word >> np.uint64(56)
    word = (word >> np.uint64(8) & np.uint64(0x00FF_00FF_00FF_00FF)) * np.uint64(100 * 2**16 + 1)
    if count <= 4:
        return word >> np.uint64(48)
    word = word >> np.uint64(16) & np.uint64(0x0000_FFFF_0000_FFFF)
    return word * np.uint64(10_000 * 2**32 + 1) >> np.uint64(32)
