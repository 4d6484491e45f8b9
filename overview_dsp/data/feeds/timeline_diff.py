"""Differences between two timelines as compact JSON, for takes and pages.

::

    {"duration_s": ..., "known_until_s": ..., "title": ..., "notes": [...], "sides": [...],
     "provenance": ..., "start": ..., "gaps": [[start_s, end_s]],
     "gap_reasons": [...],                                                only changed fields
     "gone": [event], "new": [event], "details_gone": [...], "details_new": [...],
     "curve": null | "excitement" | {"keep": n, "time_s": [...], "value": [...], "unit": ...,
                                     "percentiles": [...]}}

A change of the marks of the user alone is `{"marks": [event]}`, all marks after it.
`gone` and `new` list the removed and the added events. `excitement` is the curve that is derived
from the events, and `keep` the number of unchanged points at the start of the curve. A timeline
that these fields cannot describe, such as one with window events, is stored in full in the native
format: `{"whole": {...}}`. Applying a difference twice has the same result as applying it once.

The module also defines the announcement of a new event: a timeline with this event only. A short
tap moves the disk over it, with the same preset, so it feels and sounds as on the full timeline.
The announcement of a withdrawn event has it three times, so no new event feels like it.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from dataclasses import replace
from datetime import datetime
from typing import Any

import numpy as np

from overview_dsp.data.analysis.crowd_excitement import derive_intensity
from overview_dsp.data.feeds.feed_lines import event_object, event_of
from overview_dsp.data.readers import native
from overview_dsp.data.timeline.event import MARK, Event
from overview_dsp.data.timeline.intensity import Intensity
from overview_dsp.data.timeline.model import Timeline, with_marks
from overview_dsp.errors import InputError, quoted

EXCITEMENT = "excitement"
_SCALAR_FIELDS = ("title", "duration_s", "known_until_s", "provenance")
_LIST_FIELDS = ("notes", "gaps", "gap_reasons", "sides")


def timeline_diff(old: Timeline, new: Timeline) -> dict[str, Any]:
    """Return the difference with which `apply_diff` turns `old` into `new`.

    InputError for a curve with too many points.
    """
    marks = [event for event in new.events if event.kind == MARK]
    if marks != [event for event in old.events if event.kind == MARK] and (
        with_marks(old, marks) == new
    ):
        return {"marks": [event_object(event) for event in marks]}
    if new.rules is None and old.rules is None and old.signal is new.signal:
        parts = _parts(old, new)
        if apply_diff(old, parts) == new:
            return parts
    return {"whole": json.loads(native.encode(new))}


def apply_diff(old: Timeline, change: Mapping[str, Any]) -> Timeline:
    """Return the timeline after a change; InputError if `change` is not a valid difference."""
    try:
        if "whole" in change:
            return native.decode(change["whole"])
        if "marks" in change:
            return with_marks(old, [event_of(mark) for mark in change["marks"]])
        fields: dict[str, Any] = {name: change[name] for name in _SCALAR_FIELDS if name in change}
        if "until_s" in change:  # the key in takes of version 0.1
            fields["known_until_s"] = change["until_s"]
        for name in _LIST_FIELDS:
            if name in change:
                fields[name] = tuple(
                    tuple(one) if isinstance(one, list) else one for one in change[name]
                )
        if "start" in change:
            start = change["start"]
            fields["start"] = None if start is None else datetime.fromisoformat(start)
        events = _changed(old.events, change, "")
        fields |= {"events": events, "details": _changed(old.details, change, "details_")}
        if "curve" in change:
            until = fields.get("known_until_s", old.known_until_s)
            reach = fields.get("duration_s", old.duration_s) if until is None else until
            fields["intensity"] = _curve(old.intensity, change["curve"], events, reach)
        return replace(old, **fields)
    except InputError:
        raise
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise InputError(
            f"invalid timeline difference ({type(error).__name__}: {error}); record the take again"
        ) from None


def _parts(old: Timeline, new: Timeline) -> dict[str, Any]:
    parts: dict[str, Any] = {}
    for name in (*_SCALAR_FIELDS, *_LIST_FIELDS):
        value = getattr(new, name)
        if getattr(old, name) != value:
            parts[name] = list(value) if isinstance(value, tuple) else value
    if old.start != new.start:
        parts["start"] = None if new.start is None else new.start.isoformat()
    for key, name in (("", "events"), ("details_", "details")):
        before, after = (dict.fromkeys(getattr(timeline, name)) for timeline in (old, new))
        removed = [event_object(event) for event in before if event not in after]
        added = [event_object(event) for event in after if event not in before]
        parts |= {f"{key}gone": removed} if removed else {}
        parts |= {f"{key}new": added} if added else {}
    if old.intensity != new.intensity:
        parts["curve"] = _curve_parts(old.intensity, new)
    return parts


def _curve_parts(old: Intensity | None, new: Timeline) -> Any:
    curve = new.intensity
    if curve is None:
        return None
    reach = new.duration_s if new.known_until_s is None else new.known_until_s
    if reach > 0.0 and curve == _excitement(new.events, reach):
        return EXCITEMENT
    times, values = np.asarray(curve.time_s[:]), np.asarray(curve.value)
    keep = 0
    if old is not None:
        count = min(old.count, curve.count)
        same = (np.asarray(old.time_s[:count]) == times[:count]) & (
            np.asarray(old.value[:count]) == values[:count]
        )
        keep = count if same.all() else int(np.argmin(same))
    return {
        "keep": keep,
        "time_s": times[keep:].tolist(),
        "value": values[keep:].tolist(),
        "unit": curve.unit,
        "percentiles": list(curve.percentiles),
    }


def _curve(old: Intensity | None, change: Any, events: Iterable[Event], reach: float) -> Any:
    if change is None:
        return None
    if change == EXCITEMENT:
        return _excitement(events, reach)
    keep = change["keep"]
    if keep and (old is None or old.count < keep):
        raise InputError(f"the difference keeps {keep} points of a curve that has fewer")
    before: Any = (old.time_s[:keep], old.value[:keep]) if old is not None and keep else ([], [])
    return Intensity(
        np.concatenate((before[0], change["time_s"])),
        np.concatenate((before[1], change["value"])),
        change["unit"],
        tuple(change["percentiles"]),
    )


def _excitement(events: Iterable[Event], reach: float) -> Intensity | None:
    # periods first, as in `LiveTimeline`, so that the curve is bit-identical
    return derive_intensity(sorted(events, key=lambda event: event.kind != "period"), reach)[0]


def _changed(events: tuple[Event, ...], change: Mapping[str, Any], key: str) -> tuple[Event, ...]:
    """Return events without the removed and with the added ones."""
    removed = {event_of(one) for one in change.get(f"{key}gone", ())}
    result = dict.fromkeys(event for event in events if event not in removed)
    added = [event_of(one) for one in change.get(f"{key}new", ())]
    return (*result, *(event for event in added if event not in result))


WITHDRAWN_POSITIONS = (0.01, 0.035, 0.06)  # positions of a withdrawn event: it is felt three times
EVENT_POSITION = 0.04  # position of the announced event, 0 to 1 of its surface
TAP_POSITION = 0.08
"""Position of the tap. The event is halfway, so the disk moves when it passes the event."""

TAP_HOLD_S = 0.25
"""Duration of the tap, s. Under every bundled preset the disk has passed the event by then."""

ANNOUNCEMENT_S = 0.8  # time from the tap until the timeline is under the disk again, s


def announcement_change(event: Event, withdrawn: bool = False) -> dict[str, Any]:
    """Return the entry of a recorded take for the announcement of a new or withdrawn event."""
    pattern: dict[str, Any] = {"kind": event.kind, "weight": event.weight}
    return {"pattern": pattern | {"withdrawn": True} if withdrawn else pattern}


def announcement_of(pattern: Mapping[str, Any]) -> Timeline:
    """Return the announcement of an event's kind and weight; InputError if it is invalid."""
    keys = pattern.keys() - {"withdrawn"} if isinstance(pattern, Mapping) else None
    if keys != {"kind", "weight"} or pattern.get("withdrawn", True) is not True:
        raise InputError(f"pattern is {quoted(pattern)}; must have the keys kind and weight")
    places = WITHDRAWN_POSITIONS if "withdrawn" in pattern else (EVENT_POSITION,)
    fields = {key: pattern[key] for key in keys}
    events = tuple(event_of({"time_s": place, **fields}) for place in places)
    return Timeline("something is new", 1.0, events)
