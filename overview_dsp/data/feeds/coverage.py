"""Which stretches of a feed's time were heard of: the rest is missing."""

from __future__ import annotations

import math
from bisect import bisect_left, bisect_right
from collections.abc import Iterable

from overview_dsp.data.timeline.gaps import Gaps


class Coverage:
    """Signs of life on a time axis, joined where they are no further apart than `reach_s`.

    The same signs give the same stretches in whatever order they come. Memory is that of the
    stretches, not of the signs.
    """

    def __init__(self, reach_s: float) -> None:
        self.reach_s = reach_s
        self._starts: list[float] = []
        self._ends: list[float] = []

    def add(self, time_s: float) -> bool:
        """Note a sign; whether that changes a stretch."""
        # stretches that end at or after the sign less the reach, and begin before it and the reach
        first = bisect_left(self._ends, time_s - self.reach_s)
        stop = bisect_right(self._starts, time_s + self.reach_s)
        if first >= stop:
            self._starts.insert(first, time_s)
            self._ends.insert(first, time_s)
            return True
        start, end = self._starts[first], self._ends[stop - 1]
        if stop - first == 1 and start <= time_s <= end:
            return False
        self._starts[first:stop] = [min(start, time_s)]
        self._ends[first:stop] = [max(end, time_s)]
        return True

    @property
    def first_s(self) -> float:
        """When the first sign was, s; without end where there is none."""
        return self._starts[0] if self._starts else math.inf

    def gaps(self, more: Iterable[float] = ()) -> tuple[tuple[float, float], ...]:
        """The stretches between those that were heard of.

        Parameters
        ----------
        more
            Further signs, which are not kept.
        """
        joined = Coverage(self.reach_s)
        joined._starts, joined._ends = self._starts.copy(), self._ends.copy()
        for time_s in more:
            joined.add(time_s)
        return tuple(zip(joined._ends[:-1], joined._starts[1:], strict=True))

    def __bool__(self) -> bool:
        return bool(self._starts)


def merged_gaps(found: Iterable[tuple[float, float, str]]) -> tuple[Gaps, tuple[str, ...]]:
    """Gaps (start_s, end_s, why) in order, those that overlap as one, and why each is there.

    Of those that overlap, the first one's reason stays. Empty ones are left out.
    """
    merged: list[tuple[float, float, str]] = []
    for start, end, why in sorted(one for one in found if one[0] < one[1]):
        if merged and start < merged[-1][1]:
            first, last, reason = merged[-1]
            merged[-1] = (first, max(last, end), reason)
        else:
            merged.append((start, end, why))
    return tuple((a, b) for a, b, _ in merged), tuple(why for *_, why in merged)
