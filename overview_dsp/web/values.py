"""The data's own values for a page: what a place of a series is, in its unit, to be seen and said.

``data/points-0.json`` has every point of the curve, for all windows, or where there are more than
`MOST` those nearest to so many even moments and those at its events, and windows have files of
their own: whatever is told of a place is a point of the data, never one made up between two.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from overview_dsp.data.timeline import Timeline

MOST = 16_384
MADE_UP = "0..1"
"""In the unit of a curve that a reader has made of events: no value of anybody's data."""

_DIGITS = 4
_SAMPLE = 1000


def has_values(timeline: Timeline) -> bool:
    """Whether the curve's values mean something to a person."""
    return timeline.intensity is not None and MADE_UP not in timeline.intensity.unit


def all_points(timeline: Timeline) -> bool:
    """Whether one file has all points of the curve."""
    return timeline.intensity is None or timeline.intensity.count <= MOST


def series_json(timeline: Timeline) -> dict[str, Any] | None:
    """How values are told: unit, decimals, whether one file has them all, whether a date alone
    doesn't say which; None without values.
    """
    if timeline.intensity is None or not has_values(timeline):
        return None
    value = timeline.intensity.value
    some = np.asarray(value[:: max(1, len(value) // _SAMPLE)])
    return {
        "unit": timeline.intensity.unit,
        "decimals": _decimals(some),
        "whole": all_points(timeline),
        "hours": _has_hours(timeline),
    }


def points_json(timeline: Timeline, start_s: float, end_s: float) -> dict[str, Any]:
    """Times (s of the timeline) and values of a part of a timeline that `has_values`."""
    curve = timeline.intensity
    assert curve is not None
    if curve.is_constant:
        return {"time_s": [start_s], "value": [_number(curve.value[0])]}
    points = curve.points
    first = int(points.first_from(np.array([start_s]))[0])
    last = int(points.first_after(np.array([end_s]))[0])
    if last <= first:  # between two points: the nearer ends of the line there
        first, last = max(0, first - 1), min(curve.count, first + 1)
    index = np.arange(first, last)
    if last - first > MOST:
        at_events = [one.time_s for one in timeline.events if start_s <= one.time_s <= end_s]
        at = np.union1d(np.linspace(start_s, end_s, MOST), at_events)
        index = np.unique(_nearest(timeline, at).clip(first, last - 1))
    times = points.times_of(index)
    known = np.ones(len(times), np.bool_)
    for gap_start, gap_end in timeline.gaps:
        known &= (times < gap_start) | (times > gap_end)
    return {
        "time_s": [_number(one) for one in times[known]],
        "value": [_number(one) for one in np.asarray(curve.value[index])[known]],
    }


def _has_hours(timeline: Timeline) -> bool:
    """Whether some points don't lie whole days apart."""
    curve = timeline.intensity
    assert curve is not None
    index = np.unique(np.linspace(0, curve.count - 1, _SAMPLE).astype(np.int64))
    days = np.diff(curve.points.times_of(index)) / 86_400
    return bool((np.abs(days - np.round(days)) > 1e-3).any())


def _nearest(timeline: Timeline, times: NDArray[np.float64]) -> NDArray[np.int64]:
    curve = timeline.intensity
    assert curve is not None
    after = curve.points.first_from(times).clip(1, curve.count - 1)
    before_s, after_s = (curve.points.times_of(one) for one in (after - 1, after))
    return np.where(times - before_s <= after_s - times, after - 1, after)


def _decimals(values: NDArray[np.generic]) -> int:
    """As many as the data have, but no more than four digits of their range (two at least)."""
    wide = values.astype(np.float64)
    span = float(np.ptp(wide))
    most = _DIGITS - 1 - (math.floor(math.log10(span)) if span > 0 else 0)
    most = min(max(most, 2), 12)
    exact = (n for n in range(most) if np.allclose(np.round(wide, n), wide, rtol=1e-6, atol=0.0))
    return next(exact, most)


def _number(value: Any) -> float | int:
    """As short as it stands in the data: single precision isn't written out as double."""
    number = float(str(value)) if isinstance(value, np.float32) else float(value)
    return int(number) if number == int(number) and abs(number) < 1e15 else number
