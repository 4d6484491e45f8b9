"""The points of a curve, however many: checked, found by time, interpolated, taken in runs."""

from __future__ import annotations

import mmap
from dataclasses import dataclass
from functools import cached_property
from typing import Any, overload

import numpy as np
from numpy.typing import DTypeLike, NDArray

from overview_dsp import validation
from overview_dsp.data.timeline.minmax_pyramid import Level, Values, build_pyramid
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


@dataclass(frozen=True)
class RegularTimes:
    """The times first_s + i * step_s, i = 0 ... count - 1, read like a float64 array.

    Parameters
    ----------
    count : int
        How many, at least 1.
    step_s : float
        Seconds from one to the next, > 0.
    first_s : float
        The first one, s, >= 0.

    Raises
    ------
    InputError
        A count below 1, a step that isn't above 0, a start below 0, or times too far from 0 to
        be distinguished.

    Examples
    --------
    >>> times = ov.RegularTimes(count=7200, step_s=0.5)
    >>> curve = ov.Intensity(times, np.zeros(7200, dtype=np.float32))
    >>> curve.last_s
    3599.5
    """

    count: int
    step_s: float
    first_s: float = 0.0

    def __post_init__(self) -> None:
        if not 1 <= validation.whole(self.count, "count") < 2**53:
            raise InputError("intensity has no points, or too many to count; give one or more")
        validation.positive(self.step_s, "step_s", "give the seconds from one value to the next")
        if validation.number(self.first_s, "first_s", validation.TIME_HINT) < 0.0:
            raise InputError(
                f"first_s is {self.first_s!r}, before the start; {validation.TIME_HINT}"
            )
        if not np.isfinite(self[-1]) or (self.count > 1 and self[-2] >= self[-1]):
            raise InputError(
                f"{self.count} values {self.step_s!r} s apart lie too close together to be "
                "distinguished; count them from 0"
            )

    def __len__(self) -> int:
        return self.count

    @overload
    def __getitem__(self, index: int) -> float: ...
    @overload
    def __getitem__(self, index: slice) -> NDArray[np.float64]: ...
    def __getitem__(self, index: int | slice) -> float | NDArray[np.float64]:
        if isinstance(index, slice):
            return self.at(np.arange(*index.indices(self.count)))
        place = range(self.count)[index]
        return self.first_s + place * self.step_s

    def __array__(
        self, dtype: DTypeLike | None = None, copy: bool | None = None
    ) -> NDArray[np.float64]:
        every = self.at(np.arange(self.count))
        return every if dtype is None else every.astype(dtype)

    def tolist(self) -> list[float]:
        """List all of them.

        Returns
        -------
        list of float
            Seconds.

        Examples
        --------
        >>> times = ov.RegularTimes(count=3, step_s=0.5)
        >>> times.tolist()
        [0.0, 0.5, 1.0]
        """
        every: list[float] = self[:].tolist()
        return every

    def at(self, index: NDArray[np.int64]) -> NDArray[np.float64]:
        """Look up the times of some indices.

        Parameters
        ----------
        index : int64 (n,)
            From 0.

        Returns
        -------
        float64 (n,)
            Seconds.

        Examples
        --------
        >>> times = ov.RegularTimes(count=3, step_s=0.5)
        >>> times.at(np.array([2]))
        array([1.])
        """
        times = index.astype(np.float64)
        times *= self.step_s
        times += self.first_s
        return times

    def first_from(self, times: NDArray[np.float64]) -> NDArray[np.int64]:
        """Find the first index whose time is at or after each of some times.

        Parameters
        ----------
        times : float64 (n,)
            Seconds.

        Returns
        -------
        int64 (n,)
            Up to `count`.

        Examples
        --------
        >>> times = ov.RegularTimes(count=3, step_s=0.5)
        >>> times.first_from(np.array([0.5, 0.6]))
        array([1, 2])
        """
        guess = (times - self.first_s) / self.step_s
        np.ceil(np.clip(guess, 0.0, float(self.count), out=guess), out=guess)
        index = guess.astype(np.int64)
        # rounding may have put it one off
        index -= (self.at(index - 1) >= times) & (index > 0)
        index += (self.at(index) < times) & (index < self.count)
        return index

    def first_after(self, times: NDArray[np.float64]) -> NDArray[np.int64]:
        """Find the first index whose time is after each of some times.

        Parameters
        ----------
        times : float64 (n,)
            Seconds.

        Returns
        -------
        int64 (n,)
            Up to `count`.

        Examples
        --------
        >>> times = ov.RegularTimes(count=3, step_s=0.5)
        >>> times.first_after(np.array([0.5, 0.6]))
        array([2, 2])
        """
        index = self.first_from(times)
        index += (index < self.count) & (self.at(index) <= times)
        return index


Times = NDArray[np.float64] | RegularTimes

PARTS = 64
"""So many parts of a long curve are looked at one after another."""

_SHORT_RUN = 24
"""Runs of up to so many values are looked at by vectors that reach over many of them."""

_AT_A_TIME = 4096
"""Runs looked at together, whose values stay in a processor's cache."""

_LONG_RUN = 12
"""From so many values a run on, looking at them twice is quicker than turning their bits about."""

_DIRECT = 1 << 17
"""Up to so many values are looked at one by one."""


@dataclass(frozen=True, eq=False)
class Points:
    """Two or more points, checked: times increase strictly, values are finite."""

    time_s: Times
    value: Values

    @cached_property
    def levels(self) -> tuple[Level, ...]:
        """The pyramid of the values, built when first asked for."""
        return build_pyramid(self.value)

    def first_from(self, times: NDArray[np.float64]) -> NDArray[np.int64]:
        """Return the first index whose time is at or after each of `times` (up to the count)."""
        if isinstance(self.time_s, RegularTimes):
            return self.time_s.first_from(times)
        return np.searchsorted(self.time_s, times, side="left")

    def first_after(self, times: NDArray[np.float64]) -> NDArray[np.int64]:
        """Return the first index whose time is after each of `times` (up to the count)."""
        if isinstance(self.time_s, RegularTimes):
            return self.time_s.first_after(times)
        return np.searchsorted(self.time_s, times, side="right")

    def times_of(self, index: NDArray[np.int64]) -> NDArray[np.float64]:
        """Return the times of some indices."""
        if isinstance(self.time_s, RegularTimes):
            return self.time_s.at(index)
        return self.time_s[index]

    def interpolate(
        self, times: NDArray[np.float64], after: NDArray[np.int64] | None = None
    ) -> NDArray[np.float64]:
        """Return the values at times from the first point to the last: straight between points.

        `after` is `first_after(times)`, if that is known already.

        A weighted mean of the two neighbours instead of `numpy.interp`'s slope: the slope of two
        points a hair apart overflows to infinity, a weight in [0, 1] can't.
        """
        after = self.first_after(times) if after is None else after
        right = np.clip(after, 1, len(self.time_s) - 1)
        left = right - 1
        left_s = self.times_of(left)
        weight = (times - left_s) / (self.times_of(right) - left_s)
        before = self.value[left].astype(np.float64)
        behind = self.value[right].astype(np.float64)
        low, high = np.minimum(before, behind), np.maximum(before, behind)
        # clipped: rounding may take the mean past its ends by one unit in the last place
        return np.clip(before * (1.0 - weight) + behind * weight, low, high)

    def picked(self, index: NDArray[np.int64]) -> NDArray[np.float64]:
        """Return the values of ascending indices; of values on disk little is kept in memory."""
        found = np.empty(len(index))
        for some in np.array_split(np.arange(len(index)), PARTS):
            found[some] = self.value[index[some]]
            if isinstance(self.value, np.memmap):
                _forget(self.value)
        return found

    def extremes(self, first: NDArray[np.int64], stop: NDArray[np.int64]) -> tuple[float, float]:
        """Return the smallest and the largest value of stretches first[i] to stop[i] - 1.

        Stretches, one or more, ascend, are disjoint and not empty.
        """
        count = int((stop - first).sum())
        # look at few values one by one (two parts of a bin a stretch), and at few bins
        level = min(
            self.levels if count > _DIRECT else (),
            key=lambda one: count / one.width + 2 * len(first) * one.width,
            default=None,
        )
        if level is None:
            values = self.value[_every(first, stop)]
            return float(values.min()), float(values.max())
        low_bin, high_bin = -(-first // level.width), stop // level.width
        whole = low_bin < high_bin
        left_stop = np.where(whole, low_bin * level.width, stop)
        right_first = np.where(whole, high_bin * level.width, stop)
        ends = self.value[np.concatenate((_every(first, left_stop), _every(right_first, stop)))]
        low, high = float(ends.min(initial=np.inf)), float(ends.max(initial=-np.inf))
        if whole.any():
            edges = np.column_stack((low_bin[whole], high_bin[whole])).ravel()
            edges = edges[: len(edges) - (edges[-1] == len(level.low))]
            low = min(low, float(np.minimum.reduceat(level.low, edges)[::2].min()))
            high = max(high, float(np.maximum.reduceat(level.high, edges)[::2].max()))
        return low, high

    def runs(self, edges: NDArray[np.int64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return the mean and the largest of the values of each run edges[i] to edges[i + 1] - 1.

        Edges, shape (n + 1,), ascend. The ends of long runs are rounded to bins of at most half a
        run's average length; an empty run has its next neighbour's value.
        """
        (mean, high), starts = self._bins(edges, ("mean", "high"))
        ends = np.append(starts[1:], len(mean))
        total, largest = np.empty((2, len(starts)))
        for first in range(0, len(starts), _AT_A_TIME):
            some = slice(first, first + _AT_A_TIME)
            begin, end = int(starts[first]), max(int(ends[some][-1]), int(starts[some][-1]) + 1)
            at = starts[some] - begin
            total[some] = np.add.reduceat(mean[begin:end], at)
            largest[some] = _largest(high[begin:end], at)
        return total / np.maximum(ends - starts, 1), largest

    def lows(self, edges: NDArray[np.int64]) -> NDArray[np.float64]:
        """Return the smallest of the values of each run; edges as `runs`."""
        (low,), starts = self._bins(edges, ("low",))
        return np.minimum.reduceat(low, starts).astype(np.float64)

    def _bins(
        self, edges: NDArray[np.int64], names: tuple[str, ...]
    ) -> tuple[list[Values], NDArray[np.int64]]:
        """Rows of a level, or the values themselves, and where in them each run begins."""
        first, stop = int(edges[0]), int(edges[-1])
        wanted = (stop - first) / (len(edges) - 1) / 2.0
        level = next((one for one in reversed(self.levels) if one.width <= wanted), None)
        if level is None:
            rows = [np.asarray(self.value[first:stop])] * len(names)
            at = edges - first
        else:
            at = np.round(edges / level.width).astype(np.int64)
            begin, end = int(at[0]), max(int(at[-1]), int(at[0]) + 1)
            rows = [np.asarray(getattr(level, name)[begin:end]) for name in names]
            at -= begin
        return rows, np.minimum(at[:-1], len(rows[0]) - 1)


def _largest(row: Values, starts: NDArray[np.int64]) -> Values:
    """Return what `np.maximum.reduceat` does, which sets up its vectors anew for each short run.

    A surface asks for 65 537 runs. Short ones of about one length are the larger of two spans that
    overlap; of longer ones the floats' bits are compared as whole numbers. The bits are in the
    floats' order from 0 up, and in the reverse one below: few are turned about, of many those runs
    are taken that have no other.
    """
    ends = np.append(starts[1:], len(row))
    lengths = ends - starts
    least, most = int(lengths.min()), int(lengths.max())
    span = 1 << (least.bit_length() - 1) if least > 0 else 0
    if most <= min(2 * span, _SHORT_RUN):
        return _of_two_spans(row, starts, ends, span)
    bits = row.view(np.dtype(f"i{row.dtype.itemsize}"))
    if len(row) < _LONG_RUN * len(starts):
        return _ordered(np.maximum.reduceat(_ordered(bits), starts)).view(row.dtype)
    largest = np.maximum.reduceat(bits, starts)
    below = largest < 0
    if below.any():
        largest = np.where(below, np.minimum.reduceat(bits, starts), largest)
    return largest.view(row.dtype)


def _of_two_spans(
    row: Values, starts: NDArray[np.int64], ends: NDArray[np.int64], span: int
) -> Values:
    """The largest of runs of `span` to 2 * `span` values; `span` is a power of two."""
    width = 1
    while width < span:  # the largest of `width` values from each on
        row = np.maximum(row[:-width], row[width:])
        width *= 2
    return np.maximum(row[starts], row[ends - span])


def _ordered(bits: NDArray[Any]) -> NDArray[Any]:
    """Turn the bits of floats into whole numbers of the same order, and back."""
    kind = np.iinfo(bits.dtype)
    flipped = bits >> (kind.bits - 1)
    flipped &= kind.max
    flipped ^= bits
    return flipped


def _every(first: NDArray[np.int64], stop: NDArray[np.int64]) -> NDArray[np.int64]:
    """The indices of stretches first[i] to stop[i] - 1, one after the other."""
    lengths = stop - first
    begins = np.cumsum(lengths) - lengths
    index: NDArray[np.int64] = np.arange(int(lengths.sum())) + np.repeat(first - begins, lengths)
    return index


def _forget(values: NDArray[np.floating[Any]]) -> None:
    """Let go of the pages of a file that were mapped: the system reads some around each one."""
    base: Any = values
    while isinstance(base, np.ndarray):
        base = base.base
    if isinstance(base, mmap.mmap) and hasattr(mmap, "MADV_DONTNEED"):
        base.madvise(mmap.MADV_DONTNEED)
