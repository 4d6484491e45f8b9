"""Data values of a series for the page's text and speech.

``data/points-0.json`` has all points of the curve, for all windows. A curve with more than
`MAX_POINTS` is reduced to the points nearest to evenly spaced times and to events. Its windows then
have files of their own. The page only shows points of the data, never interpolated values.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from overview_dsp.data.timeline import Timeline

MAX_POINTS = 16_384
DERIVED_UNIT = "0..1"
"""Part of the unit of a curve that a reader derived from events; such values aren't data."""

_MAX_DIGITS = 4
_SAMPLE_SIZE = 1000


def has_values(timeline: Timeline) -> bool:
    """Return whether the curve's values are data in a unit."""
    return timeline.intensity is not None and DERIVED_UNIT not in timeline.intensity.unit


def all_points(timeline: Timeline) -> bool:
    """Return whether one file has all points of the curve."""
    return timeline.intensity is None or timeline.intensity.count <= MAX_POINTS


def series_json(timeline: Timeline) -> dict[str, Any] | None:
    """Return the format of a series' values; None without values."""
    if timeline.intensity is None or not has_values(timeline):
        return None
    value = timeline.intensity.value
    sample = np.asarray(value[:: max(1, len(value) // _SAMPLE_SIZE)])
    return {
        "unit": timeline.intensity.unit,
        "decimals": _decimals(sample),
        "complete": all_points(timeline),
        "has_times": _has_times(timeline),
    }


def points_json(timeline: Timeline, start_s: float, end_s: float) -> dict[str, Any]:
    """Return times (s of the timeline) and values of a window; `has_values` must be true."""
    curve = timeline.intensity
    assert curve is not None
    if curve.is_constant:
        return {"time_s": [start_s], "value": [_number(curve.value[0])]}
    points = curve.points
    first = int(points.first_from(np.array([start_s]))[0])
    last = int(points.first_after(np.array([end_s]))[0])
    if last <= first:  # between two points: use both
        first, last = max(0, first - 1), min(curve.count, first + 1)
    index = np.arange(first, last)
    if last - first > MAX_POINTS:
        at_events = [one.time_s for one in timeline.events if start_s <= one.time_s <= end_s]
        at = np.union1d(np.linspace(start_s, end_s, MAX_POINTS), at_events)
        index = np.unique(_nearest(timeline, at).clip(first, last - 1))
    times = points.times_of(index)
    is_data = np.ones(len(times), np.bool_)
    for gap_start, gap_end in timeline.gaps:
        is_data &= (times < gap_start) | (times > gap_end)
    return {
        "time_s": [_number(one) for one in times[is_data]],
        "value": [_number(one) for one in np.asarray(curve.value[index])[is_data]],
    }


def _has_times(timeline: Timeline) -> bool:
    """Return whether some points aren't whole days apart."""
    curve = timeline.intensity
    assert curve is not None
    index = np.unique(np.linspace(0, curve.count - 1, _SAMPLE_SIZE).astype(np.int64))
    days = np.diff(curve.points.times_of(index)) / 86_400
    return bool((np.abs(days - np.round(days)) > 1e-3).any())


def _nearest(timeline: Timeline, times: NDArray[np.float64]) -> NDArray[np.int64]:
    curve = timeline.intensity
    assert curve is not None
    after = curve.points.first_from(times).clip(1, curve.count - 1)
    before_s, after_s = (curve.points.times_of(one) for one in (after - 1, after))
    return np.where(times - before_s <= after_s - times, after - 1, after)


def _decimals(values: NDArray[np.generic]) -> int:
    """Return the data's decimals, limited to four digits of the range but at least two."""
    doubles = values.astype(np.float64)
    span = float(np.ptp(doubles))
    limit = _MAX_DIGITS - 1 - (math.floor(math.log10(span)) if span > 0 else 0)
    limit = min(max(limit, 2), 12)
    exact = (
        n for n in range(limit) if np.allclose(np.round(doubles, n), doubles, rtol=1e-6, atol=0.0)
    )
    return next(exact, limit)


def _number(value: Any) -> float | int:
    """Return a short JSON number; single precision isn't expanded to double."""
    number = float(str(value)) if isinstance(value, np.float32) else float(value)
    return int(number) if number == int(number) and abs(number) < 1e15 else number
