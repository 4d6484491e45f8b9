"""A recorded change, made again: a parameter, a preset, another part of the timeline."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from overview_dsp.engine.engine import Engine
from overview_dsp.errors import InputError
from overview_dsp.presets.dicts import preset_from_dict
from overview_dsp.timeline import Timeline


def apply_change(
    engine: Engine, whole: Timeline, what: Mapping[str, Any], sample_time: int | None = None
) -> None:
    """Make a change of `gestures.Change` at a sample; windows are of the timeline `whole`.

    Raises
    ------
    InputError
        Not a change, or one that doesn't fit this preset or timeline.
    """
    try:
        if "set" in what:
            for id, value in what["set"].items():
                engine.set(id, value, sample_time)
        elif "preset" in what:
            engine.set_preset(preset_from_dict(what["preset"]), sample_time)
        else:
            start, end = what["window"]
            engine.set_timeline(whole.window(start, end), sample_time, (start, end))
    except InputError:
        raise
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise InputError(f"not a recorded change: {str(dict(what))[:80]} ({error})") from None
