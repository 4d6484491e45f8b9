"""Checks of a curve's points: one row of finite numbers, times that increase, percentiles."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from overview_dsp import validation
from overview_dsp.data.timeline.minmax_pyramid import Values
from overview_dsp.errors import InputError, shown

MAX_VALUE = 1e300
"""Largest magnitude of an intensity value: the difference of any two stays finite."""


def require_increasing(
    time_s: NDArray[np.float64], first: int = 0, before: float | None = None
) -> None:
    """Refuse times (s, points `first` ...) that are negative or don't increase strictly."""
    if before is None and len(time_s) and time_s[0] < 0.0:
        raise InputError(
            f"intensity.time_s[{first}] is {float(time_s[0])!r}, before the start; "
            f"{validation.TIME_HINT}"
        )
    earlier = time_s[:-1] if before is None else np.concatenate(([before], time_s[:-1]))
    later = time_s[1:] if before is None else time_s
    stuck = np.flatnonzero(later <= earlier)
    if stuck.size:
        i = int(stuck[0])
        raise InputError(
            f"intensity.time_s[{first + i + (before is None)}] is {float(later[i])!r}, not after "
            f"the point before it ({float(earlier[i])!r}); times must increase strictly: sort them "
            "and merge points of the same time"
        )


def require_values(value: Values, first: int = 0) -> None:
    """Refuse values (points `first` ...) that are not finite or too large."""
    if not len(value) or max(-float(value.min()), float(value.max())) <= MAX_VALUE:
        return  # NaN isn't less or equal either
    for i in np.flatnonzero(~(np.abs(value.astype(np.float64)) <= MAX_VALUE)):
        raise InputError(
            f"intensity.value[{first + i}] is {float(value[i])!r}; values reach from "
            f"-{MAX_VALUE:g} to {MAX_VALUE:g}: choose a larger unit"
            if np.isfinite(value[i])
            else f"intensity.value[{first + i}] is {float(value[i])!r}, {_NOT_FINITE}"
        )


_NOT_FINITE = "not a finite number; leave the point out and give missing data as a gap"


def checked_percentiles(given: object) -> tuple[float, float]:
    """Return two percentiles, or refuse what is none."""
    hint = "give two percentiles, 0 <= low < high <= 100"
    if not isinstance(given, tuple | list) or len(given) != 2:
        raise InputError(f"intensity.percentiles is {shown(given)}; {hint}")
    low, high = (validation.number(edge, "intensity.percentiles", hint) for edge in given)
    if not 0.0 <= low < high <= 100.0:
        raise InputError(f"intensity.percentiles is ({low!r}, {high!r}); {hint}")
    return low, high


def _row(values: object, what: str) -> NDArray[np.generic]:
    """Return one row of numbers of any kind as an array."""
    try:
        given = np.asanyarray(values)  # a memory map stays one
    except ValueError as error:  # rows of unequal length
        raise InputError(f"{what} isn't one row of numbers; give a flat list") from error
    if given.ndim != 1 or (given.dtype.kind not in "iuf" and given.size):
        raise InputError(
            f"{what} isn't one row of numbers (shape {given.shape}, {given.dtype}); "
            "give a flat list of numbers"
        )
    return given


def as_given(values: object, what: str) -> Values:
    """Return a read-only view of one row of float32 or float64; others as float64."""
    given = _row(values, what)
    keeps = given.dtype in (np.float32, np.float64)
    kept: Values = np.asanyarray(given, None if keeps else np.float64).view()
    kept.setflags(write=False)
    return kept


def float_points(values: object, what: str) -> NDArray[np.float64]:
    """Return a read-only float64 copy of one row of finite numbers."""
    points: NDArray[np.float64] = np.array(_row(values, what), dtype=np.float64)  # ours
    bad = np.flatnonzero(~np.isfinite(points))
    if bad.size:
        i = int(bad[0])
        raise InputError(f"{what}[{i}] is {float(points[i])!r}, {_NOT_FINITE}")
    points.setflags(write=False)
    return points
