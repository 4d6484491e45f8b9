"""The fields of plain text, found in a block at a time: no quotes, no blank lines, one width.

Most tables are plain. Only the columns that are asked for become text cells, which is what makes a
wide table quick to read; what isn't plain is left to `delimited`.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

LONGEST_FIELD = 131_072
"""Longest field, characters, as of Python's csv module."""

_FLAT = 4
"""Where at least one in so many columns is asked for, all fields are made at once."""

_NEWLINE = 10


def marks_of(block: str, separator: str, width: int, comments: bool) -> NDArray[np.int64] | None:
    """Return where the fields of a block end, shape (rows * width,); None if it isn't plain.

    Parameters
    ----------
    block
        Whole lines, the last one with its end too.
    separator
        One character between fields.
    width
        Fields a line.
    comments
        Lines that begin with `#` are none.
    """
    if '"' in block or not block.isascii() or block[:1] in ("\n", " ", "#") or "\n\n" in block:
        return None
    if comments and "\n#" in block:
        return None
    if separator != "\t" and (f"{separator} " in block or "\n " in block):
        return None  # blanks before a field aren't part of it
    data = np.frombuffer(block.encode("ascii"), np.uint8)
    ends = data == _NEWLINE
    marks = np.flatnonzero(ends | (data == ord(separator)))
    rows, left = divmod(len(marks), width)
    if (
        not rows
        or left
        or np.count_nonzero(ends) != rows
        or not ends[marks[width - 1 :: width]].all()
    ):
        return None
    longest = max(int(marks[0]), int((marks[1:] - marks[:-1]).max(initial=0)))
    return marks if longest <= LONGEST_FIELD else None


def cells_of(
    block: str, marks: NDArray[np.int64], separator: str, width: int, columns: Sequence[int]
) -> tuple[list[str], ...]:
    """Return the cells of some columns of a block whose fields end at `marks`."""
    if _FLAT * len(columns) >= width:
        flat = block.replace("\n", separator).split(separator)
        return tuple(flat[i : len(marks) : width] for i in columns)
    found = []
    for i in columns:
        stops = marks[i::width]
        starts = (marks[i - 1 :: width] if i else np.append(-1, marks[width - 1 : -1 : width])) + 1
        both = zip(starts.tolist(), stops.tolist(), strict=False)
        found.append([block[start:stop] for start, stop in both])
    return tuple(found)
