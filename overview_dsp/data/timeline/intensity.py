"""Intensity curve over time, and its scaling to 0 and 1.

Many points of a long curve fall on one position of the surface, which gets their mean, so that
noise does not raise the level. Peaks keep their full height. A peak is a maximum that exceeds the
means around it by more than usual in the window (the median plus three times the distance of the
98th percentile from it), and by at least a fiftieth of the range of the window. It is widened to a
thousandth of the surface, the narrowest width that is perceived.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Self

import numpy as np

from overview_dsp import validation
from overview_dsp.arrays import BoolArray, FloatArray, IntArray
from overview_dsp.data.timeline.curve_points import (
    Points,
    RegularTimes,
    Times,
    checked_percentiles,
    float_points,
    read_only_view,
    require_increasing,
    require_values,
)
from overview_dsp.data.timeline.gaps import Gaps, in_gap
from overview_dsp.data.timeline.minmax_pyramid import CHUNK, Values
from overview_dsp.errors import InputError
from overview_dsp.public import counted

EXTREMES = (0.0, 100.0)
"""Percentiles of minimum and maximum."""


def _same_times(one: Times, other: Times) -> bool:
    if isinstance(one, RegularTimes) and isinstance(other, RegularTimes):
        return one == other
    return np.array_equal(one, other)


SAMPLED = 1 << 14  # number of random samples from which percentiles of a long curve are computed

RARE = 0.98
"""Percentile of the excess over the surrounding means, as a fraction; peaks are above it."""

STANDS_OUT = 3.0  # minimum excess of a peak, as a multiple of the usual spread, above common noise
MATTERS = 0.02  # minimum excess of a peak, as a fraction of the range of the window
SAMPLE_STEP = 7  # step between the positions at which the usual excess is measured
WIDENED = 1.0 / 2048.0
"""Width to which a peak is extended on either side, as a fraction of the surface."""


def with_peaks(mean: FloatArray, top: FloatArray) -> FloatArray:
    """Return the value at each position, shape (n,), from means and maxima there."""
    from scipy.ndimage import maximum_filter1d

    excess = np.maximum(top - maximum_filter1d(mean, 3, mode="nearest"), 0.0)
    usual, rare = np.quantile(excess[::SAMPLE_STEP], (0.5, RARE))
    spans = float(top.max()) - float(mean.min())
    peak = (excess > usual + STANDS_OUT * (rare - usual)) & (excess >= MATTERS * spans)
    if not peak.any():
        return mean
    width = 2 * round(WIDENED * len(mean)) + 1
    kept = maximum_filter1d(np.where(peak, top, -np.inf), width, mode="nearest")
    return np.asarray(np.maximum(mean, kept))


__all__ = ["EXTREMES", "LONG", "CurveWindow", "Intensity"]

LONG = 65_536
"""Number of points above which a curve is not copied, and is reduced to runs of points."""


@dataclass(frozen=True, eq=False)
class Intensity:
    """A curve over time, linear between its points; a single point is a constant.

    Arrays are copied to float64 and made read-only. With `RegularTimes` the values are not copied
    (float32 or float64, or a memory map): do not change them afterwards. For series too long for
    memory, use `CurveBuilder`.

    Parameters
    ----------
    time_s : array_like (n,) or RegularTimes
        Seconds, n >= 1, finite, >= 0, strictly increasing.
    value : array_like (n,)
        Finite, magnitude up to 1e300, in any unit.
    unit : str
        Unit of the values.
    percentiles : (float, float)
        Percentiles of the values that become 0 and 1 in scaling, 0 <= low < high <= 100. Values
        beyond them are clipped in scaling only.

    Raises
    ------
    InputError
        A wrong value; the message names the first location (`intensity.time_s[5]`).

    Examples
    --------
    >>> curve = ov.Intensity(np.array([0.0, 10.0]), np.array([0.0, 5.0]), "m/s")
    >>> curve.at(np.array([5.0]))
    array([2.5])
    """

    time_s: Times
    value: Values
    unit: str = ""
    percentiles: tuple[float, float] = EXTREMES

    def __post_init__(self) -> None:
        if isinstance(self.time_s, RegularTimes):
            time_s: Times = self.time_s
            value = read_only_view(self.value, "intensity.value")
        else:
            time_s = float_points(self.time_s, "intensity.time_s")
            value = float_points(self.value, "intensity.value")
        validation.text(self.unit, "intensity.unit")
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
        if not isinstance(time_s, RegularTimes):
            require_increasing(time_s)
        for start in range(0, len(value), CHUNK):
            require_values(np.asarray(value[start : start + CHUNK]), start)
        object.__setattr__(self, "percentiles", checked_percentiles(self.percentiles))
        object.__setattr__(self, "time_s", time_s)
        object.__setattr__(self, "value", value)

    @classmethod
    def checked(
        cls, points: Points, unit: str = "", percentiles: tuple[float, float] = EXTREMES
    ) -> Self:
        """Return a curve of points that are already validated, without copying them.

        Parameters
        ----------
        points : Points
            Points of another curve, or of a `CurveBuilder`.
        unit : str
            Unit of the values.
        percentiles : (float, float)
            As in the constructor.

        Returns
        -------
        Intensity
            The curve.

        Examples
        --------
        >>> curve = ov.Intensity(np.array([0.0, 10.0]), np.array([0.0, 5.0]), "m/s")
        >>> ov.Intensity.checked(curve.points, unit="km/h").unit
        'km/h'
        """
        curve = object.__new__(cls)
        curve.__dict__.update(
            time_s=points.time_s,
            value=points.value,
            unit=validation.text(unit, "intensity.unit"),
            percentiles=checked_percentiles(percentiles),
            points=points,
        )
        return curve

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Intensity):
            return NotImplemented
        return (
            self.unit == other.unit
            and self.percentiles == other.percentiles
            and self.count == other.count
            and _same_times(self.time_s, other.time_s)
            and np.array_equal(self.value, other.value)
        )

    def __hash__(self) -> int:
        return hash((self.unit, self.percentiles, self.count, self.first_s, self.last_s))

    @cached_property
    def count(self) -> int:
        """Number of points."""
        return len(self.value)

    @cached_property
    def first_s(self) -> float:
        """Time of the first point, s."""
        return float(self.time_s[0])

    @cached_property
    def last_s(self) -> float:
        """Time of the last point, s."""
        return float(self.time_s[-1])

    @property
    def is_constant(self) -> bool:
        """True for a curve of one point, whose value applies at all times."""
        return self.count == 1

    @cached_property
    def points(self) -> Points:
        """Points of the curve, with cached results."""
        return Points(self.time_s, self.value)

    @cached_property
    def _shift(self) -> float:
        """Offset from the time axis of this curve to that of its points, s."""
        return 0.0

    @cached_property
    def _between(self) -> tuple[int, int]:
        """Index of the first point, and of the last one + 1."""
        return 0, self.count

    def scale(self, known: BoolArray) -> tuple[float, float]:
        """Return the values that become 0 and 1: the percentiles of the known points.

        If they are equal (most values of rainfall are 0), minimum and maximum are used.

        Parameters
        ----------
        known : bool (n,)
            True for points that count.

        Returns
        -------
        (float, float)
            In the curve's unit.

        Examples
        --------
        >>> curve = ov.Intensity(np.array([0.0, 10.0]), np.array([0.0, 5.0]), "m/s")
        >>> curve.scale(np.array([True, True]))
        (0.0, 5.0)
        """
        value = self.value[known] if known.any() else self.value
        if self.percentiles == EXTREMES:
            return float(value.min()), float(value.max())
        low, high = (float(edge) for edge in np.percentile(value, self.percentiles))
        return (low, high) if low < high else (float(value.min()), float(value.max()))

    def scale_outside(self, gaps: Gaps) -> tuple[float, float]:
        """Return the values of a long curve that become 0 and 1, without reading all points.

        Parameters
        ----------
        gaps : tuple of (float, float)
            Spans (start_s, end_s) whose points do not count, unless they contain all points.

        Returns
        -------
        (float, float)
            In the curve's unit.

        Examples
        --------
        >>> curve = ov.Intensity(np.array([0.0, 10.0]), np.array([0.0, 5.0]), "m/s")
        >>> curve.scale_outside(((8.0, 10.5),))
        (0.0, 0.0)
        """
        first, stop = self._known(gaps)
        extremes = self.points.extremes(first, stop)
        if self.percentiles == EXTREMES:
            return extremes
        random = np.random.default_rng(0)
        behind = np.cumsum(stop - first)
        step = behind[-1] / SAMPLED
        place = ((np.arange(SAMPLED) + random.random(SAMPLED)) * step).astype(np.int64)
        stretch = np.searchsorted(behind, place, side="right")
        index = place - behind[stretch] + stop[stretch]
        low, high = np.percentile(self._picked(index), self.percentiles)
        return (float(low), float(high)) if low < high else extremes

    def extremes_outside(self, gaps: Gaps) -> tuple[float, float]:
        """Return minimum and maximum of the points outside of gaps.

        Parameters
        ----------
        gaps : tuple of (float, float)
            Spans (start_s, end_s) whose inner points do not count, unless they contain all points.

        Returns
        -------
        (float, float)
            In the curve's unit.

        Examples
        --------
        >>> curve = ov.Intensity(np.arange(4.0), np.array([1.0, -7.0, 3.0, 2.0]), "m/s")
        >>> curve.extremes_outside(((0.0, 2.0),))
        (1.0, 3.0)
        """
        if self.is_constant:
            return float(self.value[0]), float(self.value[0])
        return self.points.extremes(*self._known(gaps))

    def _picked(self, index: IntArray) -> FloatArray:
        return self.points.picked(index)

    def _known(self, gaps: Gaps) -> tuple[IntArray, IntArray]:
        """Return the runs of points (first, stop) outside of gaps, or all points without any."""
        first, stop = self._between
        starts, ends = np.array(gaps, dtype=np.float64).reshape(-1, 2).T + self._shift
        inside = np.clip(self.points.first_after(starts), first, stop)
        behind = np.clip(self.points.first_from(ends), first, stop)
        holding = inside < behind
        firsts = np.concatenate(([first], behind[holding]))
        stops = np.concatenate((inside[holding], [stop]))
        some = firsts < stops
        return (firsts[some], stops[some]) if some.any() else (np.array([first]), np.array([stop]))

    def at(self, times: FloatArray) -> FloatArray:
        """Evaluate the curve, linear between its points.

        Parameters
        ----------
        times : float64 (n,)
            Seconds.

        Returns
        -------
        float64 (n,)
            Values; 0 before the first point, after the last one, and for NaN. A constant has its
            value everywhere.

        Examples
        --------
        >>> curve = ov.Intensity(np.array([0.0, 10.0]), np.array([0.0, 5.0]), "m/s")
        >>> curve.at(np.array([0.0, 5.0, 11.0]))
        array([0. , 2.5, 0. ])
        """
        if self.is_constant:
            return np.full(times.shape, float(self.value[0]))
        return self._filled(times, None)

    def along(self, times: FloatArray) -> FloatArray:
        """Evaluate the curve at evenly spaced times, each for the points nearest to it.

        For up to 65 536 points this is `at`. For more points, it is the mean of the points nearest
        to each time, with peaks at their full height.

        Parameters
        ----------
        times : float64 (n,)
            Seconds, ascending.

        Returns
        -------
        float64 (n,)
            In the curve's unit.

        Examples
        --------
        >>> curve = ov.Intensity(np.array([0.0, 10.0]), np.array([0.0, 5.0]), "m/s")
        >>> curve.along(np.array([0.0, 5.0, 10.0]))
        array([0. , 2.5, 5. ])
        """
        if self.is_constant:
            return self.at(times)
        if self.count <= LONG:
            return self._filled(times, _counted(self.time_s[:], times))
        first, last = self._between
        half = (times[1] - times[0]) / 2.0
        borders = np.concatenate((times - half, [np.inf])) + self._shift
        edges = np.clip(self.points.first_from(borders), first, last)
        mean, top = self.points.runs(edges)
        empty = np.flatnonzero(edges[1:] == edges[:-1])
        if len(empty):  # uneven times, or hardly more points than times
            mean[empty] = top[empty] = self.at(times[empty])
        felt = with_peaks(mean, top)
        felt[: np.searchsorted(times, self.first_s)] = 0.0
        felt[np.searchsorted(times, self.last_s, side="right") :] = 0.0
        return felt

    def band(self, times: FloatArray, gaps: Gaps = ()) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return minimum, mean and maximum around each of some times, for a picture.

        Each time represents the points nearest to it; without any, all three are `at`.

        Parameters
        ----------
        times : float64 (n,)
            Seconds, ascending; at least two.
        gaps : tuple of (float, float)
            Spans (start_s, end_s) whose inner points do not count.

        Returns
        -------
        tuple of float64 (n,)
            Minimum, mean and maximum; NaN before the first point, after the last one, and inside a
            gap at times that are nearest to no point.

        Examples
        --------
        >>> curve = ov.Intensity(np.arange(6.0), np.array([0.0, 5.0, 1.0, 2.0, 9.0, 4.0]))
        >>> low, mean, high = curve.band(np.array([1.0, 4.0]))
        >>> low, mean, high
        (array([0., 2.]), array([2., 5.]), array([5., 9.]))
        """
        if self.is_constant:
            return (self.at(times),) * 3
        first, last = self._between
        middle = (times[:-1] + times[1:]) / 2.0
        ends = 2.0 * times[[0, -1]] - middle[[0, -1]]
        borders = np.concatenate((ends[:1], middle, ends[1:])) + self._shift
        edges = np.clip(self.points.first_from(borders), first, last)
        low, mean, high = self._runs_outside(edges, gaps)
        empty = np.isnan(mean)
        low[empty] = mean[empty] = high[empty] = self.at(times[empty])
        unknown = (times < self.first_s) | (times > self.last_s)
        unknown |= empty & in_gap(gaps, times)
        for row in (low, mean, high):
            row[unknown] = np.nan
        return low, mean, high

    def _runs_outside(
        self, edges: IntArray, gaps: Gaps
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return minimum, mean and maximum of runs of points outside of gaps; NaN without any."""
        starts, ends = np.array(gaps, dtype=np.float64).reshape(-1, 2).T + self._shift
        inside = np.clip(self.points.first_after(starts), edges[0], edges[-1])
        behind = np.clip(self.points.first_from(ends), edges[0], edges[-1])
        parts = np.unique(np.concatenate((edges, inside, behind)))
        low, mean, high = np.full((3, len(edges) - 1), np.nan)
        if len(parts) < 2:
            return low, mean, high
        means, highs = self.points.runs(parts)
        lows = self.points.lows(parts)
        sizes = np.diff(parts).astype(np.float64)
        depth = np.zeros(len(parts))
        np.add.at(depth, np.searchsorted(parts, inside), 1.0)
        np.add.at(depth, np.searchsorted(parts, behind), -1.0)
        known = np.cumsum(depth)[:-1] == 0.0
        run = np.searchsorted(edges, parts[:-1], side="right") - 1
        first = np.flatnonzero(np.diff(run[known], prepend=-1))
        if len(first):
            at = run[known][first]
            low[at] = np.minimum.reduceat(lows[known], first)
            high[at] = np.maximum.reduceat(highs[known], first)
            total = np.add.reduceat((means * sizes)[known], first)
            mean[at] = total / np.add.reduceat(sizes[known], first)
        return low, mean, high

    def cut(self, start: float, end: float) -> Intensity | None:
        """Return a window of the curve, with interpolated ends.

        Parameters
        ----------
        start, end : float
            Seconds.

        Returns
        -------
        Intensity or None
            Curve on a time axis that begins at `start`, a view for many points; None if empty.

        Examples
        --------
        >>> curve = ov.Intensity(np.array([0.0, 10.0]), np.array([0.0, 5.0]), "m/s")
        >>> curve.cut(2.0, 6.0).value
        array([1., 3.])
        """
        if self.is_constant:
            return replace(self, time_s=np.zeros(1), value=np.asarray(self.value, np.float64))
        low, high = max(start, self.first_s), min(end, self.last_s)
        if low >= high:  # a single point would become a constant
            return None
        shift = self._shift
        first = int(self.points.first_after(np.array([low + shift]))[0])
        stop = int(self.points.first_from(np.array([high + shift]))[0])
        if stop - first > LONG:
            return CurveWindow(self, start, low, high)
        inner = self.points.times_of(np.arange(first, stop)) - shift
        times = np.concatenate(([low], inner, [high]))
        shifted = times - start
        # two times one unit in the last place apart may round to the same
        apart = np.diff(shifted, prepend=-1.0) > 0.0
        values = np.asarray(self.points.value[first:stop], np.float64)
        values = np.concatenate((self.at(times[:1]), values, self.at(times[-1:])))
        return Intensity(shifted[apart], values[apart], self.unit, self.percentiles)

    def _filled(self, times: FloatArray, after: IntArray | None) -> FloatArray:
        """Interpolate inside the curve, 0 outside."""
        inside = (times >= self.first_s) & (times <= self.last_s)
        result = np.zeros(times.shape, dtype=np.float64)
        within = times[inside]
        if self._shift:
            within = self._clipped(within + self._shift)
        result[inside] = self.points.interpolate(within, None if after is None else after[inside])
        return result

    def _clipped(self, times: FloatArray) -> FloatArray:
        return times

    def __repr__(self) -> str:
        unit = f", in {self.unit}" if self.unit else ""
        span = f"{self.first_s:g} to {self.last_s:g} s"
        return f"<Intensity: {counted(self.count, 'point')}, {span}{unit}>"


class CurveWindow(Intensity):
    """A window of a long curve, on a time axis that begins at `start`: a view of the same points.

    `low` and `high` are its interpolated ends on the axis of `whole`.
    """

    _bounds: FloatArray

    def __init__(self, whole: Intensity, start: float, low: float, high: float) -> None:
        bounds = np.array([low, high]) + whole._shift
        points = whole.points
        first, stop = int(points.first_after(bounds)[0]), int(points.first_from(bounds)[1])
        self.__dict__.update(
            unit=whole.unit,
            percentiles=whole.percentiles,
            points=points,
            count=stop - first + 2,
            first_s=low - start,
            last_s=high - start,
            _shift=whole._shift + start,
            _between=(first, stop),
            _bounds=bounds,
        )

    @property
    def time_s(self) -> FloatArray:
        """Times of the points and of the two ends, computed on request."""
        inner = self.points.times_of(np.arange(*self._between)) - self._shift
        return np.concatenate(([self.first_s], inner, [self.last_s]))

    @property
    def value(self) -> FloatArray:
        """Values of the points and of the two ends, computed on request."""
        low, high = self.points.interpolate(self._bounds)
        first, stop = self._between
        return np.concatenate(([low], self.points.value[first:stop], [high]))

    def scale_outside(self, gaps: Gaps) -> tuple[float, float]:
        """Return the values that become 0 and 1; the ends count as points."""
        if self.percentiles != EXTREMES:
            return super().scale_outside(gaps)
        return self.extremes_outside(gaps)

    def extremes_outside(self, gaps: Gaps) -> tuple[float, float]:
        """Return minimum and maximum outside of gaps; the ends count as points."""
        low, high = super().extremes_outside(gaps)
        known = ~in_gap(gaps, np.array((self.first_s, self.last_s)))
        ends = self.points.interpolate(self._bounds)[known]
        return min(low, float(ends.min(initial=low))), max(high, float(ends.max(initial=high)))

    def _picked(self, index: IntArray) -> FloatArray:
        # pages stay in memory for the next zoom step
        return self.points.value[index].astype(np.float64)

    def _clipped(self, times: FloatArray) -> FloatArray:
        # rounding of the shift may take a time past an end
        return np.clip(times, *self._bounds)


def _counted(points_s: FloatArray, times: FloatArray) -> IntArray:
    """Return the number of points at or before each of evenly spaced times."""
    last = len(times) - 1
    begins = np.ceil(np.clip((points_s - times[0]) / (times[1] - times[0]), 0.0, last))
    begins = begins.astype(np.int64)
    # rounding may have shifted it by one
    begins -= (begins > 0) & (times[begins - 1] >= points_s)
    begins += times[begins] < points_s
    return np.cumsum(np.bincount(begins, minlength=len(times) + 1)[: len(times)])
