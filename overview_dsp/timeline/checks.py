"""Checks of single values, each failing with one line that names what, the value and the range."""

from __future__ import annotations

import contextlib
import math
import re
from collections.abc import Iterator
from datetime import datetime, timedelta

import numpy as np

from overview_dsp.errors import InputError
from overview_dsp.errors import shown as shown  # as `checks.shown` too

KIND_MAX_LENGTH = 64
"""Longest event kind, characters: a kind is a name a preset looks up, not a sentence."""

TIME_HINT = "times are finite seconds from 0 to the timeline's duration"
"""How an error line about a time ends."""

_KIND = re.compile(r"[a-z0-9_]+", re.ASCII)


@contextlib.contextmanager
def located(place: str) -> Iterator[None]:
    """Put `place` (with its own punctuation) before any InputError raised inside."""
    try:
        yield
    except InputError as error:
        what, _, fix = str(error).partition("\n")
        raise InputError(f"{place}{what}", fix) from error


def number(value: object, what: str, hint: str = "give a finite number") -> float:
    """Return `value` as a finite float.

    Parameters
    ----------
    value
        Any object; Python and numpy ints and floats pass, booleans and text don't.
    what
        The name the error line begins with.
    hint
        What is allowed and what to try, the end of the error line.

    Raises
    ------
    InputError
        Not a number, NaN, infinite or beyond the range of a float.
    """
    if type(value) is float and math.isfinite(value):
        return value  # nearly always
    if isinstance(value, bool) or not isinstance(value, int | float | np.integer | np.floating):
        raise InputError(f"{what} is {shown(value)}, not a number; {hint}")
    try:
        result = float(value)
    except OverflowError:
        result = math.inf
    if not math.isfinite(result):
        raise InputError(f"{what} is {result!r}, not a finite number; {hint}")
    return result


def positive(value: object, what: str, hint: str = "give a finite number above 0") -> float:
    """Return `value` as a finite float above 0 (errors as `number`)."""
    result = number(value, what, hint)
    if result <= 0.0:
        raise InputError(f"{what} is {result!r}, not above 0; {hint}")
    return result


def text(value: object, what: str) -> str:
    """Return `value` if it is text that can be written to a file; InputError otherwise."""
    if not isinstance(value, str):
        raise InputError(f"{what} is {shown(value)}, not text; give a string")
    try:
        value.encode()
    except UnicodeEncodeError as error:
        raise InputError(
            f"{what} holds half a character (a lone surrogate) at position {error.start}: "
            f"{shown(value)}; write valid Unicode text"
        ) from error
    return value


def kind(value: object, what: str = "kind") -> str:
    """Return `value` if it is an event kind: 1 to 64 of a-z, 0-9 and _; InputError otherwise."""
    if isinstance(value, str) and _KIND.fullmatch(value) and len(value) <= KIND_MAX_LENGTH:
        return value
    tried = re.sub(r"[^a-z0-9]+", "_", value.lower()).strip("_") if isinstance(value, str) else ""
    example = tried[:KIND_MAX_LENGTH] or "goal"
    raise InputError(
        f"{what} is {shown(value)}; a kind is 1 to {KIND_MAX_LENGTH} characters of a-z, 0-9 and _; "
        f"try '{example}'"
    )


def moment(value: object, duration_s: float, what: str = "start") -> None:
    """Refuse a start that is no calendar moment or whose end lies outside the calendar."""
    if value is None:
        return
    if not isinstance(value, datetime):
        raise InputError(f"{what} is {shown(value)}, not a date and time; give one or leave it out")
    try:
        value + timedelta(seconds=duration_s)
    except OverflowError as error:
        raise InputError(
            f"{what} {value.isoformat()} and {duration_s!r} s end after the year 9999; "
            "leave the start out"
        ) from error


def until(value: object, duration_s: float) -> float | None:
    """Return up to where a timeline has happened, s; None for the whole; InputError otherwise."""
    if value is None:
        return None
    hint = f"it is up to where the timeline has happened, 0 to duration_s ({duration_s!r})"
    result = number(value, "until_s", hint)
    if not 0.0 <= result <= duration_s:
        raise InputError(f"until_s is {result!r}; {hint}")
    return result if result < duration_s else None
