"""A part of the timeline as a page draws and speaks it: JSON of bounded size.

``GET /data/timeline?start=S&end=S&columns=N``::

    {"title": "...", "duration_s": 5640.0, "start": "2012-09-19T09:30:00-04:00" or null,
     "window": [start_s, end_s], "unit": "...", "has_curve": true,
     "curve": {"level": [...],      N numbers 0 to 1, as felt: a peak between two columns is kept
               "value": [...]},     N numbers in the unit
     "gaps": [[start_s, end_s], ...],
     "events": [{"time_s": 786.2, "kind": "goal", "label": "...", "weight": 1.0}, ...],
     "events_left_out": 0,          beyond the first `MAX_EVENTS`
     "kinds": {"goal": 1, ...}, "notes": [...], "provenance": "..."}

Columns lie evenly from start to end, both included. Times count from the timeline's start. Events
include the details that are felt in so short a window.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from overview_dsp.errors import InputError
from overview_dsp.timeline import Timeline

COLUMNS = 1024
MAX_COLUMNS = 4096
MAX_EVENTS = 4096
MAX_GAPS = 4096


def timeline_data(
    timeline: Timeline, window: tuple[float, float], columns: int = COLUMNS
) -> dict[str, Any]:
    """The answer for a window (s); InputError if it isn't one, or for too many columns."""
    if not 2 <= columns <= MAX_COLUMNS:
        raise InputError(f"columns {columns} is out of range; it is 2 to {MAX_COLUMNS}")
    start, end = window
    part = timeline.window(start, end)
    times = np.linspace(0.0, part.duration_s, columns)
    has_curve = timeline.intensity is not None
    levels = part.normalised_levels(columns - 1) if has_curve else np.zeros(columns)
    return {
        "title": timeline.title,
        "duration_s": timeline.duration_s,
        "start": None if timeline.start is None else timeline.start.isoformat(),
        "window": [start, end],
        "unit": "" if timeline.intensity is None else timeline.intensity.unit,
        "has_curve": has_curve,
        "curve": {
            "level": [round(one, 5) for one in levels.tolist()],
            "value": [float(f"{one:.6g}") for one in part.intensity_at(times).tolist()],
        },
        "gaps": [[start + first, start + last] for first, last in part.gaps[:MAX_GAPS]],
        "events": [
            {
                "time_s": start + event.time_s,
                "kind": event.kind,
                "label": event.label,
                "weight": event.weight,
            }
            for event in part.events[:MAX_EVENTS]
        ],
        "events_left_out": max(0, len(part.events) - MAX_EVENTS),
        "kinds": part.kinds(),
        "notes": list(timeline.notes),
        "provenance": timeline.provenance,
    }
