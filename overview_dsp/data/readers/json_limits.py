"""How deep and how large JSON is, counted before it is parsed.

The parser goes down a level for every bracket and makes an object for every value: a file of a few
megabytes can end the stack or take gigabytes. Both are known from its brackets, commas and quotes.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np

from overview_dsp.errors import InputError

MAX_DEPTH = 64
"""Deepest nesting that is read without `max_depth`: ten times what the known formats need."""

MOST_DEPTH = 500
"""Deepest nesting `max_depth` may allow: the parser's own stack ends at about twice that."""

PARSED_MB = 576.0
"""What a file holds may take in memory, MB; a limit of size above the usual 64 MB raises it too."""

PARSED_TIMES = 9
"""So many times the limit of its size is what it may take then."""

# bytes, measured with Python 3.11 on 64 bits, a copy of each number included
_OBJECT_BYTES, _LIST_BYTES, _VALUE_BYTES, _TEXT_BYTES = 240, 72, 72, 60
_CHUNK = 1 << 20
_ESCAPED = re.compile(rb"\\.", re.DOTALL)


@dataclass(frozen=True)
class Extent:
    """Levels of nesting, and bytes that the parsed document takes, roughly and at most."""

    depth: int
    parsed_bytes: int


def extent(text: str, deepest: int = MOST_DEPTH) -> Extent:
    """Count a text's nesting and values; stops counting where it is nested deeper than `deepest`.

    What isn't JSON gets some count too: the parser says where it is broken.
    """
    depth = highest = objects = lists = values = quotes = 0
    in_text, escaping = 0, False
    for start in range(0, len(text), _CHUNK):
        data = text[start : start + _CHUNK].encode("utf-8", "surrogatepass")
        if escaping:
            data = data[1:]
        data = _ESCAPED.sub(b"", data)
        escaping = data.endswith(b"\\")
        marks = np.frombuffer(data, dtype=np.uint8)
        quote = marks == ord('"')
        inside = (np.cumsum(quote) + in_text) & 1
        bare = np.where(inside == 1, np.uint8(0), marks)
        opens_object, opens_list = bare == ord("{"), bare == ord("[")
        steps = (opens_object | opens_list).astype(np.int8)
        steps -= (bare == ord("}")) | (bare == ord("]"))
        levels = np.cumsum(steps, dtype=np.int64) + depth
        if len(levels):
            highest = max(highest, int(levels.max()))
            depth, in_text = int(levels[-1]), int(inside[-1])
        objects += int(np.count_nonzero(opens_object))
        lists += int(np.count_nonzero(opens_list))
        values += int(np.count_nonzero(bare == ord(",")))
        quotes += int(np.count_nonzero(quote))
        if highest > deepest:
            break
    parsed = objects * _OBJECT_BYTES + lists * _LIST_BYTES + values * _VALUE_BYTES
    return Extent(highest, parsed + quotes // 2 * _TEXT_BYTES)


def check_extent(text: str, where: str, limit_mb: float, max_depth: int | None = None) -> None:
    """Refuse JSON that is nested too deep or would take too much memory.

    Parameters
    ----------
    text
        The file's text.
    where
        How the error line begins.
    limit_mb
        What the file may have, MB; parsed it may have `PARSED_TIMES` as many, or `PARSED_MB`.
    max_depth
        Levels it may have, in place of `MAX_DEPTH`.

    Raises
    ------
    InputError
        Too deep or too large; the line has the limit and the option that raises it.
    """
    allowed = max_depth if max_depth is not None else MAX_DEPTH
    found = extent(text, allowed)
    if found.depth > allowed:
        raise InputError(
            f"{where}: JSON nested too deep (more than {allowed} levels); a timeline needs four: "
            "correct the file, or raise the limit with max_depth (--max-depth), to "
            f"{MOST_DEPTH} at most"
        )
    budget = max(PARSED_MB, limit_mb * PARSED_TIMES)
    if found.parsed_bytes > budget * 2**20:
        raise InputError(
            f"{where}: what it holds would take about {found.parsed_bytes / 2**20:.0f} MB of "
            f"memory, more than {budget:.0f} MB; cut it into parts, or raise the limit with max_mb "
            f"(--max-mb), to {found.parsed_bytes / 2**20 / PARSED_TIMES + 1.0:.0f}"
        )
