"""JSON files from which a page draws and describes the timeline and each window.

``data/timeline.json``::

    {"title", "preset", "duration_s", "start": "2012-09-19T09:30:00" or null,
     "series": {"unit", "decimals", "complete", "has_times"}, null without values (`values`),
     "reference_torque": N m, "rates": [44100, 48000],
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
     "events": [{"position", "time_s", "kind", "label", "value" of a series}, ...],
     "strike_events": [index in "events" of each strike number, or -1],
     "scale": [value at level 0, difference to the value at level 1]}

``data/points-N.json`` of a series: ``{"time_s": [s of the timeline], "value": [...]}``.

The future of a live timeline is drawn as a gap. Columns are evenly spaced and include both ends.
Each has the mean level of its points. `sound_data` has the sound of the windows.

The windows of each zoom level are a third as long as those of the level before and overlap by half.
A page can only show these windows, since it can't build surfaces. Any time lies in the middle half
of one window per level, so that a zoom shows the time before and after it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from overview_dsp.data.analysis.series_events import KINDS as SERIES_KINDS
from overview_dsp.data.timeline import Timeline
from overview_dsp.data.timeline.ticks import KINDS as TICKS
from overview_dsp.data.timeline.time_expressions import NARROWEST_S
from overview_dsp.design.presets.model import Preset
from overview_dsp.offline.export.browser_memory import event_numbers
from overview_dsp.offline.plots.style import KIND_STYLE
from overview_dsp.signal.surface.model import Surface
from overview_dsp.web.preset_data import vibration_pattern
from overview_dsp.web.values import drawn_curve, event_values, has_values, series_json

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

# shape of each known kind, and colour on the page of a study
_STYLES = {
    "goal": ("circle", "blue"),
    "own_goal": ("hexagon", "sky"),
    "near_miss": ("triangle", "green"),
    "yellow_card": ("card", "yellow"),
    "red_card": ("red", "vermilion"),
    "foul": ("cross", "grey"),
    "period": ("bar", "ink"),
    "shot": ("wedge", "green"),
    "touch": ("plus", "grey"),
    "highest": ("triangle", "vermilion"),
    "lowest": ("fall", "blue"),
    "record_high": ("square", "vermilion"),
    "record_low": ("open_square", "blue"),
    "peak": ("peak", "vermilion"),
    "trough": ("trough", "blue"),
    "largest_rise": ("diamond", "vermilion"),
    "largest_fall": ("open_diamond", "blue"),
    "crossing_up": ("arrow_up", "vermilion"),
    "crossing_down": ("arrow_down", "blue"),
}
# names of kinds whose identifier isn't plain English
_NAMES = {
    "period": "kick-off, half-time, full time",
    "crossing_up": "rises above a level",
    "crossing_down": "falls below a level",
}
_OTHER_SHAPES = (
    "star", "diamond", "triangle", "square", "circle", "wedge", "cross", "plus", "fall",
    "open_diamond", "open_triangle", "open_square", "open_circle", "open_wedge", "open_star",
    "open_fall", "pentagon", "hexagon", "arrow_up", "arrow_down", "peak", "trough",
    "open_pentagon", "open_hexagon",
)  # fmt: skip
_OTHER_COLOURS = ("vermilion", "blue", "yellow", "sky", "green", "orange", "purple")


def kind_styles(timeline: Timeline, preset: Preset) -> dict[str, dict[str, Any]]:
    """Return name, shape, colour, count and vibration pattern of each event kind.

    The result includes kinds that occur only in windows: details, ticks and extremes of a series.
    """
    counts = timeline.kinds()
    window_kinds = SERIES_KINDS if timeline.rules is not None else TICKS
    for kind in (*(detail.kind for detail in timeline.details), *window_kinds):
        counts.setdefault(kind, 0)
    fixed = {**_STYLES, **dict.fromkeys(TICKS, ("bar", "grey"))}
    others = sorted(set(counts) - set(fixed))
    taken = {fixed[kind][0] for kind in counts if kind in fixed}
    # goals of the second team are outlines
    taken |= {f"open_{fixed[kind][0]}" for kind in ("goal", "own_goal") if kind in counts}
    free = [shape for shape in _OTHER_SHAPES if shape not in taken]
    styles = {}
    for kind in (*(name for name in fixed if name in counts), *others):
        if kind in fixed:
            shape, colour = fixed[kind]
        else:
            i = others.index(kind)
            shape = free[min(i, len(free) - 1)]
            colour = _OTHER_COLOURS[i % len(_OTHER_COLOURS)]
        name = KIND_STYLE[kind][2] if kind in _STYLES else kind.replace("_", " ")
        styles[kind] = {
            "name": _NAMES.get(kind, name),
            "shape": shape,
            "colour": colour,
            "count": counts[kind],
            "pattern": list(vibration_pattern(kind, preset)),
        }
    return styles


def timeline_json(
    timeline: Timeline, preset: Preset, windows: list[Window], rates: tuple[int, ...]
) -> dict[str, Any]:
    """Return ``data/timeline.json``."""
    return {
        "title": timeline.title,
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
    map_points = {
        "time_s": (start_s + angle_map.time_s).tolist(),
        "position": angle_map.position.tolist(),
    }
    curve = drawn_curve(timeline, angle_map, COLUMNS)
    until_s = timeline.known_until_s
    now = None if until_s is None else float(angle_map.position_of(until_s))
    return {
        "angle_map": None if angle_map.is_linear else map_points,
        **curve,
        "gaps": [
            *(angle_map.position_of(gap).tolist() for gap in timeline.gaps),
            *([[now, 1.0]] if now is not None else []),
        ],
        "now": now,
        "events": [
            {
                "position": position,
                "time_s": start_s + event.time_s,
                "kind": event.kind,
                "label": event.display_label,
                **({} if value is None else {"value": value}),
            }
            for position, event, value in zip(
                angle_map.events.tolist(), timeline.events, event_values(timeline), strict=True
            )
        ],
        "strike_events": event_numbers(surface),
    }
