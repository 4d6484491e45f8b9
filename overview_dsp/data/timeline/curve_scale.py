"""Which values of a curve are felt as 0 and as 1."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from overview_dsp.data.timeline.curve_points import EXTREMES, CurvePoints
from overview_dsp.data.timeline.gaps import Gaps

SAMPLED = 1 << 14
"""A long curve's percentiles are those of so many of its values, spread evenly and at random."""


class CurveScale(CurvePoints):
    """A curve's percentiles, outside of gaps."""

    def scale(self, known: NDArray[np.bool_]) -> tuple[float, float]:
        """Find the values that become 0 and 1: the percentiles of the known points.

        Where those are equal (more than half of a rainfall is 0), the smallest and the largest.

        Parameters
        ----------
        known : bool (n,)
            Which points count.

        Returns
        -------
        (float, float)
            In the curve's unit.

        Examples
        --------
        >>> import numpy as np
        >>> import overview_dsp as ov
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
        """Find the values that become 0 and 1 of a long curve, without looking at all points.

        Parameters
        ----------
        gaps : tuple of (float, float)
            Spans (start_s, end_s) whose points don't count, unless all points lie in them.

        Returns
        -------
        (float, float)
            In the curve's unit.

        Examples
        --------
        >>> import numpy as np
        >>> import overview_dsp as ov
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

    def _picked(self, index: NDArray[np.int64]) -> NDArray[np.float64]:
        return self.points.picked(index)

    def _known(self, gaps: Gaps) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """The stretches of points (first, stop) that lie in no gap; all, if there are none."""
        first, stop = self._between
        starts, ends = np.array(gaps, dtype=np.float64).reshape(-1, 2).T + self._shift
        inside = np.clip(self.points.first_after(starts), first, stop)
        behind = np.clip(self.points.first_from(ends), first, stop)
        holding = inside < behind
        firsts = np.concatenate(([first], behind[holding]))
        stops = np.concatenate((inside[holding], [stop]))
        some = firsts < stops
        return (firsts[some], stops[some]) if some.any() else (np.array([first]), np.array([stop]))
