"""Argument checks: each returns the value, or raises an error with its name and range."""

from __future__ import annotations

import contextlib
import math
import os
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from datetime import datetime, timedelta
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from overview_dsp.arrays import FloatArray
from overview_dsp.errors import InputError, quoted

KIND_MAX_LENGTH = 64  # maximum length of an event kind, characters

TIME_HINT = "times are finite seconds from 0 to the timeline's duration"
"""End of an error message about a time."""

T = TypeVar("T")

_KIND = re.compile(r"[a-z0-9_]+", re.ASCII)


@contextlib.contextmanager
def prefix_errors(location: str) -> Iterator[None]:
    """Prefix the message of any InputError raised inside with a location and its punctuation."""
    try:
        yield
    except InputError as error:
        what, _, fix = str(error).partition("\n")
        error.args = InputError(f"{location}{what}", fix).args
        raise


@contextlib.contextmanager
def only_input_errors(problem: str) -> Iterator[None]:
    """Convert errors of wrong data raised inside to an InputError that begins with `problem`."""
    try:
        yield
    except InputError:
        raise
    except (ValueError, OverflowError, RecursionError) as error:
        raise InputError(f"{problem}: {error}") from None
    except (KeyError, TypeError, AttributeError) as error:
        raise InputError(f"{problem}: {type(error).__name__} {error}") from None


def number(value: object, what: str, hint: str = "give a finite number") -> float:
    """Return an int or float of Python or numpy as a finite float.

    InputError begins with `what`, the name of the value, and ends with `hint`, the allowed values.
    """
    if type(value) is float and math.isfinite(value):
        return value  # the usual case
    if isinstance(value, bool) or not isinstance(value, int | float | np.integer | np.floating):
        raise InputError(f"{what} is {quoted(value)}, not a number; {hint}")
    try:
        result = float(value)
    except OverflowError:
        result = math.inf
    if not math.isfinite(result):
        raise InputError(f"{what} is {result!r}, not a finite number; {hint}")
    return result


def float_or_nan(word: str) -> float:
    """Return the number that a text holds; NaN for any other text."""
    try:
        return float(word)
    except ValueError:
        return math.nan


def positive(value: object, what: str, hint: str = "give a finite number above 0") -> float:
    """Return `value` as a finite float above 0 (errors as `number`)."""
    result = number(value, what, hint)
    if result <= 0.0:
        raise InputError(f"{what} is {result!r}, not above 0; {hint}")
    return result


def text(value: object, what: str) -> str:
    """Return `value` if it is text that can be encoded as UTF-8; InputError otherwise."""
    if not isinstance(value, str):
        raise InputError(f"{what} is {quoted(value)}, not text; give a string")
    try:
        value.encode()
    except UnicodeEncodeError as error:
        raise InputError(
            f"{what} has a lone surrogate at position {error.start}: {quoted(value)}; "
            "must be valid Unicode text"
        ) from error
    return value


def kind(value: object, what: str = "kind") -> str:
    """Return `value` if it is an event kind: 1 to 64 of a-z, 0-9 and _; InputError otherwise."""
    if isinstance(value, str) and _KIND.fullmatch(value) and len(value) <= KIND_MAX_LENGTH:
        return value
    tried = re.sub(r"[^a-z0-9]+", "_", value.lower()).strip("_") if isinstance(value, str) else ""
    example = tried[:KIND_MAX_LENGTH] or "goal"
    raise InputError(
        f"{what} is {quoted(value)}; a kind is 1 to {KIND_MAX_LENGTH} characters of a-z, 0-9 "
        f"and _; try '{example}'"
    )


def moment(value: object, duration_s: float, what: str = "start") -> None:
    """Check that a start is a date and time, and that its end is a valid date."""
    if value is None:
        return
    if not isinstance(value, datetime):
        raise InputError(
            f"{what} is {quoted(value)}, not a date and time; give one or leave it out"
        )
    try:
        value + timedelta(seconds=duration_s)
    except OverflowError as error:
        raise InputError(
            f"{what} {value.isoformat()} and {duration_s!r} s end after the year 9999; "
            "leave the start out"
        ) from error


def until(value: object, duration_s: float) -> float | None:
    """Return the time until which a timeline is known, s; None for all of it; InputError."""
    if value is None:
        return None
    hint = f"must be from 0 to duration_s ({duration_s!r})"
    result = number(value, "known_until_s", hint)
    if not 0.0 <= result <= duration_s:
        raise InputError(f"known_until_s is {result!r}; {hint}")
    return result if result < duration_s else None


def instance(value: object, kind: type[T], what: str, hint: str) -> T:
    """Return `value` if it is an instance of `kind`; InputError with the hint otherwise."""
    if not isinstance(value, kind):
        raise InputError(f"{what} is {quoted(value)}, not a {kind.__name__}; {hint}")
    return value


def of_type(value: object, kind: type[T], what: str, allowed: str) -> T:
    """Return a value of a document if it has a type; InputError with the allowed ones otherwise."""
    if not isinstance(value, kind) or isinstance(value, bool):
        raise InputError(f"{what} is {quoted(value)}; must be {allowed}")
    return value


def instances(values: object, kind: type[T], what: str, hint: str) -> list[T]:
    """Return instances of `kind` as a list; InputError names the first other value."""
    if isinstance(values, str | bytes | Mapping) or not isinstance(values, Iterable):
        raise InputError(f"{what} is {quoted(values)}; give a list, and {hint}")
    return [instance(value, kind, f"{what}[{i}]", hint) for i, value in enumerate(values)]


def real(value: object, what: str) -> float:
    """Return a number as a float; NaN and infinities are allowed, for a later range check."""
    if not isinstance(value, int | float | np.integer | np.floating):
        raise InputError(f"{what} is {quoted(value)}, not a number; give one")
    try:
        return float(value)
    except OverflowError:  # an int with hundreds of digits
        return float("inf")


def within(
    value: object, what: str, low: float, high: float, unit: str = "", end: str | None = None
) -> float:
    """Return a number from `low` to `high` as a float; InputError names the range and its unit.

    `end`: text after the range instead of its unit.
    """
    result = real(value, what)
    if not low <= result <= high:  # NaN too
        allowed = f"must be {low:g} to {high:g}{unit if end is None else end}"
        raise InputError(f"{what} is {result:g}{unit}; {allowed}")
    return result


def whole(value: object, what: str, least: int | None = None, most: int | None = None) -> int:
    """Return a whole number as an int; InputError for another type, or out of range."""
    if not isinstance(value, int | np.integer):
        raise InputError(f"{what} is {quoted(value)}; give a whole number")
    if (least is not None and value < least) or (most is not None and value > most):
        up = "up" if most is None else f"to {most}"
        raise InputError(f"{what} is {quoted(value)}; must be a whole number from {least} {up}")
    return int(value)


def path(value: object, what: str) -> Path:
    """Return a path; InputError if `value` isn't a path."""
    if not isinstance(value, str | os.PathLike):
        raise InputError(f"{what} is {quoted(value)}; give a path")
    return Path(value)


def numbers(value: object, what: str) -> FloatArray:
    """Return numbers as a float64 array of any shape; InputError for other values."""
    try:
        found = np.asarray(value)
    except ValueError:  # rows of different lengths
        found = np.array(None)
    if not (found.dtype.kind in "biuf" or found.size == 0):
        raise InputError(f"{what} is {quoted(value)}; give numbers")
    return found.astype(np.float64)


def floats(value: object, what: str) -> FloatArray:
    """Return a row of numbers as float64 (n,); InputError for another shape or other values."""
    found = numbers(value, what)
    if found.ndim != 1:
        raise InputError(f"{what} has {found.ndim} dimensions; give a row of numbers, (n,)")
    return found


def block(value: object, what: str) -> tuple[int, int]:
    """Return frames and channels of a writable sample buffer; InputError for any other."""
    if (
        not isinstance(value, np.ndarray)
        or value.dtype != np.float32
        or value.ndim != 2
        or not value.flags.c_contiguous
        or not value.flags.writeable
    ):
        raise InputError(f"{what} must be a writable, C-ordered float32 array (frames, channels)")
    frames, channels = value.shape
    return frames, channels


def equally_long(what: str, *rows: Sequence[Any] | NDArray[Any]) -> None:
    """Check that rows have the same length; InputError otherwise."""
    if len({len(row) for row in rows}) > 1:
        lengths = ", ".join(str(len(row)) for row in rows)
        raise InputError(f"{what} must have the same length; they have {lengths} values")


def random(seed: object) -> np.random.Generator:
    """Return the random generator of a seed, a whole number from 0; InputError for any other."""
    return np.random.default_rng(whole(seed, "seed", 0))
