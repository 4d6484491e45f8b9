"""What a program gives to a public function: of the right kind, or a line that says so.

Ranges are for each function to check; these refuse what would end in another library's error.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from overview_dsp.errors import InputError, shown

T = TypeVar("T")


def instance(value: object, kind: type[T], what: str, hint: str) -> T:
    """Return `value` if it is of a kind; InputError with the hint if not."""
    if not isinstance(value, kind):
        raise InputError(f"{what} is {shown(value)}, not a {kind.__name__}; {hint}")
    return value


def instances(values: object, kind: type[T], what: str, hint: str) -> list[T]:
    """Return several of a kind as a list; InputError names the first that isn't one."""
    if isinstance(values, str | bytes | Mapping) or not isinstance(values, Iterable):
        raise InputError(f"{what} is {shown(values)}; give a list, and {hint}")
    return [instance(value, kind, f"{what}[{i}]", hint) for i, value in enumerate(values)]


def real(value: object, what: str) -> float:
    """Return a number as a float: NaN and infinities too, which fail where a range is checked."""
    if not isinstance(value, int | float | np.integer | np.floating):
        raise InputError(f"{what} is {shown(value)}, not a number; give one")
    try:
        return float(value)
    except OverflowError:  # an int of hundreds of digits
        return float("inf")


def above_zero(value: object, what: str) -> float:
    """Return a finite number above 0 as a float; InputError for any other."""
    found = real(value, what)
    if not 0.0 < found < float("inf"):
        raise InputError(f"{what} is {found:g}; it is a finite number above 0")
    return found


def whole(value: object, what: str, least: int | None = None, most: int | None = None) -> int:
    """Return a whole number as an int; InputError for another kind, or one out of a range."""
    if not isinstance(value, int | np.integer):
        raise InputError(f"{what} is {shown(value)}; give a whole number")
    if (least is not None and value < least) or (most is not None and value > most):
        up = "up" if most is None else f"to {most}"
        raise InputError(f"{what} is {shown(value)}; it is a whole number from {least} {up}")
    return int(value)


def path(value: object, what: str) -> Path:
    """Return a path; InputError if it is none."""
    if not isinstance(value, str | os.PathLike):
        raise InputError(f"{what} is {shown(value)}; give a path")
    return Path(value)


def numbers(value: object, what: str) -> NDArray[np.float64]:
    """Return numbers as float64 of any shape; InputError for what holds others."""
    try:
        found = np.asarray(value)
    except ValueError:  # rows of different lengths
        found = np.array(None)
    if not (found.dtype.kind in "biuf" or found.size == 0):
        raise InputError(f"{what} is {shown(value)}; give numbers")
    return found.astype(np.float64)


def floats(value: object, what: str) -> NDArray[np.float64]:
    """Return a row of numbers as float64 (n,); InputError for another shape or no numbers."""
    found = numbers(value, what)
    if found.ndim != 1:
        raise InputError(f"{what} has {found.ndim} dimensions; give a row of numbers, (n,)")
    return found


def equally_long(what: str, *rows: Sequence[Any] | NDArray[Any]) -> None:
    """InputError unless these rows have as many values."""
    if len({len(row) for row in rows}) > 1:
        lengths = ", ".join(str(len(row)) for row in rows)
        raise InputError(f"{what} must be equally long; they have {lengths} values")


def random(seed: object) -> np.random.Generator:
    """Return the random numbers of a seed, a whole number from 0 up; InputError for any other."""
    return np.random.default_rng(whole(seed, "seed", 0))
