"""An intensity curve over time."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from overview_dsp.errors import InputError
from overview_dsp.timeline import checks

MAX_VALUE = 1e300
"""Largest magnitude of an intensity value: the difference of any two stays finite."""

EXTREMES = (0.0, 100.0)
"""Percentiles of the smallest and the largest value."""


@dataclass(frozen=True, eq=False)
class Intensity:
    """A curve over time, straight between its points; a single point is a constant.

    Parameters
    ----------
    time_s
        Seconds, shape (n,), n >= 1, finite, >= 0, strictly increasing.
    value
        Shape (n,), finite, magnitude up to 1e300, in any unit.
    unit
        What the values are, for a person.
    percentiles
        Which percentiles of the values become 0 and 1 when the curve is scaled, 0 <= low < high
        <= 100; values beyond them are clipped there, and only there.

    Both arrays are copied to float64 and made read-only.

    Raises
    ------
    InputError
        Anything else; the line names the first bad place (`intensity.time_s[5]`).
    """

    time_s: NDArray[np.float64]
    value: NDArray[np.float64]
    unit: str = ""
    percentiles: tuple[float, float] = EXTREMES

    def __post_init__(self) -> None:
        time_s = _points(self.time_s, "intensity.time_s")
        value = _points(self.value, "intensity.value")
        checks.text(self.unit, "intensity.unit")
        if len(time_s) != len(value):
            raise InputError(
                f"intensity.time_s has {len(time_s)} points and intensity.value {len(value)}; "
                "give one value for each time"
            )
        if len(time_s) == 0:
            raise InputError(
                "intensity has no points; give two or more, or one for a constant, "
                "or leave the intensity out"
            )
        if time_s[0] < 0.0:
            raise InputError(
                f"intensity.time_s[0] is {float(time_s[0])!r}, before the start; {checks.TIME_HINT}"
            )
        stuck = np.flatnonzero(time_s[1:] <= time_s[:-1])
        if stuck.size:
            i = int(stuck[0]) + 1
            raise InputError(
                f"intensity.time_s[{i}] is {float(time_s[i])!r}, not after the point before it "
                f"({float(time_s[i - 1])!r}); times must increase strictly: sort them and merge "
                "points of the same time"
            )
        wild = np.flatnonzero(np.abs(value) > MAX_VALUE)
        if wild.size:
            i = int(wild[0])
            raise InputError(
                f"intensity.value[{i}] is {float(value[i])!r}; values reach from -{MAX_VALUE:g} "
                f"to {MAX_VALUE:g}: choose a larger unit"
            )
        object.__setattr__(self, "percentiles", _percentiles(self.percentiles))
        object.__setattr__(self, "time_s", time_s)
        object.__setattr__(self, "value", value)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Intensity):
            return NotImplemented
        return (
            self.unit == other.unit
            and self.percentiles == other.percentiles
            and np.array_equal(self.time_s, other.time_s)
            and np.array_equal(self.value, other.value)
        )

    def __hash__(self) -> int:
        # "+ 0.0": minus zero equals zero but has other bytes
        return hash((self.unit, (self.time_s + 0.0).tobytes(), (self.value + 0.0).tobytes()))

    @property
    def is_constant(self) -> bool:
        """True for a curve of one point, which has that value at all times."""
        return len(self.time_s) == 1

    def at(self, times: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the values at `times`, shape (n,): straight between points, exact at them.

        0 before the first point, after the last and for NaN; a constant everywhere.
        """
        if self.is_constant:
            return np.full(times.shape, self.value[0])
        return _interpolate(self.time_s, self.value, times)

    def cut(self, start: float, end: float) -> Intensity | None:
        """Return the part between two times on an axis that begins at `start`; None if it's empty.

        The ends are interpolated, so that the part has the same value at the same moment.
        """
        if self.is_constant:
            return replace(self, time_s=np.zeros(1))
        low, high = max(start, float(self.time_s[0])), min(end, float(self.time_s[-1]))
        if low >= high:  # a single shared point would turn into a constant
            return None
        inner = self.time_s[(self.time_s > low) & (self.time_s < high)]
        times = np.concatenate(([low], inner, [high]))
        shifted = times - start
        # two times one unit in the last place apart may round to the same
        apart = np.diff(shifted, prepend=-1.0) > 0.0
        return replace(self, time_s=shifted[apart], value=self.at(times)[apart])

    def scale(self, known: NDArray[np.bool_]) -> tuple[float, float]:
        """Return the values that become 0 and 1: the percentiles of the points marked as known.

        Where those are equal (more than half of a rainfall is 0), the smallest and the largest.
        """
        value = self.value[known] if known.any() else self.value
        low, high = (float(edge) for edge in np.percentile(value, self.percentiles))
        return (low, high) if low < high else (float(value.min()), float(value.max()))


def _percentiles(given: object) -> tuple[float, float]:
    hint = "give two percentiles, 0 <= low < high <= 100"
    if not isinstance(given, tuple | list) or len(given) != 2:
        raise InputError(f"intensity.percentiles is {checks.shown(given)}; {hint}")
    low, high = (checks.number(edge, "intensity.percentiles", hint) for edge in given)
    if not 0.0 <= low < high <= 100.0:
        raise InputError(f"intensity.percentiles is ({low!r}, {high!r}); {hint}")
    return low, high


def _points(values: object, what: str) -> NDArray[np.float64]:
    """Return a read-only float64 copy of one row of finite numbers."""
    try:
        given = np.asarray(values)
    except ValueError as error:  # rows of unequal length
        raise InputError(f"{what} isn't one row of numbers; give a flat list") from error
    if given.ndim != 1 or (given.dtype.kind not in "iuf" and given.size):
        raise InputError(
            f"{what} isn't one row of numbers (shape {given.shape}, {given.dtype}); "
            "give a flat list of numbers"
        )
    points: NDArray[np.float64] = given.astype(np.float64)  # a copy, and ours
    bad = np.flatnonzero(~np.isfinite(points))
    if bad.size:
        i = int(bad[0])
        raise InputError(
            f"{what}[{i}] is {float(points[i])!r}, not a finite number; leave the point out and "
            "give missing data as a gap"
        )
    points.setflags(write=False)
    return points


def _interpolate(
    time_s: NDArray[np.float64], value: NDArray[np.float64], at: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Interpolate between two or more points; 0 outside them.

    A weighted mean of the two neighbours instead of `numpy.interp`'s slope: the slope of two
    points a hair apart overflows to infinity, a weight in [0, 1] can't.
    """
    inside = (at >= time_s[0]) & (at <= time_s[-1])
    result = np.zeros(at.shape, dtype=np.float64)
    t = at[inside]
    right = np.clip(np.searchsorted(time_s, t, side="right"), 1, len(time_s) - 1)
    left = right - 1
    weight = (t - time_s[left]) / (time_s[right] - time_s[left])
    low = np.minimum(value[left], value[right])
    high = np.maximum(value[left], value[right])
    # clipped: rounding may take the mean past its ends by one unit in the last place
    result[inside] = np.clip(value[left] * (1.0 - weight) + value[right] * weight, low, high)
    return result
