"""Columns of ASCII text, kept as positions in a buffer, and the numbers that are written in them.

Eight characters at a time are one whole number of 64 bits, in which all digits are converted at
once. Results are those of `int` and `float`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
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
_NO_DIGIT = np.uint64(0x76 * _BYTES)
"""Added to the values of eight characters: sets the high bit in those above 9."""

_KEEP = np.array([(2**64 - 1) >> 8 * (8 - n) << 8 * (8 - n) for n in range(9)], np.uint64)
"""Masks of the last n of eight characters."""

_SPARSE = 1000
"""Characters of a buffer per cell above which cells are decoded one by one."""

_DIGITS_AS_ZERO = bytes.maketrans(b"123456789", b"000000000")

_POWERS = 10 ** np.arange(17, dtype=np.uint64)
_SCALES = 10.0 ** np.arange(23)


def padded(text: bytes | memoryview) -> NDArray[np.uint8]:
    """Return a buffer that holds a text from `PAD` on."""
    return np.frombuffer(b"".join((bytes(PAD), text, bytes(PAD))), np.uint8)


class TextCells(Sequence[str]):
    """Texts between `starts` and `stops` in a buffer of ASCII characters."""

    def __init__(self, data: NDArray[np.uint8], starts: Positions, stops: Positions) -> None:
        self.data, self.starts, self.stops = data, starts, stops
        self._words: list[Words] = []

    @classmethod
    def of(cls, cells: list[Any]) -> TextCells | None:
        """Return a list of texts as cells; None if there is another type or character in it."""
        try:
            data = padded("\n".join([*cells, ""]).encode("ascii"))
        except (TypeError, UnicodeEncodeError):
            return None
        stops = np.flatnonzero(data == ord("\n"))
        starts = np.concatenate(([PAD], stops + 1))[:-1]
        return cls(data, starts, stops) if len(stops) == len(cells) else None

    def __len__(self) -> int:
        return len(self.starts)

    def __getitem__(self, index: Any) -> Any:
        """Return one text, or the cells at a slice or at indices."""
        if isinstance(index, int):
            return self.data[self.starts[index] : self.stops[index]].tobytes().decode("ascii")
        part = TextCells(self.data, self.starts[index], self.stops[index])
        part._words = [word[index] for word in self._words]
        return part

    def __iter__(self) -> Iterator[str]:
        return iter(self.tolist())

    def tolist(self) -> list[str]:
        """Return the texts."""
        low, high = int(self.starts.min(initial=len(self.data))), int(self.stops.max(initial=0))
        both = zip((self.starts - low).tolist(), (self.stops - low).tolist(), strict=True)
        data = self.data.data[low:high]
        if len(self) * _SPARSE < high - low:  # few columns of many
            return [str(data[start:stop], "ascii") for start, stop in both]
        text = str(data, "ascii")
        return [text[start:stop] for start, stop in both]

    def like_first(self, rows: Positions) -> BoolArray:
        """Return which of these cells differ from the first of them in digits only."""
        whole = len(rows) == len(self)
        sample = self[int(rows[0])].encode()
        lengths = self.stops - self.starts
        same: BoolArray = (lengths if whole else lengths[rows]) == len(sample)
        self._gather(len(sample))
        wrong: Any = np.uint64(0)
        for begin in range(0, len(sample), 8):
            part = sample[begin : begin + 8].translate(_DIGITS_AS_ZERO)
            words = self._words[begin // 8] if whole else self._words[begin // 8][rows]
            # sets the high bit in values above 9 of digits, above 0 of others
            most = _word_of(0x76 if byte == ord("0") else 0x7F for byte in part)
            wrong |= (words ^ _word_of(part)) + most & _word_of(0x80 for _ in part)
        same &= wrong == 0
        return same

    def runs(self, end: int) -> tuple[Callable[[int, int], Positions | int], Positions]:
        """Return `number` of the first cell of each run with the same characters up to `end`.

        Lengths of the runs follow.
        """
        self._gather(end)
        changed = np.ones(len(self), np.bool_)
        differ: Any = np.uint64(0)
        for begin in range(0, end, 8):
            words = self._words[begin // 8] << np.uint64(8 * max(begin + 8 - end, 0))
            differ = differ | (words[1:] ^ words[:-1])
        np.not_equal(differ, 0, out=changed[1:])
        firsts = np.flatnonzero(changed)
        return self[firsts].number, np.diff(firsts, append=len(self))

    def number(self, begin: int, end: int) -> Positions | int:
        """Return the numbers at a fixed place in all cells, which has only digits there.

        A number that is the same in all cells is an int.
        """
        self._gather(end)
        numbers: Any = 0
        while begin < end:
            first = begin // 8
            stop = min(end, 8 * first + 8)
            word = self._words[first] << np.uint64(8 * (8 * first + 8 - stop))
            word &= _KEEP[stop - begin] & np.uint64(0x0F * _BYTES)
            numbers = numbers * 10 ** (stop - begin) + _value(word, stop - begin).view(np.int64)
            begin = stop
        low = int(numbers.min(initial=0))
        return low if low == numbers.max(initial=0) else numbers

    def _gather(self, end: int) -> None:
        """Gather the words of the first `end` characters of all cells."""
        if 8 * len(self._words) < end:
            self._words = _eights(self.data, self.starts, -(-end // 8))

    def _after_sign(self) -> tuple[Positions, BoolArray]:
        """Return the lengths of the cells without their sign, and which have a minus sign."""
        lengths, first = self.stops - self.starts, self.data[self.starts]
        negative = first == ord("-")
        lengths -= negative | (first == ord("+"))
        return lengths, negative

    def wholes(self) -> tuple[Positions, BoolArray]:
        """Return whole numbers, and which cells are such, of 1 to 16 digits."""
        lengths, negative = self._after_sign()
        found, good, _ = _numbers(self.data, self.stops, lengths)
        whole = found.view(np.int64)
        return np.where(negative, -whole, whole) if negative.any() else whole, good

    def decimals(self, mark: str) -> tuple[FloatArray, BoolArray]:
        """Return numbers with a decimal mark, and which cells are such; empty cells are NaN."""
        lengths, negative = self._after_sign()
        whole, good, figures = _numbers(self.data, self.stops, lengths, mark)
        # quotients of exact numbers are rounded as `float` does
        found = whole.view(np.int64) / _SCALES.take(figures.view(np.int64))
        np.negative(found, out=found, where=negative)
        good &= whole <= 2**53
        if not good.all():  # empty, more digits, an exponent
            empty = self.starts == self.stops
            found[empty] = np.nan
            good |= empty
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


def _eights(data: NDArray[np.uint8], begins: Positions, count: int) -> list[Words]:
    """Return words of eight characters from each of `begins` on, `count` for each."""
    size, step = 8 * count, int(np.diff(begins[:2]).sum())
    even = step and begins[-1] - begins[0] == step * (len(begins) - 1)
    if even and (np.diff(begins) == step).all():  # texts of one length, as in Parquet
        words = np.ndarray((len(begins), count), "<u8", data, int(begins[0]), (step, 8))
    else:  # one copy of all words: twice as fast as of single ones, which aren't aligned
        places = np.ndarray(len(data) - size + 1, f"V{size}", data, strides=(1,))
        words = places[begins].view("<u8").reshape(-1, count)
    return list(np.ascontiguousarray(words.T))


def _numbers(
    data: NDArray[np.uint8], stops: Positions, length: Positions, mark: str = ""
) -> tuple[Words, BoolArray, Words]:
    """Return numbers without their mark, which texts are such, and their digits after the mark.

    `data`, `stops`, `length`: buffer of the texts, their ends, and their lengths.

    A number has 1 to 16 characters, at least one digit, and at most one mark.
    """
    longest = int(length.max(initial=0))
    if longest == length.min(initial=longest):
        length = length[:1]  # a mask for all
    parts = 2 if longest > 8 else 1
    *high, word = _eights(data, stops - 8 * parts, parts)
    word, marked, figures = _without(_digits(word, length), mark)
    found, good = _value(word, 8), _are_digits(word)
    for word in high:
        word, higher, more = _without(_digits(word, length - 8), mark)
        good &= _are_digits(word) & (length <= 16) & ~(marked & higher)
        figures = figures + more + np.uint64(8) * higher
        count = 8 if mark else longest - 8
        found = found + _value(word, count) * np.where(marked, _POWERS[7], _POWERS[8])
        marked = marked | higher
    return found, good & (length > marked), figures


def _digits(word: Words, length: Positions) -> Words:
    """Return the values of the last characters of each word, as many as `length` says."""
    return (word ^ _ZEROS) & _KEEP.take(length, mode="clip")


def _are_digits(word: Words) -> BoolArray:
    return np.asarray((word + _NO_DIGIT) & _HIGH == 0)


def _without(word: Words, mark: str) -> tuple[Words, Any, Any]:
    """Return words without their first mark, which had one, and the number of digits after it."""
    if not mark:
        return word, np.False_, np.uint64(0)
    byte = ord(mark) ^ ord("0")
    others = word ^ np.uint64(byte * _BYTES)
    place = (others - np.uint64(_BYTES)) & ~others & _HIGH
    place = (place & -place) >> np.uint64(7)  # 1 in the byte of the mark
    marked = place != 0
    before = (place - marked) & word
    # what stands before the mark moves over it
    word = before * np.uint64(255) + word - place * np.uint64(byte)
    return word, marked, place * np.uint64(0x0706_0504_0302_0100) >> np.uint64(56)


def _value(word: Words, count: int) -> Words:
    """Return the number of the last `count` of eight digits; those before are 0."""
    # pairs of digits, then fours, then all eight; the first is the lowest byte
    word = word * np.uint64(10 * 2**8 + 1) >> np.uint64(8)
    if count > 2:
        word = (word & np.uint64(0xFF_00FF_00FF_00FF)) * np.uint64(100 * 2**16 + 1) >> np.uint64(16)
    if count > 4:
        word = (word & np.uint64(0xFFFF_0000_FFFF)) * np.uint64(10_000 * 2**32 + 1) >> np.uint64(32)
    return word >> np.uint64(48 if count <= 2 else 32 if count <= 4 else 0)
