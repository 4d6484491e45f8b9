"""Recorded changes of an engine: parameters, presets, windows and updates of a live timeline.

An update of a surface that is being touched changes only the part ahead of the cursor.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from overview_dsp.arrays import FloatArray
from overview_dsp.data.feeds.timeline_diff import announcement_of, apply_diff
from overview_dsp.data.timeline import Timeline
from overview_dsp.design.presets.serialization import preset_from_dict
from overview_dsp.design.presets.validation import migrate_values
from overview_dsp.errors import InputError
from overview_dsp.signal.engine.engine import Engine
from overview_dsp.signal.surface.angle_map import without_map
from overview_dsp.signal.surface.build import build_surface
from overview_dsp.signal.surface.model import Surface, TextureStrikes


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
            shown = part_of(grown, window)
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
            engine.set_timeline(part_of(whole, (start, end)), sample_time, (start, end))
    except InputError:
        raise
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise InputError(f"not a recorded change: {str(dict(what))[:80]} ({error})") from None
    return whole


def part_of(whole: Timeline, window: Sequence[float] | None) -> Timeline:
    """Return a window (s); None or a window of everything is the timeline without more ticks."""
    if window is None or tuple(window) == (0.0, whole.duration_s):
        return whole
    return whole.window(*window)


def set_pattern(engine: Engine, change: Mapping[str, Any], sample_time: int | None = None) -> None:
    """Set the announcement pattern of a change as the timeline, without an angle map.

    Raises the errors of `Engine.set_timeline`.
    """
    pattern = announcement_of(change["pattern"])
    surface = build_surface(pattern, without_map(engine.preset))
    engine.set_timeline(pattern, sample_time, change=change, surface=surface)


BLEND = 0.01
"""Part of the surface over which friction changes from old to new."""


def join_surfaces(old: Surface, new: Surface, cursor: float) -> Surface | None:
    """Return a surface that is the old one up to the cursor (0 to 1) and the new one beyond it.

    Both are of the same preset and of timelines of the same duration. None if the events up to the
    cursor differ, or if a surface has bristles or detents, whose state depends on the past.
    """
    layered = (old.bristles, old.detents, new.bristles, new.detents) != (None,) * 4
    if layered or (old.kind_names, old.kind_modes, old.own_modes) != (
        new.kind_names, new.kind_modes, new.own_modes
    ):  # fmt: skip
        return None
    count = _count_before(old, cursor)
    if count is None or count != _count_before(new, cursor):
        return None
    same = (
        np.array_equal(getattr(old, name)[:count], getattr(new, name)[:count])
        for name in ("position", "kind", "event")
    )
    crests = _crests(old.texture_strikes, new.texture_strikes, cursor)
    if not all(same) or crests is None:
        return None
    cells = len(old.friction) - 1
    part = np.clip((np.arange(cells + 1) / cells - cursor) / BLEND, 0.0, 1.0)
    friction = np.where(
        part > 0.0, old.friction + part * (new.friction - old.friction), old.friction
    )
    friction[part == 1.0] = new.friction[part == 1.0]
    return replace(
        new,
        friction=friction,
        texture_strikes=crests,
        edges=np.concatenate((old.edges[:count], new.edges[count:])),
        release=np.concatenate((old.release[:count], new.release[count:])),
        span=np.concatenate((old.span[:count], new.span[count:])),
    )


def _count_before(surface: Surface, cursor: float) -> int | None:
    """Return the number of events up to the cursor; None unless they are the first in the list."""
    begins: FloatArray = np.minimum(surface.position, surface.edges.min(axis=1, initial=1))
    reached = begins <= cursor
    count = int(np.count_nonzero(reached))
    return count if reached[:count].all() else None


def _crests(old: TextureStrikes, new: TextureStrikes, cursor: float) -> TextureStrikes | None:
    count = int(np.searchsorted(old.position, cursor, side="right"))
    if not np.array_equal(old.position[:count], new.position[:count]):
        return None
    return TextureStrikes(new.position, np.concatenate((old.release[:count], new.release[count:])))
