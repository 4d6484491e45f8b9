"""Crossings, peaks and troughs of a series.

Crossings are of one to three round numbers (1, 2, 2.5 or 5 times a power of ten apart), those
nearest to the middle of the series' central 80 %. A level is crossed when the series, having been
more than the hysteresis below it, gets more than that above it (or the reverse); the event is at
the first sample on the other side. The hysteresis is 3 % of the central range, and
doubles, up to 24 %, while there are more than `MOST_CROSSINGS` crossings. If there still are, only
the middle level is used, or none.

The prominence of a peak is its height above the lowest point between it and the next higher peak
(or the end of the series); the smaller one of both sides counts. Of a long series, only the lowest
and highest samples are searched.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from overview_dsp.arrays import FloatArray, IntArray

MOST_CROSSINGS = 16  # maximum number of crossings; more would be perceived as a texture
_LEVELS = 3
_HYSTERESIS = (0.03, 0.06, 0.12, 0.24)


@dataclass(frozen=True)
class Crossing:
    """Crossing of a level at the sample `index`, upwards or downwards."""

    index: int
    level: float
    up: bool


def round_levels(low: float, high: float) -> list[float]:
    """Return one to three round numbers strictly between two values, none if they are too close."""
    span = high - low
    if not math.isfinite(span) or span <= 0.0 or span < 1e-9 * max(abs(low), abs(high)):
        return []
    power = 10.0 ** math.floor(math.log10(span))
    for step in (power * m for m in (0.1, 0.2, 0.25, 0.5, 1.0, 2.0, 2.5, 5.0)):
        if step <= 0.0:
            return []
        first, last = math.floor(low / step) + 1, math.ceil(high / step) - 1
        if 1 <= last - first + 1 <= _LEVELS:
            found = range(first, last + 1)
            levels = [round(k * step, 12) if step < 1e3 else k * step for k in found]
            return [level for level in levels if low < level < high]  # rounding may pass an end
    return []


def crossings(
    value: FloatArray, low: float, high: float
) -> tuple[list[Crossing], list[float], float]:
    """Find the crossings of a finite series, whose central 80 % reach from `low` to `high`.

    Return them by index, the levels used (none for too many crossings), and the hysteresis.
    """
    levels = round_levels(low, high)
    if not levels:
        return [], [], 0.0
    middle = min(levels, key=lambda level: abs(level - (low + high) / 2.0))
    for chosen in (levels, [middle]):
        for share in _HYSTERESIS:
            margin = share * (high - low)
            ranges = [(level, _crossing_ranges(value, level, margin)) for level in chosen]
            if sum(len(begins) for _, (begins, _) in ranges) <= MOST_CROSSINGS:
                found = [c for level, both in ranges for c in _of_level(value, level, *both)]
                return sorted(found, key=lambda c: (c.index, c.level)), chosen, margin
    return [], [], 0.0


def _crossing_ranges(value: FloatArray, level: float, margin: float) -> tuple[IntArray, IntArray]:
    """Return the last sample beyond the hysteresis before each crossing, and the first after it."""
    above = value > level + margin
    decided = np.flatnonzero(above | (value < level - margin))
    turned = np.flatnonzero(np.diff(above[decided])) + 1
    return decided[turned - 1], decided[turned]


def _of_level(value: FloatArray, level: float, begins: IntArray, ends: IntArray) -> list[Crossing]:
    found = []
    for before, here in zip(begins.tolist(), ends.tolist(), strict=True):
        up = bool(value[here] > level)
        part = value[before : here + 1]
        not_crossed = np.flatnonzero(part < level if up else part > level)
        found.append(Crossing(before + int(not_crossed[-1]) + 1, level, up))
    return found


MAX_EXTREMA = 200_000
"""Maximum number of extrema that are examined; of more, only the lowest and highest of equal runs
are kept, among them all prominent ones."""


def peaks(value: FloatArray) -> tuple[IntArray, FloatArray]:
    """Return the peaks of a finite series and their prominences, which are above 0.

    A peak is the index of the first sample of a flat top, ascending. Ends do not count.
    """
    turns = _turns(value)
    if len(turns) > MAX_EXTREMA:
        turns = _thinned(value, turns)
    if len(turns) < 3:
        return turns[:0], np.empty(0)
    levels = value[turns]
    # highs and lows alternate; an end may be either
    highs = np.arange(0 if levels[0] > levels[1] else 1, len(turns), 2)
    height = levels[highs]
    before = np.where(highs > 0, levels[highs - 1], height)
    after = np.where(highs < len(turns) - 1, levels[np.minimum(highs + 1, len(turns) - 1)], height)
    left = _bases(height, before)
    right = _bases(height[::-1], after[::-1])[::-1]
    prominence = height - np.maximum(left, right)
    inner = (highs > 0) & (highs < len(turns) - 1)
    return turns[highs[inner]], prominence[inner]


def _turns(value: FloatArray) -> IntArray:
    """Return both ends and all turning points, the first sample of a flat run."""
    moved = np.flatnonzero(np.diff(value)) + 1
    distinct = np.concatenate(([0], moved)).astype(np.int64)
    if len(distinct) < 3:
        return distinct
    sign = np.sign(np.diff(value[distinct]))
    turning = np.flatnonzero(sign[1:] != sign[:-1]) + 1
    return np.concatenate((distinct[:1], distinct[turning], distinct[-1:]))


def _thinned(value: FloatArray, turns: IntArray) -> IntArray:
    run = math.ceil(len(turns) / (MAX_EXTREMA // 2))
    kept = turns[lows_and_highs(value[turns], run)]
    inside = np.concatenate((turns[:1], kept, turns[-1:]))
    inside = inside[np.diff(inside, prepend=-1) > 0]  # without repeated ends
    return inside[_turns(value[inside])]


def _bases(heights: FloatArray, before: FloatArray) -> FloatArray:
    """Return for each high the lowest level between it and the next higher one on its left.

    `before` has the low just before each high. The search moves left by runs of 2**k highs, the
    longest first, while no high in a run is higher.
    """
    tallest, lowest = [heights], [before]
    while (span := 1 << (len(tallest) - 1)) < len(heights):
        tallest.append(np.maximum(tallest[-1], _shifted(tallest[-1], span)))
        lowest.append(np.minimum(lowest[-1], _shifted(lowest[-1], span)))
    at = np.arange(len(heights)) - 1
    bases = before
    for k in reversed(range(len(tallest))):
        over = (at >= (1 << k) - 1) & (tallest[k][at] <= heights)
        bases = np.where(over, np.minimum(bases, lowest[k][at]), bases)
        at = np.where(over, at - (1 << k), at)
    return bases


def _shifted(row: FloatArray, span: int) -> FloatArray:
    """Return a row shifted to the right; its first values are repeated."""
    return np.concatenate((row[:span], row[:-span]))


MOST_SAMPLES = 400_000  # maximum number of samples that are kept; then the length of runs doubles
RUN = 64  # initial number of samples in a run
STEPS = 16  # number of largest steps in each direction that are kept, too


def lows_and_highs(value: FloatArray, run: int) -> IntArray:
    """Return the indices of the lowest and the highest (the first ones) of each `run` values.

    The values must be finite. The indices ascend.
    """
    whole = len(value) // run * run
    rows = value[:whole].reshape(-1, run)
    begins = np.arange(0, whole, run)
    both = np.sort([begins + rows.argmin(axis=1), begins + rows.argmax(axis=1)], axis=0)
    found = [both.T.ravel()]
    if whole < len(value):
        rest = value[whole:]
        found.append(np.sort([whole + rest.argmin(), whole + rest.argmax()]))
    index = np.concatenate(found)
    return index[np.diff(index, prepend=-1) > 0]


@dataclass
class Thinner:
    """Reduction of samples, block by block, to the lowest and highest of equal runs.

    It keeps every prominent turning point, both extremes and the largest steps, at their exact
    times.
    """

    run: int = RUN
    count: int = 0
    _parts: list[FloatArray] = field(default_factory=list)
    _stored: int = 0
    _steps: FloatArray = field(default_factory=lambda: np.empty((3, 0)))

    def add(self, time_s: FloatArray, value: FloatArray, step: FloatArray) -> None:
        """Add samples with a value, in order, shape (n,); `step` may be NaN."""
        if not len(value):
            return
        self.count += len(value)
        samples = np.stack((time_s, value, step))
        self._steps = _largest(np.concatenate((self._steps, _largest(samples)), axis=1))
        part = samples[:, lows_and_highs(value, self.run)]
        self._parts.append(part)
        self._stored += part.shape[1]
        while self._stored > MOST_SAMPLES:
            whole = np.concatenate(self._parts, axis=1)
            whole = whole[:, lows_and_highs(whole[1], 4)]
            self._parts, self._stored = [whole], whole.shape[1]
            self.run *= 2

    def finish(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return times, values and steps of the kept samples, in order."""
        whole = np.concatenate((*self._parts, self._steps), axis=1)
        _, first = np.unique(whole[0], return_index=True)
        time_s, value, step = whole[:, first]
        return time_s, value, step


def _largest(samples: FloatArray) -> FloatArray:
    """Return the samples with the largest steps up and down."""
    known = np.flatnonzero(~np.isnan(samples[2]))
    step = samples[2, known]
    if len(known) > 2 * STEPS:
        order = np.argpartition(step, (STEPS, len(step) - STEPS))
        known = known[np.concatenate((order[:STEPS], order[-STEPS:]))]
    return samples[:, np.sort(known)]
