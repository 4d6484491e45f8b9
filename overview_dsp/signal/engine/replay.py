"""A recorded change, made again: a parameter, a preset, a part of the timeline, or how it grew."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from overview_dsp.data.feeds.timeline_diff import announcement_of, apply_diff
from overview_dsp.data.timeline import Timeline
from overview_dsp.design.presets.dicts import preset_from_dict
from overview_dsp.design.presets.validation import migrated_values
from overview_dsp.errors import InputError
from overview_dsp.signal.engine.engine import Engine
from overview_dsp.signal.surface.ahead import joined
from overview_dsp.signal.surface.angle_map import without_map
from overview_dsp.signal.surface.build import build_surface


def apply_change(
    engine: Engine, whole: Timeline, what: Mapping[str, Any], sample_time: int | None = None
) -> Timeline:
    """Make a change of `gestures.Change` at a sample; windows are of the timeline `whole`.

    Returns
    -------
    Timeline
        The whole from then on: another one where it has grown.

    Raises
    ------
    InputError
        Not a change, or one that doesn't fit this preset or timeline.
    """
    try:
        if "set" in what:
            for id, value in migrated_values(what["set"]).items():
                engine.set(id, value, sample_time)
        elif "preset" in what:
            engine.set_preset(preset_from_dict(what["preset"]), sample_time)
        elif "pattern" in what:
            set_pattern(engine, what, sample_time)
        elif "timeline" in what:
            grown = apply_diff(whole, what["timeline"])
            window = what["timeline"].get("window")
            shown = grown if window is None else grown.window(*window)
            ahead = what["timeline"].get("ahead")
            surface, before = None, engine.surface
            if ahead is not None or what["timeline"].get("keeps_map"):
                surface = build_surface(shown, engine.preset, before.angle_map)
            if ahead is not None and surface is not None:
                surface = joined(before, surface, float(ahead))
                if surface is None:
                    raise InputError(f"what was behind {ahead:g} isn't what it was")
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
    """Put the pattern of a change under the disk, where its tap reaches: without an angle map.

    Errors as `Engine.set_timeline`.
    """
    pattern = announcement_of(change["pattern"])
    surface = build_surface(pattern, without_map(engine.preset))
    engine.set_timeline(pattern, sample_time, change=change, surface=surface)
