"""Builder of an intensity curve from chunks, for series too long for memory."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from overview_dsp import validation
from overview_dsp.arrays import FloatArray
from overview_dsp.data.timeline import curve_points
from overview_dsp.data.timeline.gaps import Gaps
from overview_dsp.data.timeline.growable_array import Store
from overview_dsp.data.timeline.intensity import EXTREMES, Intensity
from overview_dsp.data.timeline.minmax_pyramid import CHUNK, PyramidBuilder, Values
from overview_dsp.errors import InputError
from overview_dsp.public import counted


class CurveBuilder:
    """Builder of an `Intensity` from chunks of values, in bounded memory.

    Long arrays are stored in temporary files, which are deleted after the last use of the curve.
    NaN means missing data and becomes gaps, from the last known value to the next one.

    Parameters
    ----------
    dtype : type
        Type of the stored values, `np.float32` or `np.float64`; times are float64.

    Examples
    --------
    >>> builder = ov.CurveBuilder(np.float32)
    >>> for chunk in np.arange(3_000.0).reshape(3, 1_000):
    ...     builder.append(chunk)
    >>> curve = builder.finish(step_s=0.001, unit="g")
    >>> curve.count, curve.last_s
    (3000, 2.999)
    """

    def __init__(self, dtype: type[np.float32] | type[np.float64] = np.float64) -> None:
        self._dtype = dtype
        self._values = Store(dtype)
        self._pyramid = PyramidBuilder(dtype)
        self._times: Store | None = None
        self._last_s: float | None = None
        self._known: float | None = None
        self._leading = 0
        self._holes: list[tuple[int, int]] = []
        self._open: int | None = None
        self._built: Intensity | None = None

    @property
    def count(self) -> int:
        """Number of values so far."""
        return self._values.count + self._leading

    def append(self, values: ArrayLike, time_s: ArrayLike | None = None) -> None:
        """Append the next values.

        Parameters
        ----------
        values : array_like (n,)
            In any unit; NaN is missing.
        time_s : array_like (n,) or None
            Times of the values, s, for every chunk or for none.

        Raises
        ------
        InputError
            Infinite or too large values, times that do not increase; the message names the point.
        OutputError
            The temporary folder is full.

        Examples
        --------
        >>> builder = ov.CurveBuilder()
        >>> builder.append([1.0, 2.0], time_s=[0.0, 0.7])
        >>> builder.count
        2
        """
        chunk = np.asarray(values, dtype=np.float64)
        self._take_times(len(chunk), time_s)
        missing = np.isnan(chunk)
        first = self.count
        if missing.any() or self._open is not None:
            # runs of missing values as (last known index, next known index); -1 = none yet
            edges = np.flatnonzero(np.diff(missing, prepend=self._open is not None)) + first
            for edge in edges.tolist():
                if self._open is None:
                    self._open = edge - 1
                else:
                    self._holes.append((self._open, edge))
                    self._open = None
        if self._known is None:
            if missing.all():
                self._leading += len(chunk)
                return
            self._known = float(chunk[int(np.argmin(missing))])
            curve_points.require_values(np.array([self._known]), first + int(np.argmin(missing)))
            waiting, self._leading = self._leading, 0
            while waiting:  # leading missing values become the first known value
                some = min(waiting, CHUNK)
                self._put(np.full(some, self._known))
                waiting -= some
        if missing.any():  # missing values become the last known value
            held = np.maximum.accumulate(np.where(missing, -1, np.arange(len(chunk))))
            chunk = np.where(held < 0, self._known, chunk[np.maximum(held, 0)])
        curve_points.require_values(chunk, first)
        if len(chunk):
            self._known = float(chunk[-1])
            self._put(chunk)

    def _put(self, chunk: FloatArray) -> None:
        largest = float(np.finfo(self._dtype).max)
        if self._dtype is np.float32 and np.abs(chunk).max(initial=0.0) > largest:
            raise InputError(
                f"values reach beyond {largest:.3g}, the largest of float32; keep them as float64 "
                f"(to {curve_points.MAX_VALUE:g})"
            )
        kept: Values = chunk.astype(self._dtype)
        self._values.append(kept)
        self._pyramid.append(kept)

    def _take_times(self, count: int, time_s: ArrayLike | None) -> None:
        if time_s is None:
            if self._times is not None:
                raise InputError("this chunk has no times, the ones before it had")
            return
        if self._times is None:
            if self.count:
                raise InputError("this chunk has times, the ones before it had none")
            self._times = Store(np.float64)
        times = np.asarray(time_s, dtype=np.float64)
        if len(times) != count:
            raise InputError(
                f"a chunk of {count} values has {len(times)} times; give one value for each time"
            )
        bad = np.flatnonzero(~np.isfinite(times))
        if bad.size:
            i = int(bad[0])
            raise InputError(
                f"intensity.time_s[{self.count + i}] is {float(times[i])!r}, not a finite number; "
                f"{validation.TIME_HINT}"
            )
        curve_points.require_increasing(times, self.count, self._last_s)
        if count:
            self._last_s = float(times[-1])
            self._times.append(times)

    def finish(
        self,
        step_s: float | None = None,
        first_s: float = 0.0,
        unit: str = "",
        percentiles: tuple[float, float] = EXTREMES,
    ) -> Intensity:
        """Finish the curve; nothing more can be appended.

        Parameters
        ----------
        step_s : float or None
            Time between values, s, if they have no times.
        first_s : float
            Time of the first value, s, if they have no times.
        unit : str
            Unit of the values.
        percentiles : (float, float)
            Percentiles for scaling, as in `Intensity`.

        Returns
        -------
        Intensity
            The curve.

        Raises
        ------
        InputError
            No value, or not exactly one of times and step.

        Examples
        --------
        >>> builder = ov.CurveBuilder(np.float32)
        >>> for chunk in np.arange(3_000.0).reshape(3, 1_000):
        ...     builder.append(chunk)
        >>> builder.finish(step_s=0.5).last_s
        1499.5
        """
        if self._known is None:
            raise InputError("the series has no value; give at least one")
        if (self._times is None) == (step_s is None):
            raise InputError("give the times with the values, or the step between them, not both")
        value = self._values.finish()
        if self._times is not None:
            time_s: curve_points.Times = self._times.finish()
        else:
            assert step_s is not None
            time_s = curve_points.RegularTimes(len(value), step_s, first_s)
        points = curve_points.Points(time_s, value)
        points.__dict__["levels"] = self._pyramid.finish()
        self._built = Intensity.checked(points, unit, percentiles)
        return self._built

    def gaps(self, duration_s: float) -> Gaps:
        """Return the gaps without values, after `finish`.

        Parameters
        ----------
        duration_s : float
            Length of the timeline, s.

        Returns
        -------
        tuple of (float, float)
            Spans (start_s, end_s) without data, for `Timeline`.

        Examples
        --------
        >>> builder = ov.CurveBuilder()
        >>> builder.append([1.0, 2.0, np.nan, 4.0])
        >>> curve = builder.finish(step_s=1.0)
        >>> builder.gaps(duration_s=3.0)
        ((1.0, 3.0),)
        """
        assert self._built is not None
        points = self._built.points
        count = len(points.value)
        holes = [*self._holes, *([(self._open, count)] if self._open is not None else [])]
        edges = np.array(holes, dtype=np.int64).reshape(-1, 2)
        times = points.times_of(np.clip(edges, 0, count - 1))
        times[edges < 0] = 0.0
        times[edges >= count] = duration_s
        return tuple((start, end) for start, end in times.tolist() if start < end)

    def __repr__(self) -> str:
        return f"<CurveBuilder: {counted(self.count, 'value')}, {np.dtype(self._dtype).name}>"
