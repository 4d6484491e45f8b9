"""JSON files from which a page draws and describes the timeline and each window.

``data/timeline.json``::

    {"title", "preset", "duration_s", "start": "2012-09-19T09:30:00" or null,
     "series": {"unit", "decimals", "complete", "has_times"}, null without values,
     "reference_torque": N m, "rates": [44100, 48000], "sides": names of two teams or [],
     "kinds": {"goal": {"name": "goal", "shape": "circle", "colour": "blue", "count": 6,
                        "pattern": [on ms, off ms, on ms]}, ...},
     "provenance", "notes": [...], "windows": [{"level", "start_s", "end_s"}, ...],
     "server": see `data`, null in a static folder,
     "live": {"levels", "version"} of a live timeline (in a static folder "poll_s" too), or null}

``data/window-N.json``, with positions from 0 to 1 in the window::

    {"angle_map": {"time_s": [s of the timeline], "position": [...]}, linear between its points,
        or null where position is proportional to time,
     "level": [COLUMNS numbers 0 to 1, null without data], "band": null or [minimum, maximum] of
        the levels of each column,
     "gaps": [[from, to], ...], "now": position up to which data are known, or null,
     "events": [{"position", "time_s", "kind", "label", "value" of a series, "change": [number,
        unit], "side", "score" after a goal, counted in the window: "1-0"}, ...],
     "strike_events": [index in "events" of each strike number, or -1],
     "scale": [value at level 0, difference to the value at level 1]}

``data/points-N.json`` of a series: ``{"time_s": [s of the timeline], "value": [...]}``.
``data/points-0.json`` has all points of the curve, for all windows. A curve with more than
`MAX_POINTS` is reduced to the points nearest to evenly spaced times and to events, and to the
lowest and highest point of each of some equal spans, so that no extreme is lost. Its windows then
have files of their own. The page only shows points of the data, never interpolated values.

The future of a live timeline is drawn as a gap. Columns are evenly spaced and include both ends.
Each has the mean level of its points. `sound_data` has the sound of the windows.

The windows of each zoom level are a third as long as those of the level before and overlap by half.
A page can only show these windows, since it can't build surfaces. Any time lies in the middle half
of one window per level, so that a zoom shows the time before and after it.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from overview_dsp.arrays import FloatArray, IntArray
from overview_dsp.data.analysis.series_events import KINDS as SERIES_KINDS
from overview_dsp.data.analysis.series_events import has_values
from overview_dsp.data.timeline import Event, Intensity, Timeline
from overview_dsp.data.timeline.gaps import in_gap
from overview_dsp.data.timeline.ticks import KINDS as TICKS
from overview_dsp.data.timeline.time_expressions import NARROWEST_S
from overview_dsp.design.presets.model import Preset
from overview_dsp.live.screen.position_report import running_scores
from overview_dsp.offline.export.browser_memory import event_numbers
from overview_dsp.offline.plots.style import KIND_STYLE
from overview_dsp.signal.surface.angle_map import AngleMap
from overview_dsp.signal.surface.model import Surface
from overview_dsp.web.preset_data import KINDS, vibration_pattern

MAX_POINTS = 16_384
_MAX_DIGITS = 4
_SAMPLE_SIZE = 1000
_CHUNK = 1 << 20


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
        "has_times": _has_times(timeline.intensity),
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


def event_fields(event: Event) -> dict[str, Any]:
    """Return the label without a series' value and date, and the change of a rise or fall."""
    if event.kind not in SERIES_KINDS:
        return {"label": event.display_label}
    label = event.label.partition(" to ")[0].partition(" (")[0]
    number, _, unit = label.partition(" ")
    is_change = label[:1] in ("+", "-") and number[1:].replace(".", "", 1).isdigit()
    return {"label": "", "change": [float(number), unit]} if is_change else {"label": label}


def _rounded(row: FloatArray) -> list[float | None]:
    return [None if math.isnan(one) else round(one, 4) for one in row.tolist()]


def _has_times(curve: Intensity) -> bool:
    """Return whether some points aren't whole days apart."""
    index = np.unique(np.linspace(0, curve.count - 1, _SAMPLE_SIZE).astype(np.int64))
    days = np.diff(curve.points.times_of(index)) / 86_400
    return bool((np.abs(days - np.round(days)) > 1e-3).any())


def _decimals(values: NDArray[np.generic]) -> int:
    """Return the data's decimals, limited to four digits of the range but at least two."""
    doubles = values.astype(np.float64)
    span = float(np.ptp(doubles))
    limit = _MAX_DIGITS - 1 - (math.floor(math.log10(span)) if span > 0 else 0)
    limit = min(max(limit, 2), 12)
    rounded = ((n, np.round(doubles, n)) for n in range(limit))
    exact = (n for n, row in rounded if np.allclose(row, doubles, rtol=1e-6, atol=0.0))
    return next(exact, limit)


def _number(value: Any) -> float | int:
    """Return a short JSON number; single precision isn't expanded to double."""
    number = float(str(value)) if isinstance(value, np.float32) else float(value)
    return int(number) if number == int(number) and abs(number) < 1e15 else number


RATIO = 3
LEAST_CONTENT = 8
"""Minimum mean number of values or events in the windows of a default zoom level."""


@dataclass(frozen=True)
class Window:
    """Window (s) of a zoom level; level 0 is the whole timeline."""

    level: int
    start_s: float
    end_s: float


def default_levels(timeline: Timeline) -> int:
    """Return the zoom levels that show something new: up to 3, with 8 values or events a window."""
    values = timeline.intensity.count if timeline.intensity and has_values(timeline) else 0
    count = max(values, len(timeline.events) + len(timeline.details))
    return next((n for n in (3, 2, 1) if count >= LEAST_CONTENT * RATIO**n), 0)


def site_windows(timeline: Timeline, levels: int) -> list[Window]:
    """Return the whole timeline, then the windows of each level in order of time."""
    whole = timeline.duration_s
    windows = [Window(0, 0.0, whole)]
    for level in range(1, levels + 1):
        width = whole / RATIO**level
        if width < NARROWEST_S:
            break
        count = 2 * RATIO**level - 1
        for i in range(count):
            start = min(i * width / 2.0, whole - width)
            end = whole if i == count - 1 else start + width
            windows.append(Window(level, start, end))
    return windows


COLUMNS = 1025


def kind_styles(timeline: Timeline, preset: Preset) -> dict[str, dict[str, Any]]:
    """Return name, shape, colour, count and vibration pattern of each event kind.

    The result includes kinds that occur only in windows: details, ticks and extremes of a series.
    """
    counts = timeline.kinds()
    window_kinds = SERIES_KINDS if timeline.rules is not None else TICKS
    for kind in (*(detail.kind for detail in timeline.details), *window_kinds):
        counts.setdefault(kind, 0)
    fixed = KINDS["known"] | {kind: {"shape": "bar", "colour": "grey"} for kind in TICKS}
    others = sorted(set(counts) - set(fixed))
    taken = {fixed[kind]["shape"] for kind in counts if kind in fixed}
    # goals of the second team are outlines
    taken |= {f"open_{fixed[kind]['shape']}" for kind in ("goal", "own_goal") if kind in counts}
    free = [shape for shape in KINDS["others"]["shapes"] if shape not in taken]
    colours = KINDS["others"]["colours"]
    for i, kind in enumerate(others):
        shape = free[min(i, len(free) - 1)]
        fixed[kind] = {"shape": shape, "colour": colours[i % len(colours)]}
    styles = {}
    for kind in filter(counts.__contains__, fixed):
        name = KIND_STYLE[kind][2] if kind in KINDS["known"] else kind.replace("_", " ")
        pattern = list(vibration_pattern(kind, preset))
        styles[kind] = {"name": name, **fixed[kind], "count": counts[kind], "pattern": pattern}
    return styles


def timeline_json(
    timeline: Timeline, preset: Preset, windows: list[Window], rates: tuple[int, ...]
) -> dict[str, Any]:
    """Return ``data/timeline.json``."""
    return {
        "title": timeline.title,
        "sides": timeline.sides,
        "preset": preset.name,
        "duration_s": timeline.duration_s,
        "start": None if timeline.start is None else timeline.start.isoformat(),
        "series": series_json(timeline),
        "reference_torque": preset.number("tactor.reference_torque_mnm") * 1e-3,
        "rates": list(rates),
        "kinds": kind_styles(timeline, preset),
        "provenance": timeline.provenance,
        "notes": list(timeline.notes),
        "windows": [vars(window) for window in windows],
    }


def window_json(timeline: Timeline, surface: Surface, start_s: float) -> dict[str, Any]:
    """Return ``data/window-N.json`` of a window that begins at `start_s` of the whole timeline."""
    angle_map = surface.angle_map
    times, positions = start_s + angle_map.time_s, angle_map.position
    map_points = {"time_s": times.tolist(), "position": positions.tolist()}
    scores = dict(running_scores(timeline))
    until_s = timeline.known_until_s
    now = None if until_s is None else float(angle_map.position_of(until_s))
    future = [] if now is None else [[now, 1.0]]
    return {
        "angle_map": None if angle_map.is_linear else map_points,
        **drawn_curve(timeline, angle_map, COLUMNS),
        "gaps": [angle_map.position_of(gap).tolist() for gap in timeline.gaps] + future,
        "now": now,
        "events": [
            {
                "position": position,
                "time_s": start_s + event.time_s,
                "kind": event.kind,
                **event_fields(event),
                **({} if value is None else {"value": value}),
                **({"side": event.side} if event.side else {}),
                **({"score": scores[event]} if event in scores else {}),
            }
            for position, event, value in zip(
                angle_map.events.tolist(), timeline.events, event_values(timeline), strict=True
            )
        ],
        "strike_events": event_numbers(surface),
    }
