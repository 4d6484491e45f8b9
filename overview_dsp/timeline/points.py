"""The points of a curve, however many: found by time, interpolated, and taken together in runs."""

from __future__ import annotations

import mmap
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from overview_dsp.timeline.even_times import EvenTimes
from overview_dsp.timeline.pyramid import Level, Values, build_pyramid

Times = NDArray[np.float64] | EvenTimes

PARTS = 64
"""So many parts of a long curve are looked at one after another."""

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
        if isinstance(self.time_s, EvenTimes):
            return self.time_s.first_from(times)
        return np.searchsorted(self.time_s, times, side="left")

    def first_after(self, times: NDArray[np.float64]) -> NDArray[np.int64]:
        """Return the first index whose time is after each of `times` (up to the count)."""
        if isinstance(self.time_s, EvenTimes):
            return self.time_s.first_after(times)
        return np.searchsorted(self.time_s, times, side="right")

    def times_of(self, index: NDArray[np.int64]) -> NDArray[np.float64]:
        """Return the times of some indices."""
        if isinstance(self.time_s, EvenTimes):
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

    def extremes(self, first: int, stop: int) -> tuple[float, float]:
        """Return the smallest and the largest of the values `first` to `stop` - 1 (one or more)."""
        count = stop - first
        if count <= _DIRECT:
            some = self.value[first:stop]
            return float(some.min()), float(some.max())
        level = next((one for one in self.levels if count <= one.width * _DIRECT), self.levels[-1])
        low_bin, high_bin = -(-first // level.width), stop // level.width
        low, high = level.low[low_bin:high_bin], level.high[low_bin:high_bin]
        ends = np.concatenate(
            (self.value[first : low_bin * level.width], self.value[high_bin * level.width : stop])
        )
        return (
            min(float(low.min()), float(ends.min(initial=np.inf))),
            max(float(high.max()), float(ends.max(initial=-np.inf))),
        )

    def runs(self, edges: NDArray[np.int64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return the mean and the largest of the values of each run edges[i] to edges[i + 1] - 1.

        Edges, shape (n + 1,), ascend. The ends of long runs are rounded to bins of at most half a
        run's average length; an empty run has its next neighbour's value.
        """
        first, stop = int(edges[0]), int(edges[-1])
        wanted = (stop - first) / (len(edges) - 1) / 2.0
        level = next((one for one in reversed(self.levels) if one.width <= wanted), None)
        if level is None:
            mean = high = np.asarray(self.value[first:stop])
            at = edges - first
        else:
            at = np.round(edges / level.width).astype(np.int64)
            begin, end = int(at[0]), max(int(at[-1]), int(at[0]) + 1)
            mean, high = np.asarray(level.mean[begin:end]), np.asarray(level.high[begin:end])
            at -= begin
        starts = np.minimum(at[:-1], len(mean) - 1)
        counts = np.diff(np.append(starts, len(mean)))
        total = np.add.reduceat(mean, starts).astype(np.float64)
        return total / np.maximum(counts, 1), np.maximum.reduceat(high, starts).astype(np.float64)


def _forget(values: NDArray[np.floating[Any]]) -> None:
    """Let go of the pages of a file that were mapped: the system reads some around each one."""
    base: Any = values
    while isinstance(base, np.ndarray):
        base = base.base
    if isinstance(base, mmap.mmap) and hasattr(mmap, "MADV_DONTNEED"):
        base.madvise(mmap.MADV_DONTNEED)
