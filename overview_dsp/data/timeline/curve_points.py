"""Points of a curve: validation, search by time, interpolation, and statistics of runs."""

from __future__ import annotations

import mmap
from dataclasses import dataclass
from functools import cached_property
from typing import Any, overload

import numpy as np
from numpy.typing import DTypeLike, NDArray

from overview_dsp import validation
from overview_dsp.arrays import FloatArray, IntArray
from overview_dsp.data.timeline.minmax_pyramid import Level, Values, build_pyramid
from overview_dsp.errors import InputError, quoted

MAX_VALUE = 1e300  # maximum magnitude of a value, so that differences stay finite


def require_increasing(time_s: FloatArray, first: int = 0, before: float | None = None) -> None:
    """Raise InputError for times (from point `first` on) that are negative or not increasing."""
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
    """Raise InputError for values (from point `first` on) that are too large or not finite."""
    if not len(value) or max(-float(value.min()), float(value.max())) <= MAX_VALUE:
        return  # NaN fails this comparison, too
    for i in np.flatnonzero(~(np.abs(value.astype(np.float64)) <= MAX_VALUE)):
        raise InputError(
            f"intensity.value[{first + i}] is {float(value[i])!r}; values reach from "
            f"-{MAX_VALUE:g} to {MAX_VALUE:g}: choose a larger unit"
            if np.isfinite(value[i])
            else f"intensity.value[{first + i}] is {float(value[i])!r}, {_NOT_FINITE}"
        )


_NOT_FINITE = "not a finite number; leave the point out and give missing data as a gap"


def checked_percentiles(value: object) -> tuple[float, float]:
    """Return a pair of percentiles; InputError for other values."""
    hint = "give two percentiles, 0 <= low < high <= 100"
    if not isinstance(value, tuple | list) or len(value) != 2:
        raise InputError(f"intensity.percentiles is {quoted(value)}; {hint}")
    low, high = (validation.number(edge, "intensity.percentiles", hint) for edge in value)
    if not 0.0 <= low < high <= 100.0:
        raise InputError(f"intensity.percentiles is ({low!r}, {high!r}); {hint}")
    return low, high


def _row(values: object, what: str) -> NDArray[np.generic]:
    """Return one row of numbers as an array of any type."""
    try:
        row = np.asanyarray(values)  # a memory map stays one
    except ValueError as error:  # rows of unequal length
        raise InputError(f"{what} isn't one row of numbers; give a flat list") from error
    if row.ndim != 1 or (row.dtype.kind not in "iuf" and row.size):
        raise InputError(
            f"{what} isn't one row of numbers (shape {row.shape}, {row.dtype}); "
            "give a flat list of numbers"
        )
    return row


def read_only_view(values: object, what: str) -> Values:
    """Return a read-only view of one row of floats; other types become float64."""
    row = _row(values, what)
    keeps = row.dtype in (np.float32, np.float64)
    kept: Values = np.asanyarray(row, None if keeps else np.float64).view()
    kept.setflags(write=False)
    return kept


def float_points(values: object, what: str) -> FloatArray:
    """Return a read-only float64 copy of one row of finite numbers."""
    points: FloatArray = np.array(_row(values, what), dtype=np.float64)  # ours
    bad = np.flatnonzero(~np.isfinite(points))
    if bad.size:
        i = int(bad[0])
        raise InputError(f"{what}[{i}] is {float(points[i])!r}, {_NOT_FINITE}")
    points.setflags(write=False)
    return points


@dataclass(frozen=True)
class RegularTimes:
    """Evenly spaced times first_s + i * step_s, i = 0 ... count - 1, used like a float64 array.

    Parameters
    ----------
    count : int
        Number of times, at least 1.
    step_s : float
        Time between two of them, s, > 0.
    first_s : float
        First time, s, >= 0.

    Raises
    ------
    InputError
        A count below 1, a step that is not above 0, a start below 0, or times too far from 0 to
        be distinct.

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
                "distinguished; count the times from 0"
            )

    def __len__(self) -> int:
        return self.count

    @overload
    def __getitem__(self, index: int) -> float: ...
    @overload
    def __getitem__(self, index: slice) -> FloatArray: ...
    def __getitem__(self, index: int | slice) -> float | FloatArray:
        if isinstance(index, slice):
            return self.at(np.arange(*index.indices(self.count)))
        return self.first_s + range(self.count)[index] * self.step_s

    def __array__(self, dtype: DTypeLike | None = None, copy: bool | None = None) -> FloatArray:
        every = self.at(np.arange(self.count))
        return every if dtype is None else every.astype(dtype)

    def tolist(self) -> list[float]:
        """Return all times as a list.

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
        return list(self[:].tolist())

    def at(self, index: IntArray) -> FloatArray:
        """Return the times of indices.

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

    def first_from(self, times: FloatArray) -> IntArray:
        """Return the first index at or after each of the given times.

        Parameters
        ----------
        times : float64 (n,)
            Seconds.

        Returns
        -------
        int64 (n,)
            Indices, up to `count`.

        Examples
        --------
        >>> times = ov.RegularTimes(count=3, step_s=0.5)
        >>> times.first_from(np.array([0.5, 0.6]))
        array([1, 2])
        """
        guess = (times - self.first_s) / self.step_s
        np.ceil(np.clip(guess, 0.0, float(self.count), out=guess), out=guess)
        index = guess.astype(np.int64)
        # rounding may have shifted it by one
        index -= (self.at(index - 1) >= times) & (index > 0)
        index += (self.at(index) < times) & (index < self.count)
        return index

    def first_after(self, times: FloatArray) -> IntArray:
        """Return the first index after each of the given times.

        Parameters
        ----------
        times : float64 (n,)
            Seconds.

        Returns
        -------
        int64 (n,)
            Indices, up to `count`.

        Examples
        --------
        >>> times = ov.RegularTimes(count=3, step_s=0.5)
        >>> times.first_after(np.array([0.5, 0.6]))
        array([2, 2])
        """
        index = self.first_from(times)
        index += (index < self.count) & (self.at(index) <= times)
        return index


Times = FloatArray | RegularTimes

PARTS = 64  # number of parts of a long curve that are read one after another
_SHORT_RUN = 24  # maximum length of runs that are processed as two overlapping spans
_AT_A_TIME = 4096  # number of runs processed together, so that their values fit a processor cache
_LONG_RUN = 12  # mean length of runs from which two reductions are faster than reordering bits
_DIRECT = 1 << 17  # maximum number of values that are read directly, without the pyramid


@dataclass(frozen=True, eq=False)
class Points:
    """Two or more validated points: times increase strictly, values are finite."""

    time_s: Times
    value: Values

    @cached_property
    def levels(self) -> tuple[Level, ...]:
        """Pyramid of the values, built on first use."""
        return build_pyramid(self.value)

    def first_from(self, times: FloatArray) -> IntArray:
        """Return the first index whose time is at or after each of `times` (up to the count)."""
        if isinstance(self.time_s, RegularTimes):
            return self.time_s.first_from(times)
        return np.searchsorted(self.time_s, times, side="left")

    def first_after(self, times: FloatArray) -> IntArray:
        """Return the first index whose time is after each of `times` (up to the count)."""
        if isinstance(self.time_s, RegularTimes):
            return self.time_s.first_after(times)
        return np.searchsorted(self.time_s, times, side="right")

    def times_of(self, index: IntArray) -> FloatArray:
        """Return the times of indices."""
        if isinstance(self.time_s, RegularTimes):
            return self.time_s.at(index)
        return self.time_s[index]

    def interpolate(self, times: FloatArray, after: IntArray | None = None) -> FloatArray:
        """Return the values at times within the curve, linear between its points.

        `after` is `first_after(times)`, if known.

        This uses a weighted mean of two neighbours instead of a slope as in `numpy.interp`, since
        the slope between very close points can overflow.
        """
        after = self.first_after(times) if after is None else after
        right = np.clip(after, 1, len(self.time_s) - 1)
        left = right - 1
        left_s = self.times_of(left)
        weight = (times - left_s) / (self.times_of(right) - left_s)
        before = self.value[left].astype(np.float64)
        following = self.value[right].astype(np.float64)
        low, high = np.minimum(before, following), np.maximum(before, following)
        # clipped: rounding may take the mean past its ends by one unit in the last place
        return np.clip(before * (1.0 - weight) + following * weight, low, high)

    def picked(self, index: IntArray) -> FloatArray:
        """Return the values of ascending indices; pages of values on disk are released."""
        found = np.empty(len(index))
        for some in np.array_split(np.arange(len(index)), PARTS):
            found[some] = self.value[index[some]]
            if isinstance(self.value, np.memmap):
                _forget(self.value)
        return found

    def extremes(self, first: IntArray, stop: IntArray) -> tuple[float, float]:
        """Return minimum and maximum of the values from first[i] to stop[i] - 1, for all i.

        The spans ascend, and are disjoint and not empty.
        """
        count = int((stop - first).sum())
        # choose the level with the fewest reads: bins, and single values at both ends of each span
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

    def runs(self, edges: IntArray) -> tuple[FloatArray, FloatArray]:
        """Return mean and maximum of the values of each run from edges[i] to edges[i + 1] - 1.

        Edges, shape (n + 1,), ascend. The ends of long runs are rounded to bins of at most half the
        mean length of a run. An empty run has the value of the next one.
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

    def lows(self, edges: IntArray) -> FloatArray:
        """Return the minimum of each run; edges as in `runs`."""
        (low,), starts = self._bins(edges, ("low",))
        return np.minimum.reduceat(low, starts).astype(np.float64)

    def _bins(self, edges: IntArray, names: tuple[str, ...]) -> tuple[list[Values], IntArray]:
        """Return rows of a level, or the values themselves, and the begin of each run in them."""
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


def _largest(row: Values, starts: IntArray) -> Values:
    """Return the same as `np.maximum.reduceat`, faster for many short runs.

    A surface requests 65 537 runs. The maximum of short runs of similar length is that of two
    overlapping spans. For longer runs, the bits of floats are compared as integers. Integer order
    is that of floats from 0 up, and reversed below. Few values are reordered first; of many, only
    runs without positive values are reduced again.
    """
    ends = np.append(starts[1:], len(row))
    lengths = ends - starts
    least, most = int(lengths.min()), int(lengths.max())
    span = 1 << (least.bit_length() - 1) if least > 0 else 0
    if most <= min(2 * span, _SHORT_RUN):
        width = 1
        while width < span:  # the largest of `width` values from each on
            row = np.maximum(row[:-width], row[width:])
            width *= 2
        return np.asarray(np.maximum(row[starts], row[ends - span]))
    bits = row.view(np.dtype(f"i{row.dtype.itemsize}"))
    if len(row) < _LONG_RUN * len(starts):
        return _ordered(np.maximum.reduceat(_ordered(bits), starts)).view(row.dtype)
    largest = np.maximum.reduceat(bits, starts)
    below = largest < 0
    if below.any():
        largest = np.where(below, np.minimum.reduceat(bits, starts), largest)
    return largest.view(row.dtype)


def _ordered(bits: NDArray[Any]) -> NDArray[Any]:
    """Convert the bits of floats to integers of the same order, and back."""
    kind = np.iinfo(bits.dtype)
    flipped = bits >> (kind.bits - 1)
    flipped &= kind.max
    flipped ^= bits
    return flipped


def _every(first: IntArray, stop: IntArray) -> IntArray:
    """Return the indices from first[i] to stop[i] - 1, for all i in order."""
    lengths = stop - first
    begins = np.cumsum(lengths) - lengths
    return np.asarray(np.arange(int(lengths.sum())) + np.repeat(first - begins, lengths))


def _forget(values: NDArray[np.floating[Any]]) -> None:
    """Release the pages of a mapped file, since the system reads more than requested."""
    base: Any = values
    while isinstance(base, np.ndarray):
        base = base.base
    if isinstance(base, mmap.mmap) and hasattr(mmap, "MADV_DONTNEED"):
        base.madvise(mmap.MADV_DONTNEED)
