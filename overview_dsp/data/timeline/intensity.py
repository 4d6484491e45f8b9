"""An intensity curve over time."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from overview_dsp.data.timeline.curve_points import EXTREMES
from overview_dsp.data.timeline.curve_scale import CurveScale
from overview_dsp.data.timeline.gaps import Gaps, in_gap
from overview_dsp.data.timeline.peaks import with_peaks
from overview_dsp.public import counted

__all__ = ["EXTREMES", "LONG", "Intensity", "Part"]

LONG = 65_536
"""A curve of more points isn't copied, and a surface shows it by runs of points."""


@dataclass(frozen=True, eq=False)
class Intensity(CurveScale):
    """A curve over time, straight between its points; a single point is a constant.

    Arrays are copied to float64 and made read-only. With `EvenTimes` the values are kept as they
    are given (float32 or float64, a memory map too): don't change them afterwards. A series too
    long for memory is built in chunks by `CurveBuilder`.

    Parameters
    ----------
    time_s : array_like (n,) or EvenTimes
        Seconds, n >= 1, finite, >= 0, strictly increasing.
    value : array_like (n,)
        Finite, magnitude up to 1e300, in any unit.
    unit : str
        What the values are, for a person.
    percentiles : (float, float)
        Which percentiles of the values become 0 and 1 when the curve is scaled, 0 <= low < high
        <= 100; values beyond them are clipped there, and only there.

    Raises
    ------
    InputError
        Anything else; the line names the first bad place (`intensity.time_s[5]`).

    Examples
    --------
    >>> import numpy as np
    >>> import overview_dsp as ov
    >>> curve = ov.Intensity(np.array([0.0, 10.0]), np.array([0.0, 5.0]), "m/s")
    >>> curve.at(np.array([5.0]))
    array([2.5])
    """

    def at(self, times: NDArray[np.float64]) -> NDArray[np.float64]:
        """Look up the curve: straight between points, exact at them.

        Parameters
        ----------
        times : float64 (n,)
            Seconds.

        Returns
        -------
        float64 (n,)
            In the curve's unit; 0 before the first point, after the last and for NaN. A constant
            has its value everywhere.

        Examples
        --------
        >>> import numpy as np
        >>> import overview_dsp as ov
        >>> curve = ov.Intensity(np.array([0.0, 10.0]), np.array([0.0, 5.0]), "m/s")
        >>> curve.at(np.array([0.0, 5.0, 11.0]))
        array([0. , 2.5, 0. ])
        """
        if self.is_constant:
            return np.full(times.shape, float(self.value[0]))
        return self._filled(times, None)

    def along(self, times: NDArray[np.float64]) -> NDArray[np.float64]:
        """Look up the curve at evenly spaced times, each of which stands for those nearest to it.

        Where the curve has up to 65 536 points this is `at`; where it has more, what is felt of the
        points nearest to each time: their mean, and a peak at its full height.

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
        >>> import numpy as np
        >>> import overview_dsp as ov
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

    def band(
        self, times: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
        """Look up what a picture shows at evenly spaced times: the span of the points, their mean.

        Each time stands for the points nearest to it; where there are none, all three are `at`.

        Parameters
        ----------
        times : float64 (n,)
            Seconds, ascending.

        Returns
        -------
        tuple of float64 (n,)
            The smallest, the mean and the largest, in the curve's unit; NaN before the first point
            and after the last.

        Examples
        --------
        >>> import numpy as np
        >>> import overview_dsp as ov
        >>> curve = ov.Intensity(np.arange(6.0), np.array([0.0, 5.0, 1.0, 2.0, 9.0, 4.0]))
        >>> low, mean, high = curve.band(np.array([1.0, 4.0]))
        >>> low, mean, high
        (array([0., 2.]), array([2., 5.]), array([5., 9.]))
        """
        if self.is_constant:
            return (self.at(times),) * 3
        first, last = self._between
        half = (times[1] - times[0]) / 2.0
        borders = np.concatenate((times - half, [times[-1] + half])) + self._shift
        edges = np.clip(self.points.first_from(borders), first, last)
        mean, high = self.points.runs(edges)
        low = self.points.lows(edges)
        empty = np.flatnonzero(edges[1:] == edges[:-1])
        low[empty] = mean[empty] = high[empty] = self.at(times[empty])
        outside = (times < self.first_s) | (times > self.last_s)
        for row in (low, mean, high):
            row[outside] = np.nan
        return low, mean, high

    def cut(self, start: float, end: float) -> Intensity | None:
        """Cut out a part; its ends are interpolated, so it has the same value at the same moment.

        Parameters
        ----------
        start, end : float
            Seconds.

        Returns
        -------
        Intensity or None
            On an axis that begins at `start`, a view where the points are many; None if it is
            empty.

        Examples
        --------
        >>> import numpy as np
        >>> import overview_dsp as ov
        >>> curve = ov.Intensity(np.array([0.0, 10.0]), np.array([0.0, 5.0]), "m/s")
        >>> curve.cut(2.0, 6.0).value
        array([1., 3.])
        """
        if self.is_constant:
            return replace(self, time_s=np.zeros(1), value=np.asarray(self.value, np.float64))
        low, high = max(start, self.first_s), min(end, self.last_s)
        if low >= high:  # a single shared point would turn into a constant
            return None
        shift = self._shift
        first = int(self.points.first_after(np.array([low + shift]))[0])
        stop = int(self.points.first_from(np.array([high + shift]))[0])
        if stop - first > LONG:
            return Part(self, start, low, high)
        inner = self.points.times_of(np.arange(first, stop)) - shift
        times = np.concatenate(([low], inner, [high]))
        shifted = times - start
        # two times one unit in the last place apart may round to the same
        apart = np.diff(shifted, prepend=-1.0) > 0.0
        values = np.asarray(self.points.value[first:stop], np.float64)
        values = np.concatenate((self.at(times[:1]), values, self.at(times[-1:])))
        return Intensity(shifted[apart], values[apart], self.unit, self.percentiles)

    def _filled(
        self, times: NDArray[np.float64], after: NDArray[np.int64] | None
    ) -> NDArray[np.float64]:
        """Interpolate inside the curve, 0 outside."""
        inside = (times >= self.first_s) & (times <= self.last_s)
        result = np.zeros(times.shape, dtype=np.float64)
        within = times[inside]
        if self._shift:
            within = self._clipped(within + self._shift)
        result[inside] = self.points.interpolate(within, None if after is None else after[inside])
        return result

    def _clipped(self, times: NDArray[np.float64]) -> NDArray[np.float64]:
        return times

    def __repr__(self) -> str:
        unit = f", in {self.unit}" if self.unit else ""
        span = f"{self.first_s:g} to {self.last_s:g} s"
        return f"<Intensity: {counted(self.count, 'point')}, {span}{unit}>"


class Part(Intensity):
    """A part of a long curve, on an axis that begins at `start`: a view of the same points.

    `low` and `high` are its ends on the axis of `whole`; there it is interpolated.
    """

    _start: float
    _bounds: NDArray[np.float64]
    _inner: tuple[int, int]
    _ends_s: tuple[float, float]

    def __init__(self, whole: Intensity, start: float, low: float, high: float) -> None:
        bounds = np.array([low, high]) + whole._shift
        points = whole.points
        inner = int(points.first_after(bounds)[0]), int(points.first_from(bounds)[1])
        for name, value in (
            ("unit", whole.unit),
            ("percentiles", whole.percentiles),
            ("points", points),
            ("_start", whole._shift + start),
            ("_bounds", bounds),
            ("_inner", inner),
            ("_ends_s", (low - start, high - start)),
        ):
            self.__dict__[name] = value

    @property
    def time_s(self) -> NDArray[np.float64]:
        """The times of the points and of the two ends, made when asked for."""
        inner = self.points.times_of(np.arange(*self._inner)) - self._start
        return np.concatenate((self._ends_s[:1], inner, self._ends_s[1:]))

    @property
    def value(self) -> NDArray[np.float64]:
        """The values of the points and of the two ends, made when asked for."""
        low, high = self.points.interpolate(self._bounds)
        first, stop = self._inner
        return np.concatenate(([low], self.points.value[first:stop], [high]))

    @property
    def count(self) -> int:
        """How many points there are, with the ends."""
        return self._inner[1] - self._inner[0] + 2

    @property
    def first_s(self) -> float:
        """Where it begins."""
        return self._ends_s[0]

    @property
    def last_s(self) -> float:
        """Where it ends."""
        return self._ends_s[1]

    def scale_outside(self, gaps: Gaps) -> tuple[float, float]:
        """As for the whole; a steep end counts as a point."""
        low, high = super().scale_outside(gaps)
        if self.percentiles != EXTREMES:
            return low, high
        known = ~in_gap(gaps, np.array(self._ends_s))
        ends = self.points.interpolate(self._bounds)[known]
        return min(low, float(ends.min(initial=low))), max(high, float(ends.max(initial=high)))

    def _picked(self, index: NDArray[np.int64]) -> NDArray[np.float64]:
        # what a zoom has touched stays in memory for the next step
        return self.points.value[index].astype(np.float64)

    @property
    def _shift(self) -> float:
        return self._start

    @property
    def _between(self) -> tuple[int, int]:
        return self._inner

    def _clipped(self, times: NDArray[np.float64]) -> NDArray[np.float64]:
        # rounding of the shift may take a time past an end
        return np.clip(times, *self._bounds)


def _counted(points_s: NDArray[np.float64], times: NDArray[np.float64]) -> NDArray[np.int64]:
    """The number of points at or before each of `times`, which are evenly spaced."""
    last = len(times) - 1
    begins = np.ceil(np.clip((points_s - times[0]) / (times[1] - times[0]), 0.0, last))
    begins = begins.astype(np.int64)
    # rounding may have put it one off
    begins -= (begins > 0) & (times[begins - 1] >= points_s)
    begins += times[begins] < points_s
    return np.cumsum(np.bincount(begins, minlength=len(times) + 1)[: len(times)])
