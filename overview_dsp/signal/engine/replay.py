"""Replay of recorded changes: parameters, presets, windows and updates of a live timeline."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from overview_dsp.data.feeds.timeline_diff import announcement_of, apply_diff
from overview_dsp.data.timeline import Timeline
from overview_dsp.design.presets.serialization import preset_from_dict
from overview_dsp.design.presets.validation import migrate_values
from overview_dsp.errors import InputError
from overview_dsp.signal.engine.engine import Engine
from overview_dsp.signal.surface.angle_map import without_map
from overview_dsp.signal.surface.build import build_surface
from overview_dsp.signal.surface.live_update import join_surfaces


def apply_change(
    engine: Engine, whole: Timeline, what: Mapping[str, Any], sample_time: int | None = None
) -> Timeline:
    """Apply a change of `gestures.Change` at a sample; return the whole timeline after it.

    Windows refer to the timeline `whole`. InputError if the change is invalid or doesn't fit.
    """
    try:
        if "set" in what:
            for id, value in migrate_values(what["set"]).items():
                engine.set(id, value, sample_time)
        elif "preset" in what:
            engine.set_preset(preset_from_dict(what["preset"]), sample_time)
        elif "pattern" in what:
            set_pattern(engine, what, sample_time)
        elif "timeline" in what:
            grown = apply_diff(whole, what["timeline"])
            window = what["timeline"].get("window")
            shown = grown if window is None else grown.window(*window)
            cursor = what["timeline"].get("ahead")
            surface, before = None, engine.surface
            if cursor is not None or what["timeline"].get("keeps_map"):
                surface = build_surface(shown, engine.preset, before.angle_map)
            if cursor is not None and surface is not None:
                surface = join_surfaces(before, surface, float(cursor))
                if surface is None:
                    raise InputError(f"the change alters events before position {cursor:g}")
            engine.set_timeline(shown, sample_time, change=what, surface=surface)
            return grown
        else:
            start, end = what["window"]
            engine.set_timeline(whole.window(start, end), sample_time, (start, end))
    except InputError:
        raise
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise InputError(f"not a recorded change: {str(dict(what))[:80]} ({error})") from None
    return whole


def set_pattern(engine: Engine, change: Mapping[str, Any], sample_time: int | None = None) -> None:
    """Set the announcement pattern of a change as the timeline, without an angle map.

    Raises the errors of `Engine.set_timeline`.
    """
    pattern = announcement_of(change["pattern"])
    surface = build_surface(pattern, without_map(engine.preset))
    engine.set_timeline(pattern, sample_time, change=change, surface=surface)
