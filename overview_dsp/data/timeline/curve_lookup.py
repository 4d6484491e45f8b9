"""The curve of a timeline looked up: its values, and how much of it is felt."""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from overview_dsp import validation
from overview_dsp.data.timeline.contents import Contents
from overview_dsp.data.timeline.gaps import in_gap
from overview_dsp.data.timeline.intensity import EXTREMES, LONG


class CurveLookup(Contents):
    """A timeline's curve at any moment, in its unit and on a scale of 0 to 1."""

    @cached_property
    def scale(self) -> tuple[float, float]:
        """The value of the curve that is felt as 0, and how much above it as 1."""
        if self.intensity is None:
            return 0.0, 0.0
        curve = self.intensity
        if curve.count > LONG:
            low, high = curve.scale_outside(self.gaps)
        else:
            times = np.asarray(curve.time_s)
            known = np.ones(1, np.bool_) if curve.is_constant else self._has_data(times)
            low, high = curve.scale(known)
        as_is = curve.percentiles == EXTREMES and low >= 0.0 and high <= 1.0
        return (0.0, 1.0) if as_is else (low, high - low)

    def intensity_at(self, times: ArrayLike) -> NDArray[np.float64]:
        """Look up the curve, straight between its points and exact at them.

        Parameters
        ----------
        times : array_like
            Seconds, any shape.

        Returns
        -------
        float64
            Of that shape, in the curve's unit. 0 where there is no curve: before the first point
            and after the last, inside a gap (its ends excluded), for a timeline without intensity,
            and for NaN. A curve of one point has that value over the whole timeline.

        Examples
        --------
        >>> import overview_dsp as ov
        >>> match = ov.load_timeline("world-cup-final-2018")
        >>> match.intensity_at([-1.0, 1e9])
        array([0., 0.])
        """
        at = validation.numbers(times, "times")
        flat = at.reshape(-1)  # a scalar too: boolean indexing needs an axis
        return np.where(self._has_data(flat), self._curve_at(flat), 0.0).reshape(at.shape)

    def normalised_intensity_at(self, times: ArrayLike) -> NDArray[np.float64]:
        """Look up the curve on a scale of 0 to 1.

        If all points (outside gaps) lie within [0, 1] already, values are taken as they are, a
        constant too. Otherwise the smallest becomes 0 and the largest 1, and a constant curve 0. A
        curve with percentiles of its own is scaled by these, always, and clipped beyond them.

        Parameters
        ----------
        times : array_like
            Seconds, any shape.

        Returns
        -------
        float64
            Of that shape, 0 to 1; 0 where there is no curve, as `intensity_at`.

        Examples
        --------
        >>> import numpy as np
        >>> import overview_dsp as ov
        >>> curve = ov.Intensity(np.array([0.0, 10.0]), np.array([-5.0, 5.0]))
        >>> ov.Timeline("rising", 10.0, (), curve).normalised_intensity_at([5.0, 10.0])
        array([0.5, 1. ])
        """
        at = np.asarray(times, dtype=np.float64)
        flat = at.reshape(-1)
        low, span = self.scale
        if span == 0.0:
            return np.zeros(at.shape, dtype=np.float64)
        # clipped first: a span may be so small that what lies beyond it overflows
        scaled = np.clip(self._curve_at(flat) - low, 0.0, span) / span
        return np.where(self._has_data(flat), scaled, 0.0).reshape(at.shape)

    def normalised_levels(self, steps: int) -> NDArray[np.float64]:
        """Look up the curve on a scale of 0 to 1 at even moments from the start to the end.

        For a surface: each moment stands for those nearest to it. Where the curve has few points
        this is `normalised_intensity_at`; where many points fall on one moment, what is felt of
        them.

        Parameters
        ----------
        steps : int
            Into how many equal parts the timeline is cut.

        Returns
        -------
        float64 (steps + 1,)
            0 to 1; anything in between inside a gap.

        Examples
        --------
        >>> import overview_dsp as ov
        >>> match = ov.load_timeline("world-cup-final-2018")
        >>> match.normalised_levels(100).shape
        (101,)
        """
        at = np.arange(steps + 1, dtype=np.float64) * (self.duration_s / steps)
        low, span = self.scale
        curve = self.intensity
        if curve is None or span == 0.0:
            return np.zeros(steps + 1)
        levels = curve.along(at) - low
        np.clip(levels, 0.0, span, out=levels)
        levels /= span
        if not curve.is_constant:
            levels[: np.searchsorted(at, curve.first_s)] = 0.0
            levels[np.searchsorted(at, curve.last_s, side="right") :] = 0.0
        return levels

    def _curve_at(self, at: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.zeros(at.shape) if self.intensity is None else self.intensity.at(at)

    def _has_data(self, at: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Return where the curve covers `at`, shape (n,)."""
        if self.intensity is None:
            return np.zeros(at.shape, dtype=np.bool_)
        first, last = self.intensity.first_s, self.intensity.last_s
        if self.intensity.is_constant:
            first, last = 0.0, self.duration_s
        covered = (at >= first) & (at <= last) & ~in_gap(self.gaps, at)
        return np.asarray(covered, dtype=np.bool_)
