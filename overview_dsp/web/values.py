"""Data values of a series for the page's text and speech.

``data/points-0.json`` has all points of the curve, for all windows. A curve with more than
`MAX_POINTS` is reduced to the points nearest to evenly spaced times and to events, and to the
lowest and highest point of each of some equal spans, so that no extreme is lost. Its windows then
have files of their own. The page only shows points of the data, never interpolated values.
"""

from __future__ import annotations

import itertools
import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from overview_dsp.arrays import FloatArray, IntArray
from overview_dsp.data.timeline import Timeline
from overview_dsp.data.timeline.gaps import in_gap
from overview_dsp.signal.surface.angle_map import AngleMap

MAX_POINTS = 16_384
DERIVED_UNIT = "0..1"
"""Part of the unit of a curve that a reader derived from events; such values aren't data."""

_MAX_DIGITS = 4
_SAMPLE_SIZE = 1000
_CHUNK = 1 << 20


def has_values(timeline: Timeline) -> bool:
    """Return whether the curve's values are data in a unit."""
    return timeline.intensity is not None and DERIVED_UNIT not in timeline.intensity.unit


def fits_one_file(timeline: Timeline) -> bool:
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
        "complete": fits_one_file(timeline),
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
    gap_starts, gap_ends = np.array(timeline.gaps, dtype=np.float64).reshape(-1, 2).T
    firsts = np.append(first, points.first_from(gap_ends).clip(first, last))
    stops = np.append(points.first_after(gap_starts).clip(first, last), last)
    if (stops - firsts).sum() > MAX_POINTS:
        index = _thinned(timeline, first, last, start_s, end_s)
    else:
        index = np.concatenate([np.arange(*run) for run in zip(firsts, stops, strict=True)])
    return {
        "time_s": [_number(one) for one in points.times_of(index)],
        "value": [_number(one) for one in np.asarray(curve.value[index])],
    }


def _thinned(timeline: Timeline, first: int, last: int, start_s: float, end_s: float) -> IntArray:
    """Return about `MAX_POINTS` known points of a window, in which `last` - `first` points lie.

    Points are read in chunks, since a series may be larger than the memory.
    """
    curve = timeline.intensity
    assert curve is not None
    points = curve.points
    spans = points.first_from(np.linspace(start_s, end_s, MAX_POINTS // 4 + 1)[1:-1])
    edges = np.unique([*spans.clip(first, last), *range(first, last, _CHUNK), last])
    kept = []
    for start, stop in itertools.pairwise(edges.tolist()):
        index = np.arange(start, stop)
        index = index[~in_gap(timeline.gaps, points.times_of(index))]
        if len(index) > 0:
            values = np.asarray(curve.value[index])
            kept += [index[values.argmin()], index[values.argmax()]]
    at_events = [one.time_s for one in timeline.events if start_s <= one.time_s <= end_s]
    at = np.concatenate((np.linspace(start_s, end_s, MAX_POINTS // 2), at_events))
    for gap_start, gap_end in timeline.gaps:  # the nearest points are those at its ends
        inside = (at > gap_start) & (at < gap_end)
        at[inside] = np.where(at[inside] - gap_start <= gap_end - at[inside], gap_start, gap_end)
    after = points.first_from(at).clip(first + 1, last - 1)
    left, right = points.times_of(after - 1), points.times_of(after)
    nearest = np.where(at - left <= right - at, after - 1, after)
    nearest = nearest[~in_gap(timeline.gaps, points.times_of(nearest))]
    return np.unique([*kept, *nearest])


def drawn_curve(timeline: Timeline, angle_map: AngleMap, columns: int) -> dict[str, Any]:
    """Return the picture's curve at evenly spaced positions.

    ``level`` is 0 to 1, or null without data. ``band`` has minimum and maximum of the points of
    each column, or is null where each column has one value. ``scale`` has the value at level 0 and
    the difference to that at level 1. A series reaches from its lowest to its highest value outside
    of gaps; a curve that a reader derived from events has the levels that are felt.
    """
    curve = timeline.intensity
    if curve is None or not has_values(timeline):
        felt = angle_map.at_even_positions(timeline.normalised_levels(columns - 1))
        return {"level": _rounded(felt), "band": None, "scale": list(timeline.scale)}
    low, high = curve.extremes_outside(timeline.gaps)
    span = high - low
    times = angle_map.time_at(np.linspace(0.0, 1.0, columns))
    lows, level, highs = (
        _rounded(np.clip((row - low) / (span or 1.0), 0.0, 1.0))
        for row in curve.band(times, timeline.gaps)
    )
    band = None if lows == highs else [lows, highs]
    return {"level": level, "band": band, "scale": [low, span]}


def event_values(timeline: Timeline) -> list[float | int | None]:
    """Return the value of a series at each event; None without data."""
    if timeline.intensity is None or not has_values(timeline):
        return [None] * len(timeline.events)
    times = np.array([one.time_s for one in timeline.events], dtype=np.float64)
    values = timeline.intensity.at(times).astype(timeline.intensity.points.value.dtype)
    known = timeline.has_data(times)
    return [_number(one) if is_known else None for one, is_known in zip(values, known, strict=True)]


def _rounded(row: FloatArray) -> list[float | None]:
    return [None if math.isnan(one) else round(one, 4) for one in row.tolist()]


def _has_times(timeline: Timeline) -> bool:
    """Return whether some points aren't whole days apart."""
    curve = timeline.intensity
    assert curve is not None
    index = np.unique(np.linspace(0, curve.count - 1, _SAMPLE_SIZE).astype(np.int64))
    days = np.diff(curve.points.times_of(index)) / 86_400
    return bool((np.abs(days - np.round(days)) > 1e-3).any())


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
