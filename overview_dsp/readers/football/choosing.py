"""Which of the matches in a file is meant."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Sequence

from overview_dsp.errors import InputError, shown

_SHOWN = 4
_NOT_WORD = re.compile(r"[\W_]+")


def plain(text: str) -> str:
    """Return text for comparing: small letters without accents, words apart by one blank."""
    bare = unicodedata.normalize("NFKD", text.casefold())
    letters = "".join(letter for letter in bare if not unicodedata.combining(letter))
    return _NOT_WORD.sub(" ", letters).strip()


def choose(lines: Sequence[str], match: str | None, ids: Sequence[str] = ()) -> int:
    """Return the position (from 0) of the match that is meant.

    Parameters
    ----------
    lines
        A line on each match: date, teams, score.
    match
        Its number (from 1), its id, or words that only its line has, in any order; None for a
        file of one match.
    ids
        The vendor's number of each match, where there is one.

    Raises
    ------
    InputError
        None of several named, no such match, several fit; the line says how many and how to list
        them.
    """
    listing = "'overview timeline show' lists them"
    if not lines:
        raise InputError("holds no match; is the file complete?")
    if match is None:
        if len(lines) == 1:
            return 0
        raise InputError(
            f"holds {len(lines)} matches; choose one with match (--match): its number, 1 to "
            f"{len(lines)}, or words such as {_example(lines[-1])}; {listing}"
        )
    words = plain(match).split()
    if len(words) == 1 and words[0].isascii() and words[0].isdigit():
        if words[0] in ids:
            return list(ids).index(words[0])
        number = int(words[0][:18])
        if 1 <= number <= len(lines):
            return number - 1
        if number < 1000:  # no year either
            raise InputError(f"there is no match {number}; give a number, 1 to {len(lines)}")
    asked = shown(match)
    if not words:
        raise InputError(f"match is {asked}; give a number, 1 to {len(lines)}, or words")
    found = _having(lines, words)
    if not found:
        raise InputError(
            f"none of the {len(lines)} matches has {asked}; give a number, 1 to {len(lines)}, or "
            f"words such as {_example(lines[-1])}; {listing}"
        )
    if len(found) > 1:
        first = "; ".join(f"{i + 1}: {' '.join(lines[i].split())}" for i in found[:_SHOWN])
        more = f"; and {len(found) - _SHOWN} more" if len(found) > _SHOWN else ""
        raise InputError(
            f"{len(found)} matches have {asked} ({first}{more}); give more words or its number"
        )
    return found[0]


def _having(lines: Sequence[str], words: Sequence[str]) -> list[int]:
    """Return which lines have all words; whole words first, parts of words if there is none."""
    texts = [plain(line) for line in lines]
    whole = [i for i, text in enumerate(texts) if set(words) <= set(text.split())]
    return whole or [i for i, text in enumerate(texts) if all(word in text for word in words)]


def _example(line: str) -> str:
    """Return words of a line that a person could type: its longest ones."""
    words = [word for word in plain(line).split() if not word.isdigit()]
    return f"'{' '.join(words[:2])}'" if words else "the date"
