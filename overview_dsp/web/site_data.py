"""What a page draws and speaks: JSON of the timeline and of each of its windows.

``data/timeline.json``::

    {"title", "preset", "duration_s", "start": "2012-09-19T09:30:00" or null,
     "series": {"unit", "decimals", "whole", "hours"} or null where a curve has no
        values (`values`),
     "full_torque": N m, "bare_friction": N m s/rad, "rates": [44100, 48000],
     "kinds": {"goal": {"words": "goal", "shape": "circle", "colour": "blue", "count": 6,
                        "pulse": [on ms, off ms, on ms]}, ...},
     "provenance", "notes": [...], "windows": [{"level", "start_s", "end_s"}, ...],
     "server": null in a folder, else what `data` says,
     "live": null, or {"levels", "version"} of a timeline that grows; in a folder "poll_s" too}

``data/window-N.json``, places being 0 to 1 in that window::

    {"map": {"time_s": [s of the timeline], "place": [...]}, between whose points places are linear
        in time, or null where they are all along,
     "level": [COLUMNS numbers 0 to 1], "resistance": [COLUMNS numbers, N m s/rad],
     "gaps": [[from, to], ...], "now": the place up to where it has happened, or null,
     "events": [{"place", "time_s", "kind", "label"}, ...],
     "struck": [of each number that a strike may name, its index in "events", or -1],
     "scale": [the value at level 0, how much more it is at level 1]}

``data/points-N.json``, of a series: ``{"time_s": [s of the timeline], "value": [...]}``.

What hasn't happened yet is drawn as a gap.

Columns lie evenly, both ends included; each has what is felt nearest to it, and the largest
resistance. A window's sound is beside it (`sound_data`).

The parts that a page can zoom to: each level a third as long, half overlapping.

A page can't make a surface; it is given those of these windows. Any moment lies in the middle half
of one of each level, so that a zoom about it finds what led to it and what came of it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from overview_dsp.data.analysis.series_events import KINDS as SERIES_KINDS
from overview_dsp.data.timeline import Timeline
from overview_dsp.data.timeline.ticks import KINDS as TICKS
from overview_dsp.data.timeline.time_expressions import NARROWEST_S
from overview_dsp.design.presets.model import Preset
from overview_dsp.kernels.layout import CELLS
from overview_dsp.offline.export.browser_memory import event_numbers
from overview_dsp.offline.plots.style import KIND_STYLE
from overview_dsp.signal.surface.angle_map import AngleMap
from overview_dsp.signal.surface.model import Surface
from overview_dsp.web.preset_data import pulse_of
from overview_dsp.web.values import series_json

RATIO = 3


@dataclass(frozen=True)
class Part:
    """A window (s) of a level; level 0 is the whole."""

    level: int
    start_s: float
    end_s: float


def site_windows(timeline: Timeline, levels: int) -> list[Part]:
    """The whole, then the windows of each level in order of time."""
    whole = timeline.duration_s
    parts = [Part(0, 0.0, whole)]
    for level in range(1, levels + 1):
        width = whole / RATIO**level
        if width < NARROWEST_S:
            break
        count = 2 * RATIO**level - 1
        for i in range(count):
            start = min(i * width / 2.0, whole - width)
            end = whole if i == count - 1 else start + width
            parts.append(Part(level, start, end))
    return parts


COLUMNS = 1025

# of each kind that has a style in the pictures: the page's shape and colour
_LOOKS = {
    "goal": ("circle", "blue"),
    "own_goal": ("hexagon", "sky"),
    "near_miss": ("triangle", "green"),
    "yellow_card": ("square", "yellow"),
    "red_card": ("diamond", "vermilion"),
    "foul": ("cross", "grey"),
    "period": ("bar", "ink"),
    "shot": ("wedge", "green"),
    "touch": ("plus", "grey"),
}
_TICK = ("bar", "grey")
# in plain words, where a kind's name isn't
_WORDS = {
    "period": "kick-off, half-time, full time",
    "crossing_up": "rises above a level",
    "crossing_down": "falls below a level",
}
_OTHER_SHAPES = ("pentagon", "star", "triangle", "square", "diamond", "circle", "wedge", "hexagon")
_OTHER_COLOURS = ("vermilion", "blue", "yellow", "sky", "green", "orange", "purple")


def kind_looks(timeline: Timeline, preset: Preset) -> dict[str, dict[str, Any]]:
    """Shape, colour, words, count and pulse of each kind of event; known ones as pictured.

    Those that only windows have are there too: details, ticks, what is found in a series' parts.
    """
    counts = timeline.kinds()
    found = SERIES_KINDS if timeline.rules is not None else TICKS
    for kind in (*(detail.kind for detail in timeline.details), *found):
        counts.setdefault(kind, 0)
    others = sorted(set(counts) - set(_LOOKS) - set(TICKS))
    looks = {}
    for kind in (*(name for name in (*_LOOKS, *TICKS) if name in counts), *others):
        if kind in TICKS:
            shape, colour = _TICK
            words = kind.replace("_", " ")
        elif kind in _LOOKS:
            shape, colour = _LOOKS[kind]
            words = _WORDS.get(kind, KIND_STYLE[kind][2])
        else:
            i = others.index(kind)
            shape = _OTHER_SHAPES[i % len(_OTHER_SHAPES)]
            colour = _OTHER_COLOURS[i % len(_OTHER_COLOURS)]
            words = _WORDS.get(kind, kind.replace("_", " "))
        looks[kind] = {
            "words": words,
            "shape": shape,
            "colour": colour,
            "count": counts[kind],
            "pulse": list(pulse_of(kind, preset)),
        }
    return looks


def timeline_json(
    timeline: Timeline, preset: Preset, parts: list[Part], rates: tuple[int, ...]
) -> dict[str, Any]:
    """What holds for all windows."""
    return {
        "title": timeline.title,
        "preset": preset.name,
        "duration_s": timeline.duration_s,
        "start": None if timeline.start is None else timeline.start.isoformat(),
        "series": series_json(timeline),
        "full_torque": preset.number("tactor.full_torque_mnm") * 1e-3,
        "bare_friction": preset.number("surface.friction"),
        "rates": list(rates),
        "kinds": kind_looks(timeline, preset),
        "provenance": timeline.provenance,
        "notes": list(timeline.notes),
        "windows": [
            {"level": part.level, "start_s": part.start_s, "end_s": part.end_s} for part in parts
        ],
    }


def window_json(shown: Timeline, surface: Surface, start_s: float) -> dict[str, Any]:
    """What is drawn of a window: the part `shown`, which begins at `start_s` of the timeline."""
    nearest = np.rint(np.arange(CELLS + 1) * ((COLUMNS - 1) / CELLS)).astype(np.int64)
    first = np.searchsorted(nearest, np.arange(COLUMNS))
    resistance = np.maximum.reduceat(surface.resistance, first)
    angle_map = surface.angle_map
    level = angle_map.at_even_positions(shown.normalised_levels(COLUMNS - 1))
    now = None if shown.known_until_s is None else float(angle_map.position_of(shown.known_until_s))
    return {
        "map": _map_json(angle_map, start_s),
        "level": [round(one, 4) for one in level.tolist()],
        "resistance": [float(f"{one:.4g}") for one in resistance.tolist()],
        "gaps": [
            *(angle_map.position_of(gap).tolist() for gap in shown.gaps),
            *([[now, 1.0]] if now is not None else []),
        ],
        "now": now,
        "events": [
            {
                "place": place,
                "time_s": start_s + event.time_s,
                "kind": event.kind,
                "label": event.display_label,
            }
            for place, event in zip(angle_map.events.tolist(), shown.events, strict=True)
        ],
        "struck": event_numbers(surface),
        "scale": list(shown.scale),
    }


def _map_json(angle_map: AngleMap, start_s: float) -> dict[str, list[float]] | None:
    if angle_map.is_linear:
        return None
    time_s = start_s + angle_map.time_s
    return {"time_s": time_s.tolist(), "place": angle_map.position.tolist()}
