"""What has changed from one timeline to the next: small, as JSON, for takes and for pages.

::

    {"duration_s": ..., "known_until_s": ..., "title": ..., "notes": [...], "provenance": ...,
     "start": ..., "gaps": [[start_s, end_s]], "gap_reasons": [...],      where they differ
     "gone": [event], "new": [event], "details_gone": [...], "details_new": [...],
     "curve": null | "excitement" | {"keep": n, "time_s": [...], "value": [...], "unit": ...,
                                     "percentiles": [...]}}

`excitement` is the curve that is derived from the events, `keep` how many points at its beginning
stay. A timeline that this doesn't hold (one that finds events in its windows by rule) is there as a
whole: `{"whole": {...}}`, in the native format. Making a change a second time changes nothing.

The pattern that tells of something new: the event itself, met and met again within a moment.

It is a timeline of its own with nothing but that event on it, which the disk is sent over by a
short tap: so it is felt and heard by the same disk, torque and preset as the event on the timeline.
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
from overview_dsp.data.timeline.event import Event
from overview_dsp.data.timeline.intensity import Intensity
from overview_dsp.data.timeline.model import Timeline
from overview_dsp.errors import InputError

EXCITEMENT = "excitement"
_PLAIN = ("title", "duration_s", "known_until_s", "provenance")
_LISTED = ("notes", "gaps", "gap_reasons")


def difference(old: Timeline, new: Timeline) -> dict[str, Any]:
    """Return what `applied` makes `new` of `old` with.

    Raises
    ------
    InputError
        A curve of too many points.
    """
    if new.rules is None and old.rules is None and old.signal is new.signal:
        parts = _parts(old, new)
        if applied(old, parts) == new:
            return parts
    return {"whole": json.loads(native.encode(new))}


def applied(old: Timeline, change: Mapping[str, Any]) -> Timeline:
    """Return a timeline after a change; InputError if it isn't one."""
    try:
        if "whole" in change:
            return native.decode(change["whole"])
        fields: dict[str, Any] = {name: change[name] for name in _PLAIN if name in change}
        if "until_s" in change:  # the key's name before version 0.2
            fields["known_until_s"] = change["until_s"]
        for name in _LISTED:
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
        raise InputError(f"not a change of a timeline ({type(error).__name__}: {error})") from None


def _parts(old: Timeline, new: Timeline) -> dict[str, Any]:
    parts: dict[str, Any] = {}
    for name in (*_PLAIN, *_LISTED):
        value = getattr(new, name)
        if getattr(old, name) != value:
            parts[name] = list(value) if isinstance(value, tuple) else value
    if old.start != new.start:
        parts["start"] = None if new.start is None else new.start.isoformat()
    for key, name in (("", "events"), ("details_", "details")):
        were, are = (dict.fromkeys(getattr(timeline, name)) for timeline in (old, new))
        gone = [event_object(event) for event in were if event not in are]
        came = [event_object(event) for event in are if event not in were]
        parts |= {f"{key}gone": gone} if gone else {}
        parts |= {f"{key}new": came} if came else {}
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
        raise InputError(f"a curve keeps {keep} points that aren't there")
    before: Any = (old.time_s[:keep], old.value[:keep]) if old is not None and keep else ([], [])
    return Intensity(
        np.concatenate((before[0], change["time_s"])),
        np.concatenate((before[1], change["value"])),
        change["unit"],
        tuple(change["percentiles"]),
    )


def _excitement(events: Iterable[Event], reach: float) -> Intensity | None:
    # periods first, as in `LiveTimeline`: the same products to the bit
    return derive_intensity(sorted(events, key=lambda event: event.kind != "period"), reach)[0]


def _changed(events: tuple[Event, ...], change: Mapping[str, Any], key: str) -> tuple[Event, ...]:
    """Return events without those that are gone and with those that are new."""
    without = {event_of(one) for one in change.get(f"{key}gone", ())}
    kept = [event for event in events if event not in without]
    there = set(kept)
    came = [event_of(one) for one in change.get(f"{key}new", ())]
    return (*kept, *(event for event in came if event not in there))


PLACE = 0.04
"""Where the event is, 0 to 1 of the surface ..."""

TAP = 0.08
"""... and how far the disk is sent: half of it to be in motion, half to be past the event."""

HOLDS_S = 0.25
"""How long the tap holds, s: the disk is beyond the event by then under every bundled preset."""

LASTS_S = 0.8
"""After so long, from the tap on, the timeline is under the disk again, s."""


def pattern_change(event: Event) -> dict[str, Any]:
    """Return what a recording holds of an event's pattern."""
    return {"pattern": {"kind": event.kind, "weight": event.weight}}


def pattern_of(what: Mapping[str, Any]) -> Timeline:
    """Return the timeline of the pattern of an event's kind and weight; InputError."""
    if not isinstance(what, Mapping) or what.keys() != {"kind", "weight"}:
        raise InputError("a pattern has a kind and a weight")
    event = event_of({"time_s": PLACE, **what})
    return Timeline("something is new", 1.0, (event,))
